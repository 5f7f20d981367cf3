//! Sparse symmetric equations in 6×6 blocks, one for each node but the first, and one for each pair.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, MatMut, Par, Side};
use nalgebra::{Matrix6, Vector6};

/// Unknowns of a node.
const SIZE: usize = 6;

/// The pattern of the equations and its symbolic Cholesky decomposition: found once for a list of pairs.
pub(crate) struct BlockPattern {
    /// For each node but the first, the higher nodes that it is paired with, ascending.
    above: Vec<Vec<usize>>,
    column_starts: Vec<usize>,
    pattern: SymbolicSparseColMat<usize>,
    symbolic: SymbolicCholesky<usize>,
}

impl BlockPattern {
    /// The pattern of pairs `(i, j)` with `i < j < num_nodes`, for at least two nodes.
    pub fn new(num_nodes: usize, pairs: impl Iterator<Item = (usize, usize)>) -> Self {
        let mut above = vec![Vec::new(); num_nodes - 1];
        for (i, j) in pairs.filter(|&(i, _)| i > 0) {
            above[i - 1].push(j);
        }
        let (mut column_starts, mut rows) = (vec![0], Vec::new());
        let block = |node: usize| SIZE * (node - 1)..SIZE * node;
        for (index, nodes) in above.iter_mut().enumerate() {
            nodes.sort_unstable();
            nodes.dedup();
            for row in block(index + 1) {
                rows.extend(row..SIZE * (index + 1));
                rows.extend(nodes.iter().flat_map(|&node| block(node)));
                column_starts.push(rows.len());
            }
        }
        let size = SIZE * (num_nodes - 1);
        let pattern =
            SymbolicSparseColMat::new_checked(size, size, column_starts.clone(), None, rows);
        let (order, params) = (SymmetricOrdering::Amd, CholeskySymbolicParams::default());
        let symbolic = factorize_symbolic_cholesky(pattern.as_ref(), Side::Lower, order, params)
            .expect("only a failing allocation stops the symbolic analysis");
        Self {
            above,
            column_starts,
            pattern,
            symbolic,
        }
    }

    /// Equations of this pattern, all zero.
    pub fn equations(&self) -> BlockEquations<'_> {
        BlockEquations {
            pattern: self,
            values: vec![0.0; self.column_starts.last().copied().unwrap_or(0)],
            right: vec![0.0; SIZE * self.above.len()],
        }
    }

    /// Where the entries of a block's `k`-th column start, for nodes `row ≥ column > 0` that are equal or
    /// paired. Of a diagonal block that is the diagonal entry.
    fn start(&self, row: usize, column: usize, k: usize) -> usize {
        let start = self.column_starts[SIZE * (column - 1) + k];
        if row == column {
            return start;
        }
        let place = self.above[column - 1].partition_point(|&other| other < row);
        start + SIZE * (place + 1) - k
    }
}

/// Values of the equations.
pub(crate) struct BlockEquations<'a> {
    pattern: &'a BlockPattern,
    values: Vec<f64>,
    right: Vec<f64>,
}

impl BlockEquations<'_> {
    /// Adds to a node's diagonal block and to its right-hand side. The first node is fixed.
    pub fn add_node(&mut self, node: usize, block: &Matrix6<f64>, right: &Vector6<f64>) {
        if node == 0 {
            return;
        }
        for k in 0..SIZE {
            let start = self.pattern.start(node, node, k);
            for row in k..SIZE {
                self.values[start + row - k] += block[(row, k)];
            }
            self.right[SIZE * (node - 1) + k] += right[k];
        }
    }

    /// Adds to the block of the rows of `high` and the columns of `low`.
    pub fn add_pair(&mut self, high: usize, low: usize, block: &Matrix6<f64>) {
        if low == 0 {
            return;
        }
        for k in 0..SIZE {
            let start = self.pattern.start(high, low, k);
            for row in 0..SIZE {
                self.values[start + row] += block[(row, k)];
            }
        }
    }

    /// The solution of each node, zero for the first; `None` if the matrix is not positive definite in
    /// floating point.
    pub fn solve(mut self) -> Option<Vec<Vector6<f64>>> {
        let symbolic = &self.pattern.symbolic;
        let factorize = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let solve = symbolic.solve_in_place_scratch::<f64>(1, Par::Seq);
        let mut scratch = MemBuffer::new(StackReq::any_of(&[factorize, solve]));
        let mut factor = vec![0.0; symbolic.len_val()];
        let matrix = SparseColMatRef::new(self.pattern.pattern.as_ref(), self.values.as_slice());
        symbolic
            .factorize_numeric_llt(
                &mut factor,
                matrix,
                Side::Lower,
                LltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut scratch),
                Default::default(),
            )
            .ok()?;
        let rows = self.right.len();
        LltRef::new(symbolic, &factor).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(&mut self.right, rows, 1),
            Par::Seq,
            MemStack::new(&mut scratch),
        );
        let solved = self
            .right
            .chunks_exact(SIZE)
            .map(Vector6::from_column_slice);
        Some(std::iter::once(Vector6::zeros()).chain(solved).collect())
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    #[test]
    fn the_solution_is_that_of_the_dense_equations() {
        let (num_nodes, pairs) = (5, [(0, 1), (1, 2), (2, 4), (1, 4), (0, 3)]);
        let pattern = BlockPattern::new(num_nodes, pairs.into_iter());
        let mut sparse = pattern.equations();
        let mut dense = DMatrix::zeros(6 * num_nodes, 6 * num_nodes);
        let mut right = DVector::zeros(6 * num_nodes);
        let block =
            |seed: usize| Matrix6::from_fn(|r, c| ((r * 7 + c * 3 + seed * 5) as f64).sin() * 0.3);
        for node in 0..num_nodes {
            let symmetric = block(node) * block(node).transpose() + Matrix6::identity() * 4.0;
            let side = Vector6::from_fn(|r, _| (r + node) as f64);
            sparse.add_node(node, &symmetric, &side);
            dense
                .fixed_view_mut::<6, 6>(6 * node, 6 * node)
                .copy_from(&symmetric);
            right.fixed_rows_mut::<6>(6 * node).copy_from(&side);
        }
        for (low, high) in pairs {
            let between = block(low + 10 * high);
            sparse.add_pair(high, low, &between);
            dense
                .fixed_view_mut::<6, 6>(6 * high, 6 * low)
                .copy_from(&between);
            dense
                .fixed_view_mut::<6, 6>(6 * low, 6 * high)
                .copy_from(&between.transpose());
        }
        let free = dense.view((6, 6), (24, 24)).into_owned();
        let expected = free.lu().solve(&right.rows(6, 24).into_owned()).unwrap();
        let found = sparse.solve().unwrap();
        assert_eq!(found[0], Vector6::zeros());
        for (node, step) in found.iter().enumerate().skip(1) {
            let difference = step - expected.fixed_rows::<6>(6 * (node - 1));
            assert!(difference.norm() < 1e-10);
        }
    }
}
