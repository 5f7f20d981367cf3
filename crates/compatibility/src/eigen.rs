use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::cholesky::llt::solve::solve_in_place_with_conj;
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::traits::pulp::{Arch, Simd, WithSimd};
use faer::{Conj, Mat, MatMut, MatRef, Par};
use nalgebra::{DMatrix, DVector};

/// Largest eigenvalue of a symmetric nonnegative matrix and its nonnegative unit eigenvector.
///
/// The eigenvector exists and can be chosen nonnegative by Perron and Frobenius. The zero matrix
/// has eigenvalue 0 and, as no direction is dominant, a zero vector.
///
/// ```
/// use gmpcr_compatibility::DominantEigenpair;
/// use nalgebra::dmatrix;
///
/// let eigenpair = DominantEigenpair::new(&dmatrix![0.0, 2.0; 2.0, 0.0]);
/// assert!((eigenpair.value - 2.0).abs() < 1e-14);
/// assert!((eigenpair.vector[0] - 0.5f64.sqrt()).abs() < 1e-14);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct DominantEigenpair {
    /// The eigenvalue `λ`, as the Rayleigh quotient of the vector.
    pub value: f64,
    /// The unit eigenvector `v`: exactly zero outside of the dominant connected part of the matrix.
    pub vector: DVector<f64>,
    /// Norm of `B v − λ v`: the distance of `λ` to the nearest exact eigenvalue is at most this.
    pub residual: f64,
    /// How the pair was found.
    pub route: Route,
}

/// The algorithm that gave a [`DominantEigenpair`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Route {
    /// Power iteration.
    Power {
        /// Products with the matrix.
        iterations: usize,
    },
    /// Inverse iteration from where the power iteration was slow.
    Inverse {
        /// Solves with the shifted matrix.
        iterations: usize,
    },
    /// Full symmetric eigendecomposition, where the two largest eigenvalues are too close for either.
    Decomposition,
}

/// Bound of the error of a unit eigenvector at which the power iteration stops.
const VECTOR_TOLERANCE: f64 = 1e-13;
/// Entries of an eigenvector from a decomposition below this are rounding noise.
const NOISE: f64 = 1e-12;
/// Beyond this many products inverse iteration is cheaper.
const MAX_ITERATIONS: usize = 40;
/// Solves with one factor before the shift moves closer.
const SOLVES_PER_SHIFT: usize = 3;
/// Factorisations before the inverse iteration gives up.
const MAX_FACTORISATIONS: usize = 8;

impl DominantEigenpair {
    /// Finds the pair of a symmetric nonnegative matrix.
    ///
    /// A matrix that falls apart into connected parts has the eigenpairs of its parts, so each part
    /// is solved alone, and only while its largest row sum, a bound of its eigenvalue, exceeds the
    /// best eigenvalue so far (equal ones: the part of the lowest index). Within a part, power
    /// iteration from the row sums cannot settle on another eigenvector, as a positive start has a
    /// share of the dominant one. It stops where the contraction of successive differences certifies
    /// the vector to 1e-13. Where that takes more than 40 products, that is for `λ₂/λ₁` above about
    /// 0.5, inverse iteration goes on with a shift `σ` behind `λ₁`: that `σ I − B` has a Cholesky
    /// decomposition proves that no eigenvalue lies beyond. Where eigenvalues nearly coincide,
    /// [`by_decomposition`](Self::by_decomposition) remains. `O(M²)` per product and solve.
    pub fn new(matrix: &DMatrix<f64>) -> Self {
        let mut best = Self::zero(matrix.nrows());
        for part in connected_parts(matrix) {
            if part.bound <= best.value {
                break;
            }
            let entries = part.of(matrix);
            let eigenpair = match by_power_iteration(&entries) {
                Ok(eigenpair) => eigenpair,
                Err(vector) => by_inverse_iteration(&entries, vector)
                    .unwrap_or_else(|| Self::by_decomposition(&entries)),
            };
            if eigenpair.value > best.value {
                best = eigenpair.embedded(&part.nodes, matrix.nrows());
            }
        }
        best
    }

