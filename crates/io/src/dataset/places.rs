//! Where the ground truth of a scene may lie.

use std::path::{Path, PathBuf};

use super::clouds;

/// The folder of the scene, those of its clouds, and, as 3DMatch is published, a folder of its own,
/// `<scene>-evaluation`.
pub(super) fn of_ground_truth(folder: &Path) -> Vec<PathBuf> {
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
