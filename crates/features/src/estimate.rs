//! Lengths that a cloud suggests by itself.

use crate::neighbors::{Reach, Search};
use crate::{Error, check};
use nalgebra::{Point3, Vector3};
use std::collections::HashSet;

/// Voxels that the surface of a scan should fill: enough for its shape, few enough that five of
/// them make out a part of it. Rooms of the 3DMatch benchmark fill as many at the customary 5 cm.
const MAX_VOXELS: usize = 4000;
/// Mean number of points in a voxel, at least: with fewer, neighborhoods are too sparse for descriptors.
const MIN_POINTS_PER_VOXEL: usize = 2;
/// Of larger clouds an even sample is counted: four points for each voxel miss 2 % of them.
const MAX_COUNTED: usize = 4 * MAX_VOXELS;
/// Points whose nearest neighbor is looked for.
const MAX_SEARCHED: usize = 1000;
/// The estimate is at most this much above the smallest voxel that would do, as a factor.
const ACCURACY: f64 = 1.01;

/// Estimates the voxel size at which to work with a scan, in its unit.
///
/// It is the smallest size at which at most
///
/// ```text
/// min(4000, n / 2)
/// ```
///
/// voxels hold points, where `n` is the number of different points, found by bisection to 1 %. The
/// number of occupied voxels measures the area of the surface in voxels. It depends little on how
/// densely the surface was sampled and on the position of a few points that are far off, unlike
/// the number of points and the extent. Rooms of the 3DMatch benchmark come out at 5 cm, the bunny
/// of 15 cm at 2.6 mm. Where a cloud is so sparse that the limit is `n / 2`, voxels hold two points on the
/// average, so that there are enough neighbors for normals and descriptors.
///
/// Of more than 16 000 points a sample of 16 000 is counted, so that [`voxel_grid`] keeps up to a
/// fifth more points: it also meets the voxels that the surface merely grazes. Scans of one scene
/// should have one voxel size: [`common_voxel_size`].
///
/// The estimate scales with the cloud and depends neither on the order of the points nor on
/// repeated points nor on the position of the cloud. Rotating a room changes it by a few percent; a
/// single plane, the worst case, by up to `3^(1/4) = 1.32`. A fraction `q` of outliers raises it by a
/// factor of about `1 + 2 q`. Takes `O(n log n)` time and a copy of the points: they are sorted
/// once, the rest of the work is bounded.
///
/// [`voxel_grid`]: crate::voxel_grid
///
/// `None` where there is no extent: no point, or all in one place. Otherwise the estimate is a
/// valid voxel size, from 1e-100 to 1e100.
///
/// # Errors
/// [`Error::Coordinate`] for a coordinate outside ±1e100.
///
/// ```
/// use gmpcr_features::{estimate_voxel_size, voxel_grid};
/// use nalgebra::Point3;
///
/// // A sheet of 4 m x 4 m, a point every 2 cm: 4000 squares of 6.3 cm cover it.
/// let cloud: Vec<_> = (0..40_000)
///     .map(|k| Point3::new((k % 200) as f64 * 0.02, (k / 200) as f64 * 0.02, 1.0))
///     .collect();
/// let voxel_size = estimate_voxel_size(&cloud)?.expect("the sheet has an extent");
/// assert!((0.060..0.067).contains(&voxel_size));
/// assert!((3500..4500).contains(&voxel_grid(&cloud, voxel_size)?.len()));
/// # Ok::<(), gmpcr_features::Error>(())
/// ```
pub fn estimate_voxel_size(points: &[Point3<f64>]) -> Result<Option<f64>, Error> {
    let points = distinct(points)?;
    let extent = crate::extent(&points).max();
    if extent == 0.0 {
        return Ok(None);
    }
    // The middle in the order along the first axis is no outlier.
    let center = points[points.len() / 2];
    let counted: Vec<_> = sample_indices(points.len(), MAX_COUNTED)
        .map(|index| points[index] - center)
        .collect();
    let max_voxels = MAX_VOXELS.min(counted.len() / MIN_POINTS_PER_VOXEL);
    let suffices = |voxel_size| occupies_at_most(max_voxels, &counted, voxel_size);

    // At first one voxel holds all points.
    let mut high = (4.0 * extent).max(check::SMALLEST);
    while high > check::SMALLEST && suffices(0.5 * high) {
        high *= 0.5;
    }
    let mut low = 0.5 * high;
    while high > ACCURACY * low {
        let middle = (low * high).sqrt();
        if suffices(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    Ok(Some(high.clamp(check::SMALLEST, check::LARGEST)))
}

/// One voxel size for several clouds: the median of their estimates, the lower of the two in the middle.
///
/// One size for all makes descriptors comparable. The median leaves it to the majority, whatever a few
/// clouds of another extent suggest. `None` without estimates. `O(n)`.
///
/// ```
/// use gmpcr_features::{common_voxel_size, estimate_voxel_size};
/// use nalgebra::Point3;
///
/// let cloud = |spacing: f64| (0..50).map(|k| Point3::new(f64::from(k) * spacing, 0.0, 0.0)).collect();
/// let clouds: [Vec<_>; 4] = [cloud(0.1), cloud(9.0), cloud(0.2), vec![Point3::origin()]];
/// let estimates: Vec<_> = clouds.iter().map(|cloud| estimate_voxel_size(cloud)).collect::<Result<_, _>>()?;
/// assert_eq!(common_voxel_size(estimates.iter().copied().flatten()), estimates[2]);
/// assert_eq!(common_voxel_size([]), None);
/// # Ok::<(), gmpcr_features::Error>(())
/// ```
pub fn common_voxel_size(estimates: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut estimates: Vec<f64> = estimates.into_iter().collect();
    let middle = estimates.len().checked_sub(1)? / 2;
    let (_, &mut median, _) = estimates.select_nth_unstable_by(middle, f64::total_cmp);
    Some(median)
}

/// Estimates the spacing of the points of a cloud, in its unit: the median distance of a point to
/// the nearest point that differs from it.
///
/// The median is over an even sample of at most 1000 points, the nearest point is sought among
/// all. The estimate scales with the cloud and does not depend on the order of the points and on
/// repeated points. Takes `O(n log n)` time.
///
/// `None` where there are no two different points. Otherwise the estimate is a length from 1e-100
/// to 1e100.
///
/// # Errors
/// [`Error::Coordinate`] for a coordinate outside ±1e100, [`Error::TooManyPoints`] for a cloud
/// that the search tree cannot hold.
///
/// ```
/// use gmpcr_features::estimate_resolution;
/// use nalgebra::Point3;
///
/// let at = |x: f64| Point3::new(x, 0.0, 0.0);
/// assert_eq!(estimate_resolution(&[at(0.0), at(0.5), at(1.0), at(1.0), at(99.0)])?, Some(0.5));
/// assert_eq!(estimate_resolution(&[at(1.0), at(1.0)])?, None);
/// # Ok::<(), gmpcr_features::Error>(())
/// ```
pub fn estimate_resolution(points: &[Point3<f64>]) -> Result<Option<f64>, Error> {
    let points = distinct(points)?;
    if points.len() < 2 {
        return Ok(None);
    }
    let search = Search::new(&points)?;
    let nearest_other = Reach {
        radius: f64::INFINITY,
        max_neighbors: 2,
    };
    let mut neighbors = Vec::new();
    let mut distances: Vec<f64> = sample_indices(points.len(), MAX_SEARCHED)
        .map(|center| {
            search.around(center, nearest_other, &mut neighbors);
            neighbors[0].squared_distance.sqrt()
        })
        .collect();
    let middle = distances.len() / 2;
    let (_, median, _) = distances.select_nth_unstable_by(middle, f64::total_cmp);
    Ok(Some(median.clamp(check::SMALLEST, check::LARGEST)))
}

/// The different points of a cloud, in an order that does not depend on that of the cloud.
fn distinct(points: &[Point3<f64>]) -> Result<Vec<Point3<f64>>, Error> {
    check::points(points)?;
    // Adding zero turns -0.0, which is equal to 0.0 but sorted before it, into 0.0.
    let mut points: Vec<_> = points.iter().map(|p| p.map(|x| x + 0.0)).collect();
    points.sort_unstable_by(|a, b| {
        let by = |axis: usize| a[axis].total_cmp(&b[axis]);
        by(0).then_with(|| by(1)).then_with(|| by(2))
    });
    points.dedup();
    Ok(points)
}

/// All indices below `len`, or `max_indices` of them, spread evenly but in no rhythm with rows of
/// a lattice: the multiples of the golden section, modulo one, in units of `len`.
fn sample_indices(len: usize, max_indices: usize) -> impl Iterator<Item = usize> {
    const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
    (0..len.min(max_indices)).map(move |k| {
        if len <= max_indices {
            return k;
        }
        let position = u128::from((k as u64).wrapping_mul(GOLDEN)) * len as u128;
        (position >> 64) as usize
    })
}

/// Whether at most `max_voxels` voxels hold points, one of them centered at the origin. Voxels too far
/// from it for an `i32` to number them count as one.
fn occupies_at_most(max_voxels: usize, points: &[Vector3<f64>], voxel_size: f64) -> bool {
    let mut voxels: HashSet<[i32; 3]> = HashSet::with_capacity(max_voxels + 1);
    points.iter().all(|point| {
        let cell = (point / voxel_size).map(|value| (value + 0.5).floor() as i32);
        voxels.insert(cell.into());
        voxels.len() <= max_voxels
    })
}
