//! The files of a data set, in the order in which people number them.

use std::cmp::Ordering;
use std::fs;
use std::path::{Path, PathBuf};

use crate::Error;
use crate::points::Format;

pub(crate) const KEYPOINTS: &str = ".kpts.npy";
pub(crate) const DESCRIPTORS: &str = ".desc.npy";

/// The point clouds of a folder in natural order: `scan_2` before `scan_10`.
///
/// These are the files that [`read_points`](crate::read_points) of this build reads. Tables, poses
/// and descriptors share some of the extensions: files `.txt`, `.csv`, `.npy` and `.npz` are listed
/// only where there is no point cloud of another kind, and `.kpts.npy` and `.desc.npy` never.
///
/// Hidden files, whose names start with a dot, and subfolders are left out.
///
/// # Errors
/// [`Error::Io`] if the folder cannot be listed, [`Error::NothingFound`] if it has no point cloud,
/// [`Error::FeatureOff`] if it has only some of a format that this build does not read.
///
/// # Example
/// ```
/// use gmpcr_io::scan_files;
///
/// let folder = tempfile::tempdir()?;
/// for name in ["cloud_bin_10.ply", "cloud_bin_2.ply", "poses.txt"] {
///     std::fs::write(folder.path().join(name), "")?;
/// }
/// let files = scan_files(folder.path())?;
/// assert_eq!(files, ["cloud_bin_2.ply", "cloud_bin_10.ply"].map(|name| folder.path().join(name)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn scan_files(folder: impl AsRef<Path>) -> Result<Vec<PathBuf>, Error> {
    let folder = folder.as_ref();
    let mut own = Vec::new();
    let mut common = Vec::new();
    let mut feature_off = None;
    for name in file_names(folder)? {
        let path = folder.join(&name);
        match Format::of(&path) {
            None => {}
            Some(format) if format.is_common => {
                let is_described = name.ends_with(KEYPOINTS) || name.ends_with(DESCRIPTORS);
                if format.is_readable() && !is_described {
                    common.push(path);
                }
            }
            Some(format) => match format.missing_feature() {
                None => own.push(path),
                Some(feature) => {
                    feature_off.get_or_insert_with(|| format.feature_off(&path, feature));
                }
            },
        }
    }
    match (feature_off, own.is_empty(), common.is_empty()) {
        (_, false, _) => Ok(own),
        (Some(error), true, _) => Err(error),
        (None, true, false) => Ok(common),
        (None, true, true) => Err(Error::NothingFound {
            folder: folder.to_owned(),
            wanted: "point cloud (.ply, .pcd, .xyz, ...)",
        }),
    }
}

/// Keypoints of a scan and their descriptors: two files whose rows correspond.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DescriptorFiles {
    /// What the two file names share; in a [`Scene`](crate::Scene) the number of the set.
    pub name: String,
    /// The n×3 array, for [`read_keypoints`](crate::read_keypoints).
    pub keypoints: PathBuf,
    /// The n×d array, for [`read_descriptors`](crate::read_descriptors).
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
    let described = with_ending(DESCRIPTORS);
    check_paired(folder, (&scans, KEYPOINTS), (&described, DESCRIPTORS))?;
    check_paired(folder, (&described, DESCRIPTORS), (&scans, KEYPOINTS))?;
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

/// Names of the visible files of a folder in natural order. A name that is no Unicode is no name
/// of ours, but an error where it is that of a point cloud.
pub(crate) fn file_names(folder: &Path) -> Result<Vec<String>, Error> {
    names(folder, Path::is_file)
}

/// Names of the visible subfolders of a folder in natural order.
pub(crate) fn folder_names(folder: &Path) -> Result<Vec<String>, Error> {
    names(folder, Path::is_dir)
}

fn names(folder: &Path, is_wanted: fn(&Path) -> bool) -> Result<Vec<String>, Error> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).map_err(Error::io("list", folder))? {
        let entry = entry.map_err(Error::io("list", folder))?;
        let path = entry.path();
        match entry.file_name().into_string() {
            Ok(name) if !name.starts_with('.') && is_wanted(&path) => names.push(name),
            // Better an end than a scan that is silently missing.
            Err(_) if Format::of(&path).is_some() => {
                return Err(Error::malformed(
                    &path,
                    "its name is no Unicode text: rename it",
                ));
            }
            _ => {}
        }
    }
    names.sort_by(|a, b| natural_order(a, b));
    Ok(names)
}

/// Compares runs of digits by their value and everything else letter by letter.
fn natural_order(a: &str, b: &str) -> Ordering {
    let (mut rest_a, mut rest_b) = (a, b);
    while let (Some(first_a), Some(first_b)) = (rest_a.chars().next(), rest_b.chars().next()) {
        let order = if first_a.is_ascii_digit() && first_b.is_ascii_digit() {
            let (number_a, number_b) = (take_digits(&mut rest_a), take_digits(&mut rest_b));
            (number_a.len(), number_a).cmp(&(number_b.len(), number_b))
        } else {
            rest_a = &rest_a[first_a.len_utf8()..];
            rest_b = &rest_b[first_b.len_utf8()..];
            first_a.cmp(&first_b)
        };
        if order.is_ne() {
            return order;
        }
    }
    (rest_a.len(), a).cmp(&(rest_b.len(), b))
}

