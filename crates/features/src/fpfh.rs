//! Fast point feature histograms.

use crate::neighbors::{Neighbor, Neighborhoods, Reach, Search};
use crate::pair::{BINS, Oriented, pair_bins};
use crate::{Error, FpfhParams, check};
use nalgebra::{Point3, Vector3};

/// Length of a descriptor: eleven bins for each of three features.
pub const FPFH_DIMENSION: usize = 3 * BINS;

/// Descriptor of one point: three histograms of eleven bins, each of which sums to 200.
pub type Fpfh = [f32; FPFH_DIMENSION];

/// Sums are formed in double precision and rounded once, at the end.
type Histogram = [f64; FPFH_DIMENSION];

/// Fast point feature histogram of each point: how the surface around it bends.
///
/// For every point the three angles between its normal and that of each neighbor are counted in
/// histograms of eleven bins, in percent of the neighbors: the simplified histogram `SPFH(p)`.
/// The descriptor adds those of the neighbors `k` at distance `|p - k|`,
///
/// ```text
/// FPFH(p) = SPFH(p) + c sum_k SPFH(k) / |p - k|^2 ,
/// ```
///
/// where `c` makes the second term sum to 100 in each of the three histograms (Rusu, Blodow and
/// Beetz, ICRA 2009; the squared distance and the percentages are the convention of PCL and
/// Open3D). Rigid transformations of points and normals leave it unchanged, up to pairs that rounding moves
/// to another bin: those at a border, and those with equal normals, of which rounding picks the one
/// that the angles are measured from.
///
/// `normals` are the unit normals of `points`, in the same frame. Neighbors in the same place as
/// the point count in `SPFH` as three angles of zero and are left out of the second term. A point
/// without neighbors gets 33 zeros.
///
/// Takes O(n log n) for the tree and O(k log k) per point with k neighbors; holds 16 bytes for
/// each pair of neighbors. Points that coincide in large numbers make the searches quadratic in
/// that number; [`voxel_grid`](crate::voxel_grid) removes them.
///
/// # Errors
/// [`Error::LengthMismatch`] unless there is one normal for each point, [`Error::Parameter`] for values
/// outside the ranges that [`FpfhParams`] states, [`Error::Coordinate`] for coordinates outside ±1e100. An empty cloud has no descriptors.
///
/// ```
/// use gmpcr_features::{FpfhParams, fpfh};
/// use nalgebra::{Point3, Vector3};
///
/// // On a plane all angles are zero: everything falls into the middle bins.
/// let plane: Vec<_> = (0..100).map(|k| Point3::new((k % 10) as f64, (k / 10) as f64, 0.0)).collect();
/// let normals = vec![Vector3::z(); plane.len()];
/// let descriptors = fpfh(&plane, &normals, &FpfhParams { radius: 3.0, max_neighbors: 100 })?;
/// assert_eq!([descriptors[0][5], descriptors[0][16], descriptors[0][27]], [200.0; 3]);
/// # Ok::<(), gmpcr_features::Error>(())
/// ```
pub fn fpfh(
    points: &[Point3<f64>],
    normals: &[Vector3<f64>],
    params: &FpfhParams,
) -> Result<Vec<Fpfh>, Error> {
    if points.len() != normals.len() {
        let (num_points, num_normals) = (points.len(), normals.len());
        return Err(Error::LengthMismatch {
            num_points,
            num_normals,
        });
    }
    params.validate()?;
    check::points(points)?;
    check::normals(normals)?;
    if points.is_empty() {
        return Ok(Vec::new());
    }
    let neighborhoods = Search::new(points)?.everywhere(params.reach());
    Ok(fpfh_of(points, normals, &neighborhoods))
}

impl FpfhParams {
    pub(crate) fn reach(&self) -> Reach {
        Reach {
            radius: self.radius,
            max_neighbors: self.max_neighbors,
        }
    }
}

/// Descriptors of all points, given the neighbors of each.
pub(crate) fn fpfh_of(
    points: &[Point3<f64>],
    normals: &[Vector3<f64>],
    neighborhoods: &Neighborhoods,
) -> Vec<Fpfh> {
    let oriented = |k: usize| Oriented {
        point: &points[k],
        normal: &normals[k],
    };
    let spfh: Vec<Histogram> = neighborhoods
        .iter()
        .enumerate()
        .map(|(k, neighbors)| spfh(oriented(k), neighbors.iter().map(|n| oriented(n.at()))))
        .collect();
    let descriptor = |(own, neighbors)| sum_to_f32(own, &neighbor_part(neighbors, &spfh));
    spfh.iter()
        .zip(neighborhoods.iter())
        .map(descriptor)
        .collect()
}

