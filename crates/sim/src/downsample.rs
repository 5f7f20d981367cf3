//! One point per voxel.

use nalgebra::{Point3, Vector3};

/// Integer coordinates of a voxel.
type Voxel = [i32; 3];

/// The voxel of edge length `size` that holds `point`.
fn voxel_of(point: &Point3<f64>, size: f64) -> Voxel {
    [point.x, point.y, point.z].map(|x| (x / size).floor() as i32)
}

/// Replaces the points in each cubic voxel of edge length `voxel` by their mean, in the order of
/// the voxels. A voxel size that is not positive leaves the cloud as it is.
pub(crate) fn downsample(cloud: &[Point3<f64>], voxel: f64) -> Vec<Point3<f64>> {
    if voxel.is_nan() || voxel <= 0.0 {
        return cloud.to_vec();
    }
    let mut keyed: Vec<(Voxel, &Point3<f64>)> = cloud
        .iter()
        .map(|point| (voxel_of(point, voxel), point))
        .collect();
    keyed.sort_by_key(|(voxel, _)| *voxel);
    keyed.chunk_by(|a, b| a.0 == b.0).map(mean).collect()
}

fn mean(group: &[(Voxel, &Point3<f64>)]) -> Point3<f64> {
    let sum: Vector3<f64> = group.iter().map(|(_, point)| point.coords).sum();
    Point3::from(sum / group.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_points_of_a_voxel_become_their_mean() {
        let cloud = [0.1, 0.3, 5.5].map(|x| Point3::new(x, 0.0, 0.0));
        let expected = [0.2, 5.5].map(|x| Point3::new(x, 0.0, 0.0));
        assert_eq!(downsample(&cloud, 1.0), expected);
    }

    #[test]
    fn an_empty_cloud_stays_empty_and_a_zero_voxel_changes_nothing() {
        let cloud = [Point3::new(1.0, 2.0, 3.0); 2];
        assert!(downsample(&[], 0.1).is_empty());
        assert_eq!(downsample(&cloud, 0.0), cloud);
        assert_eq!(downsample(&cloud, f64::NAN), cloud);
        assert_eq!(downsample(&cloud, 0.1), cloud[..1]);
    }
}
