//! Outliers found by what they contradict: see [`Method::Consensus`](crate::Method::Consensus).

mod assembly;
mod joint;
mod loops;
mod normal_equations;
mod poses;
mod refinement;
mod scales;
mod votes;

use crate::params::SyncParams;
use crate::solution::Solution;
use crate::subgraph::{Subgraph, relative};
use assembly::assemble;
use joint::refine_jointly;
use loops::LoopSupport;
use poses::Noise;
use refinement::{record, refine};
use votes::vote;

pub(crate) fn synchronize(
    graph: &Subgraph,
    initial_weights: &[f64],
    params: &SyncParams,
) -> Solution {
    let weights = relative(initial_weights);
    let loops = LoopSupport::new(graph, &weights, params.residual_scale);
    let noise = Noise {
        rotation: params.residual_scale,
        translation: loops.translation_noise,
    };
    let mut poses = assemble(graph, &weights, &loops, &noise);
    vote(graph, &weights, &noise, &mut poses);
    let (mut reweightings, mut position_residual) =
        refine(graph, initial_weights, params, &noise, &mut poses);
    let joint = refine_jointly(graph, initial_weights, params, &noise, &mut poses);
    if !joint.is_empty() {
        position_residual = 0.0;
    }
    reweightings.extend(joint);
    if reweightings.is_empty() {
        let weights = noise.weights(graph, initial_weights, &poses);
        reweightings.push(record(graph, weights, params.residual_scale, &poses));
    }
    Solution {
        position_residual,
        ..Solution::of_poses(poses.in_frame_of_first(), reweightings)
    }
}
