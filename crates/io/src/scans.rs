//! The scans of a file, whatever its format.

use std::path::Path;

use crate::{Error, PointFile, read_points};

/// A scan of a file.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct FileScan {
    /// The name that the file gives the scan; none in formats of one scan.
    pub name: Option<String>,
    /// The points in the frame of the scan.
    pub points: PointFile,
}

/// Reads the scans of a file, each in its own frame: those of an E57 file, which may be several, or the one of
/// any other format that [`read_points`] reads.
///
/// # Errors
/// Those of [`read_points`].
///
/// # Example
/// ```
/// use gmpcr_io::read_scans;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("scan.xyz");
/// std::fs::write(&path, "0 0 1\n0 1 1\n")?;
/// let scans = read_scans(&path)?;
/// assert_eq!((scans.len(), scans[0].points.points.len()), (1, 2));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_scans(path: impl AsRef<Path>) -> Result<Vec<FileScan>, Error> {
    let path = path.as_ref();
    #[cfg(feature = "e57")]
    if path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("e57"))
    {
        let scans = crate::read_e57(path)?.into_iter();
        let scans = scans.map(|scan| FileScan {
            name: scan.name,
            points: scan.points,
        });
        return Ok(scans.collect());
    }
    Ok(vec![FileScan {
        name: None,
        points: read_points(path)?,
    }])
}
