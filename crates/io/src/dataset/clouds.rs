//! The point clouds of a scene.

use std::path::Path;

use super::numbered::{Naming, Numbered};
use crate::Error;

/// Where clouds lie if not in the folder itself.
pub(super) const SUBFOLDERS: [&str; 2] = ["PointCloud", "scans"];

const ANY: Naming = Naming {
    what: "clouds",
    start: None,
    endings: &[".ply", ".pcd"],
};

/// As the benchmarks name them.
const CLOUD_BIN: Naming = Naming {
    start: Some("cloud_bin_"),
    ..ANY
};

/// The numbered clouds of a scene: those of a subfolder before those of the folder, and the
/// benchmarks' names before all others, since programs leave merged or downsampled clouds behind.
pub(super) fn find(folder: &Path) -> Result<Option<Numbered>, Error> {
    let subfolders = SUBFOLDERS.map(|name| folder.join(name));
    let places = subfolders.iter().filter(|place| place.is_dir());
    for place in places.map(|place| &**place).chain([folder]) {
        for naming in [CLOUD_BIN, ANY] {
            if let Some(clouds) = Numbered::find(place, naming)? {
                return Ok(Some(clouds));
            }
        }
    }
    Ok(None)
}
