//! Simulated data with ground truth: depth-camera scans of generated indoor scenes, and pose graphs.
//!
//! Registration of low-overlap scans needs data whose poses are known better than any camera
//! track knows them. This crate generates a furnished flat out of simple solids, walks a depth
//! camera through it, and hands out one point cloud per scan, each in a frame of its own,
//! together with the pose of every scan:
//!
//! ```
//! use gmpcr_sim::{SimParams, overlap, simulate};
//!
//! let params = SimParams { num_scans: 2, ..SimParams::default() };
//! let scans = simulate(&params)?;
//! let i_from_j = scans.world_from_scan[0].inv_mul(&scans.world_from_scan[1]);
//! let shared = overlap(&scans.clouds[0], &scans.clouds[1], &i_from_j, 0.0375);
//! assert!(shared > 0.2 && shared < 0.9);
//! # Ok::<(), gmpcr_sim::Error>(())
//! ```
//!
//! | step | item |
//! |---|---|
//! | solids | [`Shape`], [`Primitive`] |
//! | a scene of solids, rays cast against it | [`Scene`], [`Ray`], [`Hit`] |
//! | a generated flat | [`Scene::furnished_room`], [`RoomParams`] |
//! | a depth camera and its noise | [`DepthCamera`], [`DepthNoise`] |
//! | scans under random poses | [`simulate`], [`SimParams`], [`SimulatedScans`] |
//! | relative poses of which some are wrong | [`simulate_pose_graph`], [`PoseGraphSimParams`] |
//! | how much scans share | [`overlap`], [`overlap_matrix`], [`overlapping_points`], [`overlap_components`] |
//!
//! Lengths are metres, angles radians. `world_from_scan` maps a scan's coordinates into the
//! world. Everything is drawn from seeded generators: the same parameters give the same bits.
//! Nothing here starts a thread.

mod building;
mod bvh;
mod camera;
mod components;
mod error;
mod furniture;
mod grid;
mod noise;
mod overlap;
mod pose_graph;
mod primitive;
mod random;
mod ray;
mod scene;
mod shape;
mod simulate;
mod thin;
mod tour;
mod view;

pub use building::RoomParams;
pub use camera::DepthCamera;
pub use components::overlap_components;
pub use error::Error;
pub use noise::DepthNoise;
pub use overlap::{overlap, overlap_matrix, overlapping_points};
pub use pose_graph::{
    EdgeWeights, Outliers, PoseGraphSimParams, SimulatedEdge, SimulatedPoseGraph, Topology,
    simulate_pose_graph,
};
pub use primitive::Primitive;
pub use ray::{Hit, Ray};
pub use scene::Scene;
pub use shape::Shape;
pub use simulate::{SimParams, SimulatedScans, simulate};
pub use thin::thin;
