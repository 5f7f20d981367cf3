use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::cholesky::NotPositiveDefinite;

/// A sparse positive semidefinite matrix `A` whose smallest eigenvectors are sought.
pub(crate) trait SemidefiniteMatrix {
    /// Number of rows.
    fn size(&self) -> usize;
    /// A number of the order of the largest eigenvalue.
    fn scale(&self) -> f64;
    /// `A X`.
    fn multiply(&self, x: &DMatrix<f64>) -> DMatrix<f64>;
    /// Factors `A − shift I`. It fails, without harm, where the shift is above the smallest
    /// eigenvalue.
    fn factorize(&mut self, shift: f64) -> Result<(), NotPositiveDefinite>;
    /// Replaces `X` by `(A − shift I)⁻¹ X` with the shift last factored.
    fn solve_in_place(&mut self, x: &mut DMatrix<f64>);
    /// The full matrix.
    fn to_dense(&self) -> DMatrix<f64>;
}

/// Eigenvectors of the smallest eigenvalues of a matrix.
#[derive(Clone, Debug)]
pub(crate) struct Eigenspace {
    /// The orthonormal columns that were wanted, and where there is room a few more that converged
    /// less: the start of the next search.
    pub vectors: DMatrix<f64>,
    /// Largest norm of `A x − λ x` over the wanted ones, in units of the matrix's scale.
    pub residual: f64,
}

/// Further vectors iterated along: `k` wanted ones converge at the rate of `λ_k / λ_{k+4}`.
const GUARD: usize = 3;
/// Residual, in units of the scale, at which the search stops once it no longer falls fast.
/// The error of a vector is the residual over the gap to the next eigenvalue, which may be small.
const TOLERANCE: f64 = 1e-13;
/// A solve that leaves more than this share of the residual gains nothing any more.
const STALL: f64 = 0.25;
/// A residual that rounding keeps above the tolerance is as good as it gets below this.
const ACCEPTABLE: f64 = 1e-11;
/// Block solves before the search gives up.
const MAX_SOLVES: usize = 60;
/// Block solves that must halve the residual, or the search gives up as well: so many eigenvalues
/// nearly coincide that it would take hundreds.
const PATIENCE: usize = 10;
/// Block solves between attempts to move the shift closer to the eigenvalues.
const SOLVES_PER_SHIFT: usize = 3;
/// Up to this many rows a full decomposition is affordable where the search gives up.
const DENSE_LIMIT: usize = 600;
/// Steps of the full decomposition; a few per row are usual.
const MAX_QR_STEPS: usize = 100 * DENSE_LIMIT;

/// Finds the `wanted` smallest eigenvectors by block inverse iteration with Rayleigh–Ritz projection,
/// starting from the first columns of `start`.
///
/// The block keeps a multiple eigenvalue (noise-free rotations have λ = 0 three times) from being
/// missed, as single-vector Krylov methods may. The shift moves up behind the smallest Ritz value as
/// long as the Cholesky factorisation succeeds, which is an inertia check for free. Where the
/// iteration stalls (eigenvalues that nearly coincide) and the matrix is small, a full
/// decomposition takes over; a large one is returned as it stands, with its residual.
pub(crate) fn smallest_eigenvectors(
    matrix: &mut impl SemidefiniteMatrix,
    wanted: usize,
    start: &DMatrix<f64>,
) -> Eigenspace {
    let scale = matrix.scale();
    let block = (wanted + GUARD).min(matrix.size());
    let mut ritz = rayleigh_ritz(matrix, wanted, padded(start, block));
    let mut shift = -1e-5 * scale;
    if matrix.factorize(shift).is_err() {
        return ritz.into_eigenspace(scale);
    }
    let (mut last_residual, mut long_ago) = (f64::INFINITY, f64::INFINITY);
    for solves in 1..=MAX_SOLVES {
        matrix.solve_in_place(&mut ritz.vectors);
        ritz = rayleigh_ritz(matrix, wanted, ritz.vectors);
        let residual = ritz.residual();
        if residual <= TOLERANCE * scale && residual >= STALL * last_residual {
            return ritz.into_eigenspace(scale);
        }
        last_residual = residual;
        if solves % PATIENCE == 0 {
            if residual > 0.5 * long_ago {
                break;
            }
            long_ago = residual;
        }
        if solves % SOLVES_PER_SHIFT == 0 {
            shift = closer_shift(matrix, &ritz, shift);
        }
    }
    if ritz.residual() > ACCEPTABLE * scale && matrix.size() <= DENSE_LIMIT {
        return dense_eigenvectors(matrix, wanted).unwrap_or_else(|| ritz.into_eigenspace(scale));
    }
    ritz.into_eigenspace(scale)
}

/// The best approximation of the eigenvectors within a subspace.
struct Ritz {
    wanted: usize,
    values: Vec<f64>,
    vectors: DMatrix<f64>,
    /// `A x − θ x` of each vector.
    residuals: DMatrix<f64>,
}

impl Ritz {
    fn residual(&self) -> f64 {
        let wanted = 0..self.wanted.min(self.values.len());
        wanted
            .map(|k| self.residuals.column(k).norm())
            .fold(0.0, f64::max)
    }

    fn into_eigenspace(self, scale: f64) -> Eigenspace {
        Eigenspace {
            residual: if scale > 0.0 {
                self.residual() / scale
            } else {
                0.0
            },
            vectors: self.vectors,
        }
    }
}

