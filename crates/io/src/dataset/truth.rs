//! What is known of the true poses of a scene.

use std::path::{Path, PathBuf};

use nalgebra::Isometry3;

use super::numbered::Numbered;
use super::overlaps::{PairOverlap, read_overlaps};
use super::pairs::{ListFiles, PairList};
use super::problems::Problems;
use super::{Layout, clouds, poses};
use crate::Error;

/// Tables of overlaps, the most complete first: the benchmark's own list only some pairs.
const OVERLAPS: [&str; 3] = ["overlap.csv", "official_gt_overlap.log", "gt_overlap.log"];

/// What is known of the true poses of a scene. Scans are named by their place in
/// [`Scene::scans`](crate::Scene::scans), which is the number in their file names.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneTruth {
    /// The lists of pairs that a benchmark judges: `3dmatch`, `3dlomatch`, `gt`, in this order, as
    /// far as they are there.
    pub match_lists: Vec<PairList>,
    /// Overlaps of pairs. A pair that is not listed is one of which nothing is told.
    pub overlaps: Option<Vec<PairOverlap>>,
    /// The motion of each scan into the frame that all share, in the unit of the scans; `None` for a
    /// scan of unknown pose.
    pub world_from_scan: Option<Vec<Option<Isometry3<f64>>>>,
}

impl SceneTruth {
    /// The list of pairs of a name.
    ///
    /// # Example
    /// ```
    /// use gmpcr_io::{PairList, SceneTruth};
    ///
    /// let gt = PairList { name: "gt".into(), file: "gt.log".into(), pairs: vec![], information: None };
    /// let truth = SceneTruth { match_lists: vec![gt], ..SceneTruth::default() };
    /// assert!(truth.match_list("gt").is_some());
    /// assert!(truth.match_list("3dlomatch").is_none());
    /// ```
    #[must_use]
    pub fn match_list(&self, name: &str) -> Option<&PairList> {
        self.match_lists.iter().find(|list| list.name == name)
    }

    pub(super) fn read(
        folder: &Path,
        layout: Layout,
        scans: &Numbered,
        problems: &mut Problems,
    ) -> Result<Self, Error> {
        let places = places(folder);
        Ok(Self {
            match_lists: read_match_lists(&places, layout, scans, problems)?,
            overlaps: read_scene_overlaps(&places, scans, problems)?,
            world_from_scan: read_poses(folder, layout, scans, problems)?,
        })
    }
}

/// Where the truth of a scene may lie: in its folder, beside its clouds, or, as 3DMatch is handed
/// out, in a folder of its own, `<scene>-evaluation`.
pub(super) fn places(folder: &Path) -> Vec<PathBuf> {
    let beside_clouds = clouds::SUBFOLDERS.map(|name| folder.join(name));
    let evaluation = folder.file_name().map(|name| {
        let mut name = name.to_owned();
        name.push("-evaluation");
        folder.with_file_name(name)
    });
    [folder.to_owned()]
        .into_iter()
        .chain(beside_clouds)
        .chain(evaluation)
        .collect()
}

/// The first file of the name, if there is one.
pub(super) fn find_file(places: &[PathBuf], name: &str) -> Option<PathBuf> {
    let mut paths = places.iter().map(|place| place.join(name));
    paths.find(|path| path.is_file())
}

fn read_match_lists(
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
    if let Some(table) = find_file(&places(folder), poses::TABLE) {
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
