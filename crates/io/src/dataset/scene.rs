//! A scene as a list of its files.

use std::fs;
use std::path::{Path, PathBuf};

use super::attach::sets_of_scans;
use super::ground_truth::GroundTruth;
use crate::{DescriptorFiles, Error, scan_files};

/// The scans of a scene, by their files, and their ground truth.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Scene {
    /// Name of the folder.
    pub name: String,
    /// The folder.
    pub folder: PathBuf,
    /// The scans: the one in place `i` is scan `i` of the ground truth.
    pub scans: Vec<SceneScan>,
    /// The ground truth; all empty where nothing is known.
    pub ground_truth: GroundTruth,
}

/// The files of a scan.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct SceneScan {
    /// The point cloud, for [`read_points`](crate::read_points).
    pub cloud: Option<PathBuf>,
    /// The keypoints and their descriptors.
    pub descriptors: Option<DescriptorFiles>,
}

impl Scene {
    /// A scene of any point clouds: those of [`scan_files`], in its order, without ground truth.
    ///
    /// For folders that follow no layout, where [`Layout::of`](crate::Layout::of) finds none.
    ///
    /// # Errors
    /// Those of [`scan_files`].
    ///
    /// # Example
    /// ```
    /// use gmpcr_io::{Layout, Scene};
    ///
    /// let folder = tempfile::tempdir()?;
    /// for name in ["hall.ply", "stairs.pcd"] {
    ///     std::fs::write(folder.path().join(name), "")?;
    /// }
    /// assert_eq!(Layout::of(folder.path())?, None);
    /// let scene = Scene::of_clouds(folder.path())?;
    /// assert_eq!(scene.scans[1].cloud, Some(folder.path().join("stairs.pcd")));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of_clouds(folder: impl AsRef<Path>) -> Result<Self, Error> {
        let folder = folder.as_ref();
        let scans = scan_files(folder)?.into_iter().map(|cloud| SceneScan {
            cloud: Some(cloud),
            descriptors: None,
        });
        Ok(Self {
            name: folder_name(folder),
            folder: folder.to_owned(),
            scans: scans.collect(),
            ground_truth: GroundTruth::default(),
        })
    }

    /// Takes the files of keypoints and descriptors from a folder of their own, in one of the two forms of
    /// [`Layout::Yoho`](crate::Layout::Yoho).
    ///
    /// [`descriptor_files_of_clouds`](crate::descriptor_files_of_clouds) says which set belongs to which
    /// scan. Sets that a scan had are replaced.
    ///
    /// # Errors
    /// Those of [`descriptor_files_of_clouds`](crate::descriptor_files_of_clouds). Then the scene is as it
    /// was.
    ///
    /// # Example
    /// ```
    /// use gmpcr_io::Scene;
    ///
    /// let [clouds, learned] = [tempfile::tempdir()?, tempfile::tempdir()?];
    /// for name in ["cloud_bin_0.ply", "cloud_bin_1.ply"] {
    ///     std::fs::write(clouds.path().join(name), "")?;
    /// }
    /// for name in ["0.kpts.npy", "0.desc.npy", "1.kpts.npy"] {
    ///     std::fs::write(learned.path().join(name), "")?;
    /// }
    /// let mut scene = Scene::of_clouds(clouds.path())?;
    /// let error = scene.attach_descriptors(learned.path()).unwrap_err();
    /// assert!(error.to_string().ends_with("missing descriptors: 1.desc.npy"));
    ///
    /// std::fs::write(learned.path().join("1.desc.npy"), "")?;
    /// scene.attach_descriptors(learned.path())?;
    /// let second = scene.scans[1].descriptors.as_ref().unwrap();
    /// assert_eq!(second.keypoints, learned.path().join("1.kpts.npy"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn attach_descriptors(&mut self, folder: impl AsRef<Path>) -> Result<(), Error> {
        let clouds: Vec<_> = self
            .scans
            .iter()
            .map(|scan| scan.cloud.as_deref())
            .collect();
        let sets = sets_of_scans(&clouds, folder.as_ref())?;
        for (scan, set) in self.scans.iter_mut().zip(sets) {
            scan.descriptors = Some(set);
        }
        Ok(())
    }
}

/// The last name of the path; that of the folder itself for a path such as `.` or `..`.
pub(super) fn folder_name(folder: &Path) -> String {
    let resolved = fs::canonicalize(folder).ok();
    let name = folder
        .file_name()
        .or_else(|| resolved.as_deref()?.file_name());
    name.map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene_of(names: &[&str]) -> (tempfile::TempDir, Scene) {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let scene = Scene::of_clouds(folder.path()).unwrap();
        (folder, scene)
    }

    #[test]
    fn a_refused_folder_of_descriptors_leaves_the_scene_as_it_was() {
        let (folder, mut scene) = scene_of(&["a_0.ply", "a_1.ply"]);
        let before = scene.clone();
        let error = scene.attach_descriptors(folder.path()).unwrap_err();
        assert!(matches!(error, Error::NothingFound { .. }), "{error}");
        for name in ["0.kpts.npy", "x_0.kpts.npy", "0.desc.npy", "5.desc.npy"] {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let said = scene
            .attach_descriptors(folder.path())
            .unwrap_err()
            .to_string();
        for clause in [
            "keypoints of the same number: 0.kpts.npy = x_0.kpts.npy",
            "missing keypoints: 1.kpts.npy",
            "missing descriptors: 1.desc.npy",
            "descriptors of no scan: 5.desc.npy",
        ] {
            assert!(said.contains(clause), "{said}");
        }
        assert_eq!(scene, before);
    }

    #[test]
    fn a_folder_is_named_even_where_its_path_is_not() {
        assert_eq!(folder_name(Path::new("data/kitchen/")), "kitchen");
        assert!(!folder_name(Path::new(".")).is_empty());
    }
}
