//! The formats of point clouds, by the extension of the file.

use std::path::Path;

use crate::{Error, PointFile, npy, read_pcd, read_ply, read_xyz};

/// Reads the points of a file of one cloud; the case of the extension does not matter.
///
/// | extension | format | feature |
/// |---|---|---|
/// | `.ply` | [PLY](read_ply) | |
/// | `.pcd` | [PCD](read_pcd) | |
/// | `.xyz`, `.asc`, `.pts`, `.txt`, `.csv` | [text](read_xyz) | |
/// | `.npy` | NumPy array of `float32` or `float64`, a point per row: the first three columns | |
/// | `.npz` | NumPy archive: its array `points`, `xyz`, `pcd`, `pc` or `positions`, else its only matrix of three or more columns | `npz` |
/// | `.las` | LAS: all points, also those marked as withheld or as noise | `las` |
/// | `.laz` | LAS, compressed | `laz` |
/// | `.e57` | E57: all scans of the file in its frame, poses applied; `read_e57` keeps them apart | `e57` |
///
/// Coordinates are in the unit and the frame of the file, with all their digits. LAS and
/// E57 are often georeferenced, millions of meters from the origin.
///
/// # Errors
/// [`Error::UnknownExtension`] for other names, [`Error::FeatureOff`] for formats that this build
/// does not read, [`Error::Io`] if the file cannot be read. [`Error::Malformed`] if it is empty,
/// foreign, cut off, or false about its size; memory is reserved only for what it can hold. Damaged
/// LAZ may also make the panic hook of the program print, see `read_las`.
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
/// let error = read_points("scan.obj").unwrap_err();
/// assert!(error.to_string().contains("known extensions are .ply, .pcd, .xyz"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_points(path: impl AsRef<Path>) -> Result<PointFile, Error> {
    let path = path.as_ref();
    let Some(format) = Format::of(path) else {
        let readable = FORMATS.iter().filter(|format| format.is_readable());
        return Err(Error::UnknownExtension {
            path: path.to_owned(),
            known: readable.map(|format| format.extension).collect(),
        });
    };
    match format.reader {
        Ok(read) => read(path),
        Err(feature) => Err(format.feature_off(path, feature)),
    }
}

/// A kind of point file.
pub(crate) struct Format {
    extension: &'static str,
    name: &'static str,
    /// Whether files of other content have this extension as well.
    pub(crate) is_common: bool,
    reader: Reader,
}

/// What reads the format, or the feature that this build would need.
type Reader = Result<fn(&Path) -> Result<PointFile, Error>, &'static str>;

impl Format {
    /// The format of the extension.
    pub(crate) fn of(path: &Path) -> Option<&'static Self> {
        let extension = path.extension()?.to_str()?;
        FORMATS
            .iter()
            .find(|format| format.extension.eq_ignore_ascii_case(extension))
    }

    pub(crate) fn is_readable(&self) -> bool {
        self.reader.is_ok()
    }

    /// The feature that this build would need.
    pub(crate) fn missing_feature(&self) -> Option<&'static str> {
        self.reader.err()
    }

    pub(crate) fn feature_off(&self, path: &Path, feature: &'static str) -> Error {
        Error::FeatureOff {
            path: path.to_owned(),
            format: self.name,
            feature,
        }
    }

    const fn own(extension: &'static str, name: &'static str, reader: Reader) -> Self {
        Self {
            extension,
            name,
            is_common: false,
            reader,
        }
    }

    const fn common(extension: &'static str, name: &'static str, reader: Reader) -> Self {
        Self {
            is_common: true,
            ..Self::own(extension, name, reader)
        }
    }
}

const TEXT: Reader = Ok(|path| read_xyz(path));

#[cfg(feature = "las")]
const LAS: Reader = Ok(|path| crate::read_las(path));
#[cfg(not(feature = "las"))]
const LAS: Reader = Err("las");

#[cfg(feature = "laz")]
const LAZ: Reader = Ok(|path| crate::read_las(path));
#[cfg(not(feature = "laz"))]
const LAZ: Reader = Err("laz");

#[cfg(feature = "e57")]
const E57: Reader = Ok(crate::e57::read_merged);
#[cfg(not(feature = "e57"))]
const E57: Reader = Err("e57");

#[cfg(feature = "npz")]
const NPZ: Reader = Ok(crate::npz::read_points);
#[cfg(not(feature = "npz"))]
const NPZ: Reader = Err("npz");

const FORMATS: &[Format] = &[
    Format::own("ply", "PLY", Ok(|path| read_ply(path))),
    Format::own("pcd", "PCD", Ok(|path| read_pcd(path))),
    Format::own("xyz", "text", TEXT),
    Format::own("asc", "text", TEXT),
    Format::own("pts", "text", TEXT),
    Format::own("las", "LAS", LAS),
    Format::own("laz", "LAZ", LAZ),
    Format::own("e57", "E57", E57),
    Format::common("txt", "text", TEXT),
    Format::common("csv", "text", TEXT),
    Format::common("npy", "NPY", Ok(npy::read_points)),
    Format::common("npz", "NPZ", NPZ),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_decides_in_any_case() {
        for name in ["a.PLY", "a.Pcd", "a.XYZ", "a.Npy", "a.csv"] {
            let error = read_points(name).unwrap_err();
            assert!(matches!(error, Error::Io { .. }), "{error}");
        }
        for name in ["a", "a.obj", "ply", ".ply", ""] {
            let error = read_points(name).unwrap_err();
            assert!(matches!(error, Error::UnknownExtension { .. }), "{error}");
        }
    }

    #[test]
    fn a_format_is_read_or_its_feature_is_named() {
        for (name, format, feature) in [
            ("a.LAS", "LAS", "las"),
            ("a.laz", "LAZ", "laz"),
            ("a.e57", "E57", "e57"),
            ("a.npz", "NPZ", "npz"),
        ] {
            let error = read_points(name).unwrap_err();
            let off = format!(
                "{name} is a {format} file, but this build reads no {format}: \
                 rebuild with the feature `{feature}`"
            );
            let readable = Format::of(Path::new(name)).unwrap().is_readable();
            assert_eq!(matches!(error, Error::Io { .. }), readable, "{error}");
            assert_eq!(error.to_string() == off, !readable, "{error}");
        }
    }
}
