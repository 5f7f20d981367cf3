//! The folders in which benchmarks hand out their scenes.

mod clouds;
mod descriptors;
mod numbered;
mod overlaps;
mod pairs;
mod poses;
mod problems;
mod scene;
mod truth;

use std::path::{Path, PathBuf};

use crate::Error;
use crate::folder::folder_names;

use descriptors::DescriptorSets;
use numbered::Numbered;
use pairs::ListFiles;
use problems::Problems;

pub use overlaps::{PairOverlap, read_overlaps};
pub use pairs::PairList;
pub use scene::{Scene, SceneScan};
pub use truth::SceneTruth;

/// What a scene's folder must hold. All else that is known of the true poses is read where it is
/// there.
///
/// | layout | clouds | descriptors | pairs | `.info` | poses |
/// |---|---|---|---|---|---|
/// | [`ThreeDMatch`](Self::ThreeDMatch) | required | not looked for | where present | required beside each `.log` | `poses.txt` where present |
/// | [`Yoho`](Self::Yoho) | where present | required | where present | where present | `poses.txt` where present |
/// | [`ScanNet`](Self::ScanNet) | required | not looked for | where present | where present | required |
/// | [`Eth`](Self::Eth) | required | not looked for | required | where present | `poses.txt` where present |
///
/// * **Clouds** are the files `cloud_bin_<i>.ply` or `.pcd`; where there is none, all `.ply` and
///   `.pcd` files, whose names then must end in their numbers. They lie in the subfolder
///   `PointCloud` or `scans`, or in the folder itself.
/// * **Pairs** are the lists `3dmatch`, from `official_3dmatch.log` or else `gt_3dmatch.log`;
///   `3dlomatch`, from `official_3dlomatch.log`, `gt_3dlomatch.log` or else `gtLo.log`; and `gt`, from
///   `gt.log`; each with the `.info` file of the same name.
/// * **Overlaps** come from `overlap.csv`, or else `official_gt_overlap.log` or `gt_overlap.log`, see
///   [`read_overlaps`].
/// * **Poses** are the rows of `poses.txt`, in a format of [`read_poses_3x4`](crate::read_poses_3x4),
///   one for each scan. A pose without a finite number is unknown.
///
/// The truth lies in the folder itself, in `PointCloud` or `scans`, or, as 3DMatch is handed out, in
/// the neighbouring folder `<scene>-evaluation`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Layout {
    /// Clouds with pairs and their information matrices, as of 3DMatch and 3DLoMatch.
    ThreeDMatch,
    /// Keypoints and descriptors of each scan, as YOHO and SGHR read them.
    ///
    /// Either `<i>.kpts.npy` and `<i>.desc.npy` lie in the folder itself, or `<i>.npy` in two
    /// subfolders, one of keypoints (`Keypoints_PC`, `keypoints` or `kpts`) and one of descriptors
    /// (`YOHO_desc`, `descriptors`, `features` or `yoho`; upper and lower case are alike). The files
    /// belong together by the number at the end of their names, after which `Keypoints.npy`,
    /// `.kpts.npy` or `.desc.npy` may stand instead of `.npy`: `cloud_bin_3Keypoints.npy` and
    /// `3.npy`. Keypoints are n×3 arrays, descriptors n×d.
    ///
    /// The folder `YOHO_Output_Group_feature` is not looked for: it holds n×32×60 arrays of a number
    /// per rotation of a group, from which SGHR derives `yoho_desc` as the mean over the last axis.
    /// Lists of indices, `Keypoints/cloud_bin_<i>Keypoints.txt`, are not read either.
    Yoho,
    /// Clouds with the pose of each.
    ///
    /// Where there is no `poses.txt`, each scan has a file of [`read_pose_matrix`]: `pose/<i>.txt`,
    /// `poses/<i>.txt`, or one beside its cloud that is named like it.
    ///
    /// [`read_pose_matrix`]: crate::read_pose_matrix
    ScanNet,
    /// Clouds with pairs that need no information matrices, as YOHO and SGHR have of the ETH data:
    /// `PointCloud/cloud_bin_<i>.ply` and `PointCloud/gt.log`.
    Eth,
}

