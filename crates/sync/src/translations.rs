use gmpcr_posegraph::PoseGraph;
use nalgebra::{DMatrix, Rotation3, Vector3};

use crate::cholesky::SparseCholesky;
use crate::pattern::GroundedPattern;
use crate::subgraph::{Measurement, Subgraph, relative};

/// Relative weights are lifted to this where rounding leaves scans that hang on lower ones without a
/// position.
const WEIGHT_FLOOR: f64 = 1e-12;

/// Translations under given rotations: `argmin Σ w_ij ‖R_i t̂_ij + t_i − t_j‖²`.
///
/// Scan 0 has the zero translation, which leaves a sparse positive definite system in the other
/// scans, solved by Cholesky decomposition for the three axes at once. The unknowns are the
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
/// let positions = solve_translations(&graph, &[Rotation3::identity(); 3], &[1.0; 3]);
/// assert!((positions[1].x - 1.1).abs() < 1e-12 && (positions[2].x - 2.2).abs() < 1e-12);
/// # Ok::<(), gmpcr_posegraph::PoseGraphError>(())
/// ```
pub fn solve_translations(
    graph: &PoseGraph,
    world_from_scan: &[Rotation3<f64>],
    weights: &[f64],
) -> Vec<Vector3<f64>> {
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
) -> Vec<Vector3<f64>> {
    if graph.num_nodes < 2 {
        return vec![Vector3::zeros(); graph.num_nodes];
    }
    let tree = graph.spanning_tree(&relative(weights));
    let along_tree = graph.positions_along(&tree, world_from_node);
    let offset = |m: &Measurement| {
        world_from_node[m.i] * m.translation - (along_tree[m.j] - along_tree[m.i])
    };
    let offsets: Vec<_> = graph.measurements.iter().map(offset).collect();
    let mut system = GroundedLaplacian::new(graph);
    system.set_weights(weights);
    let corrections = system.solve(&offsets);
    let nodes = along_tree.iter().zip(&corrections);
    nodes
        .map(|(position, correction)| position + correction)
        .collect()
}

/// The weighted graph Laplacian without node 0, whose row `k − 1` is of node `k`: the normal equations
/// of `argmin Σ w_ij ‖o_ij + p_i − p_j‖²` with `p_0 = 0`. The graph has two nodes at least.
pub(crate) struct GroundedLaplacian<'a> {
    graph: &'a Subgraph,
    weights: Vec<f64>,
    pattern: GroundedPattern,
    cholesky: SparseCholesky,
    is_definite: bool,
}

impl<'a> GroundedLaplacian<'a> {
    /// The Laplacian with zero weights.
    pub fn new(graph: &'a Subgraph) -> Self {
        let pattern = GroundedPattern::new(graph, 1);
        Self {
            graph,
            weights: vec![0.0; graph.measurements.len()],
            cholesky: pattern.cholesky(),
            pattern,
            is_definite: false,
        }
    }

    /// Takes these weights, of which only the ratios matter.
    pub fn set_weights(&mut self, weights: &[f64]) {
        self.weights = relative(weights);
        self.factorize();
    }

    /// The minimising `p` of all nodes for one offset `o` per measurement. All zero where the system
    /// is singular in floating point.
    pub fn solve(&mut self, offsets: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let solution = self.try_solve(offsets).or_else(|| {
            self.lift_weights();
            self.try_solve(offsets)
        });
        let position = |node: usize| match &solution {
            Some(rows) if node > 0 => rows.fixed_view::<1, 3>(node - 1, 0).transpose(),
            _ => Vector3::zeros(),
        };
        (0..self.graph.num_nodes).map(position).collect()
    }

    fn try_solve(&mut self, offsets: &[Vector3<f64>]) -> Option<DMatrix<f64>> {
        if !self.is_definite {
            return None;
        }
        let mut right = DMatrix::zeros(self.graph.num_nodes - 1, 3);
        let measurements = self.graph.measurements.iter().zip(&self.weights);
        for ((m, &weight), offset) in measurements.zip(offsets) {
            for (node, sign) in [(m.i, -1.0), (m.j, 1.0)] {
                if node > 0 {
                    let mut row = right.row_mut(node - 1);
                    row += offset.transpose() * (sign * weight);
                }
            }
        }
        self.cholesky.solve_in_place(&mut right);
        right.iter().all(|x| x.is_finite()).then_some(right)
    }

    fn lift_weights(&mut self) {
        let lifted = self.weights.iter().map(|weight| weight.max(WEIGHT_FLOOR));
        self.weights = lifted.collect();
        self.factorize();
    }

    fn factorize(&mut self) {
        let mut values = vec![0.0; self.pattern.num_values()];
        for (m, &weight) in self.graph.measurements.iter().zip(&self.weights) {
            for node in [m.i, m.j] {
                if node > 0 {
                    values[self.pattern.start(node, node, 0)] += weight;
                }
            }
            let (low, high) = (m.i.min(m.j), m.i.max(m.j));
            if low > 0 {
                values[self.pattern.start(high, low, 0)] -= weight;
            }
        }
        self.is_definite = self.cholesky.factorize(&values).is_ok();
    }
}
