use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::cholesky::Unfactorable;

/// A sparse positive semidefinite matrix `A` whose smallest eigenvectors are sought.
pub(crate) trait SemidefiniteMatrix {
    /// Number of rows.
    fn size(&self) -> usize;
    /// A number of the order of the largest eigenvalue.
    fn scale(&self) -> f64;
    /// An upper bound of the eigenvalues.
    fn upper_bound(&self) -> f64;
    /// `A X`.
    fn multiply(&self, x: &DMatrix<f64>) -> DMatrix<f64>;
    /// Factors `A − shift I`. It fails, without harm, where the shift is above the smallest eigenvalue or
    /// the factor would fill up.
    fn factorize(&mut self, shift: f64) -> Result<(), Unfactorable>;
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
    /// The shift that it was found with, in units of the matrix's scale.
    pub shift: f64,
}

impl Eigenspace {
    /// Vectors to start from when nothing else is known.
    pub fn guess(vectors: DMatrix<f64>) -> Self {
        Self {
            vectors,
            residual: f64::INFINITY,
            shift: LOWEST_SHIFT,
        }
    }
}

/// Further vectors iterated along, so that the filter need not part the wanted ones from their next
/// neighbours.
const GUARD: usize = 3;
/// Error of each row of the wanted vectors, relative to that row, at which the search stops: weak parts of a
/// graph have rows that are smaller than others by many decades, and rotations all the same.
const TOLERANCE: f64 = 1e-9;
/// Residual, in units of the scale, at which the search stops once it no longer falls fast.
const SMALL_RESIDUAL: f64 = 1e-13;
/// A filter that leaves more than this share of the residual gains nothing any more.
const STALL: f64 = 0.25;
/// Residual, in units of the scale, that a solution has at most.
const ACCEPTABLE: f64 = 1e-11;
/// Filters that must halve the residual, or the search gives up: so many eigenvalues nearly coincide
/// that it would take hundreds.
const PATIENCE: usize = 4;
/// Filters before the search gives up in any case.
const MAX_FILTERS: usize = 24;
/// Degree of a filter, at most: solves or products between two projections.
const MAX_SOLVES: usize = 4;
const MAX_PRODUCTS: usize = 60;
/// Natural logarithm by which a filter may part wanted vectors from each other, so that they stay
/// independent in floating point.
const MAX_SPREAD: f64 = 23.0;
/// Distance of a shift from the smallest value, as a share of the spread of the block, that keeps the
/// system well conditioned.
const MARGIN: f64 = 0.03;
/// Solves that take as long as a factorisation.
const SOLVES_PER_FACTOR: f64 = 6.0;
/// A shift that is below all eigenvalues, in units of the scale.
const LOWEST_SHIFT: f64 = -1e-5;
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

/// A Chebyshev polynomial `T_d` of a matrix, mapped so that the eigenvalues beyond the block are in
/// [−1, 1], where `T_d` stays small, and the wanted ones above, where it grows fastest.
enum Filter {
    /// Of the inverse of the matrix minus this shift.
    Inverse {
        shift: f64,
        /// A shift that turned out to be above the smallest eigenvalue.
        too_high: f64,
    },
    /// Of the matrix itself, whose eigenvalues are at most this.
    Direct { largest: f64 },
}

impl Filter {
    /// With the shift that the last search ended with, if it is still below all eigenvalues, or else with
    /// one that certainly is.
    fn new(matrix: &mut impl SemidefiniteMatrix, last_shift: f64) -> Self {
        let scale = matrix.scale();
        let mut too_high = f64::INFINITY;
        for shift in [last_shift * scale, LOWEST_SHIFT * scale] {
            if matrix.factorize(shift).is_ok() {
                return Self::Inverse { shift, too_high };
            }
            too_high = shift;
        }
        Self::Direct {
            largest: matrix.upper_bound(),
        }
    }

    fn shift(&self) -> f64 {
        match self {
            Self::Inverse { shift, .. } => *shift,
            Self::Direct { .. } => 0.0,
        }
    }

    /// Where an eigenvalue is mapped to.
    fn place(&self, ritz: &Ritz, value: f64) -> f64 {
        match self {
            Self::Inverse { shift, .. } => 2.0 * (ritz.last() - shift) / (value - shift) - 1.0,
            Self::Direct { largest } => 1.0 + 2.0 * (ritz.last() - value) / (largest - ritz.last()),
        }
    }

    /// Natural logarithm by which the eigenvectors of a value grow with each degree.
    fn growth(&self, ritz: &Ritz, value: f64) -> f64 {
        self.place(ritz, value).acosh().max(1e-3)
    }