    /// Finds the pair by faer's symmetric eigendecomposition of the whole matrix, `O(M³)`. Entries
    /// below 1e-12 are noise and set to zero.
    pub fn by_decomposition(matrix: &DMatrix<f64>) -> Self {
        let size = matrix.nrows();
        let entries = MatRef::from_column_major_slice(matrix.as_slice(), size, size);
        let mut vectors = Mat::<f64>::zeros(size, size);
        let mut values = faer::Col::<f64>::zeros(size);
        let (yes, par) = (ComputeEigenvectors::Yes, Par::Seq);
        let scratch = self_adjoint_evd_scratch::<f64>(size, yes, par, Default::default());
        let decomposed = self_adjoint_evd(
            entries,
            values.as_diagonal_mut(),
            Some(vectors.as_mut()),
            par,
            MemStack::new(&mut MemBuffer::new(scratch)),
            Default::default(),
        );
        let entry = |row: usize| Some(vectors[(row, size - 1)].abs()).filter(|&v| v >= NOISE);
        let vector = match decomposed {
            Ok(()) => DVector::from_fn(size, |row, _| entry(row).unwrap_or(0.0)),
            Err(_) => DVector::zeros(size),
        };
        Self::certified(matrix, vector, Route::Decomposition)
    }

    fn certified(matrix: &DMatrix<f64>, vector: DVector<f64>, route: Route) -> Self {
        let image = product(matrix, &vector);
        let value = vector.dot(&image);
        Self {
            value,
            residual: (image - &vector * value).norm(),
            vector,
            route,
        }
    }

    fn zero(size: usize) -> Self {
        Self {
            value: 0.0,
            vector: DVector::zeros(size),
            residual: 0.0,
            route: Route::Power { iterations: 0 },
        }
    }

    /// The pair of a part as one of the whole: zero outside of the part.
    fn embedded(self, nodes: &[usize], size: usize) -> Self {
        let mut vector = DVector::zeros(size);
        for (&node, &entry) in nodes.iter().zip(self.vector.iter()) {
            vector[node] = entry;
        }
        Self { vector, ..self }
    }
}

/// The dominant pair, or the approximate vector where the iteration is too slow.
fn by_power_iteration(matrix: &DMatrix<f64>) -> Result<DominantEigenpair, DVector<f64>> {
    let mut vector = product(matrix, &DVector::repeat(matrix.nrows(), 1.0));
    let mut last_change = f64::INFINITY;
    if vector.try_normalize_mut(0.0).is_none() {
        return Err(vector);
    }
    for iterations in 1..=MAX_ITERATIONS {
        let mut next = product(matrix, &vector);
        if next.try_normalize_mut(0.0).is_none() {
            return Err(vector);
        }
        let change = (&next - &vector).norm();
        vector = next;
        if remaining_error(change, last_change) <= VECTOR_TOLERANCE {
            let route = Route::Power { iterations };
            return Ok(DominantEigenpair::certified(matrix, vector, route));
        }
        last_change = change;
    }
    Err(vector)
}

/// Inverse iteration `v ← (σ I − B)⁻¹ v` from an approximation of the dominant eigenvector.
///
/// The Rayleigh quotient is below `λ₁`, and with the residual added mostly just above it. A shift
/// that is not makes the factorisation fail and is moved away by ten times its distance. Every few
/// solves the shift moves closer, so that each solve gains several digits.
fn by_inverse_iteration(
    matrix: &DMatrix<f64>,
    mut vector: DVector<f64>,
) -> Option<DominantEigenpair> {
    let (mut iterations, mut margin) = (0, 1.0);
    for _ in 0..MAX_FACTORISATIONS {
        let image = product(matrix, &vector);
        let quotient = vector.dot(&image);
        let residual = (image - &vector * quotient).norm();
        let distance = margin * residual.max(quotient * 1e-13);
        let Some(mut factor) = ShiftedFactor::new(matrix, quotient + distance) else {
            margin *= 10.0;
            continue;
        };
        let mut last_change = f64::INFINITY;
        for _ in 0..SOLVES_PER_SHIFT {
            let next = factor.solve(&vector)?;
            let change = (&next - &vector).norm();
            vector = next;
            iterations += 1;
            if remaining_error(change, last_change) <= VECTOR_TOLERANCE {
                let entry = |v: f64| if v.abs() < NOISE { 0.0 } else { v.abs() };
                let vector = vector.map(entry);
                let route = Route::Inverse { iterations };
                return Some(DominantEigenpair::certified(matrix, vector, route));
            }
            last_change = change;
        }
    }
    None
}

