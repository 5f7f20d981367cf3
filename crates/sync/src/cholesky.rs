use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, MatMut, Par, Side};
use nalgebra::DMatrix;

/// A sparse symmetric matrix of fixed pattern, of which the lower triangle is stored, and its
/// Cholesky decomposition. The ordering and the pattern of the factor are found once; each set of
/// values costs a numeric factorisation only.
pub(crate) struct SparseCholesky {
    pattern: SymbolicSparseColMat<usize>,
    symbolic: SymbolicCholesky<usize>,
    factor: Vec<f64>,
    scratch: MemBuffer,
}

/// The matrix is not positive definite in floating point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NotPositiveDefinite;

/// Right-hand sides that are ever solved for at once.
const MAX_COLUMNS: usize = 8;

impl SparseCholesky {
    /// Analyses the pattern of a lower triangle, given by compressed columns with ascending rows.
    ///
    /// # Panics
    /// If the columns are inconsistent: the callers build them from validated graphs.
    pub fn new(size: usize, column_starts: Vec<usize>, rows: Vec<usize>) -> Self {
        let pattern = SymbolicSparseColMat::new_checked(size, size, column_starts, None, rows);
        let (order, params) = (SymmetricOrdering::Amd, CholeskySymbolicParams::default());
        let symbolic = factorize_symbolic_cholesky(pattern.as_ref(), Side::Lower, order, params)
            .expect("only a failing allocation stops the symbolic analysis");
        let factorize = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let solve = symbolic.solve_in_place_scratch::<f64>(MAX_COLUMNS, Par::Seq);
        Self {
            pattern,
            factor: vec![0.0; symbolic.len_val()],
            scratch: MemBuffer::new(StackReq::any_of(&[factorize, solve])),
            symbolic,
        }
    }

    /// Factors the matrix with these values, in the order of the pattern.
    pub fn factorize(&mut self, values: &[f64]) -> Result<(), NotPositiveDefinite> {
        let matrix = SparseColMatRef::new(self.pattern.as_ref(), values);
        let (stack, par) = (MemStack::new(&mut self.scratch), Par::Seq);
        let (regularization, params) = (LltRegularization::default(), Default::default());
        self.symbolic
            .factorize_numeric_llt(
                &mut self.factor,
                matrix,
                Side::Lower,
                regularization,
                par,
                stack,
                params,
            )
            .map(|_| ())
            .map_err(|_| NotPositiveDefinite)
    }

    /// Numbers stored in the factor, zeros of the fill among them.
    pub fn factor_len(&self) -> usize {
        self.factor.len()
    }

    /// Replaces each column of `right` by the solution of the system last factored.
    pub fn solve_in_place(&mut self, right: &mut DMatrix<f64>) {
        let (rows, columns) = right.shape();
        assert!(
            columns <= MAX_COLUMNS,
            "{columns} right-hand sides exceed {MAX_COLUMNS}"
        );
        let right = MatMut::from_column_major_slice_mut(right.as_mut_slice(), rows, columns);
        let factor = LltRef::new(&self.symbolic, &self.factor);
        factor.solve_in_place_with_conj(
            Conj::No,
            right,
            Par::Seq,
            MemStack::new(&mut self.scratch),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tridiagonal matrix `[−1, diagonal, −1]` by its lower triangle.
    fn tridiagonal(size: usize, diagonal: f64) -> (SparseCholesky, Vec<f64>) {
        let mut starts = vec![0];
        let (mut rows, mut values) = (Vec::new(), Vec::new());
        for column in 0..size {
            rows.push(column);
            values.push(diagonal);
            if column + 1 < size {
                rows.push(column + 1);
                values.push(-1.0);
            }
            starts.push(rows.len());
        }
        (SparseCholesky::new(size, starts, rows), values)
    }

    #[test]
    fn solves_with_the_values_last_factored() {
        for (size, diagonal) in [(1, 2.0), (5, 2.5), (400, 3.0)] {
            let (mut cholesky, values) = tridiagonal(size, 7.0);
            cholesky.factorize(&values).unwrap();
            let (_, values) = tridiagonal(size, diagonal);
            cholesky.factorize(&values).unwrap();
            let expected = DMatrix::from_fn(size, 2, |row, column| (row * 3 + column) as f64);
            let at =
                |row: usize, column: usize| expected.get((row, column)).map_or(0.0, |entry| *entry);
            let mut right = DMatrix::from_fn(size, 2, |row, column| {
                diagonal * at(row, column) - at(row.wrapping_sub(1), column) - at(row + 1, column)
            });
            cholesky.solve_in_place(&mut right);
            assert!((right - expected).norm() < 1e-9);
        }
    }

    #[test]
    fn an_indefinite_matrix_is_refused() {
        let (mut cholesky, values) = tridiagonal(4, 1.0);
        assert_eq!(cholesky.factorize(&values), Err(NotPositiveDefinite));
    }
}
