use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::{Mat, MatRef, Par};
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
    /// The unit eigenvector `v`. Entries below 1e-12 are noise and set to zero.
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
    /// Full symmetric eigendecomposition, where the two largest eigenvalues are too close for the
    /// power iteration.
    Decomposition,
}

/// Bound of the error of a unit eigenvector at which the power iteration stops.
const VECTOR_TOLERANCE: f64 = 1e-13;
/// Entries of the eigenvector below this are indistinguishable from zero.
const NOISE: f64 = 1e-12;
/// Beyond this many products the decomposition is cheaper.
const MAX_ITERATIONS: usize = 120;

impl DominantEigenpair {
    /// Finds the pair of a symmetric nonnegative matrix.
    ///
    /// Power iteration from the row sums: a positive start has a share of the dominant eigenvector,
    /// so the iteration cannot settle on another one. It stops where the contraction of successive
    /// differences certifies the vector to 1e-13, and falls back to faer's decomposition where that
    /// takes more than 120 products of `O(M²)`, that is for `λ₂/λ₁` above about 0.8.
    pub fn new(matrix: &DMatrix<f64>) -> Self {
        Self::by_power_iteration(matrix).unwrap_or_else(|| Self::by_decomposition(matrix))
    }

    /// Finds the pair by faer's symmetric eigendecomposition, `O(M³)`.
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
        let vector = match decomposed {
            Ok(()) if size > 0 => DVector::from_fn(size, |row, _| vectors[(row, size - 1)].abs()),
            _ => DVector::zeros(size),
        };
        Self::certified(matrix, vector, Route::Decomposition)
    }

    fn by_power_iteration(matrix: &DMatrix<f64>) -> Option<Self> {
        let mut vector = matrix.column_sum();
        vector.try_normalize_mut(0.0);
        let mut last_change = f64::INFINITY;
        for iterations in 1..=MAX_ITERATIONS {
            let mut next = matrix * &vector;
            if next.try_normalize_mut(0.0).is_none() {
                next.fill(0.0);
            }
            let change = (&next - &vector).norm();
            vector = next;
            if remaining_error(change, last_change) <= VECTOR_TOLERANCE {
                let route = Route::Power { iterations };
                return Some(Self::certified(matrix, vector, route));
            }
            last_change = change;
        }
        None
    }

    fn certified(matrix: &DMatrix<f64>, mut vector: DVector<f64>, route: Route) -> Self {
        vector.apply(|entry| {
            if *entry < NOISE {
                *entry = 0.0
            }
        });
        let image = matrix * &vector;
        let value = vector.dot(&image);
        Self {
            value,
            residual: (image - &vector * value).norm(),
            vector,
            route,
        }
    }
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
    fn a_small_gap_is_left_to_the_decomposition() {
        // A long path: λ₂/λ₁ = cos(2π/101) / cos(π/101), nearly one.
        let path = DMatrix::from_fn(100, 100, |m, n| if m.abs_diff(n) == 1 { 1.0 } else { 0.0 });
        let eigenpair = DominantEigenpair::new(&path);
        assert_eq!(eigenpair.route, Route::Decomposition);
        let exact = 2.0 * (std::f64::consts::PI / 101.0).cos();
        assert_relative_eq!(eigenpair.value, exact, max_relative = 1e-13);
        assert!(eigenpair.residual < 1e-12);
    }

    #[test]
    fn the_weight_of_two_equal_cliques_is_shared() {
        let block = |k: usize| k / 3;
        let matrix = DMatrix::from_fn(6, 6, |m, n| {
            if m != n && block(m) == block(n) {
                1.0
            } else {
                0.0
            }
        });
        let eigenpair = DominantEigenpair::new(&matrix);
        assert_relative_eq!(eigenpair.value, 2.0, max_relative = 1e-14);
        assert_relative_eq!(
            eigenpair.vector,
            DVector::repeat(6, 6f64.sqrt().recip()),
            epsilon = 1e-14
        );
    }
}
