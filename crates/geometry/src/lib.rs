//! The small rigid geometry that the gmpcr crates share.
//!
//! A rigid transformation that maps the coordinates of frame `j` into frame `i` is called `i_from_j`:
//!
//! ```text
//! x_i = i_from_j * x_j = R_ij x_j + t_ij,     world_from_j = world_from_i * i_from_j
//! ```
//!
//! Adjacent frame names match, so a mistaken composition shows. Transformations are
//! [`nalgebra::Isometry3<f64>`], angles are radians, and lengths keep the unit of the input.
//!
//! - [`PointPairs`]: corresponding points of two scans, finite and of equal number.
//! - [`SignedSvd3`] and [`nearest_rotation`]: projection of a 3×3 matrix onto SO(3).
//! - [`rotation_angle`] and [`angular_distance`]: exact from 0 to 180°.
//! - [`isometry`]: a transformation from its rotation and translation.
//! - [`InvalidParameter`]: what the parameter checks of all crates return.
//! - [`is_usable`] and [`MAX_COORDINATE`]: which coordinates all crates accept.
//! - `matrix_rows` (feature `serde`): transformations in files.
//!
//! ```
//! use gmpcr_geometry::{angular_distance, nearest_rotation};
//! use nalgebra::{Rotation3, Vector3};
//!
//! let rotation = Rotation3::new(Vector3::new(0.3, -0.2, 0.9));
//! let scaled = rotation.matrix() * 7.0;
//! assert!(angular_distance(&nearest_rotation(&scaled), &rotation) < 1e-14);
//! ```

#[cfg(feature = "serde")]
pub mod matrix_rows;
mod pairs;
mod parameter;
mod rotation;
mod svd;

pub use pairs::{MAX_COORDINATE, PairsError, PointPairs, is_usable};
pub use parameter::InvalidParameter;
pub use rotation::{angular_distance, isometry, nearest_rotation, rotation_angle};
pub use svd::SignedSvd3;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
