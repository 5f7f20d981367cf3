use super::poses::{Noise, Poses, Transformation};
use crate::subgraph::{Measurement, Subgraph};

/// Sweeps over the nodes before the votes are given up.
const MAX_SWEEPS: usize = 10;
/// Factor by which another place must have more votes: rounding alone must not move a node.
const MARGIN: f64 = 1.000_001;

/// Moves each node to where one of its measurements puts it if the measurements at the node agree
/// better with that place, until none moves: nodes that were misplaced with their part leave it.
pub(super) fn vote(graph: &Subgraph, weights: &[f64], noise: &Noise, poses: &mut Poses) {
    let mut at_node = vec![Vec::new(); graph.num_nodes];
    for (position, m) in graph.measurements.iter().enumerate() {
        at_node[m.i].push(position);
        at_node[m.j].push(position);
    }
    for _ in 0..MAX_SWEEPS {
        let mut num_moves = 0;
        for (node, measurements) in at_node.iter().enumerate() {
            let ballot = Ballot {
                graph,
                weights,
                noise,
                poses,
                node,
                measurements,
            };
            if let Some(pose) = ballot.winner() {
                poses.set(node, &pose);
                num_moves += 1;
            }
        }
        if num_moves == 0 {
            return;
        }
    }
}

/// The measurements at one node, with the other nodes where they are.
struct Ballot<'a> {
    graph: &'a Subgraph,
    weights: &'a [f64],
    noise: &'a Noise,
    poses: &'a Poses,
    node: usize,
    measurements: &'a [usize],
}

impl Ballot<'_> {
    /// A better place than the node's, if there is one.
    fn winner(&self) -> Option<Transformation> {
        let to_beat = MARGIN * self.votes(&self.poses.get(self.node));
        let mut best = (to_beat, None);
        for &k in self.measurements {
            let candidate = self.proposal(&self.graph.measurements[k]);
            let votes = self.votes(&candidate);
            if votes > best.0 {
                best = (votes, Some(candidate));
            }
        }
        best.1
    }

    fn proposal(&self, m: &Measurement) -> Transformation {
        if m.j == self.node {
            self.poses.get(m.i).then(&Transformation::measured(m))
        } else {
            self.poses
                .get(m.j)
                .then(&Transformation::measured(m).inverse())
        }
    }

    fn votes(&self, pose: &Transformation) -> f64 {
        let vote = |&k: &usize| {
            let m = &self.graph.measurements[k];
            let pose_of = |node: usize| {
                if node == self.node {
                    *pose
                } else {
                    self.poses.get(node)
                }
            };
            self.weights[k] * self.noise.agreement(&pose_of(m.i), m, &pose_of(m.j))
        };
        self.measurements.iter().map(vote).sum()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};

    use super::*;

    #[test]
    fn a_misplaced_node_returns_to_where_most_of_its_measurements_agree() {
        let pose = |k: usize| Transformation {
            rotation: Rotation3::new(Vector3::new(0.3, k as f64, -0.2)),
            position: Vector3::new(k as f64, (k * k) as f64, 1.0),
        };
        let between = |i: usize, j: usize| {
            let i_from_j = pose(i).inverse().then(&pose(j));
            Measurement {
                i,
                j,
                rotation: i_from_j.rotation,
                translation: i_from_j.position,
            }
        };
        let mut measurements = vec![between(0, 1), between(1, 2), between(3, 0), between(1, 3)];
        let outlier = Measurement {
            translation: Vector3::new(9.0, 9.0, 9.0),
            ..between(2, 3)
        };
        measurements.push(outlier);
        let graph = Subgraph {
            num_nodes: 4,
            measurements,
        };
        let noise = Noise {
            rotation: 0.1,
            translation: 0.1,
        };
        let mut poses = Poses::identities(4);
        (0..3).for_each(|node| poses.set(node, &pose(node)));
        let misled = poses
            .get(2)
            .then(&Transformation::measured(&graph.measurements[4]));
        poses.set(3, &misled);
        vote(&graph, &[1.0; 5], &noise, &mut poses);
        assert!((poses.positions[3] - pose(3).position).norm() < 1e-12);

        // A single heavy measurement outvotes two light ones.
        vote(&graph, &[1.0, 1.0, 0.1, 0.1, 1.0], &noise, &mut poses);
        assert!((poses.positions[3] - misled.position).norm() < 1e-12);
    }
}
