use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::traits::pulp::{Arch, NullaryFnOnce};
use faer::{Accum, MatMut, MatRef, Par};
use gmpcr_geometry::PointPairs;
use nalgebra::{DMatrix, Point3};

/// First- and second-order compatibility of a set of correspondences.
///
/// Both matrices are symmetric `M × M`, nonnegative, with a zero diagonal.
///
/// ```
/// use gmpcr_compatibility::CompatibilityGraph;
/// use gmpcr_geometry::PointPairs;
/// use nalgebra::{Point3, Vector3};
///
/// let target = vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 2.0, 0.0)];
/// let source = target.iter().map(|p| p + Vector3::new(5.0, 5.0, 5.0)).collect();
/// let graph = CompatibilityGraph::new(&PointPairs::new(target, source)?, 0.1);
/// assert_eq!(graph.fcg()[(0, 1)], 1.0); // a translation preserves all distances
/// assert_eq!(graph.scg()[(0, 1)], 1.0); // one common neighbor, fully compatible
/// # Ok::<(), gmpcr_geometry::PairsError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "Unchecked")
)]
pub struct CompatibilityGraph {
    fcg: DMatrix<f64>,
    /// Follows from the FCG, which alone is written to files.
    #[cfg_attr(feature = "serde", serde(skip_serializing))]
    scg: DMatrix<f64>,
}

/// A graph as a file has it.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
#[serde(rename = "CompatibilityGraph", deny_unknown_fields)]
struct Unchecked {
    fcg: DMatrix<f64>,
}

#[cfg(feature = "serde")]
impl TryFrom<Unchecked> for CompatibilityGraph {
    type Error = &'static str;

    fn try_from(Unchecked { fcg }: Unchecked) -> Result<Self, &'static str> {
        let is_affinity = |a: &f64| (0.0..=1.0).contains(a);
        let is_graph = fcg.is_square()
            && fcg == fcg.transpose()
            && fcg.iter().all(is_affinity)
            && fcg.diagonal().iter().all(|&a| a == 0.0);
        match is_graph {
            true => Ok(Self::from_fcg(fcg)),
            false => Err("the FCG must be symmetric, in [0, 1], and zero on its diagonal"),
        }
    }
}

impl CompatibilityGraph {
    /// Builds both graphs from correspondences and the geometric tolerance `τ_c > 0`.
    ///
    /// `O(M²)` distances and `M³ / 2` multiply-adds.
    pub fn new(pairs: &PointPairs, tolerance: f64) -> Self {
        Self::from_fcg(Arch::new().dispatch(FirstOrder {
            target: Axes::new(pairs.target()),
            source: Axes::new(pairs.source()),
            tolerance,
        }))
    }

    /// The graph on the `retained` correspondences alone: the FCG restricted to them,
    /// `Ã = A[S, S]`, and the SCG built again from it, so that discarded correspondences support
    /// nobody any more.
    ///
    /// # Panics
    /// If an index is [`len`](Self::len) or more.
    pub(crate) fn restricted_to(&self, retained: &[usize]) -> Self {
        let size = retained.len();
        let entry = |row, column| self.fcg[(retained[row], retained[column])];
        Self::from_fcg(DMatrix::from_fn(size, size, entry))
    }

    fn from_fcg(fcg: DMatrix<f64>) -> Self {
        let scg = second_order(&fcg);
        Self { fcg, scg }
    }

    /// Number of correspondences, `M`.
    pub fn len(&self) -> usize {
        self.fcg.nrows()
    }

    /// Whether there is no correspondence.
    pub fn is_empty(&self) -> bool {
        self.fcg.is_empty()
    }

    /// First-order affinities `A`, each in [0, 1].
    pub fn fcg(&self) -> &DMatrix<f64> {
        &self.fcg
    }

    /// Second-order affinities `B = A² ∘ A`.
    pub fn scg(&self) -> &DMatrix<f64> {
        &self.scg
    }
}

/// `a_mn = max(0, 1 − δ_mn² / τ²)` off the diagonal, in the widest vectors that the machine has.
struct FirstOrder {
    target: Axes,
    source: Axes,
    tolerance: f64,
}

