use std::collections::BTreeMap;

use gmpcr_geometry::isometry;
use nalgebra::{DMatrix, Isometry3, Matrix4, Vector3, Vector4};

use crate::averaging::nearest_rotations;
use crate::cholesky::{SparseCholesky, Unfactorable};
use crate::eigenspace::{Eigenspace, SemidefiniteMatrix, smallest_eigenvectors};
use crate::solution::Solution;
use crate::subgraph::{Measurement, Subgraph, relative};

/// Dimension of the space of stacked transformations: that of a homogeneous vector.
const WANTED: usize = 4;

/// Spectral synchronization in SE(3). Its unknowns are `X_i = T_i⁻¹`, for which `T̂_ij ≈ X_i X_j⁻¹` as
/// in the paper.
pub(crate) fn synchronize(graph: &Subgraph, initial_weights: &[f64]) -> Solution {
    let weights = relative(initial_weights);
    let along_tree = poses_along_tree(graph, &weights);
    let length = spread(&along_tree);
    let mut matrix = NormalMatrix::new(graph, &weights, length);
    let start = stacked_transformations(&along_tree, length);
    let start = Eigenspace::guess(start);
    let Eigenspace {
        vectors, residual, ..
    } = smallest_eigenvectors(&mut matrix, WANTED, &start);
    let (node_from_world, weakest_block) =
        transformations(&vectors.columns(0, WANTED).into_owned());
    let poses = poses_from(node_from_world, length);
    Solution {
        eigen_residual: residual,
        weakest_block,
        ..Solution::of_poses(poses, Vec::new())
    }
}

/// Poses along a spanning tree of maximal weight: the solution where all measurements agree.
fn poses_along_tree(graph: &Subgraph, weights: &[f64]) -> Vec<Isometry3<f64>> {
    let tree = graph.spanning_tree(weights);
    let rotations = graph.rotations_along(&tree);
    let positions = graph.positions_along(&tree, &rotations);
    let parts = rotations.iter().zip(&positions);
    parts.map(|(rotation, t)| isometry(rotation, t)).collect()
}

/// Mean distance of the positions from their centroid, one where they coincide.
///
/// In this unit the translations of the stacked transformations are of the size of the rotations. In the unit
/// of a step of a large graph they would dwarf the bottom rows, by which the four vectors are
/// distinguished.
fn spread(poses: &[Isometry3<f64>]) -> f64 {
    let positions = poses.iter().map(|pose| pose.translation.vector);
    let count = poses.len() as f64;
    let centroid = positions.clone().sum::<Vector3<f64>>() / count;
    let distances = positions.map(|position| (position - centroid).norm());
    let mean = distances.sum::<f64>() / count;
    if mean > 0.0 { mean } else { 1.0 }
}

fn stacked_transformations(poses: &[Isometry3<f64>], length: f64) -> DMatrix<f64> {
    let mut stacked = DMatrix::zeros(4 * poses.len(), 4);
    for (node, pose) in poses.iter().enumerate() {
        let mut node_from_world = pose.inverse();
        node_from_world.translation.vector /= length;
        let mut block = stacked.fixed_view_mut::<4, 4>(4 * node, 0);
        block.copy_from(&node_from_world.to_homogeneous());
    }
    stacked
}

/// `BᵀB` of `B = D ⊗ I₄ − Z`, where `Z` has the blocks `w_ij T̂_ij` and `D` the weighted degrees: zero
/// for stacked `X_i` that agree with all measurements.
struct NormalMatrix {
    num_nodes: usize,
    arcs: Vec<Arc>,
    /// `None` where the factor would fill up.
    cholesky: Option<SparseCholesky>,
    /// Position of the diagonal entry of each scalar column among the values.
    column_starts: Vec<usize>,
    values: Vec<f64>,
    /// The one last factored.
    shift: f64,
}

/// One direction of a measurement.
struct Arc {
    a: usize,
    b: usize,
    weight: f64,
    a_from_b: Matrix4<f64>,
}