impl Layout {
    /// The layout of a folder by the files that it holds, or `None` if it is not a scene.
    ///
    /// A scene has numbered clouds with a truth, or descriptors. The first that fits counts:
    /// [`Yoho`](Self::Yoho) with descriptors, [`ScanNet`](Self::ScanNet) with a pose file of any scan,
    /// [`ThreeDMatch`](Self::ThreeDMatch) with an `.info` file of any list, [`Eth`](Self::Eth) with
    /// other lists, [`ScanNet`](Self::ScanNet) with `poses.txt`. Whether all files are there is for
    /// [`read_scene`] to see. A scene of 3DMatch that has lost all its `.info` files is taken for one
    /// of ETH: name the layout where you know it.
    ///
    /// # Errors
    /// [`Error::Io`] if the folder or one of the subfolders of interest cannot be listed.
    ///
    /// # Example
    /// ```
    /// use gmpcr_io::Layout;
    ///
    /// let folder = tempfile::tempdir()?;
    /// assert_eq!(Layout::of(folder.path())?, None);
    /// for name in ["cloud_bin_0.ply", "gt.log"] {
    ///     std::fs::write(folder.path().join(name), "")?;
    /// }
    /// assert_eq!(Layout::of(folder.path())?, Some(Layout::Eth));
    /// std::fs::write(folder.path().join("gt.info"), "")?;
    /// assert_eq!(Layout::of(folder.path())?, Some(Layout::ThreeDMatch));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of(folder: impl AsRef<Path>) -> Result<Option<Self>, Error> {
        let folder = folder.as_ref();
        if DescriptorSets::find(folder)?.is_some() {
            return Ok(Some(Self::Yoho));
        }
        let Some(clouds) = clouds::find(folder)? else {
            return Ok(None);
        };
        if poses::find_pose_files(folder, &clouds)?.is_some() {
            return Ok(Some(Self::ScanNet));
        }
        let places = truth::places(folder);
        let lists = ListFiles::find(&places);
        Ok(if lists.iter().any(ListFiles::has_information) {
            Some(Self::ThreeDMatch)
        } else if !lists.is_empty() {
            Some(Self::Eth)
        } else {
            truth::find_file(&places, poses::TABLE).map(|_| Self::ScanNet)
        })
    }

    /// What a folder lacks in which nothing of this layout is found.
    fn wanted(self) -> &'static str {
        match self {
            Self::Yoho => descriptors::WANTED,
            _ => "numbered point cloud (cloud_bin_<i>.ply, .pcd), nor do PointCloud or scans in it",
        }
    }
}

