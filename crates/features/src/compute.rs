//! The three steps on one search tree.

use crate::fpfh::fpfh_of;
use crate::neighbors::{Neighborhoods, Search};
use crate::normals::normal_at;
use crate::{Error, FeatureParams, Fpfh, NormalParams, estimate_normals, voxel_grid};
use nalgebra::{Point3, Vector3};

/// A downsampled cloud with a normal and a descriptor for each point; all three of one length.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Features {
    /// One point per occupied voxel, in the frame and unit of the cloud.
    pub points: Vec<Point3<f64>>,
    /// Unit normals, towards the viewpoint.
    pub normals: Vec<Vector3<f64>>,
    /// Fast point feature histograms.
    #[cfg_attr(feature = "serde", serde(with = "crate::fpfh_rows"))]
    pub descriptors: Vec<Fpfh>,
}

/// Downsamples a cloud, and estimates the normal and computes the descriptor of every point that is left.
///
/// Gives the same bits as [`voxel_grid`], [`estimate_normals`] and [`fpfh`](crate::fpfh) one after
/// the other, but searches neighbors once, if the descriptors reach at least as far as the
/// normals in radius and number.
///
/// # Errors
/// Those of the three steps; all parameters are checked before the work begins. An empty cloud
/// has no features.
///
/// ```
/// use gmpcr_features::{Error, FeatureParams, compute_features};
/// use nalgebra::Point3;
///
/// let cloud = [Point3::new(0.0, 0.0, 1.0), Point3::new(0.0, f64::NAN, 1.0)];
/// let params = FeatureParams::default();
/// assert_eq!(compute_features(&cloud[..1], &params)?.points.len(), 1);
/// assert!(matches!(compute_features(&cloud, &params), Err(Error::Coordinate { index: 1, .. })));
/// # Ok::<(), Error>(())
/// ```
pub fn compute_features(points: &[Point3<f64>], params: &FeatureParams) -> Result<Features, Error> {
    params.validate()?;
    let points = voxel_grid(points, params.voxel_size)?;
    if points.is_empty() {
        return Ok(Features::default());
    }
    let neighborhoods = Search::new(&points)?.everywhere(params.fpfh.reach());
    let normals = if params.fpfh.reach().covers(&params.normals.reach()) {
        normals_of(&points, &neighborhoods, &params.normals)
    } else {
        estimate_normals(&points, &params.normals)?
    };
    let descriptors = fpfh_of(&points, &normals, &neighborhoods);
    Ok(Features {
        points,
        normals,
        descriptors,
    })
}

/// Normals of all points, given neighborhoods that reach at least as far as `params`.
fn normals_of(
    points: &[Point3<f64>],
    neighborhoods: &Neighborhoods,
    params: &NormalParams,
) -> Vec<Vector3<f64>> {
    let reach = params.reach();
    let normal =
        |(center, neighbors)| normal_at(points, center, reach.of(neighbors), &params.viewpoint);
    neighborhoods.iter().enumerate().map(normal).collect()
}