/// The Cholesky factor of `σ I − B`.
struct ShiftedFactor {
    factor: DMatrix<f64>,
    scratch: MemBuffer,
}

impl ShiftedFactor {
    /// `None` unless `σ` exceeds every eigenvalue of `B` in floating point.
    fn new(matrix: &DMatrix<f64>, shift: f64) -> Option<Self> {
        let size = matrix.nrows();
        let mut factor = -matrix;
        factor.set_diagonal(&matrix.diagonal().map(|entry| shift - entry));
        let (par, params) = (Par::Seq, Default::default());
        let mut scratch = MemBuffer::new(cholesky_in_place_scratch::<f64>(size, par, params));
        let entries = MatMut::from_column_major_slice_mut(factor.as_mut_slice(), size, size);
        let stack = MemStack::new(&mut scratch);
        cholesky_in_place(entries, Default::default(), par, stack, params).ok()?;
        Some(Self { factor, scratch })
    }

    /// The solution in the direction of `vector`, of unit length; `None` if it overflows.
    fn solve(&mut self, vector: &DVector<f64>) -> Option<DVector<f64>> {
        let size = vector.len();
        let factor = MatRef::from_column_major_slice(self.factor.as_slice(), size, size);
        let mut solution = vector.clone();
        let right = MatMut::from_column_major_slice_mut(solution.as_mut_slice(), size, 1);
        let stack = MemStack::new(&mut self.scratch);
        solve_in_place_with_conj(factor, Conj::No, right, Par::Seq, stack);
        let norm = solution.norm();
        (norm > 0.0 && norm.is_finite()).then(|| solution / norm)
    }
}

/// `B v` of a symmetric matrix.
fn product(matrix: &DMatrix<f64>, vector: &DVector<f64>) -> DVector<f64> {
    Arch::new().dispatch(Product { matrix, vector })
}

/// A product, column by column as inner products, in the widest vectors that the machine has.
struct Product<'a> {
    matrix: &'a DMatrix<f64>,
    vector: &'a DVector<f64>,
}

impl WithSimd for Product<'_> {
    type Output = DVector<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> DVector<f64> {
        let size = self.vector.len();
        let (blocks, rest) = S::as_simd_f64s(self.vector.as_slice());
        let mut image = DVector::zeros(size);
        let columns = self.matrix.as_slice().chunks_exact(size.max(1));
        for (entry, column) in image.as_mut_slice().iter_mut().zip(columns) {
            let (column_blocks, column_rest) = S::as_simd_f64s(column);
            *entry = inner_product(simd, column_blocks, blocks);
            for (x, y) in column_rest.iter().zip(rest) {
                *entry += x * y;
            }
        }
        image
    }
}

/// Four partial sums hide the time that an addition takes.
#[inline(always)]
fn inner_product<S: Simd>(simd: S, x: &[S::f64s], y: &[S::f64s]) -> f64 {
    let ((x_fours, x_rest), (y_fours, y_rest)) = (x.as_chunks::<4>(), y.as_chunks::<4>());
    let mut sums = [simd.splat_f64s(0.0); 4];
    for (x, y) in x_fours.iter().zip(y_fours) {
        for lane in 0..4 {
            sums[lane] = simd.mul_add_f64s(x[lane], y[lane], sums[lane]);
        }
    }
    for (&x, &y) in x_rest.iter().zip(y_rest) {
        sums[0] = simd.mul_add_f64s(x, y, sums[0]);
    }
    let [a, b, c, d] = sums;
    simd.reduce_sum_f64s(simd.add_f64s(simd.add_f64s(a, b), simd.add_f64s(c, d)))
}

