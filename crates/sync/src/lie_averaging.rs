use gmpcr_geometry::isometry;
use nalgebra::{Rotation3, Vector3};

use crate::loss::RobustLoss;
use crate::params::SyncParams;
use crate::reweighting::{Reweighting, weighted_error};
use crate::solution::Solution;
use crate::subgraph::{Measurement, Subgraph};
use crate::translations::{GroundedLaplacian, SolvedTranslations};

/// Steps of one weighted average.
const MAX_STEPS: usize = 20;
/// Residual of the equations of a step, relative to their right-hand side, where they are solved by
/// iteration: later steps make up for it.
const STEP_ACCURACY: f64 = 1e-2;
/// Mean step (radians) at which a weighted average has converged.
const STEP_TOLERANCE: f64 = 1e-9;
/// Mean change of the rotations (radians) between two reweightings at which they have converged.
const CHANGE_TOLERANCE: f64 = 1e-6;
/// Reweightings of the ℓ₁ average, which slowly forgets the least squares it starts from.
const MIN_L1_ITERATIONS: usize = 20;

/// `argmin Σ w_ij ρ(r_ij)`, near the ℓ₁ average where the loss is not ℓ₁ itself.
pub(crate) fn rot_avg(
    graph: &Subgraph,
    initial_weights: &[f64],
    loss: RobustLoss,
    params: &SyncParams,
) -> Solution {
    let start = graph.rotations_along(&graph.spanning_tree(initial_weights));
    let mut irls = Irls::new(graph, start, initial_weights, params);
    irls.solve();
    if params.iterations > 0 {
        let iterations = params.iterations.max(MIN_L1_ITERATIONS);
        irls.reweight(iterations, |residual| RobustLoss::L1.factor(residual));
    }
    if loss != RobustLoss::L1 {
        irls.reweight(params.iterations, |residual| loss.factor(residual));
    }
    irls.finish()
}

/// Iteratively reweighted rotation averaging.
pub(crate) struct Irls<'a> {
    averager: LieAverager<'a>,
    residual_scale: f64,
    initial_weights: &'a [f64],
    weights: Vec<f64>,
    reweightings: Vec<Reweighting>,
}

impl<'a> Irls<'a> {
    /// Starts at the given rotations.
    pub fn new(
        graph: &'a Subgraph,
        start: Vec<Rotation3<f64>>,
        initial_weights: &'a [f64],
        params: &SyncParams,
    ) -> Self {
        Self {
            averager: LieAverager::new(graph, start),
            residual_scale: params.residual_scale,
            weights: initial_weights.to_vec(),
            initial_weights,
            reweightings: Vec::new(),
        }
    }

    /// The weighted average under the current weights. Returns the mean change of
    /// the rotations, in radians.
    pub fn solve(&mut self) -> f64 {
        self.averager.solve(&self.weights)
    }

    /// Reweights and averages until that changes nothing, `iterations` times at most.
    pub fn reweight(&mut self, iterations: usize, factor: impl Fn(f64) -> f64) {
        for _ in 0..iterations {
            let residuals = self.residuals();
            let weighted_error = weighted_error(&self.weights, &residuals);
            let pairs = self.initial_weights.iter().zip(&residuals);
            self.weights = pairs.map(|(w, &r)| w * factor(r)).collect();
            self.reweightings.push(Reweighting {
                weighted_error,
                memory: None,
                weights: self.weights.clone(),
            });
            if self.solve() < CHANGE_TOLERANCE {
                return;
            }
        }
    }

    /// Rotation residuals in units of `σ`.
    fn residuals(&self) -> Vec<f64> {
        let LieAverager {
            graph,
            world_from_node,
            ..
        } = &self.averager;
        graph.normalized_residuals(world_from_node, self.residual_scale)
    }

    pub fn finish(self) -> Solution {
        let LieAverager {
            graph,
            world_from_node,
            ..
        } = self.averager;
        Solution::of_rotations(graph, &world_from_node, &self.weights, self.reweightings)
    }
}

/// Weighted least squares over rotations by steps in the tangent space.
///
/// With `exp(ω_ij) = R_i R̂_ij R_jᵀ`, the error of an edge in the frame of the world, and `R_i` replaced
/// by `exp(δ_i) R_i`, the error becomes `ω_ij + δ_i − δ_j` to first order. Each step solves
///
/// ```text
/// argmin_δ Σ w_ij ‖ω_ij + δ_i − δ_j‖²,   δ_0 = 0
/// ```
///
/// whose matrix is the weighted graph Laplacian. It depends on the weights only, so it is factored once.
/// Where the steps end, `Σ_j w_ij ω_ij` vanishes at each node: the gradient of `½ Σ w_ij r_ij²`.
pub(crate) struct LieAverager<'a> {
    graph: &'a Subgraph,
    system: GroundedLaplacian,
    pub world_from_node: Vec<Rotation3<f64>>,
}

