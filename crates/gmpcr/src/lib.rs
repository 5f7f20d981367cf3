//! Spectral consistency-guided multiview registration of point clouds: many partially overlapping
//! scans in, one consistent pose per scan out, also where scans share only 10–30 % of their surface.
//!
//! ```text
//! scans ── N_s keypoints each, farthest first in descriptor space
//!   └─ every pair: mutual matches → compatibility graphs → dominant eigenvector
//!        → spectral filter → confidence                      (no pose yet)
//!        └─ union of each scan's K most confident pairs      (the edges)
//!             └─ every edge: maximal cliques → weighted Kabsch → inlier ratio
//!                  └─ history-aware synchronisation          → poses
//! ```
//!
//! [`register`] runs all of it, [`register_pair`] the part that concerns two scans, and
//! `describe_clouds` (feature `features`, on by default) makes [`Scan`]s of raw clouds. Any other
//! descriptor serves as well: a [`Scan`] is points plus `f32` rows.
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
//! The result carries its evidence: per edge the confidence, inlier ratio, weights and residuals,
//! per scan the component whose frame its pose is in. Scans that overlap with no other stay in
//! components of their own instead of being forced into place.
//!
//! Where scans come one by one, a [`Registry`] keeps what is known of the earlier ones.
//!
//! A program with a progress bar, or one that can be told to stop, calls [`register_observed`].
//!
//! Scans and pairs are processed in parallel on the current [rayon] pool; the same input gives the
//! same bits with any number of threads.
//!
//! Each stage is a crate of its own, re-exported here: [`correspondence`], [`retrieval`],
//! [`compatibility`], [`posegraph`], [`cliques`], [`sync`], [`geometry`], and `features`.

#[cfg(feature = "features")]
mod describe;
mod error;
mod observer;
mod pair;
mod params;
mod preset;
mod register;
mod registration;
mod registry;

#[cfg(feature = "features")]
pub use describe::{describe_cloud, describe_clouds};
pub use error::Error;
pub use gmpcr_correspondence::{Descriptors, Scan};
pub use observer::{Observer, Stage};
pub use pair::{PairRegistration, register_pair};
pub use params::Params;
pub use preset::{Preset, UnknownPreset};
pub use register::{register, register_observed};
pub use registration::{EdgeEvidence, Registration, StageTimes, UnresolvedPair};
pub use registry::Registry;

pub use gmpcr_cliques as cliques;
pub use gmpcr_compatibility as compatibility;
pub use gmpcr_correspondence as correspondence;
#[cfg(feature = "features")]
pub use gmpcr_features as features;
pub use gmpcr_geometry as geometry;
pub use gmpcr_posegraph as posegraph;
pub use gmpcr_retrieval as retrieval;
pub use gmpcr_sync as sync;
pub use nalgebra;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
