//! Reads and writes point clouds, descriptors, poses and pose graphs in the usual file formats.
//!
//! Registration of scans needs data before it and gives results after it. This crate reads the former
//! and writes the latter as plain values: points and transformations of [`nalgebra`], and pose graphs of
//! [`gmpcr_posegraph`]. It knows no algorithm.
//!
//! | what | format | read | write |
//! |---|---|---|---|
//! | point clouds | PLY, PCD, text (XYZ, CSV, PTS), NumPy `.npy` | [`read_points`], [`read_ply`], [`read_pcd`], [`read_xyz`] | [`write_merged_ply`] |
//! | | LAS, LAZ, E57, NumPy `.npz`, each with its [feature](#features) | [`read_points`], `read_las`, `read_e57` | |
//! | keypoints with descriptors | NumPy `.npy` | `DescriptorFiles::read` with the feature `scans`, [`read_npy_matrix`] | |
//! | absolute poses | TUM; rows of 3×4 matrices, as of KITTI | [`read_world_poses`], [`read_poses`], [`read_poses_tum`] | [`write_poses_tum`], [`write_poses_3x4`] |
//! | a single pose | 4×4 or 3×4 matrix, as of ScanNet | [`read_pose_matrix`] | |
//! | pose graphs | g2o | [`read_g2o`] | [`write_g2o`] |
//! | | JSON of Open3D | [`read_open3d_pose_graph`] | [`write_open3d_pose_graph`] |
//! | benchmark pairs | 3DMatch `gt.log`, `gt.info` | [`PairList::read`], [`read_gt_log`], [`read_gt_info`] | [`write_gt_log`] |
//! | overlaps of pairs | `overlap.csv`, `gt_overlap.log` | [`read_overlaps`] | |
//! | any text | | | [`write_text`] |
//! | folders of files | | [`scan_files`], [`descriptor_files`], [`descriptor_files_of_clouds`] | |
//! | scenes of benchmarks | 3DMatch, YOHO and SGHR, ScanNet, ETH: see [`Layout`] | [`scene_folders`], [`read_scene`] | |
//!
//! Pose graphs of files are lists of records. [`G2oPoseGraph`] makes one ready for synchronization and
//! returns the solution in the frame of the file. [`PosedGraph`] writes a solution with the information
//! matrices that g2o and Open3D expect.
//!
//! # Conventions
//! * `a_from_b` maps coordinates in frame `b` to coordinates in frame `a`. A pose is
//!   `world_from_scan`; a relative pose `i_from_j = world_from_i^-1 * world_from_j` maps scan `j`
//!   into the frame of scan `i`.
//! * Lengths are in the unit of the file.
//! * Quaternions are written vector first, scalar last: `qx qy qz qw`.
//! * Information matrices of a format are in its order: g2o has translation first, Open3D has
//!   rotation first. [`PosedGraph`] takes translation first, rotation in radians, and converts.
//! * Clouds are `f64` whatever their file has, so georeferenced ones keep their millimeters.
//!
//! # Features
//! None is on by default, since each needs further crates.
//!
//! | feature | effect |
//! |---|---|
//! | `las` | reads LAS |
//! | `laz` | reads LAZ, and LAS |
//! | `e57` | reads E57 |
//! | `npz` | reads NumPy `.npz` |
//! | `all-formats` | all of the above |
//! | `scans` | reads keypoints and descriptors as the scans of `gmpcr-correspondence` |
//! | `serde` | what files hold implements `Serialize` and `Deserialize` |
//!
//! # What to rely on
//! * A file of another format gives an [`Error`] that names the file, the line where there is
//!   one, and the reason. So does a file that is cut off or false about its size, if its format
//!   states a size. No file causes a panic, and memory is reserved only for what the file can
//!   hold. (Damaged LAZ may make the decompressor panic, which is caught: the program's panic
//!   hook prints a line, the reader returns the error. Where panics abort, the program ends.)
//! * An empty file is not a point cloud, a matrix or a pose graph, hence an [`Error`]. Files of poses
//!   and of benchmark pairs are lists without a header: an empty one is read as no entries.
//! * Text does not reveal every cut: one between two entries of a list, or within the last number of the
//!   file, goes unnoticed.
//! * Writers fill a hidden temporary file beside the target and rename it: a result is complete or
//!   absent. A link at the target's place is replaced, not followed.
//! * Numbers in text are written with all the digits that bring the same `f64` back.

mod atomic;
mod benchmark;
mod bytes;
mod clouds;
mod color;
mod dataset;
mod descriptors;
#[cfg(feature = "e57")]
mod e57;
mod error;
mod folder;
mod formats;
mod g2o;
mod g2o_graph;
#[cfg(feature = "las")]
mod las;
#[cfg(feature = "laz")]
mod laz;
mod merged;
mod npy;
#[cfg(feature = "npz")]
mod npz;
mod open3d;
mod pcd;
mod ply;
mod points;
mod pose_matrix;
mod posed_graph;
mod poses;
mod rigid;
mod rows;
mod scans;
mod text;
mod world_poses;
mod xyz;

pub use atomic::write_text;
pub use benchmark::{InfoEntry, LogEntry, read_gt_info, read_gt_log, write_gt_log};
pub use clouds::scan_files;
pub use color::distinct_color;
pub use dataset::{
    GroundTruth, Layout, PairList, PairOverlap, Scene, SceneScan, descriptor_files_of_clouds,
    read_overlaps, read_scene, scene_folders,
};
pub use descriptors::{DescriptorFiles, descriptor_files};
#[cfg(feature = "e57")]
pub use e57::{E57Scan, read_e57};
pub use error::Error;
pub use formats::read_points;
pub use g2o::{G2o, G2oEdge, G2oVertex, read_g2o, write_g2o};
pub use g2o_graph::{G2oGraphError, G2oPoseGraph};
#[cfg(feature = "las")]
pub use las::read_las;
pub use merged::{ColoredCloud, Coordinates, write_merged_ply};
pub use npy::{NpyMatrix, read_npy_matrix};
pub use open3d::{Open3dEdge, Open3dPoseGraph, read_open3d_pose_graph, write_open3d_pose_graph};
pub use pcd::read_pcd;
pub use ply::read_ply;
pub use points::PointFile;
pub use pose_matrix::read_pose_matrix;
pub use posed_graph::{MeasuredEdge, PosedGraph, PosedGraphError};
pub use poses::{read_poses, read_poses_tum, write_poses_3x4, write_poses_tum};
pub use scans::{FileScan, read_scans};
pub use world_poses::read_world_poses;
pub use xyz::read_xyz;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
