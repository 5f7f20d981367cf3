use std::iter;

use gmpcr_geometry::InvalidParameter;
use gmpcr_posegraph::{Components, PoseGraph};
use nalgebra::Isometry3;

use crate::history::History;
use crate::loss::RobustLoss;
use crate::method::Method;
use crate::params::{AdaptiveHistory, SyncParams};
use crate::parts::{Part, Parts};
use crate::report::{ComponentReport, EdgeReport, Iteration, Synchronization};
use crate::residuals::{EdgeResidual, edge_residuals};
use crate::solution::Solution;
use crate::{consensus, eigse3, hara, history_aware, lie_averaging};

/// Synchronizes the relative poses of a graph: iteratively reweighted least squares with residual
/// history (paper, section "Adaptive History-aware Pose Synchronization"), or another [`Method`].
///
/// Every connected component is synchronized on its own, in the frame of its lowest scan. After the
/// last of the `L` weight updates, rotations and translations are solved once more. Cost per
/// iteration: one or two sparse factorizations of a `3N × 3N` matrix and ten to thirty block solves, more
/// where eigenvalues nearly coincide. The weights of every iteration are returned: 8 bytes per edge and
/// iteration.
///
/// # Errors
/// [`InvalidParameter`] if `params` are [out of range](SyncParams::validate).
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
/// let result = synchronize(&PoseGraph::new(5, edges)?, &SyncParams::default())?;
/// assert_eq!(result.components.members(), [vec![0, 1, 2], vec![3, 4]]);
/// let error = result.world_from_scan[2].inverse() * step * step;
/// assert!(error.translation.vector.norm() < 1e-12 && error.rotation.angle() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn synchronize(
    graph: &PoseGraph,
    params: &SyncParams,
) -> Result<Synchronization, InvalidParameter> {
    params.validate()?;
    let weighted = graph.edges().iter().filter(|edge| edge.weight > 0.0);
    let components = Components::new(graph.num_scans(), weighted.map(|edge| (edge.i, edge.j)));
    let parts = Parts::new(graph, &components);
    let solutions: Vec<_> = parts.all.iter().map(|part| solve(part, params)).collect();
    let pose = |(&label, &node): (&usize, &usize)| solutions[label].world_from_node[node];
    let places = components.labels().iter().zip(&parts.node_of_scan);
    let world_from_scan: Vec<_> = places.map(pose).collect();
    let edges = edge_reports(graph, &parts, &solutions, &world_from_scan);
    Ok(Synchronization {
        world_from_scan,
        components,
        edges,
        reports: solutions.iter().map(component_report).collect(),
    })
}

/// Synchronizes one component. Its lowest node has the identity.
fn solve(part: &Part, params: &SyncParams) -> Solution {
    let (graph, weights) = (&part.graph, &part.initial_weights[..]);
    if graph.measurements.is_empty() {
        return Solution::of_poses(vec![Isometry3::identity(); graph.num_nodes], Vec::new());
    }
    let with_history = |history| history_aware::synchronize(graph, weights, history, params);
    let rot_avg = |loss| lie_averaging::rot_avg(graph, weights, loss, params);
    match params.method {
        Method::Adaptive => with_history(History::Adaptive(params.history)),
        Method::NoRecovery => with_history(History::Adaptive(AdaptiveHistory {
            recovery: 0.0,
            ..params.history
        })),
        Method::Sghr => with_history(History::Sghr),
        Method::Memoryless => with_history(History::Memoryless),
        Method::EigSe3 => eigse3::synchronize(graph, weights),
        Method::L1 => rot_avg(RobustLoss::L1),
        Method::L1Irls => rot_avg(RobustLoss::GemanMcClure),
        Method::RotAvgLHalf => rot_avg(RobustLoss::LHalf),
        Method::Hara => hara::synchronize(graph, weights, params),
        Method::Consensus => consensus::synchronize(graph, weights, params),
    }
}

fn edge_reports(
    graph: &PoseGraph,
    parts: &Parts,
    solutions: &[Solution],
    world_from_scan: &[Isometry3<f64>],
) -> Vec<EdgeReport> {
    let residuals = edge_residuals(graph, world_from_scan);
    let edges = graph.edges().iter().zip(&parts.place_of_edge);
    edges
        .zip(residuals)
        .map(|((edge, place), residual)| {
            let reweightings = place.iter().flat_map(|&(label, measurement)| {
                let of_component = solutions[label].reweightings.iter();
                of_component.map(move |reweighting| reweighting.weights[measurement])
            });
            let weights = iter::once(edge.weight).chain(reweightings);
            edge_report(weights.collect(), place.map(|_| residual))
        })
        .collect()
}

/// Of the course of the weight of an edge, which is not empty.
fn edge_report(weights: Vec<f64>, residual: Option<EdgeResidual>) -> EdgeReport {
    EdgeReport {
        initial_weight: weights[0],
        final_weight: weights[weights.len() - 1],
        rotation_residual: residual.map(|residual| residual.rotation),
        translation_residual: residual.map(|residual| residual.translation),
        weights,
    }
}

fn component_report(solution: &Solution) -> ComponentReport {
    let iterations = solution.reweightings.iter().map(|reweighting| Iteration {
        weighted_error: reweighting.weighted_error,
        memory: reweighting.memory,
    });
    ComponentReport {
        iterations: iterations.collect(),
        eigen_residual: solution.eigen_residual,
        weakest_block: solution.weakest_block,
        position_residual: solution.position_residual,
    }
}
