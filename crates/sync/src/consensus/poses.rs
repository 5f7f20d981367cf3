use gmpcr_geometry::{angular_distance, isometry};
use nalgebra::{Isometry3, Rotation3, Vector3};

use crate::subgraph::{Measurement, Subgraph};

/// `x_a = rotation · x_b + position`: a pose or a relative pose in matrix form.
#[derive(Clone, Copy, Debug)]
pub(super) struct Transformation {
    pub rotation: Rotation3<f64>,
    pub position: Vector3<f64>,
}

impl Transformation {
    /// `i_from_j` of a measurement.
    pub fn measured(m: &Measurement) -> Self {
        Self {
            rotation: m.rotation,
            position: m.translation,
        }
    }

    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.inverse();
        Self {
            rotation,
            position: -(rotation * self.position),
        }
    }

    /// `self · next`.
    pub fn then(&self, next: &Self) -> Self {
        Self {
            rotation: self.rotation * next.rotation,
            position: self.position + self.rotation * next.position,
        }
    }
}

/// Poses of the nodes of a graph, `world_from_node`.
#[derive(Clone, Debug)]
pub(super) struct Poses {
    pub rotations: Vec<Rotation3<f64>>,
    pub positions: Vec<Vector3<f64>>,
}

impl Poses {
    pub fn identities(num_nodes: usize) -> Self {
        Self {
            rotations: vec![Rotation3::identity(); num_nodes],
            positions: vec![Vector3::zeros(); num_nodes],
        }
    }

    pub fn get(&self, node: usize) -> Transformation {
        Transformation {
            rotation: self.rotations[node],
            position: self.positions[node],
        }
    }

    pub fn set(&mut self, node: usize, pose: &Transformation) {
        self.rotations[node] = pose.rotation;
        self.positions[node] = pose.position;
    }

    /// The same poses in the frame of node 0.
    pub fn in_frame_of_first(&self) -> Vec<Isometry3<f64>> {
        let first_from_world = self.get(0).inverse();
        let others = (1..self.rotations.len()).map(|node| {
            let pose = first_from_world.then(&self.get(node));
            isometry(&pose.rotation, &pose.position)
        });
        std::iter::once(Isometry3::identity())
            .chain(others)
            .collect()
    }
}

/// Residuals of inliers that count as one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise {
    /// In radians.
    pub rotation: f64,
    /// In the unit of the translations; infinite where it is unknown, so that only rotations count.
    pub translation: f64,
}

impl Noise {
    /// One radian and one unit of the translations.
    pub const UNIT: Self = Self {
        rotation: 1.0,
        translation: 1.0,
    };

    pub fn times(&self, factor: f64) -> Self {
        Self {
            rotation: self.rotation * factor,
            translation: self.translation * factor,
        }
    }

    /// Angle and offset between a measurement and what two poses say, in units of the noise.
    pub fn residuals(
        &self,
        world_from_i: &Transformation,
        m: &Measurement,
        world_from_j: &Transformation,
    ) -> [f64; 2] {
        let predicted = world_from_i.then(&Transformation::measured(m));
        let angle = angular_distance(&predicted.rotation, &world_from_j.rotation);
        let offset = (predicted.position - world_from_j.position).norm();
        [angle / self.rotation, offset / self.translation]
    }

    /// How well a measurement agrees with two poses, in [0, 1]: the weight `(1 + r²)⁻²` of the
    /// Geman–McClure loss, with `r² = (angle / σ_R)² + (offset / σ_t)²`.
    pub fn agreement(
        &self,
        world_from_i: &Transformation,
        m: &Measurement,
        world_from_j: &Transformation,
    ) -> f64 {
        let [angle, offset] = self.residuals(world_from_i, m, world_from_j);
        (1.0 + angle * angle + offset * offset).powi(-2)
    }

    /// Weights of all measurements under the loss of this scale.
    pub fn weights(&self, graph: &Subgraph, initial_weights: &[f64], poses: &Poses) -> Vec<f64> {
        let pairs = graph.measurements.iter().zip(initial_weights);
        let weight = |(m, initial): (&Measurement, &f64)| {
            initial * self.agreement(&poses.get(m.i), m, &poses.get(m.j))
        };
        pairs.map(weight).collect()
    }
}
