//! One point per voxel.

use nalgebra::{Point3, Vector3};

use crate::grid::{Cell, cell_of};

/// Replaces the points in each cubic voxel of edge length `voxel` by their mean, in the order of
/// the voxels. A voxel size that is not positive leaves the cloud as it is.
///
/// ```
/// use gmpcr_sim::thin;
/// use nalgebra::Point3;
///
/// let cloud = [Point3::new(0.1, 0.0, 0.0), Point3::new(0.3, 0.0, 0.0), Point3::new(5.5, 0.0, 0.0)];
/// assert_eq!(thin(&cloud, 1.0), [Point3::new(0.2, 0.0, 0.0), Point3::new(5.5, 0.0, 0.0)]);
/// ```
#[must_use]
pub fn thin(cloud: &[Point3<f64>], voxel: f64) -> Vec<Point3<f64>> {
    if voxel.is_nan() || voxel <= 0.0 {
        return cloud.to_vec();
    }
    let mut keyed: Vec<(Cell, &Point3<f64>)> = cloud
        .iter()
        .map(|point| (cell_of(point, voxel), point))
        .collect();
    keyed.sort_by_key(|(cell, _)| *cell);
    keyed.chunk_by(|a, b| a.0 == b.0).map(mean).collect()
}

fn mean(group: &[(Cell, &Point3<f64>)]) -> Point3<f64> {
    let sum: Vector3<f64> = group.iter().map(|(_, point)| point.coords).sum();
    Point3::from(sum / group.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_cloud_stays_empty_and_a_zero_voxel_changes_nothing() {
        let cloud = [Point3::new(1.0, 2.0, 3.0); 2];
        assert!(thin(&[], 0.1).is_empty());
        assert_eq!(thin(&cloud, 0.0), cloud);
        assert_eq!(thin(&cloud, f64::NAN), cloud);
        assert_eq!(thin(&cloud, 0.1), cloud[..1]);
    }
}
