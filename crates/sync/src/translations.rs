use gmpcr_posegraph::PoseGraph;
use nalgebra::{DMatrix, Rotation3, Vector3};

use crate::cholesky::SparseCholesky;
use crate::conjugate_gradients::conjugate_gradients;
use crate::pattern::GroundedPattern;
use crate::subgraph::{Measurement, Subgraph, relative};

/// Relative weights are lifted to this where rounding leaves scans that only lower ones connect without
/// a position.
const WEIGHT_FLOOR: f64 = 1e-12;
/// Residual at which conjugate gradients stop where they solve.
const TOLERANCE: f64 = 1e-10;

/// Positions of all scans of a connected graph, and how well their normal equations were solved.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct SolvedTranslations {
    /// `t_i`, from the origin of scan 0 to that of the scan, along the axes of scan 0; in the unit of the
    /// input.
    pub positions: Vec<Vector3<f64>>,
    /// Residual of the normal equations as a fraction of that at the positions along the spanning tree, in
    /// the norm of the inverse weighted degrees. Rounding where a factor solved them, 1e-10 where conjugate
    /// gradients did, and more where 1000 iterations were not enough.
    pub residual: f64,
}

/// Translations under given rotations: `argmin Σ w_ij ‖R_i t̂_ij + t_i − t_j‖²`.
///
/// Scan 0 has the zero translation, which leaves a sparse positive definite system in the other
/// scans, solved for the three axes at once by Cholesky decomposition, or by conjugate gradients where its
/// factor would fill up (to a relative residual of 1e-10, in 1000 iterations at most). The unknowns are the
/// corrections to the positions along a spanning tree of maximal weight: these are small where the
/// measurements agree, so that parts joined by weak edges keep their digits. Lengths keep the unit of
/// the input. `weights` holds one weight per edge of `graph`, `world_from_scan` one rotation per scan.
/// The graph must be connected by edges of positive weight for the positions to have a meaning.
///
/// # Panics
/// If there is not one weight per edge and one rotation per scan.
///
/// ```
/// use gmpcr_posegraph::{PoseEdge, PoseGraph};
/// use gmpcr_sync::solve_translations;
/// use nalgebra::{Isometry3, Rotation3};
///
/// let edge = |i, j, x| PoseEdge { i, j, i_from_j: Isometry3::translation(x, 0.0, 0.0), weight: 1.0 };
/// // Two steps of 1 against one of 2.3: the error is spread evenly.
/// let graph = PoseGraph::new(3, vec![edge(0, 1, 1.0), edge(1, 2, 1.0), edge(0, 2, 2.3)])?;
/// let solved = solve_translations(&graph, &[Rotation3::identity(); 3], &[1.0; 3]);
/// assert!((solved.positions[1].x - 1.1).abs() < 1e-12 && (solved.positions[2].x - 2.2).abs() < 1e-12);
/// assert!(solved.residual < 1e-12);
/// # Ok::<(), gmpcr_posegraph::PoseGraphError>(())
/// ```
pub fn solve_translations(
    graph: &PoseGraph,
    world_from_scan: &[Rotation3<f64>],
    weights: &[f64],
) -> SolvedTranslations {
    assert_eq!(weights.len(), graph.edges().len(), "one weight per edge");
    assert_eq!(
        world_from_scan.len(),
        graph.num_scans(),
        "one rotation per scan"
    );
    subgraph_translations(&Subgraph::whole(graph), world_from_scan, weights)
}

pub(crate) fn subgraph_translations(
    graph: &Subgraph,
    world_from_node: &[Rotation3<f64>],
    weights: &[f64],
) -> SolvedTranslations {
    if graph.num_nodes < 2 {
        return SolvedTranslations {
            positions: vec![Vector3::zeros(); graph.num_nodes],
            residual: 0.0,
        };
    }
    let mut system = GroundedLaplacian::new(graph);
    system.set_weights(weights);
    system.positions(graph, world_from_node)
}

/// The weighted graph Laplacian without node 0, whose row `k − 1` is of node `k`: the normal equations
/// of `argmin Σ w_ij ‖o_ij + p_i − p_j‖²` with `p_0 = 0`. The graph has two nodes at least.
pub(crate) struct GroundedLaplacian {
    num_nodes: usize,
    /// The nodes that each measurement joins: all that the matrix takes from them.
    ends: Vec<(usize, usize)>,
    weights: Vec<f64>,
    /// `None` where the factor would fill up: then conjugate gradients solve.
    factored: Option<Factored>,
}

struct Factored {
    pattern: GroundedPattern,
    cholesky: SparseCholesky,
    is_definite: bool,
}

