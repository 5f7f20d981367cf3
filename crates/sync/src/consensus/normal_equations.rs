use gmpcr_geometry::isometry;
use nalgebra::{DMatrix, Matrix6, Vector3, Vector6};

use super::poses::{Noise, Poses, Transformation};
use crate::cholesky::SparseCholesky;
use crate::pattern::GroundedPattern;
use crate::subgraph::{Measurement, Subgraph};

/// Unknowns of a node.
const SIZE: usize = 6;
/// Numbers in the largest Cholesky factor that is worth its time, about 50 ms for each step.
const MAX_FACTOR_LEN: usize = 4_000_000;
/// Weights below this fraction of the largest count as much in the matrix, so that parts that only
/// they connect stay determined. That shortens steps but does not move where they end.
const WEIGHT_FLOOR: f64 = 1e-9;

/// The steps of Gauss and Newton towards poses `argmin Σ w_ij ‖e_ij‖²`, node 0 staying where it is.
///
/// The error of a measurement, in units of the noise and along the axes of the world, is
///
/// ```text
/// e = (ω / σ_R, u / σ_t),   exp(ω) = R_i R̂_ij R_jᵀ,   u = t_i + R_i t̂_ij − t_j
/// ```
///
/// whose parts are as long as those in the frames of the nodes. With `R_i` replaced by `exp(δ_i) R_i`
/// and `t_i` by `t_i + ν_i` it becomes, to first order in `x_i = (δ_i / σ_R, ν_i / σ_t)`,
///
/// ```text
/// e + J x_i − x_j,   J = [ I 0 ; −(σ_R / σ_t) [R_i t̂_ij]× I ]
/// ```
///
/// This takes the derivative of the logarithm for the identity, which leaves the gradient exact, since
/// `ω` is the axis of its own rotation. The factor of the matrix has a pattern that depends on the graph
/// only, and is analyzed once.
pub(super) struct NormalEquations<'a> {
    graph: &'a Subgraph,
    pattern: GroundedPattern,
    cholesky: SparseCholesky,
}

impl<'a> NormalEquations<'a> {
    /// `None` where the factor would be too large: each number of a graph Laplacian's becomes 36.
    pub fn new(graph: &'a Subgraph) -> Option<Self> {
        let nodes = GroundedPattern::new(graph, 1);
        if SIZE * SIZE * nodes.cholesky()?.factor_len() > MAX_FACTOR_LEN {
            return None;
        }
        let pattern = GroundedPattern::new(graph, SIZE);
        Some(Self {
            graph,
            cholesky: pattern.cholesky()?,
            pattern,
        })
    }

    /// The step `x` of each node. `None` where the system is singular in floating point.
    pub fn step(
        &mut self,
        weights: &[f64],
        noise: &Noise,
        poses: &Poses,
    ) -> Option<Vec<Vector6<f64>>> {
        let largest = weights.iter().copied().fold(0.0, f64::max);
        let mut values = vec![0.0; self.pattern.num_values()];
        let mut right = DMatrix::zeros(SIZE * (self.graph.num_nodes - 1), 1);
        for (m, &weight) in self.graph.measurements.iter().zip(weights) {
            let (error, jacobian) = linearized(m, poses, noise);
            for (node, gradient) in [(m.i, jacobian.tr_mul(&error)), (m.j, -error)] {
                if node > 0 {
                    let mut rows = right.fixed_rows_mut::<SIZE>(SIZE * (node - 1));
                    rows -= gradient * weight;
                }
            }
            let weight = weight.max(WEIGHT_FLOOR * largest);
            let blocks = [
                (m.i, m.i, jacobian.tr_mul(&jacobian)),
                (m.j, m.j, Matrix6::identity()),
                (m.j, m.i, -jacobian),
                (m.i, m.j, -jacobian.transpose()),
            ];
            for (row, column, block) in blocks {
                if row >= column && column > 0 {
                    self.add(&mut values, row, column, &(block * weight));
                }
            }
        }
        self.cholesky.factorize(&values).ok()?;
        self.cholesky.solve_in_place(&mut right);
        let blocks = right.as_slice().chunks_exact(SIZE);
        let steps = std::iter::once(Vector6::zeros()).chain(blocks.map(Vector6::from_column_slice));
        right.iter().all(|x| x.is_finite()).then(|| steps.collect())
    }

