//! The ground truth of a scene.

use std::path::{Path, PathBuf};

use nalgebra::Isometry3;

use super::layout::Layout;
use super::numbered::Numbered;
use super::overlaps::{PairOverlap, read_overlaps};
use super::pairs::{ListFiles, PairList};
use super::places::{self, find_file};
use super::poses;
use super::problems::Problems;
use crate::Error;

/// Tables of overlaps, the most complete first: the benchmark's own list only some pairs.
const OVERLAPS: [&str; 3] = ["overlap.csv", "official_gt_overlap.log", "gt_overlap.log"];

/// The ground truth of a scene: poses, relative poses and overlaps that are known from elsewhere.
///
/// Scans are named by their place in [`Scene::scans`](crate::Scene::scans), which is the number in their
/// file names.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct GroundTruth {
    /// The lists of pairs that a benchmark judges: `3dmatch`, `3dlomatch`, `gt`, in this order, as
    /// far as they are there.
    pub pair_lists: Vec<PairList>,
    /// Overlaps of pairs. Nothing is known of a pair that is not listed.
    pub overlaps: Option<Vec<PairOverlap>>,
    /// The pose of each scan in one common frame, in the unit of the scans. `None` for a scan of unknown
    /// pose.
    pub world_from_scan: Option<Vec<Option<Isometry3<f64>>>>,
}

impl GroundTruth {
    /// The list of pairs of a name.
    ///
    /// # Example
    /// ```
    /// use gmpcr_io::{Layout, read_scene};
    ///
    /// let folder = tempfile::tempdir()?;
    /// for name in ["cloud_bin_0.ply", "gt.log"] {
    ///     std::fs::write(folder.path().join(name), "")?;
    /// }
    /// let ground_truth = read_scene(folder.path(), Layout::Eth)?.ground_truth;
    /// assert!(ground_truth.pair_list("gt").is_some());
    /// assert!(ground_truth.pair_list("3dlomatch").is_none());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn pair_list(&self, name: &str) -> Option<&PairList> {
        self.pair_lists.iter().find(|list| list.name == name)
    }

    pub(super) fn read(
        folder: &Path,
        layout: Layout,
        scans: &Numbered,
        problems: &mut Problems,
    ) -> Result<Self, Error> {
        let places = places::of_ground_truth(folder);
        Ok(Self {
            pair_lists: read_pair_lists(&places, layout, scans, problems)?,
            overlaps: read_scene_overlaps(&places, scans, problems)?,
            world_from_scan: read_poses(folder, layout, scans, problems)?,
        })
    }
}

fn read_pair_lists(
    places: &[PathBuf],
    layout: Layout,
    scans: &Numbered,
    problems: &mut Problems,
) -> Result<Vec<PairList>, Error> {
    let found = ListFiles::find(places);
    if found.is_empty() && layout == Layout::Eth {
        problems.add("no pairs: gt.log is missing".to_owned());
    }
    let needs_information = layout == Layout::ThreeDMatch;
    let lists = found
        .into_iter()
        .map(|files| files.read(scans, needs_information, problems));
    lists.filter_map(Result::transpose).collect()
}

fn read_scene_overlaps(
    places: &[PathBuf],
    scans: &Numbered,
    problems: &mut Problems,
) -> Result<Option<Vec<PairOverlap>>, Error> {
    let Some(path) = OVERLAPS.iter().find_map(|name| find_file(places, name)) else {
        return Ok(None);
    };
    let overlaps = read_overlaps(&path)?;
    let named = overlaps.iter().flat_map(|pair| [pair.i, pair.j]);
    scans.check_named(&path, named, problems);
    Ok(Some(overlaps))
}

fn read_poses(
    folder: &Path,
    layout: Layout,
    scans: &Numbered,
    problems: &mut Problems,
) -> Result<Option<poses::Poses>, Error> {
    if let Some(table) = find_file(&places::of_ground_truth(folder), poses::TABLE) {
        return poses::read_table(&table, scans, problems).map(Some);
    }
    if layout != Layout::ScanNet {
        return Ok(None);
    }
    match poses::find_pose_files(folder, scans)? {
        Some(files) => poses::read_pose_files(&files, scans, problems).map(Some),
        None => {
            let cloud = problems.shown(&scans.path(0).with_extension("txt"));
            problems.add(format!(
                "no poses: neither poses.txt nor pose/0.txt, poses/0.txt or {cloud} and so on"
            ));
            Ok(None)
        }
    }
}
