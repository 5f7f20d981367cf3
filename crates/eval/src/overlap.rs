//! How much the points of two scans overlap.

use nalgebra::{DMatrix, Isometry3, Point3, Vector3, distance};

use crate::error::{Error, check_length};
use crate::grid::Grid;

/// Points of a scan, prepared to count those that lie near the points of other scans.
///
/// A point overlaps another scan if it lies within a radius of one of that scan's points once both are
/// aligned. Benchmarks of indoor scans count with a radius of 1.5 voxels, which is 0.0375 m on clouds
/// downsampled to 2.5 cm.
///
/// The index holds a grid over the points and a ball around them, so that one index serves all pairs of
/// its scan. `O(n log n)` for n points.
///
/// ```
/// use gmpcr_eval::OverlapIndex;
/// use nalgebra::{Isometry3, Point3};
///
/// let points: Vec<_> = (0..10).map(|k| Point3::new(f64::from(k), 0.0, 0.0)).collect();
/// let [i, j] = [&points, &points].map(|points| OverlapIndex::new(points, 0.1));
/// let i_from_j = Isometry3::translation(5.0, 0.0, 0.0);
/// assert_eq!(i.overlap(&j, &i_from_j), 0.5);
/// assert_eq!(i.overlapping_points(&j, &i_from_j), points[5..]);
/// ```
#[derive(Debug, Clone)]
pub struct OverlapIndex<'a> {
    points: &'a [Point3<f64>],
    grid: Grid,
    center: Point3<f64>,
    /// Radius of a ball around the center that holds every place within the radius of a point.
    reach: f64,
}

impl<'a> OverlapIndex<'a> {
    /// An index of the points of a scan, in the scan's frame, for overlaps within `radius`, in the unit of
    /// the points. No point lies within a radius that is not positive.
    #[must_use]
    pub fn new(points: &'a [Point3<f64>], radius: f64) -> Self {
        let sum: Vector3<f64> = points.iter().map(|point| point.coords).sum();
        let center = Point3::from(sum / points.len().max(1) as f64);
        let farthest = points
            .iter()
            .map(|point| distance(point, &center))
            .fold(0.0, f64::max);
        Self {
            points,
            grid: Grid::new(points, radius),
            center,
            reach: farthest + radius,
        }
    }

    /// Overlap of two scans: the fraction of the points of each that overlap the other, averaged over both
    /// directions; between 0 and 1.
    ///
    /// `i_from_j` maps the points of `other`, scan j, into the frame of this scan i. Use the same radius for
    /// both; otherwise the points of each scan are counted within the radius of the other. A scan without
    /// points overlaps nothing. Expected time is linear in the number of points.
    #[must_use]
    pub fn overlap(&self, other: &OverlapIndex<'_>, i_from_j: &Isometry3<f64>) -> f64 {
        let separation = distance(&self.center, &(i_from_j * other.center));
        if separation > self.reach + other.reach {
            return 0.0;
        }
        let here = self.overlapping_fraction(other, &i_from_j.inverse());
        let there = other.overlapping_fraction(self, i_from_j);
        (here + there) / 2.0
    }

    /// The points of this scan i, in its frame, that overlap `other`, scan j: what
    /// the information matrix of a pair of the 3DMatch benchmark sums over.
    #[must_use]
    pub fn overlapping_points(
        &self,
        other: &OverlapIndex<'_>,
        i_from_j: &Isometry3<f64>,
    ) -> Vec<Point3<f64>> {
        self.near(other, &i_from_j.inverse()).copied().collect()
    }

    fn overlapping_fraction(
        &self,
        other: &OverlapIndex<'_>,
        other_from_self: &Isometry3<f64>,
    ) -> f64 {
        let count = self.near(other, other_from_self).count();
        count as f64 / self.points.len().max(1) as f64
    }

    fn near(
        &self,
        other: &OverlapIndex<'_>,
        other_from_self: &Isometry3<f64>,
    ) -> impl Iterator<Item = &'a Point3<f64>> {
        let rotation = other_from_self.rotation.to_rotation_matrix();
        let translation = other_from_self.translation;
        let is_near =
            move |point: &&Point3<f64>| other.grid.reaches(&(translation * (rotation * *point)));
        self.points.iter().filter(is_near)
    }
}

