//! One point for every occupied cube of a regular grid.

use crate::{Error, check};
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;

/// Downsamples a cloud to the mean point of every voxel that holds points.
///
/// Point `p` falls into the voxel `floor((p - origin) / voxel_size)`, per axis, where
/// `origin = min - voxel_size / 2` and `min` is the smallest coordinate of the cloud along each
/// axis (the grid of Open3D's `VoxelDownSample`). The grid moves with the cloud but does not rotate
/// with it, and downsampling twice may merge points once more.
///
/// The result is ordered by the first point of each voxel: permuting the input permutes the
/// result, apart from the rounding of the means. Takes time linear in the number of points.
///
/// # Errors
/// [`Error::Parameter`] for a voxel size outside 1e-100..=1e100, [`Error::Coordinate`] for a
/// coordinate outside ±1e100, [`Error::ExtentTooLarge`] if the cloud spans more than 2^31 - 1
/// voxels along an axis. An empty cloud stays empty.
///
/// ```
/// use gmpcr_features::voxel_grid;
/// use nalgebra::Point3;
///
/// let cloud = [Point3::new(5.0, 0.0, 0.0), Point3::new(0.0, 0.0, 0.0), Point3::new(0.25, 0.0, 0.0)];
/// let downsampled = voxel_grid(&cloud, 1.0)?;
/// assert_eq!(downsampled, [Point3::new(5.0, 0.0, 0.0), Point3::new(0.125, 0.0, 0.0)]);
/// # Ok::<(), gmpcr_features::Error>(())
/// ```
pub fn voxel_grid(points: &[Point3<f64>], voxel_size: f64) -> Result<Vec<Point3<f64>>, Error> {
    check::length("voxel_size", voxel_size)?;
    check::points(points)?;
    let Some(grid) = Grid::around(points, voxel_size)? else {
        return Ok(Vec::new());
    };
    let mut slots = HashMap::with_capacity(points.len() / 2);
    let mut voxels: Vec<Voxel> = Vec::new();
    for point in points {
        let slot = *slots.entry(grid.cell(point)).or_insert(voxels.len());
        if slot == voxels.len() {
            voxels.push(Voxel::default());
        }
        voxels[slot].add(point);
    }
    Ok(voxels.iter().map(Voxel::mean).collect())
}

/// Cubes of one size, counted from a corner.
struct Grid {
    origin: Vector3<f64>,
    voxel_size: f64,
}

impl Grid {
    fn around(points: &[Point3<f64>], voxel_size: f64) -> Result<Option<Self>, Error> {
        let coordinates = || points.iter().map(|point| point.coords);
        let Some(min) = coordinates().reduce(|a, b| a.inf(&b)) else {
            return Ok(None);
        };
        let extent = coordinates().fold(min, |a, b| a.sup(&b)) - min;
        let axis = extent.imax();
        if extent[axis] / voxel_size >= f64::from(i32::MAX) {
            return Err(Error::ExtentTooLarge {
                axis,
                extent: extent[axis],
                voxel_size,
            });
        }
        Ok(Some(Self {
            origin: min.add_scalar(-0.5 * voxel_size),
            voxel_size,
        }))
    }

    fn cell(&self, point: &Point3<f64>) -> [u32; 3] {
        let position = (point.coords - self.origin) / self.voxel_size;
        position.map(|value| value.floor() as u32).into()
    }
}

/// Sum and number of the points of one voxel.
#[derive(Default)]
struct Voxel {
    sum: Vector3<f64>,
    count: u32,
}

impl Voxel {
    fn add(&mut self, point: &Point3<f64>) {
        self.sum += point.coords;
        self.count += 1;
    }

    fn mean(&self) -> Point3<f64> {
        (self.sum / f64::from(self.count)).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice(count: usize, spacing: f64) -> Vec<Point3<f64>> {
        let axis = |k: usize| (k % count) as f64 * spacing;
        (0..count.pow(3))
            .map(|k| [axis(k), axis(k / count), axis(k / count / count)].into())
            .collect()
    }

    #[test]
    fn a_lattice_of_the_voxel_size_stays_as_it_is() {
        let cloud = lattice(5, 0.25);
        assert_eq!(voxel_grid(&cloud, 0.25), Ok(cloud));
    }

    #[test]
    fn a_voxel_twice_as_large_as_the_cloud_keeps_the_mean() {
        let cloud = lattice(3, 1.0);
        assert_eq!(
            voxel_grid(&cloud, 4.0 + 1e-9),
            Ok(vec![Point3::new(1.0, 1.0, 1.0)])
        );
    }

    #[test]
    fn every_point_is_within_a_voxel_diagonal_of_a_kept_point() {
        let cloud = lattice(9, 0.1);
        let downsampled = voxel_grid(&cloud, 0.23).unwrap();
        assert!(downsampled.len() < cloud.len() / 4);
        for point in &cloud {
            let nearest = downsampled
                .iter()
                .map(|kept| (kept - point).norm())
                .reduce(f64::min);
            assert!(nearest.unwrap() <= 0.23 * 3_f64.sqrt());
        }
    }

    #[test]
    fn the_order_is_that_of_the_first_point_of_each_voxel() {
        let at = |x: f64| Point3::new(x, 0.0, 0.0);
        let cloud = [at(9.0), at(0.0), at(5.0), at(0.25), at(9.25), at(4.75)];
        assert_eq!(
            voxel_grid(&cloud, 1.0),
            Ok(vec![at(9.125), at(0.125), at(4.875)])
        );
        let reversed: Vec<_> = cloud.into_iter().rev().collect();
        assert_eq!(
            voxel_grid(&reversed, 1.0),
            Ok(vec![at(4.875), at(9.125), at(0.125)])
        );
    }

    #[test]
    fn a_thousand_equal_points_leave_one() {
        let point = Point3::new(1.0, 2.0, -3.0);
        assert_eq!(voxel_grid(&[point; 1000], 1e-6), Ok(vec![point]));
    }

    #[test]
    fn the_axis_that_needs_too_many_voxels_is_named() {
        let cloud = [Point3::origin(), Point3::new(1.0, 2.2e9, 0.0)];
        assert!(voxel_grid(&cloud, 1.1).is_ok());
        assert_eq!(
            voxel_grid(&cloud, 1.0),
            Err(Error::ExtentTooLarge {
                axis: 1,
                extent: 2.2e9,
                voxel_size: 1.0
            })
        );
        let widest = [Point3::new(-1e100, 0.0, 0.0), Point3::new(1e100, 0.0, 0.0)];
        assert!(matches!(
            voxel_grid(&widest, 1e-100),
            Err(Error::ExtentTooLarge { axis: 0, .. })
        ));
    }
}
