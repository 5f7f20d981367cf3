mod components;
mod lanczos;
mod power;
mod products;
mod tridiagonal;

use std::ops::Range;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::{Mat, MatRef, Par};
use nalgebra::{DMatrix, DVector};

use self::components::connected_components;
use self::lanczos::by_lanczos;
use self::power::by_power_iteration;
use self::products::inner_products;

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
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct DominantEigenpair {
    /// The eigenvalue `λ`, as the Rayleigh quotient of the vector.
    pub value: f64,
    /// The unit eigenvector `v`: exactly zero outside of the dominant connected component of the matrix. Entries
    /// below 1e-12 within may be zero, too, unless the power iteration found it.
    pub vector: DVector<f64>,
    /// Norm of `B v − λ v`: the distance of `λ` to the nearest exact eigenvalue is at most this.
    pub residual: f64,
    /// How the pair was found.
    pub route: Route,
}

/// The algorithm that gave a [`DominantEigenpair`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Route {
    /// Power iteration.
    Power {
        /// Products with the matrix.
        iterations: usize,
    },
    /// Lanczos's method, where the power iteration is slow.
    Lanczos {
        /// Products with the matrix, those of the power iteration before included.
        iterations: usize,
        /// Those that made the basis larger.
        steps: usize,
    },
    /// Full symmetric eigendecomposition, where neither found it.
    Decomposition,
}

/// Entries below this of a unit eigenvector from Lanczos's method or a decomposition, where sums cancel, are
/// rounding noise.
const NOISE: f64 = 1e-12;
/// Largest row sums of matrices whose eigenvectors are iterated: squares of their entries neither vanish nor
/// overflow.
const SCALES: Range<f64> = 1e-140..1e140;

impl DominantEigenpair {
    /// Finds the pair of a symmetric nonnegative matrix.
    ///
    /// A disconnected matrix has the eigenpairs of its components, so each component
    /// is solved alone, and only while its largest row sum, a bound of its eigenvalue, exceeds the
    /// best eigenvalue so far (equal ones: the component of the lowest index). Within a component, power
    /// iteration from the row sums cannot settle on another eigenvector, as a positive start has a
    /// fraction of the dominant one. It stops where the contraction of successive differences puts the
    /// error of the vector below 1e-13, or where a step is rounding noise. Where that would take more than
    /// 60 products, that is for `λ₂/λ₁` above about 0.6, Lanczos's method goes on from where it is, to a
    /// residual of 1e-15 of the eigenvalue, and sets entries below 1e-12 to zero. A full symmetric
    /// eigendecomposition, `O(M³)`, remains for what fails and for numbers beyond 1e±140. `O(M²)` per product.
    pub fn new(matrix: &DMatrix<f64>) -> Self {
        let mut best = Self::zero(matrix.nrows());
        for component in connected_components(matrix) {
            if component.bound <= best.value {
                break;
            }
            let entries = component.of(matrix);
            let iterated = || match by_power_iteration(&entries) {
                Ok(eigenpair) => Some(eigenpair),
                Err(start) => by_lanczos(&entries, start),
            };
            let found = SCALES.contains(&component.bound).then(iterated).flatten();
            let eigenpair = found.unwrap_or_else(|| Self::by_decomposition(&entries));
            if eigenpair.value > best.value {
                best = eigenpair.embedded(&component.nodes, matrix.nrows());
            }
        }
        best
    }

    /// Finds the pair by faer's symmetric eigendecomposition of the whole matrix, `O(M³)`. Entries
    /// below 1e-12 are noise and set to zero.
    fn by_decomposition(matrix: &DMatrix<f64>) -> Self {
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
            Ok(()) => DVector::from_fn(size, |row, _| without_noise(vectors[(row, size - 1)])),
            Err(_) => DVector::zeros(size),
        };
        Self::certified(matrix, vector, Route::Decomposition)
    }

    fn certified(matrix: &DMatrix<f64>, vector: DVector<f64>, route: Route) -> Self {
        let image = inner_products(matrix.as_slice(), &vector);
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

    /// The pair of a component as one of the whole: zero outside of the component.
    fn embedded(self, nodes: &[usize], size: usize) -> Self {
        let mut vector = DVector::zeros(size);
        for (&node, &entry) in nodes.iter().zip(self.vector.iter()) {
            vector[node] = entry;
        }
        Self { vector, ..self }
    }
}

