use nalgebra::SymmetricEigen;

use super::filter::Filter;
use super::problem::{Eigenspace, LOWEST_SHIFT, SemidefiniteMatrix, TOLERANCE};
use super::ritz::{padded, rayleigh_ritz};

/// Further vectors iterated along, so that the filter need not separate the wanted ones from their next
/// neighbors.
const GUARD: usize = 3;
/// Residual, in units of the scale, at which the search stops once it no longer falls fast.
const SMALL_RESIDUAL: f64 = 1e-13;
/// A filter that leaves more than this fraction of the residual gains nothing any more.
const STALL: f64 = 0.25;
/// Residual, in units of the scale, that a solution has at most.
const ACCEPTABLE: f64 = 1e-11;
/// Filters that must halve the residual, or the search gives up: so many eigenvalues nearly coincide
/// that it would take hundreds.
const PATIENCE: usize = 4;
/// Filters before the search gives up in any case.
const MAX_FILTERS: usize = 24;
/// Up to this many rows a full decomposition is affordable where the search gives up.
const DENSE_LIMIT: usize = 600;
/// Steps of the full decomposition; a few per row are usual.
const MAX_QR_STEPS: usize = 100 * DENSE_LIMIT;

/// Finds the `wanted` smallest eigenvectors by Chebyshev-filtered subspace iteration with
/// Rayleigh–Ritz projection, starting from the first columns of `start`.
///
/// The filter is a polynomial of the inverse of the shifted matrix, or of the matrix itself where it
/// cannot be factored. The block keeps a multiple eigenvalue (noise-free rotations have λ = 0 three times)
/// from being missed, as single-vector Krylov methods may. Where the iteration stalls (eigenvalues
/// that nearly coincide) and the matrix is small, a full decomposition takes over; a large one is
/// returned as it stands, with its residual.
pub(crate) fn smallest_eigenvectors(
    matrix: &mut impl SemidefiniteMatrix,
    wanted: usize,
    start: &Eigenspace,
) -> Eigenspace {
    let scale = matrix.scale();
    let block = (wanted + GUARD).min(matrix.size());
    let mut ritz = rayleigh_ritz(matrix, wanted, padded(&start.vectors, block));
    let mut filter = Filter::new(matrix, start.shift);
    let (mut error, mut milestone) = (1.0, f64::INFINITY);
    let max_filters = if scale > 0.0 { MAX_FILTERS } else { 0 };
    for filters in 1..=max_filters {
        let (before, residual_before) = (ritz.vectors.clone(), ritz.residual());
        let degree = filter.degree(&ritz, error);
        let filtered = filter.apply(matrix, &ritz, degree);
        ritz = rayleigh_ritz(matrix, wanted, filtered);
        // What the filter changed is the error there was.
        let decay = ritz.residual() / residual_before.max(f64::MIN_POSITIVE);
        error = ritz.change_since(&before).min(1.0) * decay;
        let residual = ritz.residual() / scale;
        let is_converged = error <= TOLERANCE && residual <= ACCEPTABLE;
        if is_converged || residual <= SMALL_RESIDUAL && decay >= STALL {
            return ritz.into_eigenspace(scale, filter.shift());
        }
        if filters % PATIENCE == 0 {
            if ritz.residual() > 0.5 * milestone {
                break;
            }
            milestone = ritz.residual();
        }
        filter.move_closer(matrix, &ritz, error);
    }
    if ritz.residual() > ACCEPTABLE * scale
        && matrix.size() <= DENSE_LIMIT
        && let Some(exact) = dense_eigenvectors(matrix, wanted)
    {
        return exact;
    }
    ritz.into_eigenspace(scale, filter.shift())
}

