use std::cmp::Reverse;
use std::collections::BinaryHeap;

use gmpcr_posegraph::{PoseEdge, PoseGraph};
use nalgebra::{Matrix3, Rotation3, Vector3};

/// A relative pose between nodes of a [`Subgraph`], in matrix form.
#[derive(Clone, Debug)]
pub(crate) struct Measurement {
    pub i: usize,
    pub j: usize,
    pub rotation: Rotation3<f64>,
    pub translation: Vector3<f64>,
}

impl Measurement {
    /// The relative pose of an edge, between the nodes `i` and `j` that its scans are.
    pub fn new(edge: &PoseEdge, i: usize, j: usize) -> Self {
        Self {
            i,
            j,
            rotation: edge.i_from_j.rotation.to_rotation_matrix(),
            translation: edge.i_from_j.translation.vector,
        }
    }

    pub fn matrix(&self) -> &Matrix3<f64> {
        self.rotation.matrix()
    }
}

/// A connected part of a pose graph, its nodes renumbered from zero.
#[derive(Clone, Debug)]
pub(crate) struct Subgraph {
    pub num_nodes: usize,
    pub measurements: Vec<Measurement>,
}

impl Subgraph {
    /// The whole graph as one part.
    pub fn whole(graph: &PoseGraph) -> Self {
        let edges = graph.edges().iter();
        Self {
            num_nodes: graph.num_scans(),
            measurements: edges
                .map(|edge| Measurement::new(edge, edge.i, edge.j))
                .collect(),
        }
    }

    /// Angles between measured and estimated relative rotations in units of a scale (radians),
    /// `d_R(R_iᵀ R_j, R̂_ij) / s_r`, one per measurement.
    pub fn normalized_residuals(&self, world_from_node: &[Rotation3<f64>], scale: f64) -> Vec<f64> {
        let residual = |m: &Measurement| {
            let i_from_j = world_from_node[m.i].inverse() * world_from_node[m.j];
            gmpcr_geometry::angular_distance(&i_from_j, &m.rotation) / scale
        };
        self.measurements.iter().map(residual).collect()
    }

    /// A spanning tree of maximal weight (Prim 1957), as branches from visited to new nodes in the order
    /// of the visits. Parts out of reach start from their lowest node. Ties: lower measurement.
    pub fn spanning_tree(&self, weights: &[f64]) -> Vec<Branch> {
        let mut at_node = vec![Vec::new(); self.num_nodes];
        for (position, m) in self.measurements.iter().enumerate() {
            at_node[m.i].push(position);
            at_node[m.j].push(position);
        }
        let (mut is_visited, mut tree) = (vec![false; self.num_nodes], Vec::new());
        // Nonnegative numbers are ordered as their bits are.
        let candidate = |&position: &usize| (weights[position].to_bits(), Reverse(position));
        for root in 0..self.num_nodes {
            let mut frontier = BinaryHeap::new();
            if !is_visited[root] {
                is_visited[root] = true;
                frontier.extend(at_node[root].iter().map(candidate));
            }
            while let Some((_, Reverse(position))) = frontier.pop() {
                let m = &self.measurements[position];
                let (parent, child) = if is_visited[m.i] {
                    (m.i, m.j)
                } else {
                    (m.j, m.i)
                };
                if !is_visited[child] {
                    is_visited[child] = true;
                    frontier.extend(at_node[child].iter().map(candidate));
                    tree.push(Branch {
                        parent,
                        child,
                        measurement: position,
                    });
                }
            }
        }
        tree
    }

    /// Rotations along a tree, its root having the identity. Exact where the measurements are.
    pub fn rotations_along(&self, tree: &[Branch]) -> Vec<Rotation3<f64>> {
        let mut world_from_node = vec![Rotation3::identity(); self.num_nodes];
        for branch in tree {
            let m = &self.measurements[branch.measurement];
            let parent_from_child = if m.i == branch.parent {
                m.rotation
            } else {
                m.rotation.inverse()
            };
            world_from_node[branch.child] = world_from_node[branch.parent] * parent_from_child;
        }
        world_from_node
    }

    /// Positions along a tree under given rotations, its root being the origin.
    pub fn positions_along(
        &self,
        tree: &[Branch],
        world_from_node: &[Rotation3<f64>],
    ) -> Vec<Vector3<f64>> {
        let mut positions = vec![Vector3::zeros(); self.num_nodes];
        for branch in tree {
            let m = &self.measurements[branch.measurement];
            let step = world_from_node[m.i] * m.translation;
            let direction = if m.i == branch.parent { 1.0 } else { -1.0 };
            positions[branch.child] = positions[branch.parent] + step * direction;
        }
        positions
    }
}

/// An edge of a spanning tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Branch {
    pub parent: usize,
    pub child: usize,
    /// The measurement between the two.
    pub measurement: usize,
}

/// Weights in units of the largest, so that no product of them overflows or vanishes.
pub(crate) fn relative(weights: &[f64]) -> Vec<f64> {
    let largest = weights.iter().copied().fold(0.0, f64::max);
    if largest > 0.0 {
        weights.iter().map(|weight| weight / largest).collect()
    } else {
        weights.to_vec()
    }
}
