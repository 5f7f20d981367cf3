//! Descriptors in a folder of their own, and the clouds to which they belong.

use std::collections::BTreeSet;
use std::path::Path;

use super::descriptors::{self, DescriptorSets};
use super::numbered::trailing_number;
use super::problems::Problems;
use crate::{DescriptorFiles, Error};

/// The keypoints and descriptors of each of the clouds, from a folder in one of the two forms of
/// [`Layout::Yoho`](crate::Layout::Yoho). Neither clouds nor descriptors are opened.
///
/// A set belongs to the cloud whose name ends in the same number. If clouds have no such numbers, or two
/// have the same, it belongs to the cloud in the place of its number.
///
/// # Errors
/// [`Error::Io`] if the folder cannot be listed, [`Error::NothingFound`] if it has no descriptors.
/// [`Error::Incomplete`] if a cloud has no set, if a set has no cloud or lacks a file, or if two sets
/// have the same number.
///
/// # Example
/// ```
/// use gmpcr_io::descriptor_files_of_clouds;
///
/// let folder = tempfile::tempdir()?;
/// for name in ["7.kpts.npy", "7.desc.npy", "3.kpts.npy", "3.desc.npy"] {
///     std::fs::write(folder.path().join(name), "")?;
/// }
/// let sets = descriptor_files_of_clouds(&["scans/hall_7.ply", "scans/hall_3.ply"], folder.path())?;
/// assert_eq!(sets[0].keypoints, folder.path().join("7.kpts.npy"));
/// let error = descriptor_files_of_clouds(&["hall_7.ply"], folder.path()).unwrap_err();
/// assert!(error.to_string().contains("keypoints of no scan: 3.kpts.npy"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn descriptor_files_of_clouds(
    clouds: &[impl AsRef<Path>],
    folder: impl AsRef<Path>,
) -> Result<Vec<DescriptorFiles>, Error> {
    let clouds: Vec<_> = clouds.iter().map(|cloud| Some(cloud.as_ref())).collect();
    sets_of_scans(&clouds, folder.as_ref())
}

/// The same for scans. Some may have no cloud.
pub(super) fn sets_of_scans(
    clouds: &[Option<&Path>],
    folder: &Path,
) -> Result<Vec<DescriptorFiles>, Error> {
    let sets = DescriptorSets::find(folder)?.ok_or_else(|| Error::NothingFound {
        folder: folder.to_owned(),
        wanted: descriptors::WANTED,
    })?;
    let numbers = numbers(clouds);
    let mut problems = Problems::of(folder);
    sets.check(&numbers.iter().copied().collect(), &mut problems);
    problems.into_result()?;
    Ok(numbers
        .into_iter()
        .map(|number| sets.of_scan(number))
        .collect())
}

/// The number of each scan, by which files elsewhere belong to it.
fn numbers(clouds: &[Option<&Path>]) -> Vec<usize> {
    let number = |cloud: &Option<&Path>| trailing_number((*cloud)?.file_stem()?.to_str()?);
    let in_names: Option<Vec<usize>> = clouds.iter().map(number).collect();
    let is_unique =
        |numbers: &Vec<usize>| numbers.iter().collect::<BTreeSet<_>>().len() == numbers.len();
    in_names
        .filter(is_unique)
        .unwrap_or_else(|| (0..clouds.len()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_the_names_of_clouds_count_unless_one_lacks_or_repeats_it() {
        for (names, expected) in [
            (["scan_3.ply", "scan_7.ply"], [3, 7]),
            (["scan_3.ply", "stairs.ply"], [0, 1]),
            (["a_3.ply", "b_3.ply"], [0, 1]),
        ] {
            assert_eq!(numbers(&names.map(|name| Some(Path::new(name)))), expected);
        }
        assert_eq!(numbers(&[None, Some(Path::new("a_7.ply"))]), [0, 1]);
    }
}
