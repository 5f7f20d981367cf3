//! Synthetic data with ground truth, for tests, examples and benchmarks: depth-camera scans of generated
//! indoor scenes, and pose graphs.
//!
//! Registration of low-overlap scans needs data whose poses are known better than any camera
//! track knows them. This crate generates a furnished flat out of simple solids, walks a depth
//! camera through it, and hands out one point cloud per scan, each in a frame of its own,
//! together with the pose of every scan:
//!
//! ```
//! use gmpcr_eval::overlap_matrix;
//! use gmpcr_sim::{SimParams, simulate};
//!
//! let params = SimParams { num_scans: 2, ..SimParams::default() };
//! let scans = simulate(&params)?;
//! let overlap = overlap_matrix(&scans.clouds, &scans.world_from_scan, 1.5 * params.voxel)?;
//! assert!(overlap[(0, 1)] > 0.2 && overlap[(0, 1)] < 0.9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | data | item |
//! |---|---|
//! | scans of a generated flat under random poses | [`simulate`], [`SimParams`], [`SimulatedScans`] |
//! | the flat, the depth camera and its noise | [`RoomParams`], [`DepthCamera`], [`DepthNoise`] |
//! | relative poses of which some are outliers | [`simulate_pose_graph`], [`PoseGraphSimParams`], [`SimulatedPoseGraph`] |
//!
//! Lengths are meters, angles radians. `world_from_scan` maps a scan's coordinates into the
//! world. Everything is drawn from seeded generators: the same parameters give the same bits.
//! Nothing here starts a thread.

mod building;
mod bvh;
mod camera;
mod downsample;
mod error;
mod furniture;
mod noise;
mod pose_graph;
mod primitive;
mod random;
mod ray;
mod scene;
mod shape;
mod simulate;
mod tour;
mod view;

pub use building::RoomParams;
pub use camera::DepthCamera;
pub use error::{Error, InvalidParameter};
pub use noise::DepthNoise;
pub use pose_graph::{
    EdgeWeights, Outliers, PoseGraphSimParams, SimulatedEdge, SimulatedPoseGraph, Topology,
    simulate_pose_graph,
};
pub use simulate::{SimParams, SimulatedScans, simulate};