impl Arc {
    fn both_ways(m: &Measurement, weight: f64, length: f64) -> [Self; 2] {
        let i_from_j = isometry(&m.rotation, &(m.translation / length));
        let arc = |a, b, a_from_b: Isometry3<f64>| Self {
            a,
            b,
            weight,
            a_from_b: a_from_b.to_homogeneous(),
        };
        [arc(m.i, m.j, i_from_j), arc(m.j, m.i, i_from_j.inverse())]
    }
}

/// 4×4 blocks by column and row.
type Blocks = BTreeMap<(usize, usize), Matrix4<f64>>;

impl NormalMatrix {
    fn new(graph: &Subgraph, weights: &[f64], length: f64) -> Self {
        let pairs = graph.measurements.iter().zip(weights);
        let arcs = pairs.flat_map(|(m, &weight)| Arc::both_ways(m, weight, length));
        let arcs: Vec<Arc> = arcs.collect();
        let blocks = normal_blocks(graph.num_nodes, &arcs);
        let (mut column_starts, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
        for column_node in 0..graph.num_nodes {
            let column_blocks = blocks.range((column_node, 0)..(column_node + 1, 0));
            for axis in 0..4 {
                for (&(_, node), block) in column_blocks.clone() {
                    let first = if node == column_node { axis } else { 0 };
                    rows.extend((first..4).map(|row| 4 * node + row));
                    values.extend((first..4).map(|row| block[(row, axis)]));
                }
                column_starts.push(rows.len());
            }
        }
        Self {
            num_nodes: graph.num_nodes,
            arcs,
            cholesky: SparseCholesky::new(4 * graph.num_nodes, column_starts.clone(), rows),
            column_starts,
            values,
            shift: 0.0,
        }
    }

    /// `B X`, from the differences along the edges, which lose little where `B X = 0`.
    fn differences(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        let mut y = DMatrix::zeros(x.nrows(), x.ncols());
        for arc in &self.arcs {
            for column in 0..x.ncols() {
                let x_a = x.fixed_view::<4, 1>(4 * arc.a, column);
                let x_b = x.fixed_view::<4, 1>(4 * arc.b, column);
                let mut y_a = y.fixed_view_mut::<4, 1>(4 * arc.a, column);
                y_a += (x_a - arc.a_from_b * x_b) * arc.weight;
            }
        }
        y
    }

    /// `Bᵀ Y`.
    fn transposed_differences(&self, y: &DMatrix<f64>) -> DMatrix<f64> {
        let mut x = DMatrix::zeros(y.nrows(), y.ncols());
        for arc in &self.arcs {
            for column in 0..y.ncols() {
                let y_a = y.fixed_view::<4, 1>(4 * arc.a, column) * arc.weight;
                let mut x_a = x.fixed_view_mut::<4, 1>(4 * arc.a, column);
                x_a += y_a;
                let mut x_b = x.fixed_view_mut::<4, 1>(4 * arc.b, column);
                x_b -= arc.a_from_b.tr_mul(&y_a);
            }
        }
        x
    }
}

/// The lower triangle of `BᵀB`: each node joins all its neighbors.
fn normal_blocks(num_nodes: usize, arcs: &[Arc]) -> Blocks {
    let mut rows = vec![BTreeMap::<usize, Matrix4<f64>>::new(); num_nodes];
    for arc in arcs {
        *rows[arc.a].entry(arc.a).or_default() += Matrix4::from_diagonal_element(arc.weight);
        *rows[arc.a].entry(arc.b).or_default() -= arc.a_from_b * arc.weight;
    }
    let mut blocks = Blocks::new();
    for row in &rows {
        for (&low, right) in row {
            for (&high, left) in row.range(low..) {
                *blocks.entry((low, high)).or_default() += left.tr_mul(right);
            }
        }
    }
    blocks
}

impl SemidefiniteMatrix for NormalMatrix {
    fn size(&self) -> usize {
        4 * self.num_nodes
    }

    fn scale(&self) -> f64 {
        let starts = &self.column_starts[..self.size()];
        let diagonal = starts.iter().map(|&start| self.values[start]);
        diagonal.fold(0.0, f64::max)
    }