/// Percentage of neighbors in each bin of each feature; zeros without neighbors.
fn spfh<'a>(center: Oriented, neighbors: impl ExactSizeIterator<Item = Oriented<'a>>) -> Histogram {
    let mut histogram = [0.0; FPFH_DIMENSION];
    let percent = 100.0 / neighbors.len() as f64;
    for neighbor in neighbors {
        for (feature, bin) in pair_bins(center, neighbor).into_iter().enumerate() {
            histogram[feature * BINS + bin] += 1.0;
        }
    }
    histogram.map(|count| if count > 0.0 { count * percent } else { 0.0 })
}

/// Sum of the neighbors' histograms, the near ones weighing more, scaled to 100 per feature.
fn neighbor_part(neighbors: &[Neighbor], spfh: &[Histogram]) -> Histogram {
    let mut sum = [0.0; FPFH_DIMENSION];
    let coincident = neighbors.partition_point(|neighbor| neighbor.squared_distance == 0.0);
    let apart = &neighbors[coincident..];
    for neighbor in apart {
        // Only ratios of the weights matter; relative to the nearest they cannot overflow.
        let weight = apart[0].squared_distance / neighbor.squared_distance;
        for (total, percent) in sum.iter_mut().zip(&spfh[neighbor.at()]) {
            *total += weight * percent;
        }
    }
    for feature in sum.chunks_exact_mut(BINS) {
        let total: f64 = feature.iter().sum();
        if total > 0.0 {
            feature.iter_mut().for_each(|value| *value *= 100.0 / total);
        }
    }
    sum
}

fn sum_to_f32(own: &Histogram, neighbors: &Histogram) -> Fpfh {
    std::array::from_fn(|k| (own[k] + neighbors[k]) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEAR: FpfhParams = FpfhParams {
        radius: 2.5,
        max_neighbors: 100,
    };

    #[test]
    fn a_plane_falls_into_the_middle_bins() {
        let plane: Vec<_> = (0..100)
            .map(|k| Point3::new((k % 10) as f64, (k / 10) as f64, 0.0))
            .collect();
        let mut flat = [0.0; FPFH_DIMENSION];
        flat[5] = 200.0;
        flat[16] = 200.0;
        flat[27] = 200.0;
        assert_eq!(
            fpfh(&plane, &[Vector3::z(); 100], &NEAR),
            Ok(vec![flat; 100])
        );
    }

    #[test]
    fn two_points_have_the_histogram_that_the_formula_gives() {
        // d = x, u = (0.8, 0, 0.6), v = d x u / |d x u| = -y, w = u x v = (0.6, 0, -0.8):
        // f0 = atan2(w . z, u . z) = atan2(-0.8, 0.6) = -0.927, f1 = 0, f2 = u . d = 0.8.
        let points = [Point3::origin(), Point3::new(1.0, 0.0, 0.0)];
        let normals = [Vector3::new(0.8, 0.0, 0.6), Vector3::z()];
        let mut expected = [0.0; FPFH_DIMENSION];
        expected[3] = 200.0;
        expected[11 + 5] = 200.0;
        expected[22 + 9] = 200.0;
        assert_eq!(fpfh(&points, &normals, &NEAR), Ok(vec![expected; 2]));
    }

    #[test]
    fn near_neighbors_weigh_more_by_the_squared_distance() {
        // The end points see only the middle: SPFH of one pair each, which differ in f2.
        let points = [-1.0, 0.0, 2.0].map(|x| Point3::new(x, 0.0, 0.0));
        let normals = [Vector3::z(), Vector3::z(), Vector3::new(0.6, 0.0, 0.8)];
        let descriptors = fpfh(&points, &normals, &NEAR).unwrap();
        let f2 = &descriptors[1][22..];
        // Own part: half and half. Neighbors: weights 1 and 1/4, hence 80 and 20.
        // f2 of the pair with the tilted normal: (0.6, 0, 0.8) . (-1, 0, 0) = -0.6, bin 2.
        assert_eq!((f2[5], f2[2]), (50.0 + 80.0, 50.0 + 20.0));
    }

    #[test]
    fn a_point_without_neighbors_has_a_zero_descriptor() {
        let points = [Point3::origin(), Point3::new(9.0, 0.0, 0.0)];
        assert_eq!(
            fpfh(&points, &[Vector3::z(); 2], &NEAR),
            Ok(vec![[0.0; 33]; 2])
        );
        let alone = FpfhParams {
            radius: 10.0,
            max_neighbors: 1,
        };
        assert_eq!(
            fpfh(&points, &[Vector3::z(); 2], &alone),
            Ok(vec![[0.0; 33]; 2])
        );
    }

    #[test]
    fn coincident_points_have_only_their_own_part() {
        let descriptors = fpfh(&[Point3::origin(); 200], &[Vector3::z(); 200], &NEAR).unwrap();
        assert!(
            descriptors
                .iter()
                .all(|d| [d[5], d[16], d[27]] == [100.0; 3])
        );
        assert!(descriptors.iter().all(|d| d.iter().sum::<f32>() == 300.0));
    }
}
