//! The three steps on one search tree.

use crate::fpfh::fpfh_of;
use crate::neighbors::{Neighborhoods, Search};
use crate::normals::normal_at;
use crate::{Error, FeatureParams, Fpfh, NormalParams, estimate_normals, voxel_grid};
use nalgebra::{Point3, Vector3};

/// A thinned cloud with a normal and a descriptor for each point; all three of one length.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Described {
    /// One point per occupied voxel, in the frame and unit of the cloud.
    pub points: Vec<Point3<f64>>,
    /// Unit normals, towards the viewpoint.
    pub normals: Vec<Vector3<f64>>,
    /// Fast point feature histograms.
    pub descriptors: Vec<Fpfh>,
}

/// Thins a cloud, estimates normals and describes every point that is left.
///
/// Gives the same bits as [`voxel_grid`], [`estimate_normals`] and [`fpfh`](crate::fpfh) one after
/// the other, but searches neighbors once, if the descriptors reach at least as far as the
/// normals in radius and number.
///
/// # Errors
/// Those of the three steps; all parameters are checked before the work begins. An empty cloud is
/// described by nothing.
///
/// ```
/// use gmpcr_features::{Error, FeatureParams, describe};
/// use nalgebra::Point3;
///
/// let cloud = [Point3::new(0.0, 0.0, 1.0), Point3::new(0.0, f64::NAN, 1.0)];
/// let params = FeatureParams::default();
/// assert_eq!(describe(&cloud[..1], &params)?.points.len(), 1);
/// assert!(matches!(describe(&cloud, &params), Err(Error::Coordinate { index: 1, .. })));
/// # Ok::<(), Error>(())
/// ```
pub fn describe(points: &[Point3<f64>], params: &FeatureParams) -> Result<Described, Error> {
    params.check()?;
    let points = voxel_grid(points, params.voxel_size)?;
    if points.is_empty() {
        return Ok(Described::default());
    }
    let neighborhoods = Search::new(&points)?.everywhere(params.fpfh.reach());
    let normals = if params.fpfh.reach().covers(&params.normals.reach()) {
        normals_of(&points, &neighborhoods, &params.normals)
    } else {
        estimate_normals(&points, &params.normals)?
    };
    let descriptors = fpfh_of(&points, &normals, &neighborhoods);
    Ok(Described {
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