/// A connected part of the graph of the positive entries.
struct Part {
    /// Its nodes, ascending.
    nodes: Vec<usize>,
    /// Its largest row sum.
    bound: f64,
}

impl Part {
    /// Its rows and columns of the matrix, copied by runs of successive nodes.
    fn of(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        let (size, all) = (self.nodes.len(), matrix.nrows());
        let runs: Vec<_> = self.nodes.chunk_by(|a, b| a + 1 == *b).collect();
        let mut entries = Vec::with_capacity(size * size);
        for &node in &self.nodes {
            let column = &matrix.as_slice()[node * all..][..all];
            for run in &runs {
                entries.extend_from_slice(&column[run[0]..][..run.len()]);
            }
        }
        DMatrix::from_vec(size, size, entries)
    }
}

/// The parts with a positive entry in descending order of their bounds; equal ones: lower index.
fn connected_parts(matrix: &DMatrix<f64>) -> Vec<Part> {
    let size = matrix.nrows();
    let row_sums = product(matrix, &DVector::repeat(size, 1.0));
    let mut unseen: Vec<usize> = (0..size).rev().collect();
    let mut parts = Vec::new();
    while let Some(first) = unseen.pop() {
        if row_sums[first] <= 0.0 {
            continue;
        }
        let (mut nodes, mut next, mut bound) = (vec![first], 0, 0f64);
        while next < nodes.len() {
            let column = &matrix.as_slice()[nodes[next] * size..(nodes[next] + 1) * size];
            bound = bound.max(row_sums[nodes[next]]);
            unseen.retain(|&node| {
                let is_joined = column[node] > 0.0;
                if is_joined {
                    nodes.push(node);
                }
                !is_joined
            });
            next += 1;
        }
        nodes.sort_unstable();
        parts.push(Part { nodes, bound });
    }
    parts.sort_by(|a, b| b.bound.total_cmp(&a.bound).then(a.nodes.cmp(&b.nodes)));
    parts
}

