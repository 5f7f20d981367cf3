use gmpcr_geometry::rotation_angle;
use nalgebra::Vector3;

use super::poses::Transformation;
use crate::subgraph::{Measurement, Subgraph};
use crate::triangles::for_each_triangle;

/// A triangle closes if its gap is within this many times the noise of one measurement: three add
/// up, and noise has tails. A uniformly random rotation is as near as 3 · 5° once in a thousand.
const LIMIT: f64 = 3.0;

/// Which measurements are confirmed by others.
pub(super) struct LoopSupport {
    /// Number of triangles that each measurement closes, in rotation and translation.
    pub num_loops: Vec<usize>,
    /// Translation noise: the median gap of the triangles whose rotations close, and at least what a
    /// tenth of the rotation noise does to a measurement of median length. Infinite without such
    /// triangles or lengths.
    pub translation_noise: f64,
}

impl LoopSupport {
    /// `rotation_noise` in radians. Measurements without weight confirm nothing.
    pub fn new(graph: &Subgraph, weights: &[f64], rotation_noise: f64) -> Self {
        let mut closed = Vec::new();
        for_each_triangle(graph, |triangle| {
            if triangle.iter().all(|&k| weights[k] > 0.0) {
                let gap = Gap::new(triangle.map(|k| &graph.measurements[k]));
                if gap.angle <= LIMIT * rotation_noise {
                    closed.push((gap.offset, triangle));
                }
            }
        });
        let lengths = graph.measurements.iter().map(|m| m.translation.norm());
        let least = 0.1 * rotation_noise * median(lengths.collect()).unwrap_or(0.0);
        let translation_noise = median(closed.iter().map(|&(offset, _)| offset).collect())
            .map(|offset| offset.max(least))
            .filter(|&noise| noise > 0.0)
            .unwrap_or(f64::INFINITY);
        let mut num_loops = vec![0; graph.measurements.len()];
        let within = closed
            .iter()
            .filter(|(offset, _)| *offset <= LIMIT * translation_noise);
        for &k in within.flat_map(|(_, triangle)| triangle) {
            num_loops[k] += 1;
        }
        Self {
            num_loops,
            translation_noise,
        }
    }
}

/// How far the composition around a triangle is from the identity, which it is for exact measurements.
struct Gap {
    angle: f64,
    /// Mean over the three nodes of how far the way around leads away from the node.
    offset: f64,
}

impl Gap {
    fn new([ab, bc, ac]: [&Measurement; 3]) -> Self {
        let (a, b) = (ab.i.min(ab.j), ab.i.max(ab.j));
        let (a_from_b, b_from_c, a_from_c) = (directed(ab, a), directed(bc, b), directed(ac, a));
        let around = a_from_b.then(&b_from_c).then(&a_from_c.inverse());
        let nodes = [Vector3::zeros(), a_from_b.position, a_from_c.position];
        let offset = |node: &Vector3<f64>| (around.position + around.rotation * node - node).norm();
        Self {
            angle: rotation_angle(&around.rotation),
            offset: nodes.iter().map(offset).sum::<f64>() / 3.0,
        }
    }
}

/// The measured transformation into the frame of one of its two nodes.
fn directed(m: &Measurement, into: usize) -> Transformation {
    if m.i == into {
        Transformation::measured(m)
    } else {
        Transformation::measured(m).inverse()
    }
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len() / 2;
    let has_middle = !values.is_empty();
    has_middle.then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;

    use super::*;

    fn measurement(i: usize, j: usize, angle: f64, x: f64) -> Measurement {
        Measurement {
            i,
            j,
            rotation: Rotation3::new(Vector3::z() * angle),
            translation: Vector3::x() * x,
        }
    }

    #[test]
    fn closed_triangles_confirm_whichever_way_their_edges_point() {
        // All rotations are about z, positions on the x axis of node 0, which is at the pivot.
        let inliers = [
            measurement(0, 1, 0.0, 1.0),
            measurement(2, 1, 0.0, -1.0),
            measurement(2, 0, 0.0, -2.0),
        ];
        let outliers = [measurement(3, 0, 2.0, 0.0), measurement(1, 3, 2.0, 0.0)];
        let graph = Subgraph {
            num_nodes: 4,
            measurements: inliers.into_iter().chain(outliers).collect(),
        };
        let support = LoopSupport::new(&graph, &[1.0; 5], 0.1);
        assert_eq!(support.num_loops, [1, 1, 1, 0, 0]);
        // A tenth of the rotation noise over the median length.
        assert_eq!(support.translation_noise, 0.1 * 0.1 * 1.0);
        let without_weight = LoopSupport::new(&graph, &[1.0, 0.0, 1.0, 1.0, 1.0], 0.1);
        assert_eq!(without_weight.num_loops, [0; 5]);
        assert_eq!(without_weight.translation_noise, f64::INFINITY);
    }

    #[test]
    fn a_triangle_must_close_in_translation_too() {
        let triangle = |first: usize, gap: f64| {
            let [a, b, c] = [first, first + 1, first + 2];
            [
                measurement(a, b, 0.0, 1.0),
                measurement(b, c, 0.0, 1.0),
                measurement(a, c, 0.0, 2.0 + gap),
            ]
        };
        let graph = Subgraph {
            num_nodes: 9,
            measurements: [triangle(0, 0.1), triangle(3, 0.2), triangle(6, 0.7)].concat(),
        };
        let support = LoopSupport::new(&graph, &[1.0; 9], 0.1);
        assert!((support.translation_noise - 0.2).abs() < 1e-12);
        assert_eq!(support.num_loops, [1, 1, 1, 1, 1, 1, 0, 0, 0]);
    }
}