    /// Adds a block of the lower triangle, of which the diagonal ones are stored in half.
    fn add(&self, values: &mut [f64], row: usize, column: usize, block: &Matrix6<f64>) {
        for (k, entries) in block.column_iter().enumerate() {
            let skipped = if row == column { k } else { 0 };
            let start = self.pattern.start(row, column, k);
            for (value, entry) in values[start..].iter_mut().zip(entries.iter().skip(skipped)) {
                *value += entry;
            }
        }
    }
}

/// `e` and `J`.
fn linearized(m: &Measurement, poses: &Poses, noise: &Noise) -> (Vector6<f64>, Matrix6<f64>) {
    let (i, j) = (poses.get(m.i), poses.get(m.j));
    let predicted = i.then(&Transformation::measured(m));
    let difference = isometry(
        &(predicted.rotation * j.rotation.inverse()),
        &Vector3::zeros(),
    );
    let angles = difference.rotation.scaled_axis() / noise.rotation;
    let offset = (predicted.position - j.position) / noise.translation;
    let lever = (i.rotation * m.translation) * (noise.rotation / noise.translation);
    let mut jacobian = Matrix6::identity();
    let mut below = jacobian.fixed_view_mut::<3, 3>(3, 0);
    below -= lever.cross_matrix();
    let error = Vector6::new(angles.x, angles.y, angles.z, offset.x, offset.y, offset.z);
    (error, jacobian)
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;

    use super::*;

    fn complete(num_nodes: usize) -> Subgraph {
        let pairs = (0..num_nodes).flat_map(|i| (0..i).map(move |j| (i, j)));
        let measurement = |(i, j)| Measurement {
            i,
            j,
            rotation: Rotation3::identity(),
            translation: Vector3::zeros(),
        };
        Subgraph {
            num_nodes,
            measurements: pairs.map(measurement).collect(),
        }
    }

    #[test]
    fn only_factors_that_fit_are_analyzed() {
        assert!(NormalEquations::new(&complete(100)).is_some());
        assert!(NormalEquations::new(&complete(600)).is_none());
    }

    /// Without error the linearization is exact, so that the step shrinks the distance to its square.
    #[test]
    fn one_step_leads_to_the_poses_of_exact_measurements() {
        let wave = |k: usize, f: f64| {
            let x = k as f64;
            Vector3::new(
                (f * x).sin(),
                (1.3 * f * x + 1.0).cos(),
                (0.7 * f * x).cos(),
            )
        };
        let mut poses = Poses::identities(5);
        for k in 1..5 {
            let rotation = Rotation3::new(wave(k, 1.1));
            let position = wave(k, 2.3) * 5.0;
            poses.set(k, &Transformation { rotation, position });
        }
        let ends = [
            (0, 1),
            (2, 1),
            (0, 3),
            (3, 2),
            (1, 0),
            (4, 0),
            (2, 4),
            (4, 3),
        ];
        let measurement = |(i, j): (usize, usize)| {
            let i_from_j = poses.get(i).inverse().then(&poses.get(j));
            let (rotation, translation) = (i_from_j.rotation, i_from_j.position);
            Measurement {
                i,
                j,
                rotation,
                translation,
            }
        };
        let graph = Subgraph {
            num_nodes: 5,
            measurements: ends.into_iter().map(measurement).collect(),
        };
        let noise = Noise {
            rotation: 0.1,
            translation: 0.3,
        };
        let mut start = poses.clone();
        for k in 1..5 {
            start.rotations[k] = Rotation3::new(wave(k, 3.1) * 1e-4) * start.rotations[k];
            start.positions[k] += wave(k, 1.7) * 1e-4;
        }
        let mut equations = NormalEquations::new(&graph).unwrap();
        let weights = [1.0, 0.5, 2.0, 0.25, 0.125, 3.0, 1.0, 0.7];
        let steps = equations.step(&weights, &noise, &start).unwrap();
        for (k, step) in steps.iter().enumerate() {
            let rotation = Rotation3::new(step.fixed_rows::<3>(0) * noise.rotation);
            let moved = rotation * start.rotations[k];
            let position = start.positions[k] + step.fixed_rows::<3>(3) * noise.translation;
            assert!((moved.matrix() - poses.rotations[k].matrix()).norm() < 1e-6);
            assert!((position - poses.positions[k]).norm() < 1e-6);
        }
    }
}
