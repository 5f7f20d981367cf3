use nalgebra::DMatrix;

use crate::cholesky::Unfactorable;

/// Error of each row of the wanted vectors, relative to that row, at which the search stops: weak parts of a
/// graph have rows that are smaller than others by many decades, and rotations all the same.
pub(super) const TOLERANCE: f64 = 1e-9;
/// A shift that is below all eigenvalues, in units of the scale.
pub(super) const LOWEST_SHIFT: f64 = -1e-5;

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