impl NullaryFnOnce for FirstOrder {
    type Output = DMatrix<f64>;

    #[inline(always)]
    fn call(self) -> DMatrix<f64> {
        let size = self.target.x.len();
        let scale = 1.0 / (self.tolerance * self.tolerance);
        let mut fcg = DMatrix::zeros(size, size);
        let mut source_distances = vec![0.0; size];
        for (m, column) in fcg.as_mut_slice().chunks_exact_mut(size.max(1)).enumerate() {
            let (below, source_distances) = (&mut column[m + 1..], &mut source_distances[m + 1..]);
            self.target.distances_to_following(m, below);
            self.source.distances_to_following(m, source_distances);
            for (entry, source_distance) in below.iter_mut().zip(source_distances) {
                let discrepancy = *entry - *source_distance;
                *entry = (1.0 - discrepancy * discrepancy * scale).max(0.0);
            }
        }
        fcg.fill_upper_triangle_with_lower_triangle();
        fcg
    }
}

/// `b_mn = a_mn Σ_l a_ml a_ln`.
///
/// A matrix product that computes the lower triangle. Each sum runs over `l` in ascending order and has no
/// negative terms, so it is zero exactly where nothing supports.
fn second_order(fcg: &DMatrix<f64>) -> DMatrix<f64> {
    let size = fcg.nrows();
    let mut scg = DMatrix::zeros(size, size);
    let affinities = MatRef::from_column_major_slice(fcg.as_slice(), size, size);
    matmul(
        MatMut::from_column_major_slice_mut(scg.as_mut_slice(), size, size),
        BlockStructure::TriangularLower,
        Accum::Replace,
        affinities,
        BlockStructure::Rectangular,
        affinities,
        BlockStructure::Rectangular,
        1.0,
        Par::Seq,
    );
    for (sum, affinity) in scg.as_mut_slice().iter_mut().zip(fcg.as_slice()) {
        *sum *= affinity;
    }
    scg.fill_upper_triangle_with_lower_triangle();
    scg
}

/// Coordinates axis by axis: the loops over points become vector instructions.
struct Axes {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
}

impl Axes {
    fn new(points: &[Point3<f64>]) -> Self {
        Self {
            x: points.iter().map(|p| p.x).collect(),
            y: points.iter().map(|p| p.y).collect(),
            z: points.iter().map(|p| p.z).collect(),
        }
    }