impl GroundedLaplacian {
    /// The Laplacian with zero weights.
    pub fn new(graph: &Subgraph) -> Self {
        let pattern = GroundedPattern::new(graph, 1);
        let cholesky = pattern.cholesky();
        Self {
            num_nodes: graph.num_nodes,
            ends: graph.measurements.iter().map(|m| (m.i, m.j)).collect(),
            weights: vec![0.0; graph.measurements.len()],
            factored: cholesky.map(|cholesky| Factored {
                pattern,
                cholesky,
                is_definite: false,
            }),
        }
    }

    /// Takes these weights, of which only the ratios matter.
    pub fn set_weights(&mut self, weights: &[f64]) {
        self.weights = relative(weights);
        self.factorize();
    }

    /// The translations of its graph under given rotations and the weights it has.
    pub fn positions(
        &mut self,
        graph: &Subgraph,
        world_from_node: &[Rotation3<f64>],
    ) -> SolvedTranslations {
        let tree = graph.spanning_tree(&self.weights);
        let along_tree = graph.positions_along(&tree, world_from_node);
        let offset = |m: &Measurement| {
            world_from_node[m.i] * m.translation - (along_tree[m.j] - along_tree[m.i])
        };
        let offsets: Vec<_> = graph.measurements.iter().map(offset).collect();
        let corrections = self.solve(&offsets, TOLERANCE);
        let nodes = along_tree.iter().zip(&corrections);
        SolvedTranslations {
            positions: nodes
                .map(|(position, correction)| position + correction)
                .collect(),
            residual: self.relative_residual(&corrections, &offsets),
        }
    }

    /// The minimizing `p` of all nodes for one offset `o` per measurement, where it is iterated to this
    /// tolerance. All zero where the system is singular in floating point.
    pub fn solve(&mut self, offsets: &[Vector3<f64>], tolerance: f64) -> Vec<Vector3<f64>> {
        let solution = self.try_solve(offsets, tolerance).or_else(|| {
            let lifted = self.weights.iter().map(|weight| weight.max(WEIGHT_FLOOR));
            self.weights = lifted.collect();
            self.factorize();
            self.try_solve(offsets, tolerance)
        });
        solution.unwrap_or_else(|| vec![Vector3::zeros(); self.num_nodes])
    }

    fn try_solve(&mut self, offsets: &[Vector3<f64>], tolerance: f64) -> Option<Vec<Vector3<f64>>> {
        let right = self.right_side(offsets);
        let solution = match &mut self.factored {
            Some(factored) => factored.solve(&right)?,
            None => {
                let multiply = |x: &[_]| self.multiply(x);
                conjugate_gradients(multiply, &self.diagonal(), &right, tolerance)?
            }
        };
        let is_finite = |p: &Vector3<f64>| p.iter().all(|x| x.is_finite());
        solution.iter().all(is_finite).then_some(solution)
    }

    /// The right side of the normal equations.
    fn right_side(&self, offsets: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let mut right = vec![Vector3::zeros(); self.num_nodes];
        for ((i, j, weight), offset) in self.weighted_ends().zip(offsets) {
            right[i] -= offset * weight;
            right[j] += offset * weight;
        }
        right[0] = Vector3::zeros();
        right
    }

    /// The residual of a solution as a fraction of that of zero, in the norm of the inverse diagonal.
    fn relative_residual(&self, solution: &[Vector3<f64>], offsets: &[Vector3<f64>]) -> f64 {
        let diagonal = self.diagonal();
        let size = |x: &[Vector3<f64>]| -> f64 {
            let squares = x.iter().zip(&diagonal).map(|(x, d)| x.norm_squared() / d);
            squares.sum::<f64>().sqrt()
        };
        let right = self.right_side(offsets);
        let image = self.multiply(solution);
        let residual: Vec<_> = right.iter().zip(&image).map(|(b, y)| b - y).collect();
        match size(&right) {
            0.0 => 0.0,
            all => size(&residual) / all,
        }
    }

    /// The product with the matrix, whose row and column of node 0 are those of the identity.
    fn multiply(&self, x: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let mut y = vec![Vector3::zeros(); x.len()];
        for (i, j, weight) in self.weighted_ends() {
            let difference = (x[i] - x[j]) * weight;
            y[i] += difference;
            y[j] -= difference;
        }
        y[0] = x[0];
        y
    }

    /// Its diagonal.
    fn diagonal(&self) -> Vec<f64> {
        let mut degrees = vec![0.0; self.num_nodes];
        for (i, j, weight) in self.weighted_ends() {
            degrees[i] += weight;
            degrees[j] += weight;
        }
        degrees[0] = 1.0;
        degrees
    }

    /// The nodes of each measurement and its weight.
    fn weighted_ends(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        self.ends
            .iter()
            .zip(&self.weights)
            .map(|(&(i, j), &weight)| (i, j, weight))
    }

