use std::cmp::Ordering::Greater;

use faer::linalg::matmul::matmul;
use faer::traits::pulp::{Arch, NullaryFnOnce};
use faer::{Accum, MatMut, MatRef, Par};
use gmpcr_geometry::{PairsError, PointPairs};

use crate::descriptors::squared_distance;
use crate::{CorrespondenceError, CorrespondenceParams, Descriptors, DimensionsDiffer, Keypoints};

/// Two descriptors that are each other's nearest neighbor.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Match {
    /// Row among the first set's descriptors.
    pub i: usize,
    /// Row among the second set's descriptors.
    pub j: usize,
    /// Euclidean distance of the two descriptors.
    pub distance: f64,
}

/// Correspondences `C_ij` of two keypoint sets: the `N_o = max_correspondences` best
/// [matches](match_descriptors) as point pairs (target: scan i, source: scan j), in ascending order
/// of descriptor distance. All matches are kept where there are fewer.
///
/// # Errors
/// [`CorrespondenceError`] if the descriptors have different dimensions or a parameter is out of range.
///
/// ```
/// use gmpcr_correspondence::{CorrespondenceParams, Descriptors, Keypoints, Scan, correspondences};
/// use nalgebra::Point3;
///
/// let points = vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0)];
/// let scan = Scan::new(points, Descriptors::new(vec![0.0, 1.0], 1)?)?;
/// let params = CorrespondenceParams::default();
/// let keypoints = Keypoints::sample(&scan, &params)?;
/// let pairs = correspondences(&keypoints, &keypoints, &params)?;
/// assert_eq!(pairs.target(), pairs.source());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn correspondences(
    keypoints_i: &Keypoints,
    keypoints_j: &Keypoints,
    params: &CorrespondenceParams,
) -> Result<PointPairs, CorrespondenceError> {
    params.validate()?;
    let mut matches = match_descriptors(keypoints_i.descriptors(), keypoints_j.descriptors())?;
    matches.truncate(params.max_correspondences);
    let target = matches.iter().map(|m| keypoints_i.points()[m.i]).collect();
    let source = matches.iter().map(|m| keypoints_j.points()[m.j]).collect();
    let pairs: Result<_, PairsError> = PointPairs::new(target, source);
    Ok(pairs.expect("keypoints come from scans, whose coordinates are finite"))
}

/// Mutual nearest neighbors of two descriptor sets, in ascending order of Euclidean distance.
///
/// A match `(i, j)` is kept only where `j` is nearest to `i` and `i` is nearest to `j`. Equal
/// distances go to the lower row, and equal matches are ordered by `i`.
///
/// One matrix product gives all squared distances `‖a‖² + ‖b‖² − 2 aᵀb` in `f32`. Its rounding
/// error is bounded, and wherever the bound leaves more than one candidate the distances of the
/// candidates are computed again in `f64` from the differences, so that the result is that of exact
/// arithmetic. `O(n_i n_j d)` multiply-adds and `4 n_i n_j` bytes.
///
/// # Errors
/// [`DimensionsDiffer`] if the dimensions differ. An empty set matches nothing, whatever its
/// dimension.
///
/// ```
/// use gmpcr_correspondence::{Descriptors, match_descriptors};
///
/// let a = Descriptors::new(vec![0.0, 10.0, 20.0], 1)?;
/// let b = Descriptors::new(vec![10.5, 0.25], 1)?;
/// let matches = match_descriptors(&a, &b)?;
/// assert_eq!((matches[0].i, matches[0].j, matches[0].distance), (0, 1, 0.25));
/// assert_eq!((matches[1].i, matches[1].j, matches[1].distance), (1, 0, 0.5));
/// assert_eq!(matches.len(), 2); // 20 is nearest to 10.5, but 10.5 is not nearest to 20
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn match_descriptors(a: &Descriptors, b: &Descriptors) -> Result<Vec<Match>, DimensionsDiffer> {
    if a.is_empty() || b.is_empty() {
        return Ok(Vec::new());
    }
    if a.dimension() != b.dimension() {
        return Err(DimensionsDiffer {
            i: a.dimension(),
            j: b.dimension(),
        });
    }
    let approximate = ApproximateDistances::new(a, b);
    let exact = |i: usize, j: usize| squared_distance(a.row(i), b.row(j));
    let (nearest_in_a, nearest_in_b) = Arch::new().dispatch(Search {
        distances: &approximate,
        exact,
    });
    let mut matches: Vec<Match> = (0..a.len())
        .map(|i| (i, nearest_in_b[i].index))
        .filter(|&(i, j)| nearest_in_a[j].index == i)
        .map(|(i, j)| Match {
            i,
            j,
            distance: exact(i, j).sqrt(),
        })
        .collect();
    matches.sort_by(|m, n| m.distance.total_cmp(&n.distance).then(m.i.cmp(&n.i)));
    Ok(matches)
}