/// Takes the digits at the front of `text`, without leading zeros.
fn take_digits<'a>(text: &mut &'a str) -> &'a str {
    let end = text
        .find(|c: char| !c.is_ascii_digit())
        .unwrap_or(text.len());
    let (digits, rest) = text.split_at(end);
    *text = rest;
    digits.trim_start_matches('0')
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[cfg(unix)]
    #[test]
    fn a_scan_whose_name_is_no_text_is_not_silently_missing() {
        use std::os::unix::ffi::OsStrExt;
        let folder = tempfile::tempdir().unwrap();
        let name = |bytes| folder.path().join(std::ffi::OsStr::from_bytes(bytes));
        fs::write(name(b"a.ply"), "").unwrap();
        fs::write(name(b"note \xff"), "").unwrap();
        assert_eq!(scan_files(folder.path()).unwrap().len(), 1);
        fs::write(name(b"\xfe0.ply"), "").unwrap();
        let error = scan_files(folder.path()).unwrap_err().to_string();
        assert!(
            error.contains("0.ply: its name is no Unicode text"),
            "{error}"
        );
    }

    #[test]
    fn numbers_count_by_value_however_long() {
        let sorted = [
            "a1",
            "a2",
            "a02",
            "a10",
            "a10b",
            "a99999999999999999999",
            "a100000000000000000000",
            "b0",
            "scan",
            "scan-1",
            "scan1",
            "scan_1",
        ];
        let mut names = sorted;
        names.reverse();
        names.sort_by(|a, b| natural_order(a, b));
        assert_eq!(
            names[..7],
            [
                "a1",
                "a02",
                "a2",
                "a10",
                "a10b",
                "a99999999999999999999",
                "a100000000000000000000"
            ]
        );
        assert_eq!(names[7], "b0");
    }

    proptest! {
        #[test]
        fn natural_order_is_an_order(names in prop::collection::vec("[a01é9]{0,6}", 3)) {
            let [a, b, c] = [&names[0], &names[1], &names[2]];
            prop_assert_eq!(natural_order(a, b), natural_order(b, a).reverse());
            prop_assert_eq!(natural_order(a, b).is_eq(), a == b);
            if natural_order(a, b).is_le() && natural_order(b, c).is_le() {
                prop_assert!(natural_order(a, c).is_le());
            }
        }
    }

    #[test]
    fn hidden_files_folders_and_other_files_are_no_scans() {
        let folder = tempfile::tempdir().unwrap();
        for name in [
            "b.PLY",
            "a.pcd",
            "._a.pcd",
            ".b.ply.1-1.part",
            "ply",
            "c.ply.gz",
        ] {
            fs::write(folder.path().join(name), "").unwrap();
        }
        fs::create_dir(folder.path().join("d.ply")).unwrap();
        let files = scan_files(folder.path()).unwrap();
        assert_eq!(
            files,
            [folder.path().join("a.pcd"), folder.path().join("b.PLY")]
        );
    }

    fn scans_of(names: &[&str]) -> Result<Vec<String>, Error> {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let name = |path: PathBuf| path.file_name().unwrap().to_str().unwrap().to_owned();
        Ok(scan_files(folder.path())?.into_iter().map(name).collect())
    }

    #[test]
    fn files_that_may_be_tables_are_scans_only_where_no_others_are() {
        let tables = ["1.csv", "2.txt", "10.npy"];
        assert_eq!(scans_of(&tables).unwrap(), tables);
        let others = ["1.csv", "2.txt", "3.xyz", "4.pts", "5.asc", "10.npy"];
        assert_eq!(scans_of(&others).unwrap(), ["3.xyz", "4.pts", "5.asc"]);
        let described = ["0.desc.npy", "0.kpts.npy", "0.npy"];
        assert_eq!(scans_of(&described).unwrap(), ["0.npy"]);
        assert!(scans_of(&described[..2]).is_err());
    }

    #[test]
    fn clouds_are_listed_or_their_feature_is_named() {
        for name in ["1.las", "1.laz", "1.e57"] {
            let scans = scans_of(&[name, "poses.txt"]);
            if Format::of(Path::new(name)).unwrap().is_readable() {
                assert_eq!(scans.unwrap(), [name]);
            } else {
                assert!(matches!(scans, Err(Error::FeatureOff { .. })), "{scans:?}");
            }
            assert!(
                scans_of(&[name, "2.ply"])
                    .unwrap()
                    .ends_with(&["2.ply".to_owned()])
            );
        }
    }

    #[test]
    fn missing_and_empty_folders_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let empty = scan_files(folder.path()).unwrap_err().to_string();
        assert!(
            empty.contains("holds no point cloud (.ply, .pcd, .xyz, ...)"),
            "{empty}"
        );
        assert!(matches!(
            descriptor_files(folder.path()),
            Err(Error::NothingFound { .. })
        ));
        let missing = folder.path().join("missing");
        assert!(
            scan_files(&missing)
                .unwrap_err()
                .to_string()
                .contains("missing")
        );
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
