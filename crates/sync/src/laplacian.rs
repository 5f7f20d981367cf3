use nalgebra::{DMatrix, Matrix3};

use crate::cholesky::{SparseCholesky, Unfactorable};
use crate::eigenspace::SemidefiniteMatrix;
use crate::subgraph::{Measurement, Subgraph};

/// The weighted connection Laplacian of the measured rotations.
///
/// A symmetric matrix of 3×3 blocks, `L_ii = Σ_j w_ij I` and `L_ij = −w_ij R̂_ij`, whose quadratic
/// form is the objective of rotation averaging: for stacked blocks `G_i`,
///
/// ```text
/// tr(Gᵀ L G) = Σ w_ij ‖G_i − R̂_ij G_j‖_F²,   smallest at G_i = R_iᵀ
/// ```
pub(crate) struct ConnectionLaplacian<'a> {
    graph: &'a Subgraph,
    weights: Vec<f64>,
    /// Weighted degree of each node.
    degrees: Vec<f64>,
    /// `None` where the factor would fill up.
    cholesky: Option<SparseCholesky>,
    layout: Layout,
}

/// Where the blocks of the lower triangle stand among the values.
struct Layout {
    /// Position of the diagonal entry of each scalar column.
    column_starts: Vec<usize>,
    /// For each measurement, which block below the diagonal it adds to, counted within its column.
    block_in_column: Vec<usize>,
}

impl<'a> ConnectionLaplacian<'a> {
    /// The Laplacian with zero weights.
    pub fn new(graph: &'a Subgraph) -> Self {
        let (layout, rows) = Layout::new(graph);
        let column_starts = layout.column_starts.clone();
        Self {
            graph,
            weights: vec![0.0; graph.measurements.len()],
            degrees: vec![0.0; graph.num_nodes],
            cholesky: SparseCholesky::new(3 * graph.num_nodes, column_starts, rows),
            layout,
        }
    }

    pub fn set_weights(&mut self, weights: &[f64]) {
        self.weights.copy_from_slice(weights);
        self.degrees.fill(0.0);
        for (m, weight) in self.graph.measurements.iter().zip(weights) {
            self.degrees[m.i] += weight;
            self.degrees[m.j] += weight;
        }
    }
}

impl SemidefiniteMatrix for ConnectionLaplacian<'_> {
    /// Number of rows: three per node.
    fn size(&self) -> usize {
        3 * self.graph.num_nodes
    }

    /// The largest weighted degree: half an upper bound of the eigenvalues.
    fn scale(&self) -> f64 {
        self.degrees.iter().copied().fold(0.0, f64::max)
    }

    fn upper_bound(&self) -> f64 {
        2.0 * self.scale()
    }

    /// `L X`, from the differences along the edges, which lose nothing where `X` solves `L X = 0`.
    fn multiply(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        let mut product = DMatrix::zeros(x.nrows(), x.ncols());
        for (m, &weight) in self.graph.measurements.iter().zip(&self.weights) {
            let rotation = m.matrix();
            for column in 0..x.ncols() {
                let x_i = x.fixed_view::<3, 1>(3 * m.i, column);
                let x_j = x.fixed_view::<3, 1>(3 * m.j, column);
                let difference = (x_i - rotation * x_j) * weight;
                let mut y_i = product.fixed_view_mut::<3, 1>(3 * m.i, column);
                y_i += difference;
                let mut y_j = product.fixed_view_mut::<3, 1>(3 * m.j, column);
                y_j -= rotation.tr_mul(&difference);
            }
        }
        product
    }

    fn factorize(&mut self, shift: f64) -> Result<(), Unfactorable> {
        let cholesky = self.cholesky.as_mut().ok_or(Unfactorable)?;
        let values = self
            .layout
            .values(self.graph, &self.weights, &self.degrees, shift);
        cholesky.factorize(&values)
    }

    fn solve_in_place(&mut self, x: &mut DMatrix<f64>) {
        let cholesky = self.cholesky.as_mut().expect("the matrix was factored");
        cholesky.solve_in_place(x);
    }

    fn to_dense(&self) -> DMatrix<f64> {
        let mut dense = DMatrix::zeros(self.size(), self.size());
        for (node, &degree) in self.degrees.iter().enumerate() {
            let diagonal = Matrix3::from_diagonal_element(degree);
            dense
                .fixed_view_mut::<3, 3>(3 * node, 3 * node)
                .copy_from(&diagonal);
        }
        for (m, &weight) in self.graph.measurements.iter().zip(&self.weights) {
            let mut upper = dense.fixed_view_mut::<3, 3>(3 * m.i, 3 * m.j);
            upper -= m.matrix() * weight;
            let mut lower = dense.fixed_view_mut::<3, 3>(3 * m.j, 3 * m.i);
            lower -= m.matrix().transpose() * weight;
        }
        dense
    }
}

