use nalgebra::Rotation3;

use super::poses::{Noise, Poses};
use crate::lie_averaging::LieAverager;
use crate::params::SyncParams;
use crate::reweighting::{Reweighting, weighted_error};
use crate::subgraph::Subgraph;

/// Scale of the loss at the start, in units of the noise.
const START_SCALE: f64 = 4.0;

/// Iteratively reweighted least squares with the Geman–McClure loss of rotation and translation
/// residuals together. During the first half of the iterations its scale falls to the noise
/// (graduated non-convexity), so that first poses that are off by a few times the noise are forgiven.
/// Also returns the residual of the last positions.
pub(super) fn refine(
    graph: &Subgraph,
    initial_weights: &[f64],
    params: &SyncParams,
    noise: &Noise,
    poses: &mut Poses,
) -> (Vec<Reweighting>, f64) {
    let mut least_squares = LeastSquares::new(graph, poses.rotations.clone());
    let (mut reweightings, mut position_residual) = (Vec::new(), 0.0);
    for k in 0..params.iterations {
        let progress = 2.0 * k as f64 / params.iterations as f64;
        let noise = noise.times(START_SCALE.powf(1.0 - progress).max(1.0));
        let weights = noise.weights(graph, initial_weights, poses);
        (*poses, position_residual) = least_squares.solve(&weights);
        reweightings.push(record(graph, weights, params.residual_scale, poses));
    }
    (reweightings, position_residual)
}

/// What a reweighting and the poses under it have come to.
pub(super) fn record(
    graph: &Subgraph,
    weights: Vec<f64>,
    residual_scale: f64,
    poses: &Poses,
) -> Reweighting {
    let residuals = graph.normalized_residuals(&poses.rotations, residual_scale);
    Reweighting {
        weighted_error: weighted_error(&weights, &residuals),
        memory: None,
        weights,
    }
}

/// Least squares over rotations, then over the positions that go with them.
pub(super) struct LeastSquares<'a> {
    averager: LieAverager<'a>,
}

impl<'a> LeastSquares<'a> {
    /// Starts from these rotations.
    pub fn new(graph: &'a Subgraph, world_from_node: Vec<Rotation3<f64>>) -> Self {
        Self {
            averager: LieAverager::new(graph, world_from_node),
        }
    }

    /// The poses and the residual of their positions.
    pub fn solve(&mut self, weights: &[f64]) -> (Poses, f64) {
        self.averager.solve(weights);
        let translations = self.averager.positions();
        let poses = Poses {
            positions: translations.positions,
            rotations: self.averager.world_from_node.clone(),
        };
        (poses, translations.residual)
    }
}
