use gmpcr_geometry::isometry;
use gmpcr_posegraph::{Components, PoseGraph};
use nalgebra::Isometry3;

use crate::method::Solution;
use crate::subgraph::Subgraph;
use crate::{SyncParams, Update};

/// Poses of all scans, with the evidence for them.
#[derive(Clone, Debug, PartialEq)]
pub struct Synchronization {
    /// `T_i`, from each scan's frame into that of the lowest scan of its component, which has the
    /// identity. Poses of different components do not compare.
    pub world_from_scan: Vec<Isometry3<f64>>,
    /// Which scans share a frame: the components of the graph of edges of positive weight.
    pub components: Components,
    /// One report per edge of the graph, in its order.
    pub edges: Vec<EdgeReport>,
    /// One report per component, in the order of `components`.
    pub reports: Vec<ComponentReport>,
}

/// What became of an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeReport {
    /// Weight `w⁰` that the edge came with.
    pub initial_weight: f64,
    /// Weight under which the final poses were solved.
    pub final_weight: f64,
    /// Angle in radians between the measured and the final relative rotation; `None` where the
    /// edge, being without weight, joins two components.
    pub rotation_residual: Option<f64>,
    /// Distance between the measured and the final relative translation, in the unit of the input.
    pub translation_residual: Option<f64>,
}

/// How the synchronisation of one component went.
#[derive(Clone, Debug, PartialEq)]
pub struct ComponentReport {
    /// Positions in the graph of the component's edges: the order of residuals and weights below.
    pub edges: Vec<usize>,
    /// One record per reweighting iteration.
    pub iterations: Vec<Iteration>,
    /// Largest [`eigen_residual`](crate::AveragedRotations::eigen_residual) of all rotation solves.
    pub eigen_residual: f64,
    /// Smallest [`weakest_block`](crate::AveragedRotations::weakest_block) of all rotation solves. Below
    /// about 1e-6 the reweighting has split the component in all but name.
    pub weakest_block: f64,
    /// [Residual](crate::SolvedTranslations::residual) of the final positions; 0 for those that were
    /// solved together with the rotations.
    pub position_residual: f64,
}

/// One reweighting iteration `ℓ`.
#[derive(Clone, Debug, PartialEq)]
pub struct Iteration {
    /// Normalised rotation residuals `r_ij⁽ℓ⁾`.
    pub residuals: Vec<f64>,
    /// Overall error, memory, and the weights `w_ij⁽ℓ⁺¹⁾` that follow.
    pub update: Update,
}

/// Synchronises the relative poses of a graph: iteratively reweighted least squares with residual
/// history (paper, section "Adaptive History-aware Pose Synchronization").
///
/// Every connected component is synchronised on its own, in the frame of its lowest scan. After the
/// last of the `L` weight updates, rotations and translations are solved once more. Cost per
/// iteration: one or two sparse factorisations of a `3N × 3N` matrix and ten to thirty block solves, more where
/// eigenvalues nearly coincide. Residuals and weights of every iteration are returned: 16 bytes per
/// edge and iteration.
///
/// `params` must be in range: see [`SyncParams`].
///
/// ```
/// use gmpcr_posegraph::{PoseEdge, PoseGraph};
/// use gmpcr_sync::{SyncParams, synchronize};
/// use nalgebra::{Isometry3, Vector3};
///
/// let step = Isometry3::new(Vector3::x(), Vector3::z() * 0.2);
/// let edge = |i, j, i_from_j| PoseEdge { i, j, i_from_j, weight: 1.0 };
/// let mut edges = vec![edge(0, 1, step), edge(1, 2, step), edge(0, 2, step * step)];
/// edges.push(edge(3, 4, step));
/// let result = synchronize(&PoseGraph::new(5, edges)?, &SyncParams::default());
/// assert_eq!(result.components.members(), [vec![0, 1, 2], vec![3, 4]]);
/// let error = result.world_from_scan[2].inverse() * step * step;
/// assert!(error.translation.vector.norm() < 1e-12 && error.rotation.angle() < 1e-12);
/// # Ok::<(), gmpcr_posegraph::PoseGraphError>(())
/// ```
pub fn synchronize(graph: &PoseGraph, params: &SyncParams) -> Synchronization {
    let weighted = graph.edges().iter().filter(|edge| edge.weight > 0.0);
    let components = Components::new(graph.num_scans(), weighted.map(|edge| (edge.i, edge.j)));
    let mut result = Synchronization {
        world_from_scan: vec![Isometry3::identity(); graph.num_scans()],
        edges: graph
            .edges()
            .iter()
            .map(|edge| EdgeReport::unused(edge.weight))
            .collect(),
        reports: Vec::with_capacity(components.members().len()),
        components,
    };
    let parts = Subgraph::of_components(graph, &result.components);
    for (label, (part, positions)) in parts.into_iter().enumerate() {
        let initial_weights = positions.iter().map(|&k| graph.edges()[k].weight).collect();
        let solution = Solution::new(&part, initial_weights, params);
        for (node, &scan) in result.components.members()[label].iter().enumerate() {
            result.world_from_scan[scan] = solution.world_from_node[node];
        }
        for (measurement, &position) in positions.iter().enumerate() {
            describe_edge(&part, &solution, measurement, &mut result.edges[position]);
        }
        result.reports.push(ComponentReport {
            edges: positions,
            iterations: solution.iterations,
            eigen_residual: solution.eigen_residual,
            weakest_block: solution.weakest_block,
            position_residual: solution.position_residual,
        });
    }
    result
}

fn describe_edge(
    graph: &Subgraph,
    solution: &Solution,
    measurement: usize,
    report: &mut EdgeReport,
) {
    let m = &graph.measurements[measurement];
    let measured = isometry(&m.rotation, &m.translation);
    let i_from_j = solution.world_from_node[m.i].inv_mul(&solution.world_from_node[m.j]);
    let [a, b] = [&measured, &i_from_j].map(|motion| motion.rotation.to_rotation_matrix());
    let offset = measured.translation.vector - i_from_j.translation.vector;
    report.final_weight = solution.final_weights[measurement];
    report.rotation_residual = Some(gmpcr_geometry::angular_distance(&a, &b));
    report.translation_residual = Some(offset.norm());
}

impl EdgeReport {
    fn unused(initial_weight: f64) -> Self {
        Self {
            initial_weight,
            final_weight: 0.0,
            rotation_residual: None,
            translation_residual: None,
        }
    }
}
