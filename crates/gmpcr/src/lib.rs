//! GMPCR, spectral consistency-Guided Multiview Point Cloud Registration: many overlapping scans in, one
//! consistent pose per scan out, also where scans share only 10–30 % of their surface.
//!
//! | you have | call |
//! |---|---|
//! | two scans | [`register_pair`] |
//! | many scans | [`register`] |
//! | raw clouds | `compute_features` (feature `fpfh`, on by default), then [`register`] |
//! | your own matches of two scans | [`register_correspondences`] |
//! | your own matches of many pairs | [`register_matches`] |
//! | a pose graph | [`sync::synchronize`] |
//! | scans that come one by one, and leave | [`IncrementalRegistration`] |
//! | a progress bar, or a stop button | an [`Observer`], for [`register_observed`] and the others |
//!
//! ```
//! use gmpcr::nalgebra::{Isometry3, Point3, Vector3};
//! use gmpcr::{Descriptors, Params, Scan, register};
//!
//! // One surface seen from three places; here the descriptors tell the points apart.
//! let world: Vec<Point3<f64>> = (0..60)
//!     .map(|k| k as f64)
//!     .map(|k| Point3::new(k.sin() * 2.0, (k * 1.7).cos() * 2.0, (k * 0.9).sin()))
//!     .collect();
//! let world_from_scan = [0.0, 0.4, 0.9].map(|a| Isometry3::new(Vector3::x() * a, Vector3::z() * a));
//! let scans = world_from_scan.map(|pose| {
//!     let points = world.iter().map(|p| pose.inverse_transform_point(p)).collect();
//!     let rows = (0..60).flat_map(|k| [(k as f32).sin(), (k as f32).cos()]).collect();
//!     Scan::new(points, Descriptors::new(rows, 2).unwrap()).unwrap()
//! });
//!
//! let registration = register(&scans, &Params::threedmatch())?;
//! assert!(registration.connectivity.is_connected);
//! let error = registration.world_from_scan[2].inverse() * world_from_scan[2];
//! assert!(error.translation.vector.norm() < 1e-9 && error.rotation.angle() < 1e-9);
//! # Ok::<(), gmpcr::Error>(())
//! ```
//!
//! The method is that of T. Li, Y. Lin, S. Zhou, K. Yang, J. Zhang, L. Fang, W. Yao, *Spectral Consistency-Guided
//! Multiview Point Cloud Registration for Low-Overlap Scenes*, 2026 ("the paper" in all crates):
//!
//! ```text
//! scans ── N_s keypoints each, farthest first in descriptor space
//!   └─ every pair: mutual matches → compatibility graphs → dominant eigenvector
//!        → spectral filter → confidence                      (no pose yet)
//!        └─ union of each scan's K most confident pairs      (the edges)
//!             └─ every edge: maximal cliques → weighted Kabsch → inlier ratio
//!                  └─ history-aware synchronization          → poses
//! ```
//!
//! A [`Registration`] carries its support and diagnostics: per edge the confidence, inlier ratio, weights and
//! residuals, per scan the component whose frame its pose is in, and [warnings](Registration::warnings) of what
//! a person should check. Scans that overlap with no other stay in components of their own.
//!
//! Scans and pairs are processed in parallel on the current [rayon] pool; the same input gives the
//! same bits with any number of threads.
//!
//! Each stage is a crate of its own, re-exported here: [`correspondence`], [`retrieval`],
//! [`compatibility`], [`posegraph`], [`cliques`], [`sync`], [`geometry`], and `features`. Cargo features:
//! `fpfh` (on by default) makes scans of raw clouds, `io` reads and writes files of clouds, poses and pose
//! graphs, `serde` makes results and parameters serializable.

#[cfg(feature = "fpfh")]
mod cloud;
mod connections;
mod edge;
mod error;
mod incremental;
mod known_pairs;
mod limits;
mod pair;
mod params;
mod pipeline;
#[cfg(feature = "io")]
mod posed_graph;
mod preset;
mod progress;
mod register;
mod registration;
mod scan_id;
#[cfg(feature = "fpfh")]
mod scan_set;
mod selected_pair;
mod source;
mod stage;
#[cfg(feature = "serde")]
mod unchecked;
mod warning;
mod warnings;

#[cfg(feature = "fpfh")]
pub use cloud::Cloud;
pub use edge::{Edge, UnresolvedPair};
pub use error::Error;
pub use gmpcr_correspondence::{Descriptors, Scan};
pub use incremental::IncrementalRegistration;
pub use limits::MAX_CORRESPONDENCES;
pub use pair::{PairRegistration, register_correspondences, register_pair};
pub use params::Params;
pub use preset::{Preset, UnknownPreset};
pub use progress::Observer;
pub use register::{register, register_matches, register_matches_observed, register_observed};
pub use registration::Registration;
pub use scan_id::ScanId;
#[cfg(feature = "fpfh")]
pub use scan_set::{ScanSet, VoxelSize, compute_features, compute_features_with, compute_scan};
pub use stage::{Stage, StageTimes};
pub use warning::Warning;

pub use gmpcr_cliques as cliques;
pub use gmpcr_compatibility as compatibility;
pub use gmpcr_correspondence as correspondence;
#[cfg(feature = "fpfh")]
pub use gmpcr_features as features;
pub use gmpcr_geometry as geometry;
#[cfg(feature = "io")]
pub use gmpcr_io as io;
pub use gmpcr_posegraph as posegraph;
pub use gmpcr_retrieval as retrieval;
pub use gmpcr_sync as sync;
pub use nalgebra;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
