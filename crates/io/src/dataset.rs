//! The folders in which benchmarks publish their scenes.

mod attach;
mod clouds;
mod descriptors;
mod folders;
mod ground_truth;
mod layout;
mod numbered;
mod overlaps;
mod pairs;
mod places;
mod poses;
mod problems;
mod read;
mod scene;

pub use attach::descriptor_files_of_clouds;
pub use folders::scene_folders;
pub use ground_truth::GroundTruth;
pub use layout::Layout;
pub use overlaps::{PairOverlap, read_overlaps};
pub use pairs::PairList;
pub use read::read_scene;
pub use scene::{Scene, SceneScan};
