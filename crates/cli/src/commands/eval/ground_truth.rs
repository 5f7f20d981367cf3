//! Ground truth from files: pairs or poses.

use std::path::Path;

use gmpcr::nalgebra::{Isometry3, Matrix6};
use gmpcr_io::{
    Layout, LogEntry, PairList, read_gt_info, read_gt_log, read_scene, read_world_poses,
};

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
            lists: scene.ground_truth.match_lists,
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
    let pairs = read_gt_log(path)?;
    let Some(last) = pairs.iter().map(|pair| pair.i.max(pair.j)).max() else {
        return Err(Failure::of(path, "there is no pair in it"));
    };
    if last >= num_scans {
        return Err(other_scans(path, last.saturating_add(1), num_scans));
    }
    let info = path.with_extension("info");
    let information = match info.exists() {
        true => Some(information_of(&pairs, &info)?),
        false => None,
    };
    Ok(PairList {
        name: list_name(path),
        file: path.to_owned(),
        pairs,
        information,
    })
}

/// The name of the file; that of a benchmark's folder comes first, since `3DLoMatch/gt.log` is no list of 3DMatch.
fn list_name(path: &Path) -> String {
    let words = |name: Option<&std::ffi::OsStr>| name.unwrap_or_default().to_string_lossy().into_owned();
    let (stem, folder) = (
        words(path.file_stem()),
        words(path.parent().and_then(Path::file_name)),
    );
    match folder.to_ascii_lowercase().contains("match") {
        true => format!("{folder}/{stem}"),
        false => stem,
    }
}

fn information_of(pairs: &[LogEntry], info: &Path) -> Result<Vec<Matrix6<f64>>, Failure> {
    let entries = read_gt_info(info)?;
    let ends = entries.iter().map(|entry| (entry.i, entry.j));
    if !ends.eq(pairs.iter().map(|pair| (pair.i, pair.j))) {
        return Err(Failure::of(
            info,
            "it does not list the pairs of the .log beside it",
        ));
    }
    Ok(entries.into_iter().map(|entry| entry.information).collect())
}
