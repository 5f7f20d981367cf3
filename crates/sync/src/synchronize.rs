use gmpcr_geometry::isometry;
use gmpcr_posegraph::{Components, PoseGraph};
use nalgebra::{Isometry3, Rotation3};

use crate::averaging::RotationAverager;
use crate::history::EdgeHistory;
use crate::subgraph::Subgraph;
use crate::translations::subgraph_translations;
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
/// iteration: one sparse factorisation of a `3N × 3N` matrix and a few block solves, more where
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
        let solved = Solved::new(&part, initial_weights, params);
        for (node, &scan) in result.components.members()[label].iter().enumerate() {
            result.world_from_scan[scan] = solved.world_from_node[node];
        }
        for (measurement, &position) in positions.iter().enumerate() {
            solved.describe_edge(&part, measurement, &mut result.edges[position]);
        }
        result.reports.push(ComponentReport {
            edges: positions,
            iterations: solved.iterations,
            eigen_residual: solved.eigen_residual,
            weakest_block: solved.weakest_block,
        });
    }
    result
}

/// The solution of one component.
struct Solved {
    world_from_node: Vec<Isometry3<f64>>,
    final_weights: Vec<f64>,
    iterations: Vec<Iteration>,
    eigen_residual: f64,
    weakest_block: f64,
}

impl Solved {
    fn new(graph: &Subgraph, initial_weights: Vec<f64>, params: &SyncParams) -> Self {
        if graph.measurements.is_empty() {
            return Self::isolated(graph.num_nodes);
        }
        let mut averager = RotationAverager::new(graph, &initial_weights);
        let mut history = EdgeHistory::new(params.history, params.iterations, initial_weights);
        let mut iterations = Vec::new();
        let (mut eigen_residual, mut weakest_block) = (0f64, 1f64);
        let mut average = |weights: &[f64]| -> Vec<Rotation3<f64>> {
            let averaged = averager.solve(weights);
            eigen_residual = eigen_residual.max(averaged.eigen_residual);
            weakest_block = weakest_block.min(averaged.weakest_block);
            averaged.world_from_scan
        };
        for _ in 0..params.iterations {
            let rotations = average(history.weights());
            let mut residuals = graph.rotation_residuals(&rotations);
            residuals
                .iter_mut()
                .for_each(|angle| *angle /= params.residual_scale);
            let update = history.update(&residuals, params.residual_scale);
            iterations.push(Iteration { residuals, update });
        }
        let final_weights = history.weights().to_vec();
        let rotations = average(&final_weights);
        let translations = subgraph_translations(graph, &rotations, &final_weights);
        let parts = rotations.iter().zip(&translations);
        Self {
            world_from_node: parts.map(|(rotation, t)| isometry(rotation, t)).collect(),
            final_weights,
            iterations,
            eigen_residual,
            weakest_block,
        }
    }

    fn isolated(num_nodes: usize) -> Self {
        Self {
            world_from_node: vec![Isometry3::identity(); num_nodes],
            final_weights: Vec::new(),
            iterations: Vec::new(),
            eigen_residual: 0.0,
            weakest_block: 1.0,
        }
    }

    fn describe_edge(&self, graph: &Subgraph, measurement: usize, report: &mut EdgeReport) {
        let m = &graph.measurements[measurement];
        let measured = isometry(&m.rotation, &m.translation);
        let i_from_j = self.world_from_node[m.i].inv_mul(&self.world_from_node[m.j]);
        let [a, b] = [&measured, &i_from_j].map(|motion| motion.rotation.to_rotation_matrix());
        let offset = measured.translation.vector - i_from_j.translation.vector;
        report.final_weight = self.final_weights[measurement];
        report.rotation_residual = Some(gmpcr_geometry::angular_distance(&a, &b));
        report.translation_residual = Some(offset.norm());
    }
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
