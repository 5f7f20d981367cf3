//! Keypoints of a scan and what describes them.

use std::path::Path;

use nalgebra::Point3;

use crate::{DescriptorFiles, Error, read_npy_matrix};

/// Descriptors of equal length, one after another.
#[derive(Clone, Debug, PartialEq)]
pub struct Descriptors {
    /// How many numbers a descriptor has; at least one.
    pub dimension: usize,
    /// The numbers: descriptor `k` is `values[k * dimension..(k + 1) * dimension]`.
    pub values: Vec<f32>,
}

impl DescriptorFiles {
    /// Reads keypoints and descriptors: equally many, and all keypoints finite.
    ///
    /// # Errors
    /// Those of [`read_keypoints`] and [`read_descriptors`], and [`Error::Malformed`] where numbers differ
    /// or a keypoint is not finite.
    pub fn read(&self) -> Result<(Vec<Point3<f64>>, Descriptors), Error> {
        let keypoints = read_keypoints(&self.keypoints)?;
        let descriptors = read_descriptors(&self.descriptors)?;
        let num_rows = descriptors.values.len() / descriptors.dimension;
        if num_rows != keypoints.len() {
            let reason = format!(
                "{num_rows} descriptors, but {} holds {} keypoints",
                self.keypoints.display(),
                keypoints.len()
            );
            return Err(Error::malformed(&self.descriptors, reason));
        }
        let is_finite = |keypoint: &Point3<f64>| keypoint.iter().all(|x| x.is_finite());
        match keypoints.iter().position(|keypoint| !is_finite(keypoint)) {
            None => Ok((keypoints, descriptors)),
            Some(row) => {
                let reason = format!("the keypoint in row {row} is not finite");
                Err(Error::malformed(&self.keypoints, reason))
            }
        }
    }
}

/// Reads keypoints from an n×3 `.npy` array of `float32` or `float64`, a point per row.
///
/// All rows are kept, also those that are not finite, since row `k` belongs to row `k` of the
/// descriptors.
///
/// # Errors
/// As for [`read_npy_matrix`], and [`Error::Malformed`] if there are not three columns.
///
/// # Example
/// ```
/// use gmpcr_io::read_keypoints;
/// use npyz::WriterBuilder;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("0.kpts.npy");
/// let mut file = npyz::WriteOptions::new()
///     .default_dtype()
///     .shape(&[2, 3])
///     .writer(std::fs::File::create(&path)?)
///     .begin_nd()?;
/// file.extend([1.0f32, 2.0, 3.0, 4.0, 5.0, 6.0])?;
/// file.finish()?;
///
/// assert_eq!(read_keypoints(&path)?, [[1.0, 2.0, 3.0].into(), [4.0, 5.0, 6.0].into()]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_keypoints(path: impl AsRef<Path>) -> Result<Vec<Point3<f64>>, Error> {
    let path = path.as_ref();
    let matrix = read_npy_matrix(path)?;
    if matrix.columns != 3 {
        let (rows, columns) = (matrix.rows, matrix.columns);
        let reason = format!("keypoints are n x 3, but the array is {rows} x {columns}");
        return Err(Error::malformed(path, reason));
    }
    let points = matrix.values.chunks_exact(3);
    Ok(points.map(Point3::from_slice).collect())
}

/// Reads descriptors from an n×d `.npy` array of `float32` or `float64`, a descriptor per row.
///
/// Wider numbers are rounded to `f32`. All rows are kept, also those that are not finite, since row
/// `k` belongs to row `k` of the keypoints.
///
/// # Errors
/// As for [`read_npy_matrix`], and [`Error::Malformed`] if there are no columns.
///
/// # Example
/// ```
/// use gmpcr_io::read_descriptors;
/// use npyz::WriterBuilder;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("0.desc.npy");
/// let mut file = npyz::WriteOptions::new()
///     .default_dtype()
///     .shape(&[3, 2])
///     .writer(std::fs::File::create(&path)?)
///     .begin_nd()?;
/// file.extend([0.0f32, 1.0, 0.6, 0.8, 1.0, 0.0])?;
/// file.finish()?;
///
/// let descriptors = read_descriptors(&path)?;
/// assert_eq!(descriptors.dimension, 2);
/// assert_eq!(descriptors.values[2..4], [0.6, 0.8]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_descriptors(path: impl AsRef<Path>) -> Result<Descriptors, Error> {
    let path = path.as_ref();
    let matrix = read_npy_matrix(path)?;
    if matrix.columns == 0 {
        return Err(Error::malformed(
            path,
            "descriptors need columns, but the array is 0 x 0",
        ));
    }
    Ok(Descriptors {
        dimension: matrix.columns,
        values: matrix
            .values
            .into_iter()
            .map(|value| value as f32)
            .collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use npyz::WriterBuilder;

    /// What reading says of keypoints with these coordinates and of as many descriptors.
    fn complaint(coordinates: &[f64], num_descriptors: usize) -> String {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, columns: usize, entries: &[f64]| {
            let path = folder.path().join(name);
            let shape = [(entries.len() / columns) as u64, columns as u64];
            let options = npyz::WriteOptions::new().default_dtype().shape(&shape);
            let file = std::fs::File::create(&path).unwrap();
            let mut array = options.writer(file).begin_nd().unwrap();
            array.extend(entries.iter().copied()).unwrap();
            array.finish().unwrap();
            path
        };
        let files = DescriptorFiles {
            name: "7".into(),
            keypoints: write("7.kpts.npy", 3, coordinates),
            descriptors: write("7.desc.npy", 2, &vec![0.5; 2 * num_descriptors]),
        };
        files
            .read()
            .map_or_else(|error| error.to_string(), |_| String::new())
    }

    #[test]
    fn keypoints_and_descriptors_are_equally_many_and_finite() {
        assert_eq!(complaint(&[0.0; 6], 2), "");
        let said = complaint(&[0.0; 6], 3);
        assert!(said.contains("7.desc.npy: 3 descriptors, but "), "{said}");
        assert!(said.ends_with("7.kpts.npy holds 2 keypoints"), "{said}");
        let said = complaint(&[0.0, 0.0, 0.0, 0.0, f64::NAN, 0.0], 2);
        assert!(
            said.ends_with("7.kpts.npy: the keypoint in row 1 is not finite"),
            "{said}"
        );
    }
}