impl Layout {
    /// The layout and the row of each stored value. Measurements of the same two nodes share a
    /// block.
    fn new(graph: &Subgraph) -> (Self, Vec<usize>) {
        let ends = |m: &Measurement| (m.i.min(m.j), m.i.max(m.j));
        let mut below = vec![Vec::new(); graph.num_nodes];
        for m in &graph.measurements {
            let (low, high) = ends(m);
            below[low].push(high);
        }
        for nodes in &mut below {
            nodes.sort_unstable();
            nodes.dedup();
        }
        let (mut column_starts, mut rows) = (vec![0], Vec::new());
        for (node, nodes_below) in below.iter().enumerate() {
            for axis in 0..3 {
                rows.push(3 * node + axis);
                rows.extend(
                    nodes_below
                        .iter()
                        .flat_map(|&other| 3 * other..3 * other + 3),
                );
                column_starts.push(rows.len());
            }
        }
        let block_in_column = |m: &Measurement| {
            let (low, high) = ends(m);
            below[low].partition_point(|&other| other < high)
        };
        let layout = Self {
            block_in_column: graph.measurements.iter().map(block_in_column).collect(),
            column_starts,
        };
        (layout, rows)
    }

    fn values(&self, graph: &Subgraph, weights: &[f64], degrees: &[f64], shift: f64) -> Vec<f64> {
        let mut values = vec![0.0; self.column_starts[3 * degrees.len()]];
        for (scalar, &start) in self.column_starts[..3 * degrees.len()].iter().enumerate() {
            values[start] = degrees[scalar / 3] - shift;
        }
        for (k, m) in graph.measurements.iter().enumerate() {
            for axis in 0..3 {
                let start = self.column_starts[3 * m.i.min(m.j) + axis];
                let first = start + 1 + 3 * self.block_in_column[k];
                for (row, value) in values[first..first + 3].iter_mut().enumerate() {
                    // The block of row `high` and column `low` maps low's coordinates into high's.
                    let entry = if m.i > m.j { (row, axis) } else { (axis, row) };
                    *value -= weights[k] * m.matrix()[entry];
                }
            }
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};

    use super::*;

    fn graph() -> Subgraph {
        let edges = [(0, 1), (2, 1), (0, 3), (3, 2), (1, 0), (4, 0)];
        let measurement = |(k, &(i, j)): (usize, &(usize, usize))| Measurement {
            i,
            j,
            rotation: Rotation3::new(Vector3::new(k as f64, 1.0, -0.3)),
            translation: Vector3::zeros(),
        };
        let measurements = edges.iter().enumerate().map(measurement).collect();
        Subgraph {
            num_nodes: 5,
            measurements,
        }
    }

    #[test]
    fn product_factor_and_dense_matrix_agree() {
        let graph = graph();
        let mut laplacian = ConnectionLaplacian::new(&graph);
        laplacian.set_weights(&[1.0, 0.5, 2.0, 0.25, 0.125, 3.0]);
        let x = DMatrix::from_fn(15, 2, |row, column| ((row * 2 + column) as f64).sin());
        let dense = laplacian.to_dense();
        assert!((laplacian.multiply(&x) - &dense * &x).norm() < 1e-13);
        assert_eq!(dense, dense.transpose());

        let shift = -0.01;
        laplacian.factorize(shift).unwrap();
        let mut solution = x.clone();
        laplacian.solve_in_place(&mut solution);
        let shifted = dense - DMatrix::identity(15, 15) * shift;
        assert!((shifted * solution - x).norm() < 1e-11);
    }

    #[test]
    fn the_quadratic_form_is_the_objective() {
        let graph = graph();
        let weights = [1.0, 0.5, 2.0, 0.25, 0.125, 3.0];
        let mut laplacian = ConnectionLaplacian::new(&graph);
        laplacian.set_weights(&weights);
        let node = |k: usize| Rotation3::new(Vector3::new(0.3, k as f64, 0.1));
        let blocks = DMatrix::from_fn(15, 3, |row, column| {
            node(row / 3).matrix()[(row % 3, column)]
        });
        let squares = graph.measurements.iter().zip(weights).map(|(m, w)| {
            w * (node(m.i).matrix() - m.matrix() * node(m.j).matrix()).norm_squared()
        });
        let objective = (blocks.transpose() * laplacian.multiply(&blocks)).trace();
        assert!((objective - squares.sum::<f64>()).abs() < 1e-12);
    }
}