/// All squared distances in `f32` up to a known error.
struct ApproximateDistances {
    /// Column by column, that is per row of `b`: its distances to all rows of `a`.
    columns: Vec<f32>,
    /// For each row of `a`, what the distance of the nearest row of `b` does not exceed.
    row_limits: Vec<f32>,
    /// The same for each row of `b`.
    column_limits: Vec<f32>,
}

impl ApproximateDistances {
    fn new(a: &Descriptors, b: &Descriptors) -> Self {
        let mut columns = vec![0.0; a.len() * b.len()];
        let product = MatMut::from_column_major_slice_mut(&mut columns, a.len(), b.len());
        let (a_rows, b_rows) = (as_matrix(a), as_matrix(b));
        matmul(
            product,
            Accum::Replace,
            a_rows,
            b_rows.transpose(),
            -2.0,
            Par::Seq,
        );
        let mut distances = Self {
            columns,
            row_limits: vec![f32::INFINITY; a.len()],
            column_limits: vec![f32::INFINITY; b.len()],
        };
        Arch::new().dispatch(AddNorms {
            distances: &mut distances,
            a_norms: a.squared_norms(),
            b_norms: b.squared_norms(),
        });
        let resolution = resolution(a.dimension(), a.squared_norms(), b.squared_norms());
        let limits = distances
            .row_limits
            .iter_mut()
            .chain(&mut distances.column_limits);
        limits.for_each(|limit| *limit += resolution);
        distances
    }
}

/// Makes squared distances of products, and finds the smallest of each row and column.
struct AddNorms<'a> {
    distances: &'a mut ApproximateDistances,
    a_norms: &'a [f32],
    b_norms: &'a [f32],
}

impl NullaryFnOnce for AddNorms<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let ApproximateDistances {
            columns,
            row_limits,
            column_limits,
        } = self.distances;
        let columns = columns.chunks_exact_mut(self.a_norms.len());
        for ((column, &b_norm), limit) in columns.zip(self.b_norms).zip(column_limits) {
            // Three loops, as the compiler makes vector instructions of each.
            for (entry, a_norm) in column.iter_mut().zip(self.a_norms) {
                *entry += a_norm + b_norm;
            }
            for (limit, &entry) in row_limits.iter_mut().zip(&*column) {
                *limit = lesser(*limit, entry);
            }
            *limit = smallest(column);
        }
    }
}

/// Finds the row of `a` that is nearest to each row of `b` by the `exact` squared distance, and the row
/// of `b` that is nearest to each row of `a`.
struct Search<'a, Exact> {
    distances: &'a ApproximateDistances,
    exact: Exact,
}

impl<Exact: Fn(usize, usize) -> f64> NullaryFnOnce for Search<'_, Exact> {
    type Output = (Vec<Nearest>, Vec<Nearest>);

    #[inline(always)]
    fn call(self) -> Self::Output {
        let ApproximateDistances {
            columns,
            row_limits,
            column_limits,
        } = self.distances;
        let mut nearest_in_a = vec![Nearest::NONE; column_limits.len()];
        let mut nearest_in_b = vec![Nearest::NONE; row_limits.len()];
        let columns = columns.chunks_exact(row_limits.len());
        for (j, (column, &column_limit)) in columns.zip(column_limits).enumerate() {
            let mut compare = |i: usize| {
                if is_within(column[i], column_limit) {
                    nearest_in_a[j].compare(i, |i| (self.exact)(i, j));
                }
                if is_within(column[i], row_limits[i]) {
                    nearest_in_b[i].compare(j, |j| (self.exact)(i, j));
                }
            };
            let (blocks, rest) = column.as_chunks::<LANES>();
            let (limits, _) = row_limits.as_chunks::<LANES>();
            for (k, (entries, limits)) in blocks.iter().zip(limits).enumerate() {
                if !any_within(entries, limits, column_limit) {
                    continue;
                }
                for lane in 0..LANES {
                    let limit = greater(limits[lane], column_limit);
                    if is_within(entries[lane], limit) {
                        compare(k * LANES + lane);
                    }
                }
            }
            (column.len() - rest.len()..column.len()).for_each(compare);
        }
        (nearest_in_a, nearest_in_b)
    }
}

