//! A scan as its file has it.

use std::path::Path;

use nalgebra::Point3;

use crate::{Error, read_pcd, read_ply};

/// Extensions of point files, in lower case.
pub(crate) const EXTENSIONS: &[&str] = &["ply", "pcd"];

/// The points of a file, in its order and unit, and how many more it listed without a position.
///
/// Depth sensors mark pixels without a return by coordinates that are no numbers, and organised
/// clouds keep these rows. They are left out here, so that all coordinates in `points` are finite,
/// and counted. Where `invalid` is not zero, the place of a point in `points` is not its row in the
/// file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointFile {
    /// The points with three finite coordinates.
    pub points: Vec<Point3<f64>>,
    /// How many points were left out since a coordinate is NaN or infinite.
    pub invalid: usize,
}

impl PointFile {
    pub(crate) fn push(&mut self, coordinates: [f64; 3]) {
        if coordinates.iter().all(|coordinate| coordinate.is_finite()) {
            self.points.push(Point3::from(coordinates));
        } else {
            self.invalid += 1;
        }
    }
}

/// Reads the points of a `.ply` or `.pcd` file; upper and lower case of the extension are alike.
///
/// # Errors
/// [`Error::UnknownExtension`] for other names, and those of [`read_ply`] and [`read_pcd`].
///
/// # Example
/// ```
/// use gmpcr_io::read_points;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("scan.ply");
/// let header = "ply\nformat ascii 1.0\nelement vertex 2\n\
///               property float x\nproperty float y\nproperty float z\nend_header\n";
/// std::fs::write(&path, format!("{header}0 0.5 1\nnan nan nan\n"))?;
///
/// let scan = read_points(&path)?;
/// assert_eq!(scan.points, [[0.0, 0.5, 1.0].into()]);
/// assert_eq!(scan.invalid, 1);
///
/// let error = read_points("scan.xyz").unwrap_err();
/// assert!(error.to_string().contains("known extensions are .ply, .pcd"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_points(path: impl AsRef<Path>) -> Result<PointFile, Error> {
    let path = path.as_ref();
    match extension(path).as_deref() {
        Some("ply") => read_ply(path),
        Some("pcd") => read_pcd(path),
        _ => Err(Error::UnknownExtension {
            path: path.to_owned(),
            known: EXTENSIONS,
        }),
    }
}

/// The extension in lower case.
pub(crate) fn extension(path: &Path) -> Option<String> {
    let extension = path.extension()?.to_str()?;
    Some(extension.to_ascii_lowercase())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_counts_as_invalid_if_any_coordinate_is_not_finite() {
        let mut file = PointFile::default();
        file.push([1.0, 2.0, 3.0]);
        file.push([f64::NAN, 2.0, 3.0]);
        file.push([1.0, f64::INFINITY, 3.0]);
        file.push([f64::NAN; 3]);
        assert_eq!((file.points.len(), file.invalid), (1, 3));
    }

    #[test]
    fn the_extension_decides_in_any_case() {
        for name in ["a.PLY", "a.Pcd"] {
            let error = read_points(name).unwrap_err();
            assert!(matches!(error, Error::Io { .. }), "{error}");
        }
        for name in ["a", "a.xyz", "ply", ".ply", ""] {
            let error = read_points(name).unwrap_err();
            assert!(matches!(error, Error::UnknownExtension { .. }), "{error}");
        }
    }
}
