//! Ground truth from files: pairs or poses.

use std::path::Path;

use gmpcr::nalgebra::Isometry3;
use gmpcr_io::{Layout, PairList, read_scene, read_world_poses};

use crate::outcome::Failure;

/// Relative poses, or poses, that are known from elsewhere.
pub struct GroundTruth {
    pub lists: Vec<PairList>,
    /// By scan; `None` where the pose of a scan is not known.
    pub world_from_scan: Option<Vec<Option<Isometry3<f64>>>>,
}

impl GroundTruth {
    pub fn read(path: &Path, num_scans: usize) -> Result<Self, Failure> {
        if path.is_dir() {
            return Self::of_scene(path, num_scans);
        }
        let extension = path.extension();
        match extension.is_some_and(|extension| extension.eq_ignore_ascii_case("log")) {
            true => Ok(Self {
                lists: vec![pair_list(path, num_scans)?],
                world_from_scan: None,
            }),
            false => Ok(Self {
                lists: Vec::new(),
                world_from_scan: Some(read_world_poses(path, num_scans)?),
            }),
        }
    }

    fn of_scene(folder: &Path, num_scans: usize) -> Result<Self, Failure> {
        let Some(layout) = Layout::of(folder)? else {
            let reason =
                "the folder has the layout of no benchmark: name its file of pairs or poses";
            return Err(Failure::of(folder, reason));
        };
        let scene = read_scene(folder, layout)?;
        if scene.scans.len() != num_scans {
            return Err(other_scans(folder, scene.scans.len(), num_scans));
        }
        Ok(Self {
            lists: scene.ground_truth.pair_lists,
            world_from_scan: scene.ground_truth.world_from_scan,
        })
    }
}

fn other_scans(ground_truth: &Path, num_known: usize, num_scans: usize) -> Failure {
    let reason = format!("the ground truth is of {num_known} scans, the result of {num_scans}");
    Failure::of(ground_truth, reason)
}

/// The pairs of a `.log`, with the matrices of the `.info` of the same name where there is one.
fn pair_list(path: &Path, num_scans: usize) -> Result<PairList, Failure> {
    let list = PairList::read(path)?;
    let scans = list.pairs.iter().map(|pair| pair.i.max(pair.j));
    match scans.max() {
        None => Err(Failure::of(path, "there is no pair in it")),
        Some(last) if last >= num_scans => {
            Err(other_scans(path, last.saturating_add(1), num_scans))
        }
        Some(_) => Ok(list),
    }
}