/// The best candidate so far. A single candidate needs no distance.
#[derive(Clone, Copy)]
struct Nearest {
    index: usize,
    /// Exact distance, once there is a second candidate to compare with.
    distance: Option<f64>,
}

impl Nearest {
    /// Every row and column has a candidate: its smallest entry, or any where overflow made a NaN.
    const NONE: Self = Self {
        index: usize::MAX,
        distance: None,
    };

    /// Takes a candidate into account; of equal ones the first stays.
    fn compare(&mut self, candidate: usize, exact: impl Fn(usize) -> f64) {
        if self.index == Self::NONE.index {
            self.index = candidate;
            return;
        }
        let best = self.distance.unwrap_or_else(|| exact(self.index));
        let distance = exact(candidate);
        self.distance = Some(best.min(distance));
        if distance < best {
            self.index = candidate;
        }
    }
}

/// Entries that are looked at together, as a vector register.
const LANES: usize = 8;

/// `f32::min` in the form of the machine's instruction; NaN in `b` does not count.
#[inline(always)]
fn lesser(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

#[inline(always)]
fn greater(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

/// The smallest entry; NaN does not count.
#[inline(always)]
fn smallest(entries: &[f32]) -> f32 {
    let (blocks, rest) = entries.as_chunks::<LANES>();
    let mut least = [f32::INFINITY; LANES];
    for block in blocks {
        for lane in 0..LANES {
            least[lane] = lesser(least[lane], block[lane]);
        }
    }
    let mut smallest = f32::INFINITY;
    for &entry in least.iter().chain(rest) {
        smallest = lesser(smallest, entry);
    }
    smallest
}

/// Whether an entry is within its row's limit or the column's.
#[inline(always)]
fn any_within(entries: &[f32; LANES], row_limits: &[f32; LANES], column_limit: f32) -> bool {
    let mut any = false;
    // Without an early exit this loop becomes vector instructions.
    for lane in 0..LANES {
        any |= is_within(entries[lane], greater(row_limits[lane], column_limit));
    }
    any
}

/// Whether an entry does not exceed a limit; NaN, which an overflow made, might.
#[inline(always)]
fn is_within(entry: f32, limit: f32) -> bool {
    !matches!(entry.partial_cmp(&limit), Some(Greater))
}

/// Twice the largest rounding error of an entry.
///
/// A product of `d` terms in any order of summation errs by at most `d ε ‖a‖‖b‖` to first order,
/// with `ε` the unit roundoff; the norms and the two additions err by as much again. The factor 4
/// covers both, the doubling of the product, and higher orders. Terms that underflow err by up to the
/// smallest normal number instead.
fn resolution(dimension: usize, a_norms: &[f32], b_norms: &[f32]) -> f32 {
    let largest = |norms: &[f32]| norms.iter().copied().fold(0.0, f32::max);
    let scale = largest(a_norms) + largest(b_norms);
    2.0 * 4.0 * (dimension as f32 + 4.0) * (f32::EPSILON / 2.0 * scale + f32::MIN_POSITIVE)
}

fn as_matrix(descriptors: &Descriptors) -> MatRef<'_, f32> {
    MatRef::from_row_major_slice(
        descriptors.values(),
        descriptors.len(),
        descriptors.dimension(),
    )
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Mutual nearest neighbors as they are defined.
    fn plain_matches(a: &Descriptors, b: &Descriptors) -> Vec<(usize, usize)> {
        let exact = |i: usize, j: usize| squared_distance(a.row(i), b.row(j));
        let nearest_j = |i| (0..b.len()).min_by(|&j, &k| exact(i, j).total_cmp(&exact(i, k)));
        let nearest_i = |j| (0..a.len()).min_by(|&i, &k| exact(i, j).total_cmp(&exact(k, j)));
        let mut matches: Vec<_> = (0..a.len())
            .filter_map(|i| nearest_j(i).map(|j| (i, j)))
            .filter(|&(i, j)| nearest_i(j) == Some(i))
            .collect();
        matches.sort_by(|&(i, j), &(k, l)| exact(i, j).total_cmp(&exact(k, l)).then(i.cmp(&k)));
        matches
    }

    fn descriptors(dimension: usize) -> impl Strategy<Value = Descriptors> {
        // Close values around a large offset defeat the matrix product; few values make ties.
        let entry = prop_oneof![
            (0..3i32).prop_map(|k| k as f32),
            (0..99i32).prop_map(|k| 1e3 + k as f32 * 1e-4),
            -1.0..1.0f32
        ];
        prop::collection::vec(prop::collection::vec(entry, dimension), 0..25).prop_map(
            move |rows| Descriptors::new(rows.into_iter().flatten().collect(), dimension).unwrap(),
        )
    }

    fn descriptor_pairs() -> impl Strategy<Value = (Descriptors, Descriptors)> {
        (1..9usize).prop_flat_map(|dimension| (descriptors(dimension), descriptors(dimension)))
    }

    proptest! {
        #[test]
        fn the_matrix_product_gives_the_matches_of_exact_distances((a, b) in descriptor_pairs()) {
            let matches = match_descriptors(&a, &b).unwrap();
            let indices: Vec<_> = matches.iter().map(|m| (m.i, m.j)).collect();
            prop_assert_eq!(indices, plain_matches(&a, &b));
        }

        #[test]
        fn swapping_the_sets_swaps_the_matches((a, b) in descriptor_pairs()) {
            let mut forward: Vec<_> = match_descriptors(&a, &b).unwrap().iter().map(|m| (m.i, m.j)).collect();
            let mut backward: Vec<_> = match_descriptors(&b, &a).unwrap().iter().map(|m| (m.j, m.i)).collect();
            forward.sort_unstable();
            backward.sort_unstable();
            prop_assert_eq!(forward, backward);
        }
    }

    #[test]
    fn huge_descriptors_overflow_no_decision() {
        let a = Descriptors::new(vec![1e38, -1e38, 3e38, 0.0], 2).unwrap();
        let b = Descriptors::new(vec![3e38, 1e37, 1e38, -1.1e38], 2).unwrap();
        let matches = match_descriptors(&a, &b).unwrap();
        let indices: Vec<_> = matches.iter().map(|m| (m.i, m.j)).collect();
        assert_eq!(indices, plain_matches(&a, &b));
        assert_eq!(indices.len(), 2);
    }

    #[test]
    fn tiny_descriptors_underflow_no_decision() {
        for scale in [1e-20, 1e-21, 1e-22, 1e-23, 1e-30, 1e-44] {
            let wave = |k: usize, f: f32| (k as f32 * f).sin() * scale;
            let rows = |f: f32| Descriptors::new((0..60 * 33).map(|k| wave(k, f)).collect(), 33);
            let [a, b] = [1.7, 2.9].map(|f| rows(f).unwrap());
            let matches = match_descriptors(&a, &b).unwrap();
            let indices: Vec<_> = matches.iter().map(|m| (m.i, m.j)).collect();
            assert_eq!(indices, plain_matches(&a, &b), "scale {scale}");
        }
    }

    #[test]
    fn different_dimensions_do_not_compare() {
        let a = Descriptors::new(vec![0.0; 32], 32).unwrap();
        let b = Descriptors::new(vec![0.0; 33], 33).unwrap();
        assert_eq!(
            match_descriptors(&a, &b),
            Err(DimensionsDiffer { i: 32, j: 33 })
        );
        let empty = Descriptors::new(vec![], 33).unwrap();
        assert_eq!(match_descriptors(&a, &empty), Ok(vec![]));
    }

    #[test]
    fn equal_descriptors_match_once() {
        let a = Descriptors::new(vec![0.5; 4 * 8], 8).unwrap();
        let matches = match_descriptors(&a, &a).unwrap();
        assert_eq!(
            matches,
            [Match {
                i: 0,
                j: 0,
                distance: 0.0
            }]
        );
    }
}