/// Distance to the limit of a sequence whose last two steps had these lengths: the errors shrink
/// geometrically by the ratio `λ₂/λ₁`, which the lengths of the steps reveal. A slow share of the
/// error may still hide behind a fast one, so no ratio below one half is believed.
fn remaining_error(change: f64, last_change: f64) -> f64 {
    if change <= 4.0 * f64::EPSILON {
        return 0.0; // rounding: nothing is left to gain
    }
    if last_change == f64::INFINITY {
        return f64::INFINITY; // one step reveals no ratio
    }
    let ratio = (change / last_change).clamp(0.5, 0.999);
    change * ratio / (1.0 - ratio)
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    use super::*;

    /// A symmetric nonnegative matrix with a zero diagonal, sparse enough to fall apart at times.
    fn affinities() -> impl Strategy<Value = DMatrix<f64>> {
        let entry = prop_oneof![2 => Just(0.0), 1 => 0.0..1.0f64];
        (1..30usize).prop_flat_map(move |n| {
            prop::collection::vec(entry.clone(), n * n).prop_map(move |entries| {
                let mut matrix = DMatrix::from_vec(n, n, entries);
                matrix.fill_diagonal(0.0);
                matrix.fill_upper_triangle_with_lower_triangle();
                matrix
            })
        })
    }

    proptest! {
        #[test]
        fn both_routes_find_the_same_eigenvalue(matrix in affinities()) {
            let fast = DominantEigenpair::new(&matrix);
            let reference = DominantEigenpair::by_decomposition(&matrix);
            prop_assert!((fast.value - reference.value).abs() <= 1e-11 * (1.0 + reference.value));
            prop_assert!(fast.residual <= 1e-11 * (1.0 + fast.value));
        }

        #[test]
        fn both_routes_find_the_same_vector_where_it_is_unique(matrix in affinities(), shift in 0.5..1.0f64) {
            // A dense positive part separates the largest eigenvalue from the others.
            let matrix = matrix.map(|b| b + shift);
            let fast = DominantEigenpair::new(&matrix);
            let reference = DominantEigenpair::by_decomposition(&matrix);
            let is_power = matches!(fast.route, Route::Power { .. });
            prop_assert!(is_power);
            assert_relative_eq!(fast.vector, reference.vector, epsilon = 1e-11);
        }
    }

    #[test]
    fn the_zero_matrix_has_no_dominant_direction() {
        for size in [0, 1, 7] {
            let eigenpair = DominantEigenpair::new(&DMatrix::zeros(size, size));
            assert_eq!(eigenpair.value, 0.0);
            assert_eq!(eigenpair.vector, DVector::zeros(size));
        }
    }

    #[test]
    fn extreme_scales_keep_the_eigenvalue() {
        let clique = DMatrix::from_fn(6, 6, |m, n| if m == n { 0.0 } else { 1.0 });
        for scale in [1e-250, 1e-200, 1e-150, 1e150, 1e200, 1e250] {
            let eigenpair = DominantEigenpair::new(&(&clique * scale));
            assert_relative_eq!(eigenpair.value, 5.0 * scale, max_relative = 1e-12);
        }
    }

    #[test]
    fn the_larger_of_two_separate_cliques_takes_all() {
        let mut matrix = DMatrix::zeros(9, 9);
        for (range, value) in [(0..3, 1.0), (3..8, 1.0)] {
            for (m, n) in range
                .clone()
                .flat_map(|m| range.clone().map(move |n| (m, n)))
            {
                matrix[(m, n)] = if m == n { 0.0 } else { value };
            }
        }
        let eigenpair = DominantEigenpair::new(&matrix);
        assert_relative_eq!(eigenpair.value, 4.0, max_relative = 1e-13);
        assert!(eigenpair.vector.rows(0, 3).iter().all(|&v| v == 0.0));
        assert!(
            eigenpair
                .vector
                .rows(3, 5)
                .iter()
                .all(|&v| (v - 0.2f64.sqrt()).abs() < 1e-12)
        );
        assert_eq!(eigenpair.vector[8], 0.0);
    }

    #[test]
    fn a_small_gap_is_left_to_the_inverse_iteration() {
        // A long path: λ₂/λ₁ = cos(2π/101) / cos(π/101), nearly one.
        let path = DMatrix::from_fn(100, 100, |m, n| if m.abs_diff(n) == 1 { 1.0 } else { 0.0 });
        let eigenpair = DominantEigenpair::new(&path);
        assert!(
            matches!(eigenpair.route, Route::Inverse { .. }),
            "{:?}",
            eigenpair.route
        );
        let reference = DominantEigenpair::by_decomposition(&path);
        assert_relative_eq!(eigenpair.vector, reference.vector, epsilon = 1e-11);
        let exact = 2.0 * (std::f64::consts::PI / 101.0).cos();
        assert_relative_eq!(eigenpair.value, exact, max_relative = 1e-13);
        assert!(eigenpair.residual < 1e-12);
    }

    #[test]
    fn of_two_equal_cliques_the_first_is_dominant() {
        let block = |k: usize| k / 3;
        let is_joined = |m, n| m != n && block(m) == block(n);
        let matrix = DMatrix::from_fn(6, 6, |m, n| if is_joined(m, n) { 1.0 } else { 0.0 });
        let eigenpair = DominantEigenpair::new(&matrix);
        assert_relative_eq!(eigenpair.value, 2.0, max_relative = 1e-14);
        let third = 3f64.sqrt().recip();
        let expected = DVector::from_fn(6, |k, _| if k < 3 { third } else { 0.0 });
        assert_relative_eq!(eigenpair.vector, expected, epsilon = 1e-14);
    }

    #[test]
    fn parts_are_connected_and_ordered_by_their_bounds() {
        let edges = [(0, 4, 1.0), (1, 2, 3.0), (2, 5, 0.5)];
        let mut matrix = DMatrix::zeros(7, 7);
        for (m, n, weight) in edges {
            matrix[(m, n)] = weight;
            matrix[(n, m)] = weight;
        }
        let parts: Vec<_> = connected_parts(&matrix)
            .into_iter()
            .map(|p| (p.nodes, p.bound))
            .collect();
        assert_eq!(parts, [(vec![1, 2, 5], 3.5), (vec![0, 4], 1.0)]);
    }
}
