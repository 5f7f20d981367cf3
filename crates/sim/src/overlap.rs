//! How much two scans share.

use nalgebra::{DMatrix, Isometry3, Point3, Vector3, distance};

use crate::grid::Grid;
use crate::simulate::SimulatedScans;

/// Share of the points of one cloud that have a point of the other within `radius` after
/// alignment; the mean of both directions, between 0 and 1.
///
/// `i_from_j` maps cloud j into the frame of cloud i. Benchmarks of indoor scans count with a
/// radius of 1.5 voxels: 0.0375 m on clouds thinned to 2.5 cm. An empty cloud or a radius that
/// is not positive gives 0. Expected time is linear in the number of points.
///
/// ```
/// use gmpcr_sim::overlap;
/// use nalgebra::{Isometry3, Point3};
///
/// let i: Vec<_> = (0..10).map(|k| Point3::new(f64::from(k), 0.0, 0.0)).collect();
/// let i_from_j = Isometry3::translation(5.0, 0.0, 0.0);
/// assert_eq!(overlap(&i, &i, &i_from_j, 0.1), 0.5);
/// ```
#[must_use]
pub fn overlap(
    cloud_i: &[Point3<f64>],
    cloud_j: &[Point3<f64>],
    i_from_j: &Isometry3<f64>,
    radius: f64,
) -> f64 {
    if radius.is_nan() || radius <= 0.0 {
        return 0.0;
    }
    let (i, j) = (Indexed::new(cloud_i, radius), Indexed::new(cloud_j, radius));
    i.overlap(&j, i_from_j)
}

/// The points of cloud i, in its frame, that have a point of cloud j within `radius` after
/// alignment; none where the radius is not positive.
///
/// ```
/// use gmpcr_sim::overlapping_points;
/// use nalgebra::{Isometry3, Point3};
///
/// let i: Vec<_> = (0..10).map(|k| Point3::new(f64::from(k), 0.0, 0.0)).collect();
/// let i_from_j = Isometry3::translation(5.0, 0.0, 0.0);
/// assert_eq!(overlapping_points(&i, &i, &i_from_j, 0.1), i[5..]);
/// ```
#[must_use]
pub fn overlapping_points(
    cloud_i: &[Point3<f64>],
    cloud_j: &[Point3<f64>],
    i_from_j: &Isometry3<f64>,
    radius: f64,
) -> Vec<Point3<f64>> {
    if radius.is_nan() || radius <= 0.0 {
        return Vec::new();
    }
    let (i, j) = (Indexed::new(cloud_i, radius), Indexed::new(cloud_j, radius));
    i.shared_with(&j, &i_from_j.inverse()).copied().collect()
}

/// [`overlap`] of every pair of scans under their true poses: symmetric, with a unit diagonal.
///
/// Quadratic in the number of scans; thin the clouds first where there are hundreds.
#[must_use]
pub fn overlap_matrix(scans: &SimulatedScans, radius: f64) -> DMatrix<f64> {
    let size = scans.clouds.len().min(scans.world_from_scan.len());
    let mut matrix = DMatrix::identity(size, size);
    if radius.is_nan() || radius <= 0.0 {
        return matrix;
    }
    let indexed: Vec<Indexed> = scans
        .clouds
        .iter()
        .map(|cloud| Indexed::new(cloud, radius))
        .collect();
    for i in 0..size {
        for j in i + 1..size {
            let i_from_j = scans.world_from_scan[i].inv_mul(&scans.world_from_scan[j]);
            let shared = indexed[i].overlap(&indexed[j], &i_from_j);
            matrix[(i, j)] = shared;
            matrix[(j, i)] = shared;
        }
    }
    matrix
}

/// A cloud, the grid over it and a ball around it.
struct Indexed<'a> {
    cloud: &'a [Point3<f64>],
    grid: Grid,
    centre: Point3<f64>,
    reach: f64,
}

impl<'a> Indexed<'a> {
    fn new(cloud: &'a [Point3<f64>], radius: f64) -> Self {
        let sum: Vector3<f64> = cloud.iter().map(|point| point.coords).sum();
        let centre = Point3::from(sum / cloud.len().max(1) as f64);
        let farthest = cloud
            .iter()
            .map(|point| distance(point, &centre))
            .fold(0.0, f64::max);
        Self {
            cloud,
            grid: Grid::new(cloud, radius),
            centre,
            reach: farthest + radius,
        }
    }

    fn overlap(&self, other: &Self, self_from_other: &Isometry3<f64>) -> f64 {
        let apart = distance(&self.centre, &(self_from_other * other.centre));
        if apart > self.reach + other.reach {
            return 0.0;
        }
        let here = self.share_within(other, &self_from_other.inverse());
        let there = other.share_within(self, self_from_other);
        (here + there) / 2.0
    }

    fn share_within(&self, other: &Self, other_from_self: &Isometry3<f64>) -> f64 {
        let shared = self.shared_with(other, other_from_self).count();
        shared as f64 / self.cloud.len().max(1) as f64
    }

    fn shared_with<'b>(
        &'b self,
        other: &'b Self,
        other_from_self: &Isometry3<f64>,
    ) -> impl Iterator<Item = &'b Point3<f64>> {
        let rotation = other_from_self.rotation.to_rotation_matrix();
        let shift = other_from_self.translation;
        let is_shared =
            move |point: &&Point3<f64>| other.grid.reaches(&(shift * (rotation * *point)));
        self.cloud.iter().filter(is_shared)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Stream, generator, rigid_motion, uniform};

    fn cube(seed: u64, size: usize) -> Vec<Point3<f64>> {
        let mut rng = generator(seed, Stream::World);
        (0..size)
            .map(|_| Point3::from([(); 3].map(|()| uniform(&mut rng, 0.0, 1.0))))
            .collect()
    }

    #[test]
    fn a_cloud_overlaps_its_moved_copy_entirely_under_the_true_motion() {
        let cloud = cube(1, 500);
        let i_from_j = rigid_motion(&mut generator(2, Stream::World), 3.0);
        let copy: Vec<_> = cloud
            .iter()
            .map(|p| i_from_j.inverse_transform_point(p))
            .collect();
        assert_eq!(overlap(&cloud, &copy, &i_from_j, 1e-6), 1.0);
        assert!(overlap(&cloud, &copy, &Isometry3::identity(), 1e-6) < 0.1);
    }

    #[test]
    fn swapping_the_clouds_and_inverting_the_motion_changes_nothing() {
        let (i, j) = (cube(1, 400), cube(2, 300));
        let i_from_j = Isometry3::translation(0.4, 0.1, 0.0);
        let forth = overlap(&i, &j, &i_from_j, 0.1);
        let back = overlap(&j, &i, &i_from_j.inverse(), 0.1);
        assert!(forth > 0.1 && forth < 0.9);
        assert_eq!(forth, back);
    }

    #[test]
    fn nothing_overlaps_an_empty_cloud_or_within_no_radius() {
        let cloud = cube(1, 10);
        let here = Isometry3::identity();
        assert_eq!(overlap(&cloud, &[], &here, 0.1), 0.0);
        assert_eq!(overlap(&[], &[], &here, 0.1), 0.0);
        assert_eq!(overlap(&cloud, &cloud, &here, 0.0), 0.0);
        assert_eq!(overlap(&cloud, &cloud, &here, f64::NAN), 0.0);
    }
}