fn rayleigh_ritz(matrix: &impl SemidefiniteMatrix, wanted: usize, mut basis: DMatrix<f64>) -> Ritz {
    orthonormalize(&mut basis);
    let image = matrix.multiply(&basis);
    let SymmetricEigen {
        eigenvectors,
        eigenvalues,
    } = SymmetricEigen::new(basis.tr_mul(&image));
    let mut order: Vec<usize> = (0..eigenvalues.len()).collect();
    order.sort_by(|&a, &b| eigenvalues[a].total_cmp(&eigenvalues[b]));
    let rotation = eigenvectors.select_columns(&order);
    let values: Vec<f64> = order.iter().map(|&k| eigenvalues[k]).collect();
    let vectors = basis * &rotation;
    let mut residuals = image * &rotation;
    for (k, &value) in values.iter().enumerate() {
        residuals
            .column_mut(k)
            .axpy(-value, &vectors.column(k), 1.0);
    }
    Ritz {
        wanted,
        values,
        vectors,
        residuals,
    }
}

/// Tries to move the shift up behind the smallest eigenvalue; returns the shift that is factored.
///
/// The smallest eigenvalue is at least `θ₁ − ‖A x₁ − θ₁ x₁‖` once the iteration has found it. A tenth
/// of the spread of the block is kept as a distance, so that the system stays well conditioned.
fn closer_shift(matrix: &mut impl SemidefiniteMatrix, ritz: &Ritz, current: f64) -> f64 {
    let (first, last) = (ritz.values[0], ritz.values[ritz.values.len() - 1]);
    let distance = (0.1 * (last - first)).max(2.0 * ritz.residuals.column(0).norm());
    let closer = first - distance;
    if closer <= 0.5 * current || closer - current <= 0.5 * (first - current) {
        return current;
    }
    match matrix.factorize(closer) {
        Ok(()) => closer,
        Err(_) => {
            // The current shift was factored before, so it can be again.
            let _ = matrix.factorize(current);
            current
        }
    }
}

/// The eigenvectors by the full decomposition; `None` where it does not converge.
fn dense_eigenvectors(matrix: &impl SemidefiniteMatrix, wanted: usize) -> Option<Eigenspace> {
    let eigen = SymmetricEigen::try_new(matrix.to_dense(), f64::EPSILON, MAX_QR_STEPS)?;
    let mut order: Vec<usize> = (0..matrix.size()).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    order.truncate(wanted + GUARD);
    let vectors = eigen.eigenvectors.select_columns(&order);
    Some(rayleigh_ritz(matrix, wanted, vectors).into_eigenspace(matrix.scale()))
}

/// `start` with columns cut or added to make `columns` of them.
fn padded(start: &DMatrix<f64>, columns: usize) -> DMatrix<f64> {
    DMatrix::from_fn(start.nrows(), columns, |row, column| {
        if column < start.ncols() {
            start[(row, column)]
        } else {
            scattered(row, column)
        }
    })
}

/// A fixed number in (−1, 1) that looks random (Weyl sequence, golden ratio and √2).
fn scattered(row: usize, column: usize) -> f64 {
    let phase =
        (row + 1) as f64 * 0.618_033_988_749_895 + (column + 1) as f64 * std::f64::consts::SQRT_2;
    2.0 * (phase * phase).fract() - 1.0
}

/// Gram–Schmidt, twice. A column that depends on the others, or overflowed, is replaced by a
/// scattered one.
fn orthonormalize(basis: &mut DMatrix<f64>) {
    for column in 0..basis.ncols() {
        let original = basis.column(column).norm();
        project_out_previous(basis, column);
        let is_independent = basis.column(column).norm() > 1e-14 * original;
        if !(is_independent && original.is_finite()) {
            let fresh = DVector::from_fn(basis.nrows(), |row, _| scattered(row, column + 7));
            basis.set_column(column, &fresh);
            project_out_previous(basis, column);
        }
        basis.column_mut(column).normalize_mut();
        project_out_previous(basis, column);
        basis.column_mut(column).normalize_mut();
    }
}

fn project_out_previous(basis: &mut DMatrix<f64>, column: usize) {
    for previous in 0..column {
        let (before, mut after) = basis.columns_range_pair_mut(..column, column..);
        let previous = before.column(previous);
        let overlap = previous.dot(&after.column(0));
        after.column_mut(0).axpy(-overlap, &previous, 1.0);
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};

    use super::*;
    use crate::laplacian::ConnectionLaplacian;
    use crate::subgraph::{Measurement, Subgraph};

    /// A ring with chords whose rotations are off by up to `noise`.
    fn graph(num_nodes: usize, noise: f64) -> Subgraph {
        let node = |k: usize| Rotation3::new(Vector3::new(k as f64, 0.5 * k as f64, -1.0));
        let pairs = (0..num_nodes).flat_map(|i| [1, 2, 5].map(|step| (i, (i + step) % num_nodes)));
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
            let start = DMatrix::from_element(3 * num_nodes, 1, 1.0);
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

    #[test]
    fn zero_weights_give_some_orthonormal_vectors() {
        let graph = graph(5, 0.0);
        let mut laplacian = ConnectionLaplacian::new(&graph);
        let found = smallest_eigenvectors(&mut laplacian, 3, &DMatrix::zeros(15, 3));
        let gram = found.vectors.tr_mul(&found.vectors);
        assert!((gram - DMatrix::identity(6, 6)).norm() < 1e-12);
    }
}