    /// `‖B‖₁ ‖B‖_∞`.
    fn upper_bound(&self) -> f64 {
        let mut column_sums = vec![0.0; self.size()];
        let mut row_sums = vec![0.0; self.size()];
        for arc in &self.arcs {
            for row in 0..4 {
                column_sums[4 * arc.a + row] += arc.weight;
                row_sums[4 * arc.a + row] += arc.weight;
                for column in 0..4 {
                    let entry = arc.weight * arc.a_from_b[(row, column)].abs();
                    column_sums[4 * arc.b + column] += entry;
                    row_sums[4 * arc.a + row] += entry;
                }
            }
        }
        let largest = |sums: Vec<f64>| sums.into_iter().fold(0.0, f64::max);
        largest(column_sums) * largest(row_sums)
    }

    fn multiply(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        self.transposed_differences(&self.differences(x))
    }

    fn factorize(&mut self, shift: f64) -> Result<(), Unfactorable> {
        let size = self.size();
        let cholesky = self.cholesky.as_mut().ok_or(Unfactorable)?;
        let mut values = self.values.clone();
        for &start in &self.column_starts[..size] {
            values[start] -= shift;
        }
        self.shift = shift;
        cholesky.factorize(&values)
    }

    /// One step of refinement makes up for what the squared condition costs.
    fn solve_in_place(&mut self, x: &mut DMatrix<f64>) {
        let right = x.clone();
        let cholesky = self.cholesky.as_mut().expect("the matrix was factored");
        cholesky.solve_in_place(x);
        let mut rest = right - self.multiply(x) + &*x * self.shift;
        let cholesky = self.cholesky.as_mut().expect("the matrix was factored");
        cholesky.solve_in_place(&mut rest);
        *x += rest;
    }

