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
/// values costs a numeric factorization only.
pub(crate) struct SparseCholesky {
    pattern: SymbolicSparseColMat<usize>,
    symbolic: SymbolicCholesky<usize>,
    factor: Vec<f64>,
    scratch: MemBuffer,
}

/// The matrix is not positive definite in floating point, or its factor would fill up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Unfactorable;

/// Right-hand sides that are ever solved for at once.
const MAX_COLUMNS: usize = 8;
/// Numbers of the factor for each of the matrix, at most. Graphs of scans that are joined with their
/// neighbors in space reach 10 with hundreds of scans and 30 with ten thousands; in graphs joined at random
/// the factor fills up.
const MAX_FILL: usize = 128;

impl SparseCholesky {
    /// Analyzes the pattern of a lower triangle, given by compressed columns with ascending rows. `None`
    /// where the factor would have more than 128 times as many numbers, so that memory stays linear.
    ///
    /// # Panics
    /// If the columns are inconsistent: the callers build them from validated graphs.
    pub fn new(size: usize, column_starts: Vec<usize>, rows: Vec<usize>) -> Option<Self> {
        let max_factor_len = MAX_FILL * rows.len();
        let pattern = SymbolicSparseColMat::new_checked(size, size, column_starts, None, rows);
        let (order, params) = (SymmetricOrdering::Amd, CholeskySymbolicParams::default());
        let symbolic = factorize_symbolic_cholesky(pattern.as_ref(), Side::Lower, order, params)
            .expect("only a failing allocation stops the symbolic analysis");
        if symbolic.len_val() > max_factor_len {
            return None;
        }
        let factorize = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let solve = symbolic.solve_in_place_scratch::<f64>(MAX_COLUMNS, Par::Seq);
        Some(Self {
            pattern,
            factor: vec![0.0; symbolic.len_val()],
            scratch: MemBuffer::new(StackReq::any_of(&[factorize, solve])),
            symbolic,
        })
    }

    /// Factors the matrix with these values, in the order of the pattern.
    pub fn factorize(&mut self, values: &[f64]) -> Result<(), Unfactorable> {
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
            .map_err(|_| Unfactorable)
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
        (SparseCholesky::new(size, starts, rows).unwrap(), values)
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
    fn a_factor_that_fills_up_is_refused() {
        let size = 5000;
        let mut state = 1_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % size
        };
        let mut below = vec![std::collections::BTreeSet::new(); size];
        for _ in 0..5 * size {
            let (a, b) = (random(), random());
            below[a.min(b)].insert(a.max(b));
        }
        let (mut starts, mut rows) = (vec![0], Vec::new());
        for (column, others) in below.iter_mut().enumerate() {
            others.insert(column);
            rows.extend(&*others);
            starts.push(rows.len());
        }
        assert!(SparseCholesky::new(size, starts, rows).is_none());
    }

    #[test]
    fn an_indefinite_matrix_is_refused() {
        let (mut cholesky, values) = tridiagonal(4, 1.0);
        assert_eq!(cholesky.factorize(&values), Err(Unfactorable));
    }
}
