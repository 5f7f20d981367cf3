//! What a user can choose, with the defaults of the field.

use crate::{InvalidParameter, check};
use nalgebra::Point3;

/// Neighborhood and orientation of [`estimate_normals`](crate::estimate_normals).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct NormalParams {
    /// Only points closer than this are fitted, in the unit of the cloud; from 1e-100 to 1e100.
    /// Default 0.10 (two voxels of 5 cm, in meters).
    pub radius: f64,
    /// Fit at most this many of the nearest points, the point itself among them; at least 1.
    /// Default 30.
    pub max_neighbors: usize,
    /// Normals point to the side of the surface on which this point lies, in the frame of the
    /// cloud; coordinates from -1e100 to 1e100. Default the origin, where the sensor of a scan usually is.
    pub viewpoint: Point3<f64>,
}

/// Neighborhood of [`fpfh`](crate::fpfh).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct FpfhParams {
    /// Only points closer than this are compared, in the unit of the cloud; from 1e-100 to
    /// 1e100. Default 0.25 (five voxels of 5 cm, in meters).
    pub radius: f64,
    /// Compare at most this many of the nearest points, the point itself among them; at least 1.
    /// Default 100.
    pub max_neighbors: usize,
}

/// Everything [`compute_features`](crate::compute_features) needs to know.
///
/// All lengths are independent of each other: another `voxel_size` leaves the radii as they are, also in a
/// file that gives no radii. [`from_voxel_size`](Self::from_voxel_size) derives them.
///
/// ```
/// use gmpcr_features::{FeatureParams, NormalParams};
/// use nalgebra::Point3;
///
/// let params = FeatureParams::from_voxel_size(0.05);
/// assert_eq!(params, FeatureParams::default());
/// assert_eq!((params.normals.radius, params.fpfh.radius), (0.10, 0.25));
///
/// // The sensor stood two meters above the origin of the scan.
/// let viewpoint = Point3::new(0.0, 0.0, 2.0);
/// let normals = NormalParams { viewpoint, ..params.normals };
/// let params = FeatureParams { normals, ..params };
/// # assert_eq!(params.normals.radius, 0.10);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct FeatureParams {
    /// Edge of the cubes of which each keeps one point, in the unit of the cloud; from 1e-100 to
    /// 1e100. Default 0.05 (meters).
    pub voxel_size: f64,
    /// Normals, fitted to the downsampled cloud.
    pub normals: NormalParams,
    /// Descriptors of the downsampled cloud.
    pub fpfh: FpfhParams,
}

impl FeatureParams {
    /// The customary radii for a cloud with one point per voxel: two voxels for normals, five for
    /// descriptors, with at most 30 and 100 neighbors.
    ///
    /// Five centimeters suit rooms scanned by depth cameras, as in the 3DMatch benchmark.
    #[must_use]
    pub fn from_voxel_size(voxel_size: f64) -> Self {
        Self {
            voxel_size,
            normals: NormalParams {
                radius: 2.0 * voxel_size,
                max_neighbors: 30,
                viewpoint: Point3::origin(),
            },
            fpfh: FpfhParams {
                radius: 5.0 * voxel_size,
                max_neighbors: 100,
            },
        }
    }

    /// Checks that every parameter is in its range.
    ///
    /// # Errors
    /// [`InvalidParameter`] names the first that is not, such as `normals.radius`.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        let Self {
            voxel_size,
            normals,
            fpfh,
        } = self;
        check::length("voxel_size", *voxel_size)?;
        normals
            .validate()
            .map_err(|error| error.within("normals"))?;
        fpfh.validate().map_err(|error| error.within("fpfh"))
    }
}

impl Default for FeatureParams {
    fn default() -> Self {
        Self::from_voxel_size(0.05)
    }
}

impl NormalParams {
    /// Checks that every parameter is in its range.
    ///
    /// # Errors
    /// [`InvalidParameter`] names the first that is not, such as `viewpoint.x`.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        let Self {
            radius,
            max_neighbors,
            viewpoint,
        } = self;
        check::length("radius", *radius)?;
        check::count("max_neighbors", *max_neighbors)?;
        check::viewpoint(viewpoint)
    }
}

impl Default for NormalParams {
    fn default() -> Self {
        FeatureParams::default().normals
    }
}

impl FpfhParams {
    /// Checks that every parameter is in its range.
    ///
    /// # Errors
    /// [`InvalidParameter`] names the first that is not.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        let Self {
            radius,
            max_neighbors,
        } = self;
        check::length("radius", *radius)?;
        check::count("max_neighbors", *max_neighbors)
    }
}

impl Default for FpfhParams {
    fn default() -> Self {
        FeatureParams::default().fpfh
    }
}