    fn factorize(&mut self) {
        let Some(Factored { pattern, .. }) = &self.factored else {
            return;
        };
        let mut values = vec![0.0; pattern.num_values()];
        for (i, j, weight) in self.weighted_ends() {
            for node in [i, j] {
                if node > 0 {
                    values[pattern.start(node, node, 0)] += weight;
                }
            }
            let (low, high) = (i.min(j), i.max(j));
            if low > 0 {
                values[pattern.start(high, low, 0)] -= weight;
            }
        }
        if let Some(factored) = &mut self.factored {
            factored.is_definite = factored.cholesky.factorize(&values).is_ok();
        }
    }
}

impl Factored {
    fn solve(&mut self, right: &[Vector3<f64>]) -> Option<Vec<Vector3<f64>>> {
        if !self.is_definite {
            return None;
        }
        let mut rows = DMatrix::from_fn(right.len() - 1, 3, |row, axis| right[row + 1][axis]);
        self.cholesky.solve_in_place(&mut rows);
        let position = |row: usize| rows.fixed_view::<1, 3>(row, 0).transpose();
        let fixed = std::iter::once(Vector3::zeros());
        Some(fixed.chain((0..rows.nrows()).map(position)).collect())
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;

    use super::*;

    #[test]
    fn factored_and_iterated_solutions_agree() {
        let measurement = |k: usize| Measurement {
            i: k * k % 50,
            j: (k * 7 + k / 50 + 1) % 50,
            rotation: Rotation3::identity(),
            translation: Vector3::zeros(),
        };
        let chain = (1..50).map(|j| Measurement {
            i: j - 1,
            j,
            ..measurement(0)
        });
        let all = chain.chain((0..200).map(measurement).filter(|m| m.i != m.j));
        let graph = Subgraph {
            num_nodes: 50,
            measurements: all.collect(),
        };
        let count = graph.measurements.len();
        // Weights over eight decades.
        let weights: Vec<f64> = (0..count).map(|k| 10f64.powi(-((k % 9) as i32))).collect();
        let offset =
            |k: usize| Vector3::new((k as f64).sin(), (2.0 * k as f64).cos(), 0.1 * k as f64);
        let offsets: Vec<_> = (0..count).map(offset).collect();
        let mut system = GroundedLaplacian::new(&graph);
        system.set_weights(&weights);
        let factored = system.solve(&offsets, TOLERANCE);
        system.factored = None;
        let iterated = system.solve(&offsets, TOLERANCE);
        for (a, b) in factored.iter().zip(&iterated) {
            assert!((a - b).norm() < 1e-6, "{a} {b}");
        }
        let residuals = [factored, iterated].map(|x| system.relative_residual(&x, &offsets));
        assert!(residuals.iter().all(|&residual| residual < 1e-9));
    }

    #[test]
    fn a_node_whose_weights_have_vanished_is_placed_by_iteration_too() {
        let measurement = |(i, j)| Measurement {
            i,
            j,
            rotation: Rotation3::identity(),
            translation: Vector3::zeros(),
        };
        let graph = Subgraph {
            num_nodes: 4,
            measurements: [(0, 1), (1, 2), (2, 3)].map(measurement).to_vec(),
        };
        for weights in [[1.0, 1.0, 0.0], [0.0; 3]] {
            let mut system = GroundedLaplacian::new(&graph);
            system.set_weights(&weights);
            system.factored = None;
            let solution = system.solve(&[Vector3::x(); 3], TOLERANCE);
            assert!((solution[3].x - 3.0).abs() < 1e-6, "{}", solution[3]);
            assert!(system.relative_residual(&solution, &[Vector3::x(); 3]) < 1e-9);
        }
    }

    #[test]
    fn an_iteration_that_did_not_converge_has_a_large_residual() {
        let measurement = |j: usize| Measurement {
            i: j - 1,
            j,
            rotation: Rotation3::identity(),
            translation: Vector3::zeros(),
        };
        // A chain needs as many iterations as it has edges, and there are 1000 of them at most.
        let graph = |num_nodes| Subgraph {
            num_nodes,
            measurements: (1..num_nodes).map(measurement).collect(),
        };
        let residual = |num_nodes: usize| {
            let mut system = GroundedLaplacian::new(&graph(num_nodes));
            system.set_weights(&vec![1.0; num_nodes - 1]);
            system.factored = None;
            let offsets = vec![Vector3::x(); num_nodes - 1];
            let solution = system.solve(&offsets, TOLERANCE);
            system.relative_residual(&solution, &offsets)
        };
        assert!(residual(900) < 1e-9);
        assert!(residual(3000) > 1e-3);
    }
}