impl<'a> LieAverager<'a> {
    pub fn new(graph: &'a Subgraph, world_from_node: Vec<Rotation3<f64>>) -> Self {
        Self {
            graph,
            system: GroundedLaplacian::new(graph),
            world_from_node,
        }
    }

    /// Steps to the weighted average. Returns the sum of the mean steps.
    pub fn solve(&mut self, weights: &[f64]) -> f64 {
        self.system.set_weights(weights);
        let mut change = 0.0;
        for _ in 0..MAX_STEPS {
            let step = self.step();
            change += step;
            if step < STEP_TOLERANCE {
                break;
            }
        }
        change
    }

    /// The positions that go with the rotations, under the weights of the last average.
    pub fn positions(&mut self) -> SolvedTranslations {
        self.system.positions(self.graph, &self.world_from_node)
    }

    /// One step of all nodes. Returns its mean length.
    fn step(&mut self) -> f64 {
        let errors: Vec<_> = self
            .graph
            .measurements
            .iter()
            .map(|m| self.error(m))
            .collect();
        let steps = self.system.solve(&errors, STEP_ACCURACY);
        for (rotation, step) in self.world_from_node.iter_mut().zip(&steps) {
            *rotation = Rotation3::new(*step) * *rotation;
        }
        let lengths = steps.iter().map(|step| step.norm());
        lengths.sum::<f64>() / steps.len() as f64
    }

    /// `ω_ij`.
    fn error(&self, m: &Measurement) -> Vector3<f64> {
        let [of_i, of_j] = [m.i, m.j].map(|node| &self.world_from_node[node]);
        let error = of_i * m.rotation * of_j.inverse();
        isometry(&error, &Vector3::zeros()).rotation.scaled_axis()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Parallel measurements about one axis.
    fn parallel(angles: &[f64]) -> Subgraph {
        let measurement = |&angle: &f64| Measurement {
            i: 0,
            j: 1,
            rotation: Rotation3::new(Vector3::y() * angle),
            translation: Vector3::zeros(),
        };
        Subgraph {
            num_nodes: 2,
            measurements: angles.iter().map(measurement).collect(),
        }
    }

    fn angle_found(graph: &Subgraph, loss: RobustLoss, iterations: usize) -> f64 {
        let params = SyncParams {
            iterations,
            ..SyncParams::default()
        };
        let weights = vec![0.5; graph.measurements.len()];
        let solution = rot_avg(graph, &weights, loss, &params);
        solution.world_from_node[1].rotation.angle()
    }

    #[test]
    fn one_axis_has_the_averages_of_numbers() {
        let graph = parallel(&[0.0, 0.1, 1.0]);
        let mean = angle_found(&graph, RobustLoss::L1, 0);
        let median = angle_found(&graph, RobustLoss::L1, 100);
        let mode = angle_found(&graph, RobustLoss::GemanMcClure, 100);
        assert!((mean - 1.1 / 3.0).abs() < 1e-9, "{mean}");
        assert!((median - 0.1).abs() < 1e-2, "{median}");
        assert!((mode - 0.05).abs() < 1e-2, "{mode}");
    }

    #[test]
    fn the_average_of_large_errors_is_stationary() {
        let ends = [(0, 1), (1, 2), (2, 0), (3, 1), (0, 3), (2, 3)];
        let measurement = |(k, (i, j)): (usize, (usize, usize))| Measurement {
            i,
            j,
            rotation: Rotation3::new(Vector3::new(0.3 * k as f64, 0.2, -0.1)),
            translation: Vector3::zeros(),
        };
        let graph = Subgraph {
            num_nodes: 4,
            measurements: ends.into_iter().enumerate().map(measurement).collect(),
        };
        let mut averager = LieAverager::new(&graph, vec![Rotation3::identity(); 4]);
        let weights = [1.0, 0.5, 0.7, 0.2, 0.9, 0.4];
        averager.solve(&weights);
        averager.solve(&weights);
        let mut gradient = [Vector3::zeros(); 4];
        for (m, weight) in graph.measurements.iter().zip(weights) {
            gradient[m.i] += averager.error(m) * weight;
            gradient[m.j] -= averager.error(m) * weight;
        }
        assert!(averager.error(&graph.measurements[3]).norm() > 0.1);
        for sum in gradient {
            assert!(sum.norm() < 1e-8, "{sum}");
        }
    }
}