/// Lists the files of a scene and reads its truth. Clouds and descriptors are not opened.
///
/// The scans are numbered 0, 1, 2, ... in the names of their clouds, or, in a scene of
/// [`Layout::Yoho`] without clouds, of their keypoints. [`Layout`] tells which files are looked for,
/// and where.
///
/// # Errors
/// * [`Error::NothingFound`] if there are no clouds, or for [`Layout::Yoho`] no descriptors.
/// * [`Error::Io`] and [`Error::Malformed`] if a file of the truth cannot be read.
/// * [`Error::Incomplete`], once for all of these that are found: gaps in the numbers of the scans or
///   two files of one number; lists of pairs without their `.info` file where the layout requires
///   it, or an `.info` file without its list; a `.log` and an `.info` file of different pairs; a list
///   that counts other than the present scans, names an absent one, or pairs one with itself;
///   overlaps or poses of absent scans; scans without a pose file, or a row in `poses.txt`, or with
///   two; scans without keypoints or descriptors, and the reverse.
///
/// # Example
/// ```
/// use gmpcr_io::{Layout, read_scene};
///
/// let folder = tempfile::tempdir()?;
/// let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text);
/// write("cloud_bin_0.ply", "")?;
/// write("cloud_bin_2.ply", "")?;
/// write("gt.log", "0 2 3\n1 0 0 0.5\n0 1 0 0\n0 0 1 0\n0 0 0 1\n")?;
/// let error = read_scene(folder.path(), Layout::ThreeDMatch).unwrap_err().to_string();
/// assert!(error.contains("missing clouds: cloud_bin_1.ply"));
/// assert!(error.contains("missing beside gt.log: gt.info"));
///
/// write("cloud_bin_1.ply", "")?;
/// let scene = read_scene(folder.path(), Layout::Eth)?;
/// assert_eq!(scene.scans.len(), 3);
/// let pair = &scene.truth.match_list("gt").unwrap().pairs[0];
/// assert_eq!((pair.i, pair.j, pair.i_from_j.translation.x), (0, 2, 0.5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_scene(folder: impl AsRef<Path>, layout: Layout) -> Result<Scene, Error> {
    let folder = folder.as_ref();
    let clouds = clouds::find(folder)?;
    let sets = match layout {
        Layout::Yoho => DescriptorSets::find(folder)?,
        _ => None,
    };
    let scans = numbered_scans(layout, clouds.as_ref(), sets.as_ref());
    let scans = scans.ok_or_else(|| Error::NothingFound {
        folder: folder.to_owned(),
        wanted: layout.wanted(),
    })?;

    let mut problems = Problems::of(folder);
    scans.check_sequence(&mut problems);
    if let Some(sets) = &sets {
        sets.check(&scans.numbers(), &mut problems);
    }
    let truth = SceneTruth::read(folder, layout, scans, &mut problems)?;
    problems.into_result()?;

    let files = |scan| SceneScan {
        cloud: clouds.as_ref().map(|clouds| clouds.path(scan)),
        descriptors: sets.as_ref().map(|sets| sets.of_scan(scan)),
    };
    Ok(Scene {
        name: scene::folder_name(folder),
        folder: folder.to_owned(),
        scans: scans.numbers().into_iter().map(files).collect(),
        truth,
    })
}

/// The files whose numbers are those of the scans.
fn numbered_scans<'a>(
    layout: Layout,
    clouds: Option<&'a Numbered>,
    sets: Option<&'a DescriptorSets>,
) -> Option<&'a Numbered> {
    match layout {
        Layout::Yoho => sets.map(|sets| clouds.unwrap_or(&sets.keypoints)),
        _ => clouds,
    }
}

/// The scenes of a data set: the folder itself if [`Layout::of`] knows it, else those of its
/// subfolders that are scenes, in natural order.
///
/// # Errors
/// [`Error::Io`] if the folder or one in it cannot be listed, [`Error::NothingFound`] if there is no
/// scene.
///
/// # Example
/// ```
/// use gmpcr_io::scene_folders;
///
/// let root = tempfile::tempdir()?;
/// for scene in ["scene10", "scene9", "notes"] {
///     std::fs::create_dir(root.path().join(scene))?;
/// }
/// for file in ["cloud_bin_0.ply", "gt.log"] {
///     std::fs::write(root.path().join("scene9").join(file), "")?;
///     std::fs::write(root.path().join("scene10").join(file), "")?;
/// }
/// let scenes = scene_folders(root.path())?;
/// assert_eq!(scenes, ["scene9", "scene10"].map(|scene| root.path().join(scene)));
/// assert_eq!(scene_folders(&scenes[0])?, scenes[..1]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn scene_folders(root: impl AsRef<Path>) -> Result<Vec<PathBuf>, Error> {
    let root = root.as_ref();
    if Layout::of(root)?.is_some() {
        return Ok(vec![root.to_owned()]);
    }
    let mut scenes = Vec::new();
    for name in folder_names(root)? {
        let folder = root.join(name);
        if Layout::of(&folder)?.is_some() {
            scenes.push(folder);
        }
    }
    if scenes.is_empty() {
        return Err(Error::NothingFound {
            folder: root.to_owned(),
            wanted: "scene, nor does any folder in it",
        });
    }
    Ok(scenes)
}