    /// Distances of point `m` to the points after it.
    #[inline(always)]
    fn distances_to_following(&self, m: usize, distances: &mut [f64]) {
        let (x, y, z) = (self.x[m], self.y[m], self.z[m]);
        let others = self.x[m + 1..]
            .iter()
            .zip(&self.y[m + 1..])
            .zip(&self.z[m + 1..]);
        for (distance, ((&other_x, &other_y), &other_z)) in distances.iter_mut().zip(others) {
            let (dx, dy, dz) = (x - other_x, y - other_y, z - other_z);
            *distance = (dx * dx + dy * dy + dz * dz).sqrt();
        }
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;
    use nalgebra::{Isometry3, Vector3};
    use proptest::prelude::*;

    use super::*;

    fn points(n: usize) -> impl Strategy<Value = Vec<Point3<f64>>> {
        let point = prop::array::uniform3(-0.5..0.5f64).prop_map(Point3::from);
        prop::collection::vec(point, n)
    }

    fn pairs() -> impl Strategy<Value = PointPairs> {
        (0..20usize)
            .prop_flat_map(|n| (points(n), points(n)))
            .prop_map(|(target, source)| PointPairs::new(target, source).unwrap())
    }

    fn plain_fcg(pairs: &PointPairs, tolerance: f64) -> DMatrix<f64> {
        DMatrix::from_fn(pairs.len(), pairs.len(), |m, n| {
            let target = (pairs.target()[m] - pairs.target()[n]).norm();
            let source = (pairs.source()[m] - pairs.source()[n]).norm();
            let affinity = 1.0 - ((target - source) / tolerance).powi(2);
            if m == n { 0.0 } else { affinity.max(0.0) }
        })
    }

    proptest! {
        #[test]
        fn both_graphs_are_their_definitions(pairs in pairs(), tolerance in 0.01..1.0f64) {
            let graph = CompatibilityGraph::new(&pairs, tolerance);
            let fcg = plain_fcg(&pairs, tolerance);
            let scg = (&fcg * &fcg).component_mul(&fcg);
            assert_relative_eq!(graph.fcg(), &fcg, epsilon = 1e-11);
            assert_relative_eq!(graph.scg(), &scg, epsilon = 1e-9);
            prop_assert_eq!(graph.scg(), &graph.scg().transpose());
        }

        #[test]
        fn transforming_a_scan_or_swapping_the_scans_changes_nothing(pairs in pairs(), r in prop::array::uniform3(-3.0..3.0f64)) {
            let graph = CompatibilityGraph::new(&pairs, 0.2);
            prop_assert_eq!(&CompatibilityGraph::new(&pairs.swapped(), 0.2), &graph);
            let transformation = Isometry3::new(Vector3::new(1.0, -2.0, 3.0), Vector3::from(r));
            let moved = pairs.source().iter().map(|p| transformation * p).collect();
            let moved = PointPairs::new(pairs.target().to_vec(), moved).unwrap();
            assert_relative_eq!(CompatibilityGraph::new(&moved, 0.2).scg(), graph.scg(), epsilon = 1e-10);
        }

        #[test]
        fn restricting_the_graph_is_building_it_from_the_restricted_set(pairs in pairs()) {
            let retained: Vec<usize> = (0..pairs.len()).step_by(2).collect();
            let restricted = CompatibilityGraph::new(&pairs, 0.3).restricted_to(&retained);
            prop_assert_eq!(restricted, CompatibilityGraph::new(&pairs.select(&retained), 0.3));
        }
    }

    #[test]
    fn a_rigid_set_is_fully_compatible() {
        let source: Vec<_> = (0..6)
            .map(|k| Point3::new(k as f64, (k * k) as f64, 0.3))
            .collect();
        let transformation =
            Isometry3::new(Vector3::new(4.0, 0.0, -1.0), Vector3::new(0.2, 0.4, 3.0));
        let target = source.iter().map(|p| transformation * p).collect();
        let graph = CompatibilityGraph::new(&PointPairs::new(target, source).unwrap(), 0.1);
        let complete = |value: f64| DMatrix::from_fn(6, 6, |m, n| if m == n { 0.0 } else { value });
        assert_relative_eq!(graph.fcg(), &complete(1.0), epsilon = 1e-12);
        assert_relative_eq!(graph.scg(), &complete(4.0), epsilon = 1e-12);
    }

    #[test]
    fn extreme_coordinates_give_finite_affinities() {
        let target = vec![
            Point3::new(1e100, 0.0, 0.0),
            Point3::new(-1e100, 1e100, 0.0),
            Point3::origin(),
        ];
        let pairs = PointPairs::new(target.clone(), target).unwrap();
        let graph = CompatibilityGraph::new(&pairs, 0.1);
        assert!(graph.scg().iter().all(|b| b.is_finite()));
    }

    #[test]
    fn the_place_in_memory_does_not_change_a_bit() {
        for size in [1, 2, 7, 50, 97, 100] {
            let fcg = DMatrix::from_fn(size, size, |m, n| {
                let wave = (1.0 + (m * n) as f64 * 0.37).sin() + (m + n) as f64 * 0.01;
                if m == n { 0.0 } else { wave.max(0.0) }
            });
            let expected = second_order(&fcg);
            // Copies of different length between them move the following ones.
            let mut padding = Vec::new();
            for k in 1..40 {
                padding.push(vec![0u8; 24 * k]);
                let copy = fcg.clone();
                assert_eq!(second_order(&copy), expected);
                padding.push(
                    copy.as_slice()[..k.min(copy.len())]
                        .iter()
                        .map(|x| *x as u8)
                        .collect(),
                );
            }
        }
    }
}
