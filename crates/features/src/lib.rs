//! From a raw point cloud to normals and descriptors.
//!
//! Two scans of one place have no points in common, only surfaces. To find again in one scan what the
//! other saw, each point needs a description of the surface around it that does not depend on
//! where the sensor stood. This crate computes one in three steps, each usable alone:
//!
//! | step | function | result |
//! |---|---|---|
//! | downsample the cloud to an even density | [`voxel_grid`] | the mean point of every occupied voxel |
//! | fit a plane around every point | [`estimate_normals`] | unit normals that face the sensor |
//! | count how the normals around a point differ | [`fpfh`] | fast point feature histograms, 33 numbers |
//!
//! [`compute_features`] does all three with one neighbor search. Lengths, radii and voxel sizes are in
//! the unit of the input; the defaults of [`FeatureParams`] are for rooms measured in meters. For
//! other data the cloud itself suggests them:
//!
//! | length | function | result |
//! |---|---|---|
//! | voxel size, from which [`FeatureParams::from_voxel_size`] derives all radii | [`estimate_voxel_size`] | the size at which about 4000 voxels hold points |
//! | one voxel size for several clouds | [`common_voxel_size`] | the median of their estimates |
//! | spacing of the points | [`estimate_resolution`] | the median distance to the nearest other point |
//!
//! Raw clouds may need some conditioning before:
//!
//! | trouble | function | result |
//! |---|---|---|
//! | points that a sensor wrote where nothing returned | [`remove_stray_points`] | the cloud without points far from its median point |
//! | georeferenced coordinates, of many digits | [`localize_georeferenced`] | [`LocalCloud`]s with an origin of their own, if most are remote from zero |
//!
//! The conventions are those of Open3D, so that on the same points normals and descriptors agree
//! with it up to rounding; where a cloud leaves the result open, the documentation of the
//! function says what is returned. Every function is sequential and a pure function of its
//! arguments: equal input gives equal bits. To use several cores, compute the features of several
//! clouds at a time.
//!
//! ```
//! use gmpcr_features::{FeatureParams, compute_features};
//! use nalgebra::Point3;
//!
//! // A sheet of 60 cm x 60 cm, one meter in front of the sensor, a point every centimeter.
//! let cloud: Vec<_> = (0..3600)
//!     .map(|k| Point3::new((k % 60) as f64 * 0.01, (k / 60) as f64 * 0.01, 1.0))
//!     .collect();
//!
//! let features = compute_features(&cloud, &FeatureParams::from_voxel_size(0.05))?;
//!
//! assert_eq!(features.points.len(), features.descriptors.len());
//! assert!(features.normals.iter().all(|normal| (normal.z + 1.0).abs() < 1e-12));
//! # Ok::<(), gmpcr_features::Error>(())
//! ```

mod check;
mod compute;
mod error;
mod estimate;
mod fpfh;
#[cfg(feature = "serde")]
mod fpfh_rows;
mod local_cloud;
mod middle;
mod neighbors;
mod normals;
mod pair;
mod params;
mod strays;
mod voxel;

pub use compute::{Features, compute_features};
pub use error::Error;
pub use estimate::{common_voxel_size, estimate_resolution, estimate_voxel_size};
pub use fpfh::{FPFH_DIMENSION, Fpfh, fpfh};
pub use gmpcr_geometry::InvalidParameter;
pub use local_cloud::{LocalCloud, localize_georeferenced};
pub use middle::extent;
pub use normals::estimate_normals;
pub use params::{FeatureParams, FpfhParams, NormalParams};
pub use strays::remove_stray_points;
pub use voxel::voxel_grid;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
