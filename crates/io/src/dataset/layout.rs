//! How the folders of the benchmarks are laid out.

use std::path::Path;

use super::descriptors::{self, DescriptorSets};
use super::pairs::ListFiles;
use super::{clouds, places, poses};
use crate::Error;

/// What a scene's folder must hold. All else that is known of the poses is read if it is there.
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
///   [`read_overlaps`](crate::read_overlaps).
/// * **Poses** are the rows of `poses.txt`, in a format of [`read_poses`](crate::read_poses),
///   one for each scan. A pose without a finite number is unknown.
///
/// The ground truth lies in the folder itself, in `PointCloud` or `scans`, or, as 3DMatch is published, in
/// the neighboring folder `<scene>-evaluation`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Layout {
    /// Clouds with pairs and their information matrices, as of 3DMatch and 3DLoMatch.
    ThreeDMatch,
    /// Keypoints and descriptors of each scan, as YOHO and SGHR read them.
    ///
    /// Either `<i>.kpts.npy` and `<i>.desc.npy` lie in the folder itself, or `<i>.npy` in two
    /// subfolders, one of keypoints (`Keypoints_PC`, `keypoints` or `kpts`) and one of descriptors
    /// (`YOHO_desc`, `descriptors`, `features` or `yoho`; case does not matter). The files
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
    /// A scene has numbered clouds with a ground truth, or descriptors. The first that fits counts:
    /// [`Yoho`](Self::Yoho) with descriptors, [`ScanNet`](Self::ScanNet) with a pose file of any
    /// scan, [`ThreeDMatch`](Self::ThreeDMatch) with an `.info` file of any list,
    /// [`Eth`](Self::Eth) with other lists, [`ScanNet`](Self::ScanNet) with `poses.txt`.
    /// [`read_scene`](crate::read_scene) checks whether all files are there. A scene of 3DMatch
    /// without any `.info` file is taken for one of ETH: name the layout if you know it.
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
        let places = places::of_ground_truth(folder);
        let lists = ListFiles::find(&places);
        Ok(if lists.iter().any(ListFiles::has_information) {
            Some(Self::ThreeDMatch)
        } else if !lists.is_empty() {
            Some(Self::Eth)
        } else {
            places::find_file(&places, poses::TABLE).map(|_| Self::ScanNet)
        })
    }

    /// What a folder lacks in which nothing of this layout is found.
    pub(super) fn wanted(self) -> &'static str {
        match self {
            Self::Yoho => descriptors::WANTED,
            _ => "numbered point cloud (cloud_bin_<i>.ply, .pcd), nor do PointCloud or scans in it",
        }
    }
}
