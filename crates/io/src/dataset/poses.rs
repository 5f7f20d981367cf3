//! The known poses of the scans of a scene.

use std::collections::BTreeMap;
use std::path::Path;

use super::numbered::{Naming, Numbered};
use super::problems::Problems;
use crate::pose_matrix::KnownPose;
use crate::poses::read_known_poses;
use crate::{Error, read_pose_matrix};

/// The table of all poses.
pub(super) const TABLE: &str = "poses.txt";

/// Folders of a pose file per scan.
const FOLDERS: [&str; 2] = ["pose", "poses"];

/// `world_from_scan` of each scan.
pub(super) type Poses = Vec<KnownPose>;

/// The pose files of a scene that has one per scan: `pose/<i>.txt`, `poses/<i>.txt`, or beside each
/// cloud one of the same name.
pub(super) fn find_pose_files(folder: &Path, clouds: &Numbered) -> Result<Option<Numbered>, Error> {
    let naming = Naming {
        what: "poses",
        start: None,
        endings: &[".txt"],
    };
    let folders = FOLDERS.map(|name| folder.join(name));
    for place in folders.iter().filter(|place| place.is_dir()) {
        if let Some(files) = Numbered::find(place, naming)? {
            return Ok(Some(files));
        }
    }
    let named_as_clouds = Naming {
        start: Some(clouds.start()),
        ..naming
    };
    Numbered::find(clouds.folder(), named_as_clouds)
}

pub(super) fn read_pose_files(
    files: &Numbered,
    scans: &Numbered,
    problems: &mut Problems,
) -> Result<Poses, Error> {
    files.check_scans(&scans.numbers(), problems);
    let paths = scans.numbers().into_iter().map(|scan| files.path(scan));
    paths
        .filter(|path| path.is_file())
        .map(read_pose_matrix)
        .collect()
}

/// The poses of a table, which has a row for each scan.
pub(super) fn read_table(
    path: &Path,
    scans: &Numbered,
    problems: &mut Problems,
) -> Result<Poses, Error> {
    let rows = read_known_poses(path)?;
    let num_rows = rows.len();
    let poses: BTreeMap<usize, _> = rows.into_iter().collect();
    let file = problems.shown(path);
    if poses.len() < num_rows {
        let repeated = num_rows - poses.len();
        problems.add(format!(
            "{file} has {repeated} rows of scans that it had before"
        ));
    }
    let numbers = scans.numbers();
    let unposed = numbers.iter().filter(|scan| !poses.contains_key(scan));
    problems.add_files(
        &format!("{file} has no row of"),
        unposed.map(|&scan| scans.path(scan)),
    );
    scans.check_named(path, poses.keys().copied(), problems);
    let pose = |scan| poses.get(scan).copied().flatten();
    Ok(numbers.iter().map(pose).collect())
}
