//! The scan of which the files are.

use std::path::Path;

use gmpcr_correspondence::{Descriptors, Scan};
use nalgebra::Point3;

use super::DescriptorFiles;
use crate::{Error, read_npy_matrix};

impl DescriptorFiles {
    /// Reads the scan: an n×3 array of keypoints in its frame, and an n×d array of their descriptors.
    ///
    /// Both are `.npy` arrays of `float32` or `float64`. Descriptors are rounded to `f32`. It needs
    /// the feature `scans`.
    ///
    /// # Errors
    /// Those of [`read_npy_matrix`]. [`Error::Malformed`] if there are not three columns of keypoints or
    /// no columns of descriptors, if the numbers of rows differ, or if an entry is not finite: the
    /// message names the file.
    ///
    /// # Example
    /// ```
    /// use gmpcr_io::descriptor_files;
    /// use npyz::WriterBuilder;
    ///
    /// let folder = tempfile::tempdir()?;
    /// let write = |name: &str, columns: u64, entries: &[f32]| {
    ///     let shape = [entries.len() as u64 / columns, columns];
    ///     let options = npyz::WriteOptions::new().default_dtype().shape(&shape);
    ///     let file = std::fs::File::create(folder.path().join(name))?;
    ///     let mut array = options.writer(file).begin_nd()?;
    ///     array.extend(entries.iter().copied())?;
    ///     array.finish()
    /// };
    /// write("0.kpts.npy", 3, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0])?;
    /// write("0.desc.npy", 2, &[0.0, 1.0, 0.6, 0.8])?;
    ///
    /// let scan = descriptor_files(folder.path())?[0].read()?;
    /// assert_eq!(scan.points()[1], [4.0, 5.0, 6.0].into());
    /// assert_eq!(scan.descriptors().row(1), [0.6, 0.8]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn read(&self) -> Result<Scan, Error> {
        let keypoints = read_keypoints(&self.keypoints)?;
        let descriptors = read_descriptors(&self.descriptors)?;
        if descriptors.len() != keypoints.len() {
            let reason = format!(
                "{} descriptors, but {} holds {} keypoints",
                descriptors.len(),
                self.keypoints.display(),
                keypoints.len()
            );
            return Err(Error::malformed(&self.descriptors, reason));
        }
        // Only a coordinate is left to be refused.
        let scan = Scan::new(keypoints, descriptors);
        scan.map_err(|error| Error::parser(&self.keypoints, None, "keypoints", error))
    }
}

/// All rows, also those that are not finite: row `k` belongs to row `k` of the descriptors.
fn read_keypoints(path: &Path) -> Result<Vec<Point3<f64>>, Error> {
    let matrix = read_npy_matrix(path)?;
    if matrix.columns != 3 {
        let (rows, columns) = (matrix.rows, matrix.columns);
        let reason = format!("keypoints are n x 3, but the array is {rows} x {columns}");
        return Err(Error::malformed(path, reason));
    }
    let points = matrix.values.chunks_exact(3);
    Ok(points.map(Point3::from_slice).collect())
}

fn read_descriptors(path: &Path) -> Result<Descriptors, Error> {
    let matrix = read_npy_matrix(path)?;
    let values = matrix.values.into_iter().map(|value| value as f32);
    let descriptors = Descriptors::new(values.collect(), matrix.columns);
    descriptors.map_err(|error| Error::parser(path, None, "descriptors", error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use npyz::WriterBuilder;

    /// What reading says of keypoints and descriptors of these shapes.
    fn complaint(keypoints: (&[f64], u64), descriptors: (&[f64], u64)) -> String {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, (entries, columns): (&[f64], u64)| {
            let path = folder.path().join(name);
            let shape = [entries.len() as u64 / columns.max(1), columns];
            let options = npyz::WriteOptions::new().default_dtype().shape(&shape);
            let file = std::fs::File::create(&path).unwrap();
            let mut array = options.writer(file).begin_nd().unwrap();
            array.extend(entries.iter().copied()).unwrap();
            array.finish().unwrap();
            path
        };
        let files = DescriptorFiles {
            name: "7".into(),
            keypoints: write("7.kpts.npy", keypoints),
            descriptors: write("7.desc.npy", descriptors),
        };
        let scan = files.read();
        scan.map_or_else(|error| error.to_string(), |_| String::new())
    }

    #[test]
    fn keypoints_and_descriptors_are_equally_many_and_finite() {
        let two = (&[0.5; 4][..], 2);
        assert_eq!(complaint((&[0.0; 6], 3), two), "");
        assert_eq!(complaint((&[], 3), (&[], 2)), "");
        let said = complaint((&[0.0; 6], 3), (&[0.5; 6], 2));
        assert!(said.contains("7.desc.npy: 3 descriptors, but "), "{said}");
        assert!(said.ends_with("7.kpts.npy holds 2 keypoints"), "{said}");
        let said = complaint((&[0.0, 0.0, 0.0, 0.0, f64::NAN, 0.0], 3), two);
        assert!(said.contains("7.kpts.npy: keypoints: point 1 "), "{said}");
        for large in [f64::NAN, 1e300] {
            let said = complaint((&[0.0; 6], 3), (&[0.5, 0.5, large, 0.5], 2));
            assert!(
                said.contains("7.desc.npy: descriptors: descriptor 1 "),
                "{said}"
            );
        }
    }

    #[test]
    fn arrays_of_other_shapes_are_named() {
        let said = complaint((&[0.0; 4], 4), (&[0.5; 2], 2));
        let shape = "7.kpts.npy: keypoints are n x 3, but the array is 1 x 4";
        assert!(said.ends_with(shape), "{said}");
        let said = complaint((&[], 3), (&[], 0));
        assert!(said.contains("7.desc.npy: descriptors: "), "{said}");
    }
}
