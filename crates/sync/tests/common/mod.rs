//! Small random scenes.

use gmpcr_posegraph::{PoseEdge, PoseGraph};
use gmpcr_sync::Synchronization;
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;

/// Two scans and the weight of the edge between them.
pub type WeightedEnds = (usize, usize, f64);

/// Rotations of up to 3.1 radians, translations of up to 5 along each axis.
fn pose() -> impl Strategy<Value = Isometry3<f64>> {
    let vector = |range: f64| prop::array::uniform3(-range..range).prop_map(Vector3::from);
    (vector(5.0), vector(1.8)).prop_map(|(t, r)| Isometry3::new(t, r))
}

/// True poses and the edges (j, i, weight) of a connected graph, `j > i` first in a tree, then at
/// random.
pub fn scene() -> impl Strategy<Value = (Vec<Isometry3<f64>>, Vec<WeightedEnds>)> {
    (2..12usize).prop_flat_map(|n| {
        let tree = prop::collection::vec((any::<prop::sample::Index>(), 0.1..1.0f64), n - 1);
        let extra = prop::collection::vec((0..n, 0..n, 0.1..1.0f64), 0..2 * n);
        let edges = (tree, extra).prop_map(|(tree, extra)| {
            let tree = tree.into_iter().enumerate();
            let mut edges: Vec<_> = tree.map(|(k, (i, w))| (k + 1, i.index(k + 1), w)).collect();
            edges.extend(extra.into_iter().filter(|(i, j, _)| i != j));
            edges
        });
        (prop::collection::vec(pose(), n), edges)
    })
}

/// A graph whose measurements are off by up to `noise`.
pub fn measured(poses: &[Isometry3<f64>], ends: &[WeightedEnds], noise: f64) -> PoseGraph {
    let edge = |(k, &(i, j, weight)): (usize, &WeightedEnds)| {
        let wave = |f: f64| (k as f64 * f + 0.5).sin() * noise;
        let rotation = Vector3::new(wave(1.1), wave(2.3), wave(3.7));
        let translation = Vector3::new(wave(0.7), wave(1.9), wave(2.9));
        let i_from_j = poses[i].inv_mul(&poses[j]) * Isometry3::new(translation, rotation);
        PoseEdge {
            i,
            j,
            i_from_j,
            weight,
        }
    };
    let edges = ends.iter().enumerate().map(edge).collect();
    PoseGraph::new(poses.len(), edges).unwrap()
}

/// The graph with other numbers for its scans and its edges backwards; scan `k` is now `order[k]`.
pub fn renumbered(graph: &PoseGraph, seed: u32) -> (Vec<usize>, PoseGraph) {
    let mut order: Vec<usize> = (0..graph.num_scans()).collect();
    order.sort_by_key(|&k| (k as u32).wrapping_mul(seed | 1).rotate_left(7));
    let edges = graph.edges().iter().rev().map(|edge| PoseEdge {
        i: order[edge.i],
        j: order[edge.j],
        ..*edge
    });
    let renumbered = PoseGraph::new(graph.num_scans(), edges.collect()).unwrap();
    (order, renumbered)
}

/// The graph with weights and lengths in another unit.
pub fn scaled(graph: &PoseGraph, scale: f64) -> PoseGraph {
    let edges = graph.edges().iter().map(|edge| {
        let mut edge = PoseEdge {
            weight: edge.weight * scale,
            ..*edge
        };
        edge.i_from_j.translation.vector *= scale;
        edge
    });
    PoseGraph::new(graph.num_scans(), edges.collect()).unwrap()
}

/// Distance of two transformations as matrices.
pub fn difference(a: &Isometry3<f64>, b: &Isometry3<f64>) -> f64 {
    (a.to_matrix() - b.to_matrix()).norm()
}

/// Largest difference of the poses to the ground truth in the frame of scan 0.
pub fn error(result: &Synchronization, poses: &[Isometry3<f64>]) -> f64 {
    let expected = poses.iter().map(|pose| poses[0].inv_mul(pose));
    let pairs = result.world_from_scan.iter().zip(expected);
    pairs
        .map(|(pose, expected)| difference(pose, &expected))
        .fold(0.0, f64::max)
}
