use gmpcr_correspondence::{Descriptors, Scan};
use gmpcr_features::{self as features, Described, FPFH_DIMENSION, FeatureParams, describe};
use nalgebra::Point3;
use rayon::prelude::*;

use crate::Error;

/// Turns raw clouds into described scans: voxel grid, normals and FPFH of each, in parallel.
///
/// Each cloud is in its own frame with the sensor at `params.normals.viewpoint`, by default the
/// origin.
///
/// # Errors
/// [`Error::Features`] names the cloud and the reason: a coordinate that is not finite, or a
/// parameter out of range.
///
/// ```
/// use gmpcr::describe_clouds;
/// use gmpcr::features::FeatureParams;
/// use gmpcr::nalgebra::Point3;
///
/// let sheet = (0..900).map(|k| (k % 30, k / 30)).map(|(x, y)| {
///     let (x, y) = (f64::from(x) * 0.03, f64::from(y) * 0.03);
///     Point3::new(x, y, 1.0 + 0.1 * (7.0 * x).sin() * (5.0 * y).cos())
/// });
/// let scans = describe_clouds(&[sheet.collect()], &FeatureParams::from_voxel_size(0.05))?;
/// assert_eq!(scans[0].descriptors().dimension(), 33);
/// # Ok::<(), gmpcr::Error>(())
/// ```
pub fn describe_clouds(
    clouds: &[Vec<Point3<f64>>],
    params: &FeatureParams,
) -> Result<Vec<Scan>, Error> {
    clouds
        .par_iter()
        .enumerate()
        .map(|(cloud, points)| {
            describe_cloud(points, params).map_err(|source| Error::Features { cloud, source })
        })
        .collect()
}

/// Turns one raw cloud into a described scan: voxel grid, normals and FPFH, on the calling thread.
///
/// For clouds whose sensors stood in different places of their frames, or that do not all fit into
/// memory; else [`describe_clouds`].
///
/// # Errors
/// Those of [`features::describe`].
pub fn describe_cloud(
    points: &[Point3<f64>],
    params: &FeatureParams,
) -> Result<Scan, features::Error> {
    describe(points, params).map(into_scan)
}

fn into_scan(described: Described) -> Scan {
    let rows = described.descriptors.into_flattened();
    Descriptors::new(rows, FPFH_DIMENSION)
        .ok()
        .and_then(|descriptors| Scan::new(described.points, descriptors).ok())
        .expect("features are finite, one row per point")
}
