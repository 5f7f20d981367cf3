use gmpcr_geometry::angular_distance;
use nalgebra::Rotation3;

use crate::lie_averaging::Irls;
use crate::loss::RobustLoss;
use crate::params::SyncParams;
use crate::solution::Solution;
use crate::subgraph::{Measurement, Subgraph, relative};
use crate::triangles::for_each_triangle;

/// Loop errors up to which a triangle supports its edges, strict to loose, in units of `σ`.
const LOOP_THRESHOLDS: [f64; 3] = [0.5, 1.0, 2.0];
/// Support beyond this many triangles makes no difference.
const MAX_SUPPORT: usize = 10;
/// Residual, in units of `σ`, beyond which the first fit leaves an edge out: 40° by default, as in the
/// paper. The rotations it starts from carry the errors of many edges in a row.
const FILTER_THRESHOLD: f64 = 8.0;
/// What such an edge weighs nevertheless, to keep the graph connected.
const FILTERED: f64 = 1e-6;

/// Hierarchical initialization, edge filtering, ℓ½ refinement.
pub(crate) fn synchronize(
    graph: &Subgraph,
    initial_weights: &[f64],
    params: &SyncParams,
) -> Solution {
    let start = initial_rotations(graph, initial_weights, params.residual_scale);
    let mut irls = Irls::new(graph, start, initial_weights, params);
    if params.iterations == 0 {
        irls.solve();
    } else {
        irls.reweight(1, |residual| {
            if residual > FILTER_THRESHOLD {
                FILTERED
            } else {
                1.0
            }
        });
        irls.reweight(params.iterations - 1, |residual| {
            RobustLoss::LHalf.factor(residual)
        });
    }
    irls.finish()
}

/// Rotations along a tree of the best supported edges. A node that no supported edge reaches takes the
/// vote of one of its edges from earlier nodes.
fn initial_rotations(graph: &Subgraph, weights: &[f64], scale: f64) -> Vec<Rotation3<f64>> {
    let ranks = support_ranks(graph, weights, scale);
    let priorities = ranks.iter().zip(relative(weights));
    let priorities: Vec<f64> = priorities
        .map(|(&rank, weight)| rank as f64 + 0.5 * weight)
        .collect();
    let at_node = weighted_edges_of_nodes(graph, weights);
    let mut world_from_node = vec![None; graph.num_nodes];
    for branch in graph.spanning_tree(&priorities) {
        world_from_node[branch.parent].get_or_insert_with(Rotation3::identity);
        let vote = |position: usize| {
            let m = &graph.measurements[position];
            let neighbor = m.i + m.j - branch.child;
            let rotation: &Rotation3<f64> = world_from_node[neighbor].as_ref()?;
            Some((rotation * toward(m, neighbor), weights[position]))
        };
        let votes: Vec<_> = if ranks[branch.measurement] > 0 {
            vote(branch.measurement).into_iter().collect()
        } else {
            let edges = at_node[branch.child].iter();
            edges.filter_map(|&position| vote(position)).collect()
        };
        world_from_node[branch.child] = central_vote(&votes);
    }
    let reached = world_from_node.into_iter();
    reached.map(Option::unwrap_or_default).collect()
}

/// How well triangles support each measurement: 0 where none does, else the higher the more do, and
/// among as many, the higher the smaller their loop errors.
fn support_ranks(graph: &Subgraph, weights: &[f64], scale: f64) -> Vec<usize> {
    let mut supports = vec![[0; LOOP_THRESHOLDS.len()]; weights.len()];
    for_each_triangle(graph, |triangle| {
        if triangle.iter().any(|&position| weights[position] == 0.0) {
            return;
        }
        let [ab, bc, ac] = triangle.map(|position| {
            let m = &graph.measurements[position];
            toward(m, m.i.min(m.j))
        });
        let loop_error = angular_distance(&(ab * bc), &ac) / scale;
        for position in triangle {
            for (support, threshold) in supports[position].iter_mut().zip(LOOP_THRESHOLDS) {
                *support += usize::from(loop_error <= threshold);
            }
        }
    });
    supports.iter().map(|support| rank(support)).collect()
}

