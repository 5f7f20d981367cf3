use gmpcr_geometry::isometry;
use nalgebra::{Isometry3, Rotation3};

use crate::reweighting::Reweighting;
use crate::subgraph::Subgraph;
use crate::translations::subgraph_translations;

/// The solution of one component.
pub(crate) struct Solution {
    /// Poses in the frame of node 0, which has the identity.
    pub world_from_node: Vec<Isometry3<f64>>,
    /// The last holds the final weights; without any, these are the initial ones.
    pub reweightings: Vec<Reweighting>,
    pub eigen_residual: f64,
    pub weakest_block: f64,
    pub position_residual: f64,
}

impl Solution {
    /// A solution that neither an eigenproblem nor translation least squares led to.
    pub fn of_poses(world_from_node: Vec<Isometry3<f64>>, reweightings: Vec<Reweighting>) -> Self {
        Self {
            world_from_node,
            reweightings,
            eigen_residual: 0.0,
            weakest_block: 1.0,
            position_residual: 0.0,
        }
    }

    /// Rotations, completed by translation least squares under the final weights.
    pub fn of_rotations(
        graph: &Subgraph,
        rotations: &[Rotation3<f64>],
        final_weights: &[f64],
        reweightings: Vec<Reweighting>,
    ) -> Self {
        let translations = subgraph_translations(graph, rotations, final_weights);
        let parts = rotations.iter().zip(&translations.positions);
        let poses = parts.map(|(rotation, t)| isometry(rotation, t)).collect();
        Self {
            position_residual: translations.residual,
            ..Self::of_poses(poses, reweightings)
        }
    }
}
