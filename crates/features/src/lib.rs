//! From a raw point cloud to described keypoints.
//!
//! Two scans of one place share no points, only surfaces. To find again in one scan what the
//! other saw, each point needs a description of the surface around it that does not depend on
//! where the sensor stood. This crate computes one in three steps, each usable alone:
//!
//! | step | function | result |
//! |---|---|---|
//! | thin the cloud to an even density | [`voxel_grid`] | the mean point of every occupied voxel |
//! | fit a plane around every point | [`estimate_normals`] | unit normals that face the sensor |
//! | describe how the normals around a point turn | [`fpfh`] | fast point feature histograms, 33 numbers |
//!
//! [`describe`] does all three with one neighbor search. Lengths, radii and voxel sizes are in
//! the unit of the input; the defaults of [`FeatureParams`] are for rooms measured in meters. For
//! other data the cloud itself suggests them:
//!
//! | length | function | result |
//! |---|---|---|
//! | working voxel, from which [`FeatureParams::from_voxel_size`] derives all radii | [`estimate_voxel_size`] | the size at which about 4000 voxels hold points |
//! | spacing of the points | [`estimate_resolution`] | the median distance to the nearest other point |
//!
//! The conventions are those of Open3D, so that on the same points normals and descriptors agree
//! with it up to rounding; where a cloud leaves the result open, the documentation of the
//! function says what is returned. Every function is sequential and a pure function of its
//! arguments: equal input gives equal bits. To use several cores, describe several clouds at a
//! time.
//!
//! ```
//! use gmpcr_features::{FeatureParams, describe};
//! use nalgebra::Point3;
//!
//! // A sheet of 60 cm x 60 cm, one meter in front of the sensor, a point every centimetre.
//! let cloud: Vec<_> = (0..3600)
//!     .map(|k| Point3::new((k % 60) as f64 * 0.01, (k / 60) as f64 * 0.01, 1.0))
//!     .collect();
//!
//! let described = describe(&cloud, &FeatureParams::from_voxel_size(0.05))?;
//!
//! assert_eq!(described.points.len(), described.descriptors.len());
//! assert!(described.normals.iter().all(|normal| (normal.z + 1.0).abs() < 1e-12));
//! # Ok::<(), gmpcr_features::Error>(())
//! ```

mod check;
mod describe;
mod error;
mod estimate;
mod fpfh;
mod neighbors;
mod normals;
mod pair;
mod params;
mod voxel;

pub use describe::{Described, describe};
pub use error::Error;
pub use estimate::{estimate_resolution, estimate_voxel_size};
pub use fpfh::{FPFH_DIMENSION, Fpfh, fpfh};
pub use normals::estimate_normals;
pub use params::{FeatureParams, FpfhParams, NormalParams};
pub use voxel::voxel_grid;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