/// The entry of a nonnegative eigenvector that is known up to [`NOISE`] and its sign.
fn without_noise(entry: f64) -> f64 {
    if entry.abs() < NOISE {
        0.0
    } else {
        entry.abs()
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    use super::*;

    /// A symmetric nonnegative matrix with a zero diagonal, sparse enough to be disconnected at times.
    fn affinities() -> impl Strategy<Value = DMatrix<f64>> {
        let entry = prop_oneof![2 => Just(0.0), 1 => 0.0..1.0f64];
        (1..60usize).prop_flat_map(move |n| {
            prop::collection::vec(entry.clone(), n * n).prop_map(move |entries| {
                let mut matrix = DMatrix::from_vec(n, n, entries);
                matrix.fill_diagonal(0.0);
                matrix.fill_upper_triangle_with_lower_triangle();
                matrix
            })
        })
    }

    /// Ties of one between neighbors in a row: `λ₁ = 2 cos(π / (n + 1))`.
    fn path(size: usize) -> DMatrix<f64> {
        DMatrix::from_fn(
            size,
            size,
            |m, n| if m.abs_diff(n) == 1 { 1.0 } else { 0.0 },
        )
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
            // A positive constant separates the largest eigenvalue from the others.
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
        let path = path(20);
        let of_path = 2.0 * (std::f64::consts::PI / 21.0).cos();
        let tiny = [1e-250, 1e-200, 1e-165, 1e-160, 1e-155, 1e-150, 1e-130];
        let huge = [1e130, 1e150, 1e155, 1e160, 1e200, 1e250];
        for scale in tiny.into_iter().chain(huge) {
            let of_clique = DominantEigenpair::new(&(&clique * scale));
            assert_relative_eq!(of_clique.value, 5.0 * scale, max_relative = 1e-12);
            let eigenpair = DominantEigenpair::new(&(&path * scale));
            assert_relative_eq!(eigenpair.value, of_path * scale, max_relative = 1e-12);
            let reference = DominantEigenpair::by_decomposition(&path);
            assert_relative_eq!(eigenpair.vector, reference.vector, epsilon = 1e-11);
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
    fn a_small_gap_is_left_to_lanczos() {
        // A long path: λ₂/λ₁ = cos(2π/101) / cos(π/101), nearly one.
        let path = path(100);
        let eigenpair = DominantEigenpair::new(&path);
        assert!(
            matches!(eigenpair.route, Route::Lanczos { .. }),
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
    fn a_gap_that_lanczos_cannot_resolve_is_left_to_the_decomposition() {
        let eigenpair = DominantEigenpair::new(&path(400));
        assert_eq!(eigenpair.route, Route::Decomposition);
        let exact = 2.0 * (std::f64::consts::PI / 401.0).cos();
        assert_relative_eq!(eigenpair.value, exact, max_relative = 1e-13);
    }

    #[test]
    fn lanczos_ends_in_fewer_steps_than_there_are_nodes() {
        // A path with ties of all strengths, where nothing is symmetric.
        let tie = |k: usize| 0.6 + 0.4 * (1.7 * (k * k) as f64).sin();
        let matrix = DMatrix::from_fn(90, 90, |m, n| match m.abs_diff(n) {
            1 => tie(m.min(n)),
            2 => 0.2 * tie(m + n),
            _ => 0.0,
        });
        let eigenpair = DominantEigenpair::new(&matrix);
        let is_short = matches!(eigenpair.route, Route::Lanczos { steps, .. } if steps < 90);
        assert!(is_short, "{:?}", eigenpair.route);
        assert!(eigenpair.residual < 1e-11, "{}", eigenpair.residual);
        let reference = DominantEigenpair::by_decomposition(&matrix);
        assert_relative_eq!(eigenpair.vector, reference.vector, epsilon = 1e-11);
    }

    #[test]
    fn a_star_has_an_opposite_eigenvalue_and_a_space_of_two_dimensions() {
        let star = DMatrix::from_fn(26, 26, |m, n| if (m == 0) != (n == 0) { 1.0 } else { 0.0 });
        let eigenpair = DominantEigenpair::new(&star);
        assert!(matches!(eigenpair.route, Route::Lanczos { steps: 2, .. }));
        assert_relative_eq!(eigenpair.value, 5.0, max_relative = 1e-14);
        assert_relative_eq!(eigenpair.vector[0], 0.5f64.sqrt(), max_relative = 1e-13);
    }

    #[test]
    fn nearly_equal_cliques_that_hardly_touch_keep_a_small_residual() {
        let mut matrix = DMatrix::from_fn(12, 12, |m, n| match (m / 6 == n / 6, m == n) {
            (true, false) if m < 6 => 1.0,
            (true, false) => 1.0 - 1e-13,
            _ => 0.0,
        });
        for tie in [1e-14, 1e-12] {
            (matrix[(0, 6)], matrix[(6, 0)]) = (tie, tie);
            let eigenpair = DominantEigenpair::new(&matrix);
            assert!(eigenpair.residual < 2e-14, "{tie}: {eigenpair:?}");
        }
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
}