fn rank(support: &[usize]) -> usize {
    let strictness = (0..support.len()).rev();
    let levels = support.iter().zip(strictness);
    let supported = levels.filter(|&(&count, _)| count > 0);
    let ranks = supported.map(|(&count, strict)| count.min(MAX_SUPPORT) * support.len() + strict);
    ranks.max().unwrap_or(0)
}

/// The measurement as the rotation to one of its nodes from the other.
fn toward(m: &Measurement, node: usize) -> Rotation3<f64> {
    if m.i == node {
        m.rotation
    } else {
        m.rotation.inverse()
    }
}

/// The positions of the measurements at each node that have a weight.
fn weighted_edges_of_nodes(graph: &Subgraph, weights: &[f64]) -> Vec<Vec<usize>> {
    let mut at_node = vec![Vec::new(); graph.num_nodes];
    for (position, m) in graph.measurements.iter().enumerate() {
        if weights[position] > 0.0 {
            at_node[m.i].push(position);
            at_node[m.j].push(position);
        }
    }
    at_node
}

/// The vote with the smallest weighted sum of angles to all: a robust single rotation average.
fn central_vote(votes: &[(Rotation3<f64>, f64)]) -> Option<Rotation3<f64>> {
    let cost = |candidate: &Rotation3<f64>| -> f64 {
        let angles = votes
            .iter()
            .map(|(vote, weight)| weight * angular_distance(candidate, vote));
        angles.sum()
    };
    let candidates = votes.iter().map(|(vote, _)| (*vote, cost(vote)));
    let best = candidates.min_by(|a, b| a.1.total_cmp(&b.1));
    best.map(|(vote, _)| vote)
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    const SCALE: f64 = 0.1;

    fn node(k: usize) -> Rotation3<f64> {
        Rotation3::new(Vector3::new(0.4 * k as f64, -0.3, 0.1))
    }

    fn measurement(i: usize, j: usize, error: f64) -> Measurement {
        Measurement {
            i,
            j,
            rotation: node(i).inverse() * node(j) * Rotation3::new(Vector3::z() * error),
            translation: Vector3::zeros(),
        }
    }

    #[test]
    fn more_triangles_count_before_smaller_loop_errors() {
        assert_eq!(rank(&[0, 0, 0]), 0);
        let ascending = [
            [0, 0, 1],
            [0, 1, 1],
            [1, 1, 1],
            [0, 0, 2],
            [1, 1, 3],
            [10, 10, 10],
        ];
        let ranks = ascending.map(|support| rank(&support));
        assert!(ranks.is_sorted_by(|a, b| a < b), "{ranks:?}");
        assert_eq!(rank(&[30, 40, 50]), rank(&[10, 10, 10]));
    }

    #[test]
    fn the_tree_avoids_outliers_of_high_weight() {
        // All pairs of five nodes; those of (0, 1) and (2, 4) are outliers. Node 5 has three edges
        // that close no good triangle, of which two agree.
        let pairs = (0..5).flat_map(|j| (0..j).map(move |i| (i, j)));
        let is_outlier = |pair| pair == (0, 1) || pair == (2, 4);
        let error = |pair| if is_outlier(pair) { 1.5 } else { 0.0 };
        let mut measurements: Vec<_> = pairs
            .map(|(i, j)| measurement(i, j, error((i, j))))
            .collect();
        let votes = [(0, 2.0), (1, 0.3), (2, -0.001)];
        measurements.extend(votes.map(|(i, error)| measurement(i, 5, error)));
        let weight = |m: &Measurement| if error((m.i, m.j)) > 0.0 { 9.0 } else { 1.0 };
        let weights: Vec<f64> = measurements.iter().map(weight).collect();
        let graph = Subgraph {
            num_nodes: 6,
            measurements,
        };
        let rotations = initial_rotations(&graph, &weights, SCALE);
        for (k, rotation) in rotations.iter().enumerate() {
            let error = angular_distance(rotation, &(node(0).inverse() * node(k)));
            assert!(
                error < if k == 5 { 0.5 } else { 1e-12 },
                "node {k}: {error}"
            );
        }
    }
}
