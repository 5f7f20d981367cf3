use nalgebra::{Rotation3, Vector6};

use super::normal_equations::NormalEquations;
use super::poses::{Noise, Poses};
use super::refinement::record;
use super::scales::Scales;
use crate::params::SyncParams;
use crate::reweighting::Reweighting;
use crate::subgraph::{Subgraph, relative};

/// Halvings of a step that does not lower the weighted squares.
const MAX_HALVINGS: i32 = 4;
/// Root mean square step, in units of the scales, at which the poses have converged.
const STEP_TOLERANCE: f64 = 1e-6;

/// Rotations and positions at once, by reweighted Gauss–Newton steps, one for each reweighting. A step
/// that lowers the weighted squares lowers the Geman–McClure loss too; where none does, this ends.
///
/// The poses stay as they are where the noise of the translations is unknown, and where the normal
/// equations would be too large.
pub(super) fn refine_jointly(
    graph: &Subgraph,
    initial_weights: &[f64],
    params: &SyncParams,
    noise: &Noise,
    poses: &mut Poses,
) -> Vec<Reweighting> {
    let mut reweightings = Vec::new();
    let mut scales = Scales::new(graph, initial_weights, *noise, poses);
    if scales.loss().translation.is_infinite() {
        return reweightings;
    }
    let Some(mut equations) = NormalEquations::new(graph) else {
        return reweightings;
    };
    for _ in 0..params.iterations {
        let loss = scales.loss();
        let weights = loss.weights(graph, initial_weights, poses);
        let descent = descend(&mut equations, graph, &relative(&weights), &loss, poses);
        let Some((lower, step)) = descent else {
            break;
        };
        *poses = lower;
        reweightings.push(record(graph, weights, params.residual_scale, poses));
        if step < STEP_TOLERANCE {
            break;
        }
        scales.update(poses);
    }
    reweightings
}

/// Poses with a lower `Σ w_ij ‖e_ij‖²` and the root mean square step to them.
fn descend(
    equations: &mut NormalEquations,
    graph: &Subgraph,
    weights: &[f64],
    loss: &Noise,
    poses: &Poses,
) -> Option<(Poses, f64)> {
    let steps = equations.step(weights, loss, poses)?;
    let squares: f64 = steps.iter().map(|step| step.norm_squared()).sum();
    let length = (squares / steps.len() as f64).sqrt();
    let before = weighted_squares(graph, weights, loss, poses);
    (0..=MAX_HALVINGS).find_map(|halvings| {
        let fraction = 0.5f64.powi(halvings);
        let moved = moved(poses, &steps, &loss.times(fraction));
        let is_lower = weighted_squares(graph, weights, loss, &moved) < before;
        is_lower.then_some((moved, fraction * length))
    })
}

fn weighted_squares(graph: &Subgraph, weights: &[f64], loss: &Noise, poses: &Poses) -> f64 {
    let pairs = graph.measurements.iter().zip(weights);
    let squares = pairs.map(|(m, weight)| {
        let [angle, offset] = loss.residuals(&poses.get(m.i), m, &poses.get(m.j));
        weight * (angle * angle + offset * offset)
    });
    squares.sum()
}

/// The poses after steps in this unit.
fn moved(poses: &Poses, steps: &[Vector6<f64>], unit: &Noise) -> Poses {
    let mut moved = poses.clone();
    for (node, step) in steps.iter().enumerate() {
        let rotation = Rotation3::new(step.fixed_rows::<3>(0) * unit.rotation);
        moved.rotations[node] = rotation * moved.rotations[node];
        moved.positions[node] += step.fixed_rows::<3>(3) * unit.translation;
    }
    moved
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::subgraph::Measurement;

    #[test]
    fn the_steps_end_where_the_weighted_squares_of_large_errors_are_stationary() {
        let ends = [(0, 1), (1, 2), (2, 0), (3, 1), (0, 3), (2, 3)];
        let measurement = |(k, (i, j)): (usize, (usize, usize))| Measurement {
            i,
            j,
            rotation: Rotation3::new(Vector3::new(0.3 * k as f64, 0.2, -0.1)),
            translation: Vector3::new(1.0, 0.4 * k as f64, -0.5),
        };
        let graph = Subgraph {
            num_nodes: 4,
            measurements: ends.into_iter().enumerate().map(measurement).collect(),
        };
        let loss = Noise {
            rotation: 0.5,
            translation: 0.8,
        };
        let weights = [1.0, 0.5, 0.7, 0.2, 0.9, 0.4];
        let mut equations = NormalEquations::new(&graph).unwrap();
        let mut poses = Poses::identities(4);
        let descents = std::iter::from_fn(|| {
            let (lower, step) = descend(&mut equations, &graph, &weights, &loss, &poses)?;
            poses = lower;
            (step > 1e-9).then_some(())
        });
        assert!(descents.take(200).count() < 200);
        assert!(weighted_squares(&graph, &weights, &loss, &poses) > 0.1);
        for unknown in 0..4 * 6 {
            let along = |step: f64| {
                let mut steps = [Vector6::zeros(); 4];
                steps[unknown / 6][unknown % 6] = step;
                weighted_squares(&graph, &weights, &loss, &moved(&poses, &steps, &loss))
            };
            let slope = (along(1e-4) - along(-1e-4)) / 2e-4;
            assert!(slope.abs() < 1e-5, "{unknown}: {slope}");
        }
    }
}
