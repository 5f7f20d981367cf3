use nalgebra::Rotation3;

use crate::averaging::RotationAverager;
use crate::history::{EdgeHistory, History};
use crate::params::SyncParams;
use crate::solution::Solution;
use crate::subgraph::Subgraph;

/// Iteratively reweighted rotation averaging with residual history; rotations and translations are
/// solved once more under the last weights.
pub(crate) fn synchronize(
    graph: &Subgraph,
    initial_weights: &[f64],
    history: History,
    params: &SyncParams,
) -> Solution {
    let mut averager = RotationAverager::new(graph, initial_weights);
    let mut history = EdgeHistory::new(history, params.iterations, initial_weights.to_vec());
    let mut reweightings = Vec::new();
    let (mut eigen_residual, mut weakest_block) = (0f64, 1f64);
    let mut average = |weights: &[f64]| -> Vec<Rotation3<f64>> {
        let averaged = averager.solve(weights);
        eigen_residual = eigen_residual.max(averaged.eigen_residual);
        weakest_block = weakest_block.min(averaged.weakest_block);
        averaged.world_from_scan
    };
    for _ in 0..params.iterations {
        let rotations = average(history.weights());
        let residuals = graph.normalized_residuals(&rotations, params.residual_scale);
        reweightings.push(history.update(&residuals, params.residual_scale));
    }
    let rotations = average(history.weights());
    Solution {
        eigen_residual,
        weakest_block,
        ..Solution::of_rotations(graph, &rotations, history.weights(), reweightings)
    }
}