/// [`OverlapIndex::overlap`] of every pair of scans under their poses: symmetric, with a unit diagonal.
///
/// `clouds` holds the points of each scan in its own frame. Quadratic in the number of scans.
///
/// # Errors
/// [`Error::LengthMismatch`] unless there is one pose per cloud.
///
/// ```
/// use gmpcr_eval::overlap_matrix;
/// use nalgebra::{Isometry3, Point3};
///
/// let cloud: Vec<_> = (0..10).map(|k| Point3::new(f64::from(k), 0.0, 0.0)).collect();
/// let world_from_scan = [0.0, 4.0, 8.0].map(|x| Isometry3::translation(x, 0.0, 0.0));
/// let overlap = overlap_matrix(&[cloud.clone(), cloud.clone(), cloud], &world_from_scan, 0.1)?;
/// assert_eq!((overlap[(0, 1)], overlap[(2, 0)], overlap[(2, 2)]), (0.6, 0.2, 1.0));
/// # Ok::<(), gmpcr_eval::Error>(())
/// ```
pub fn overlap_matrix(
    clouds: &[Vec<Point3<f64>>],
    world_from_scan: &[Isometry3<f64>],
    radius: f64,
) -> Result<DMatrix<f64>, Error> {
    check_length("poses", clouds.len(), world_from_scan.len())?;
    let size = clouds.len();
    let indices: Vec<_> = clouds
        .iter()
        .map(|cloud| OverlapIndex::new(cloud, radius))
        .collect();
    let mut matrix = DMatrix::identity(size, size);
    for i in 0..size {
        for j in i + 1..size {
            let i_from_j = world_from_scan[i].inv_mul(&world_from_scan[j]);
            let overlap = indices[i].overlap(&indices[j], &i_from_j);
            matrix[(i, j)] = overlap;
            matrix[(j, i)] = overlap;
        }
    }
    Ok(matrix)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points scattered over the unit cube; another salt gives others.
    fn cube(salt: usize, size: usize) -> Vec<Point3<f64>> {
        let coordinate = |k: usize, axis: usize| {
            let x = (3 * k + axis + salt) as f64 * 0.754_877_666_246_692_7;
            (x * x * 91.7).fract()
        };
        let point = |k| Point3::from([0, 1, 2].map(|axis| coordinate(k, axis)));
        (1..=size).map(point).collect()
    }

    fn overlap(
        i: &[Point3<f64>],
        j: &[Point3<f64>],
        i_from_j: &Isometry3<f64>,
        radius: f64,
    ) -> f64 {
        let [i, j] = [i, j].map(|points| OverlapIndex::new(points, radius));
        i.overlap(&j, i_from_j)
    }

    #[test]
    fn a_cloud_overlaps_its_transformed_copy_entirely_under_the_true_transformation() {
        let cloud = cube(1, 500);
        let i_from_j = Isometry3::new(Vector3::new(1.0, -2.0, 0.5), Vector3::new(0.3, -1.2, 0.8));
        let copy: Vec<_> = cloud
            .iter()
            .map(|point| i_from_j.inverse_transform_point(point))
            .collect();
        assert_eq!(overlap(&cloud, &copy, &i_from_j, 1e-6), 1.0);
        assert!(overlap(&cloud, &copy, &Isometry3::identity(), 1e-6) < 0.1);
    }

    #[test]
    fn exchanging_the_clouds_and_inverting_the_transformation_changes_nothing() {
        let (i, j) = (cube(1, 400), cube(5000, 300));
        let i_from_j = Isometry3::translation(0.4, 0.1, 0.0);
        let forth = overlap(&i, &j, &i_from_j, 0.1);
        let back = overlap(&j, &i, &i_from_j.inverse(), 0.1);
        assert!(forth > 0.1 && forth < 0.9, "{forth}");
        assert_eq!(forth, back);
    }

    #[test]
    fn both_directions_count_what_asking_every_point_counts() {
        let (i, j) = (cube(1, 200), cube(5000, 150));
        let i_from_j = Isometry3::new(Vector3::new(0.3, 0.1, 0.2), Vector3::new(0.0, 0.4, 0.1));
        let j_in_i: Vec<_> = j.iter().map(|point| i_from_j * point).collect();
        let fraction = |points: &[Point3<f64>], others: &[Point3<f64>]| {
            let is_near = |p: &&Point3<f64>| others.iter().any(|other| distance(p, other) <= 0.1);
            points.iter().filter(is_near).count() as f64 / points.len() as f64
        };
        let expected = (fraction(&i, &j_in_i) + fraction(&j_in_i, &i)) / 2.0;
        assert_eq!(overlap(&i, &j, &i_from_j, 0.1), expected);
    }

    #[test]
    fn nothing_overlaps_an_empty_cloud_or_within_no_radius() {
        let cloud = cube(1, 10);
        let here = Isometry3::identity();
        assert_eq!(overlap(&cloud, &[], &here, 0.1), 0.0);
        assert_eq!(overlap(&[], &[], &here, 0.1), 0.0);
        for radius in [0.0, -1.0, f64::NAN] {
            assert_eq!(overlap(&cloud, &cloud, &here, radius), 0.0);
        }
        assert_eq!(overlap(&cloud, &cloud, &here, f64::INFINITY), 1.0);
    }

    #[test]
    fn every_cloud_needs_a_pose() {
        let error = overlap_matrix(&[cube(1, 3)], &[], 0.1).unwrap_err();
        assert_eq!(error.to_string(), "1 poses are needed, but there are 0");
    }
}