    fn to_dense(&self) -> DMatrix<f64> {
        self.multiply(&DMatrix::identity(self.size(), self.size()))
    }
}

/// The transformations whose stack spans the space of four vectors, and the ratio of the smallest to the
/// largest singular value of their rotation blocks before projection.
///
/// A change of basis makes the bottom rows `[0 0 0 1]` as nearly as possible: three combinations of
/// unit length with the smallest bottom rows, and the multiple of the fourth whose bottom rows are
/// nearest to one.
fn transformations(vectors: &DMatrix<f64>) -> (Vec<Isometry3<f64>>, f64) {
    let num_nodes = vectors.nrows() / 4;
    let bottom = |node: usize| vectors.fixed_view::<1, 4>(4 * node + 3, 0).transpose();
    let (mut gram, mut sum) = (Matrix4::zeros(), Vector4::zeros());
    for row in (0..num_nodes).map(bottom) {
        gram += row * row.transpose();
        sum += row;
    }
    let eigen = gram.symmetric_eigen();
    let last = eigen.eigenvalues.imax();
    let direction = eigen.eigenvectors.column(last);
    let fourth = direction * (direction.dot(&sum) / eigen.eigenvalues[last]);
    let others = eigen.eigenvectors.remove_column(last);

    let block = |node: usize| vectors.fixed_view::<3, 4>(4 * node, 0).into_owned();
    let blocks = (0..num_nodes).map(|node| block(node) * others);
    let (rotations, weakest_block) = nearest_rotations(blocks.collect());
    let transformation = |(node, rotation)| isometry(rotation, &(block(node) * fourth));
    let transformations = rotations.iter().enumerate().map(transformation);
    (transformations.collect(), weakest_block)
}

/// `T_i = X_0 X_i⁻¹`, in the unit of the input.
fn poses_from(node_from_world: Vec<Isometry3<f64>>, length: f64) -> Vec<Isometry3<f64>> {
    let Some((reference, others)) = node_from_world.split_first() else {
        return Vec::new();
    };
    let in_its_frame = others.iter().map(|node_from_world| {
        let mut pose = reference * node_from_world.inverse();
        pose.translation.vector *= length;
        pose
    });
    let poses = std::iter::once(Isometry3::identity()).chain(in_its_frame);
    poses.collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;

    use super::*;

    fn graph(noise: f64) -> Subgraph {
        let pose = |k: usize| {
            let k = k as f64;
            Isometry3::new(Vector3::new(k, k * k, -k), Vector3::new(k, 1.0, -0.3 * k))
        };
        let ends = [(0, 1), (2, 1), (0, 3), (3, 2), (1, 0), (4, 0), (4, 2)];
        let measurement = |(k, &(i, j)): (usize, &(usize, usize))| {
            let error = Vector3::new(1.0, k as f64, -2.0) * noise;
            let i_from_j = pose(i).inv_mul(&pose(j)) * Isometry3::new(error, error);
            Measurement {
                i,
                j,
                rotation: i_from_j.rotation.to_rotation_matrix(),
                translation: i_from_j.translation.vector,
            }
        };
        Subgraph {
            num_nodes: 5,
            measurements: ends.iter().enumerate().map(measurement).collect(),
        }
    }

    const WEIGHTS: [f64; 7] = [1.0, 0.5, 0.7, 0.25, 0.125, 0.3, 0.9];

    #[test]
    fn product_factor_and_dense_matrix_agree() {
        let mut matrix = NormalMatrix::new(&graph(0.1), &WEIGHTS, 3.0);
        let x = DMatrix::from_fn(20, 2, |row, column| ((row * 2 + column) as f64).sin());
        let dense = matrix.to_dense();
        assert!((matrix.multiply(&x) - &dense * &x).norm() < 1e-11);
        let largest = dense.symmetric_eigenvalues().max();
        assert!(largest <= matrix.upper_bound());

        let shift = -0.01;
        matrix.factorize(shift).unwrap();
        let mut solution = x.clone();
        matrix.solve_in_place(&mut solution);
        let shifted = dense - DMatrix::identity(20, 20) * shift;
        assert!((shifted * solution - x).norm() < 1e-10);
    }

    #[test]
    fn the_vectors_are_the_right_singular_ones_of_the_dense_matrix() {
        let graph = graph(0.02);
        let mut b = DMatrix::<f64>::zeros(20, 20);
        for (m, weight) in graph.measurements.iter().zip(WEIGHTS) {
            for arc in Arc::both_ways(m, weight, 3.0) {
                let mut diagonal = b.fixed_view_mut::<4, 4>(4 * arc.a, 4 * arc.a);
                diagonal += Matrix4::from_diagonal_element(weight);
                let mut block = b.fixed_view_mut::<4, 4>(4 * arc.a, 4 * arc.b);
                block -= arc.a_from_b * weight;
            }
        }
        let rows = b.svd(false, true).v_t.unwrap();
        let expected = rows.rows(16, 4).transpose();
        let mut matrix = NormalMatrix::new(&graph, &WEIGHTS, 3.0);
        let found = smallest_eigenvectors(
            &mut matrix,
            WANTED,
            &Eigenspace::guess(DMatrix::zeros(20, 4)),
        )
        .vectors;
        let found = found.columns(0, 4);
        assert!((found - &expected * expected.tr_mul(&found)).norm() < 1e-9);
    }

    #[test]
    fn any_basis_of_the_space_gives_the_transformations() {
        let poses: Vec<_> = (0..6)
            .map(|k| {
                let k = f64::from(k);
                let rotation = Rotation3::new(Vector3::new(k, 0.5, -k));
                isometry(&rotation, &Vector3::new(0.1 * k, 1.0, k.sin()))
            })
            .collect();
        let entry = |row: usize, column: usize| ((3 * row + column) as f64).cos();
        let basis = Matrix4::from_fn(entry) + Matrix4::from_diagonal_element(0.1);
        // Like the vectors of the search, these are orthonormal.
        let vectors = (stacked_transformations(&poses, 2.0) * basis).qr().q();
        let (node_from_world, weakest_block) = transformations(&vectors);
        assert!(weakest_block > 1.0 - 1e-10);
        for (found, pose) in poses_from(node_from_world, 2.0).iter().zip(&poses) {
            let expected = poses[0].inv_mul(pose).to_matrix();
            assert!((found.to_matrix() - expected).norm() < 1e-10);
        }
    }
}
