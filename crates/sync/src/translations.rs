use gmpcr_posegraph::PoseGraph;
use nalgebra::{DMatrix, Rotation3, Vector3};

use crate::cholesky::SparseCholesky;
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
    let weights = relative(weights);
    let tree = graph.spanning_tree(&weights);
    let along_tree = graph.positions_along(&tree, world_from_node);
    let offset = |m: &Measurement| {
        world_from_node[m.i] * m.translation - (along_tree[m.j] - along_tree[m.i])
    };
    let offsets: Vec<_> = graph.measurements.iter().map(offset).collect();
    let system = GroundedLaplacian::new(graph);
    let corrections = system.solve(graph, &offsets, &weights).or_else(|| {
        let lifted: Vec<f64> = weights.iter().map(|w| w.max(WEIGHT_FLOOR)).collect();
        system.solve(graph, &offsets, &lifted)
    });
    let correction = |node: usize| match &corrections {
        Some(rows) if node > 0 => rows.fixed_view::<1, 3>(node - 1, 0).transpose(),
        _ => Vector3::zeros(),
    };
    let nodes = along_tree.iter().enumerate();
    nodes
        .map(|(node, position)| position + correction(node))
        .collect()
}

/// The weighted graph Laplacian without node 0; node `k` is row `k − 1`.
struct GroundedLaplacian {
    column_starts: Vec<usize>,
    rows: Vec<usize>,
}

impl GroundedLaplacian {
    fn new(graph: &Subgraph) -> Self {
        let mut below = vec![Vec::new(); graph.num_nodes - 1];
        for m in &graph.measurements {
            let (low, high) = (m.i.min(m.j), m.i.max(m.j));
            if low > 0 {
                below[low - 1].push(high - 1);
            }
        }
        let (mut column_starts, mut rows) = (vec![0], Vec::new());
        for (column, mut nodes) in below.into_iter().enumerate() {
            nodes.sort_unstable();
            nodes.dedup();
            rows.push(column);
            rows.extend(nodes);
            column_starts.push(rows.len());
        }
        Self {
            column_starts,
            rows,
        }
    }

    /// Positions `p` of all nodes but the first that minimise `Σ w ‖offset + p_i − p_j‖²`; `None`
    /// where the system is singular in floating point.
    fn solve(
        &self,
        graph: &Subgraph,
        offsets: &[Vector3<f64>],
        weights: &[f64],
    ) -> Option<DMatrix<f64>> {
        let mut values = vec![0.0; self.rows.len()];
        let mut right = DMatrix::zeros(graph.num_nodes - 1, 3);
        for ((m, &weight), offset) in graph.measurements.iter().zip(weights).zip(offsets) {
            for (node, sign) in [(m.i, -1.0), (m.j, 1.0)] {
                if node > 0 {
                    values[self.column_starts[node - 1]] += weight;
                    let mut row = right.row_mut(node - 1);
                    row += offset.transpose() * (sign * weight);
                }
            }
            let (low, high) = (m.i.min(m.j), m.i.max(m.j));
            if low > 0 {
                values[self.position(low - 1, high - 1)] -= weight;
            }
        }
        let mut cholesky = SparseCholesky::new(
            graph.num_nodes - 1,
            self.column_starts.clone(),
            self.rows.clone(),
        );
        cholesky.factorize(&values).ok()?;
        cholesky.solve_in_place(&mut right);
        right.iter().all(|x| x.is_finite()).then_some(right)
    }

    fn position(&self, column: usize, row: usize) -> usize {
        let range = self.column_starts[column]..self.column_starts[column + 1];
        range.start + self.rows[range].partition_point(|&other| other < row)
    }
}
