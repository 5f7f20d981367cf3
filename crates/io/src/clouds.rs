//! The point clouds of a folder.

use std::path::{Path, PathBuf};

use crate::Error;
use crate::descriptors::{DESCRIPTORS, KEYPOINTS};
use crate::folder::file_names;
use crate::formats::Format;

/// The point clouds of a folder in natural order: `scan_2` before `scan_10`.
///
/// These are the files that [`read_points`](crate::read_points) of this build reads. Tables, poses
/// and descriptors have some of the same extensions: files `.txt`, `.csv`, `.npy` and `.npz` are listed
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
                let has_features = name.ends_with(KEYPOINTS) || name.ends_with(DESCRIPTORS);
                if format.is_readable() && !has_features {
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

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
            error.contains("0.ply: its name is not Unicode text"),
            "{error}"
        );
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
        let with_features = ["0.desc.npy", "0.kpts.npy", "0.npy"];
        assert_eq!(scans_of(&with_features).unwrap(), ["0.npy"]);
        assert!(scans_of(&with_features[..2]).is_err());
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
        let missing = folder.path().join("missing");
        let error = scan_files(&missing).unwrap_err().to_string();
        assert!(error.contains("missing"), "{error}");
    }
}