    /// The degree that takes this error to the tolerance, or as much of the way as keeps the vectors
    /// independent.
    fn degree(&self, ritz: &Ritz, error: f64) -> usize {
        let needed = (error / TOLERANCE).ln() / self.growth(ritz, ritz.last_wanted());
        let independent = MAX_SPREAD / self.growth(ritz, ritz.values[0]);
        let max_degree = match self {
            Self::Inverse { .. } => MAX_SOLVES,
            Self::Direct { .. } => MAX_PRODUCTS,
        };
        (needed.ceil().min(independent) as usize).clamp(1, max_degree)
    }

    /// `T_d` of the mapped matrix times the Ritz vectors, by the three-term recurrence.
    fn apply(
        &self,
        matrix: &mut impl SemidefiniteMatrix,
        ritz: &Ritz,
        degree: usize,
    ) -> DMatrix<f64> {
        let mut mapped = |x: &DMatrix<f64>| match self {
            Self::Inverse { shift, .. } => {
                let mut y = x * (2.0 * (ritz.last() - shift));
                matrix.solve_in_place(&mut y);
                y - x
            }
            Self::Direct { largest } => {
                let width = largest - ritz.last();
                x * ((largest + ritz.last()) / width) - matrix.multiply(x) * (2.0 / width)
            }
        };
        let mut before = ritz.vectors.clone();
        let mut now = mapped(&before);
        for _ in 1..degree {
            let next = mapped(&now) * 2.0 - &before;
            before = std::mem::replace(&mut now, next);
        }
        now
    }

    /// Moves the shift up behind the smallest eigenvalue, where that saves more solves than a
    /// factorisation costs. That the factorisation succeeds proves that the shift is below.
    ///
    /// The smallest eigenvalue is at least `θ₁ − ‖A x₁ − θ₁ x₁‖` once the iteration has found it.
    fn move_closer(&mut self, matrix: &mut impl SemidefiniteMatrix, ritz: &Ritz, error: f64) {
        let Self::Inverse { shift, too_high } = *self else {
            return;
        };
        let spread = ritz.last() - ritz.values[0];
        let distance = (MARGIN * spread).max(2.0 * ritz.residuals.column(0).norm());
        let closer = Self::Inverse {
            shift: ritz.values[0] - distance,
            too_high,
        };
        let solves =
            |filter: &Self| (error / TOLERANCE).ln() / filter.growth(ritz, ritz.last_wanted());
        let is_allowed = closer.shift() > shift && closer.shift() < too_high;
        if is_allowed && solves(self) - solves(&closer) > SOLVES_PER_FACTOR {
            if matrix.factorize(closer.shift()).is_ok() {
                *self = closer;
            } else {
                // The current shift was factored before, so it can be again.
                let _ = matrix.factorize(shift);
                *self = Self::Inverse {
                    shift,
                    too_high: closer.shift(),
                };
            }
        }
    }
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
        (0..self.num_wanted())
            .map(|k| self.residuals.column(k).norm())
            .fold(0.0, f64::max)
    }

    /// The largest value of the block.
    fn last(&self) -> f64 {
        self.values[self.values.len() - 1]
    }

    fn num_wanted(&self) -> usize {
        self.wanted.min(self.values.len())
    }

    fn last_wanted(&self) -> f64 {
        self.values[self.num_wanted() - 1]
    }

    /// The largest change of a row of the wanted vectors, relative to the row, apart from a change of
    /// their basis.
    fn change_since(&self, before: &DMatrix<f64>) -> f64 {
        let (now, before) = (
            self.vectors.columns(0, self.num_wanted()),
            before.columns(0, self.num_wanted()),
        );
        let moved = now - before * before.tr_mul(&now);
        let rows = moved.row_iter().zip(now.row_iter());
        let squares = rows.map(|(moved, now)| moved.norm_squared() / now.norm_squared());
        squares.fold(0.0, f64::max).sqrt()
    }

    fn into_eigenspace(self, scale: f64, shift: f64) -> Eigenspace {
        Eigenspace {
            shift: if scale > 0.0 { shift / scale } else { shift },
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
            let graph = graph(DENSE_LIMIT, noise);
            let mut laplacian = ConnectionLaplacian::new(&graph);
            laplacian.set_weights(&vec![0.7; graph.measurements.len()]);
            let start = DMatrix::from_element(3 * DENSE_LIMIT, 1, 1.0);
            let start = Eigenspace::guess(start);
            let factored = smallest_eigenvectors(&mut laplacian, 3, &start);
            let free = smallest_eigenvectors(&mut Unfactored(laplacian), 3, &factored);
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