/// The eigenvectors by the full decomposition; `None` where it does not converge.
fn dense_eigenvectors(matrix: &impl SemidefiniteMatrix, wanted: usize) -> Option<Eigenspace> {
    let eigen = SymmetricEigen::try_new(matrix.to_dense(), f64::EPSILON, MAX_QR_STEPS)?;
    let mut order: Vec<usize> = (0..matrix.size()).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    order.truncate(wanted + GUARD);
    let vectors = eigen.eigenvectors.select_columns(&order);
    let scale = matrix.scale();
    Some(rayleigh_ritz(matrix, wanted, vectors).into_eigenspace(scale, LOWEST_SHIFT * scale))
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, Rotation3, Vector3};

    use super::*;
    use crate::cholesky::Unfactorable;
    use crate::laplacian::ConnectionLaplacian;
    use crate::subgraph::{Measurement, Subgraph};

    /// A ring with chords whose rotations are off by up to `noise`.
    fn graph(num_nodes: usize, noise: f64) -> Subgraph {
        circulant(num_nodes, &[1, 2, 5], noise)
    }

    /// Each node is joined with those so many steps ahead.
    fn circulant(num_nodes: usize, steps: &[usize], noise: f64) -> Subgraph {
        let node = |k: usize| Rotation3::new(Vector3::new(k as f64, 0.5 * k as f64, -1.0));
        let pairs =
            (0..num_nodes).flat_map(|i| steps.iter().map(move |step| (i, (i + step) % num_nodes)));
        let measurement = |(k, (i, j)): (usize, (usize, usize))| {
            let phase = k as f64 * 1.7;
            let error = Vector3::new(phase.sin(), phase.cos(), (2.0 * phase).sin()) * noise;
            let rotation = node(i).inverse() * node(j) * Rotation3::new(error);
            Measurement {
                i,
                j,
                rotation,
                translation: Vector3::zeros(),
            }
        };
        let measurements = pairs
            .filter(|(i, j)| i != j)
            .enumerate()
            .map(measurement)
            .collect();
        Subgraph {
            num_nodes,
            measurements,
        }
    }

    fn distance(a: &DMatrix<f64>, b: &DMatrix<f64>) -> f64 {
        let (a, b) = (a.columns(0, 3).into_owned(), b.columns(0, 3).into_owned());
        (&a - &b * b.tr_mul(&a)).norm()
    }

    #[test]
    fn the_iteration_finds_the_space_of_the_full_decomposition() {
        for (num_nodes, noise) in [
            (1, 0.0),
            (2, 0.1),
            (3, 0.1),
            (7, 0.0),
            (40, 0.0),
            (40, 0.05),
            (60, 0.4),
            (90, 1.0),
        ] {
            let graph = graph(num_nodes, noise);
            let mut laplacian = ConnectionLaplacian::new(&graph);
            laplacian.set_weights(&vec![0.7; graph.measurements.len()]);
            let start = Eigenspace::guess(DMatrix::from_element(3 * num_nodes, 1, 1.0));
            let found = smallest_eigenvectors(&mut laplacian, 3, &start);
            let dense = dense_eigenvectors(&laplacian, 3).unwrap();
            assert!(
                found.residual < 1e-11,
                "{num_nodes} nodes: residual {}",
                found.residual
            );
            assert!(
                distance(&found.vectors, &dense.vectors) < 1e-8,
                "{num_nodes} nodes"
            );
        }
    }

    /// A matrix that cannot be factored.
    struct Unfactored<M>(M);

    impl<M: SemidefiniteMatrix> SemidefiniteMatrix for Unfactored<M> {
        fn size(&self) -> usize {
            self.0.size()
        }

        fn scale(&self) -> f64 {
            self.0.scale()
        }

        fn upper_bound(&self) -> f64 {
            self.0.upper_bound()
        }

        fn multiply(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
            self.0.multiply(x)
        }

        fn factorize(&mut self, _shift: f64) -> Result<(), Unfactorable> {
            Err(Unfactorable)
        }

        fn solve_in_place(&mut self, _x: &mut DMatrix<f64>) {
            unreachable!("there is no factor")
        }

        fn to_dense(&self) -> DMatrix<f64> {
            self.0.to_dense()
        }
    }

    #[test]
    fn polynomials_of_the_matrix_find_the_space_without_a_factor() {
        // Beyond the limit of the full decomposition.
        for noise in [0.0, 0.1] {
            let graph = circulant(DENSE_LIMIT, &[1, 7, 49, 171], noise);
            let mut laplacian = ConnectionLaplacian::new(&graph);
            laplacian.set_weights(&vec![0.7; graph.measurements.len()]);
            let start = DMatrix::from_element(3 * DENSE_LIMIT, 1, 1.0);
            let start = Eigenspace::guess(start);
            let factored = smallest_eigenvectors(&mut laplacian, 3, &start);
            let free = smallest_eigenvectors(&mut Unfactored(laplacian), 3, &start);
            assert!(free.residual < 1e-10, "{}", free.residual);
            assert!(distance(&free.vectors, &factored.vectors) < 1e-6);
        }
    }

    #[test]
    fn zero_weights_give_some_orthonormal_vectors() {
        let graph = graph(5, 0.0);
        let mut laplacian = ConnectionLaplacian::new(&graph);
        let found =
            smallest_eigenvectors(&mut laplacian, 3, &Eigenspace::guess(DMatrix::zeros(15, 3)));
        let gram = found.vectors.tr_mul(&found.vectors);
        assert!((gram - DMatrix::identity(6, 6)).norm() < 1e-12);
    }
}
