//! Keypoints of a scan and their descriptors, in two files.

#[cfg(feature = "scans")]
mod scan;

use std::path::{Path, PathBuf};

use crate::Error;
use crate::folder::file_names;

pub(crate) const KEYPOINTS: &str = ".kpts.npy";
pub(crate) const DESCRIPTORS: &str = ".desc.npy";

/// Keypoints of a scan and their descriptors: two files whose rows correspond.
///
/// With the feature `scans`, its method `read` reads both.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DescriptorFiles {
    /// What the two file names have in common; in a [`Scene`](crate::Scene) the number of the set.
    pub name: String,
    /// The n×3 array of points, for [`read_npy_matrix`](crate::read_npy_matrix).
    pub keypoints: PathBuf,
    /// The n×d array of descriptors, for [`read_npy_matrix`](crate::read_npy_matrix).
    pub descriptors: PathBuf,
}

/// The pairs `<name>.kpts.npy`, `<name>.desc.npy` of a folder in natural order of their names.
///
/// # Errors
/// [`Error::Io`] if the folder cannot be listed, [`Error::NothingFound`] if it has no such file,
/// [`Error::Unpaired`] if one of the two stands alone.
///
/// # Example
/// ```
/// use gmpcr_io::{Error, descriptor_files};
///
/// let folder = tempfile::tempdir()?;
/// for name in ["10.desc.npy", "10.kpts.npy", "9.desc.npy", "9.kpts.npy"] {
///     std::fs::write(folder.path().join(name), "")?;
/// }
/// let scans = descriptor_files(folder.path())?;
/// assert_eq!(scans[0].name, "9");
/// assert_eq!(scans[1].keypoints, folder.path().join("10.kpts.npy"));
///
/// std::fs::write(folder.path().join("11.kpts.npy"), "")?;
/// assert!(matches!(descriptor_files(folder.path()), Err(Error::Unpaired { .. })));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn descriptor_files(folder: impl AsRef<Path>) -> Result<Vec<DescriptorFiles>, Error> {
    let folder = folder.as_ref();
    let names = file_names(folder)?;
    let with_ending = |ending: &str| -> Vec<&str> {
        let stems = names.iter().filter_map(|name| name.strip_suffix(ending));
        stems.collect()
    };
    let scans = with_ending(KEYPOINTS);
    let descriptors = with_ending(DESCRIPTORS);
    check_paired(folder, (&scans, KEYPOINTS), (&descriptors, DESCRIPTORS))?;
    check_paired(folder, (&descriptors, DESCRIPTORS), (&scans, KEYPOINTS))?;
    if scans.is_empty() {
        return Err(Error::NothingFound {
            folder: folder.to_owned(),
            wanted: "pair of <name>.kpts.npy and <name>.desc.npy",
        });
    }
    let files = scans.into_iter().map(|name| DescriptorFiles {
        name: name.to_owned(),
        keypoints: folder.join(format!("{name}{KEYPOINTS}")),
        descriptors: folder.join(format!("{name}{DESCRIPTORS}")),
    });
    Ok(files.collect())
}

fn check_paired(
    folder: &Path,
    (present, present_ending): (&[&str], &str),
    (partners, missing_ending): (&[&str], &str),
) -> Result<(), Error> {
    match present.iter().find(|name| !partners.contains(name)) {
        None => Ok(()),
        Some(name) => Err(Error::Unpaired {
            present: folder.join(format!("{name}{present_ending}")),
            missing: folder.join(format!("{name}{missing_ending}")),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn missing_and_empty_folders_are_named() {
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(
            descriptor_files(folder.path()),
            Err(Error::NothingFound { .. })
        ));
        let missing = folder.path().join("missing");
        assert!(matches!(descriptor_files(&missing), Err(Error::Io { .. })));
    }

    #[test]
    fn a_lone_file_of_either_kind_is_named_with_its_partner() {
        for (present, missing) in [("4.kpts.npy", "4.desc.npy"), ("4.desc.npy", "4.kpts.npy")] {
            let folder = tempfile::tempdir().unwrap();
            fs::write(folder.path().join(present), "").unwrap();
            let error = descriptor_files(folder.path()).unwrap_err().to_string();
            assert!(
                error.contains(present) && error.contains(missing),
                "{error}"
            );
        }
    }
}
