use super::poses::{Noise, Poses};
use crate::subgraph::Subgraph;

/// Scale of the loss in standard deviations of the noise. Smaller ones waste inliers, whose six residuals
/// together reach 2.4 on average; larger ones give weight to slight outliers.
const LOSS_SCALE: f64 = 4.0;
/// Agreement from which on measurements count as inliers: residuals up to 1.5 times the scale of the loss.
const MIN_AGREEMENT: f64 = 0.1;
/// Measurements beyond those that the poses absorb, that it takes to estimate the noise.
const MIN_REDUNDANCY: f64 = 10.0;
/// The noise is at least this fraction of the given one, also in exact measurements.
const MIN_NOISE: f64 = 1e-3;

/// The noise of inliers, from their residuals under estimated poses.
///
/// ```text
/// σ_R² = Σ ‖e_R‖² / 3 (M − A_R),   σ_t² = Σ ‖e_t‖² / 3 (M − A_t)
/// ```
///
/// over the `M` measurements that agree, of which the poses absorb `A`: for `N` nodes, `A_R = A_t = N − 1`
/// where rotations were averaged alone. Estimated together, positions and rotations may both follow
/// the translations, `A_t = 2 (N − 1)`. That makes rather too much than too little of the noise, so that
/// the scale does not fall with residuals that its own fall shrinks; the first estimate, which errors
/// of the rotations add to, bounds it from above.
pub(super) struct Scales<'a> {
    graph: &'a Subgraph,
    initial_weights: &'a [f64],
    /// Of the rotations.
    least: f64,
    most: Noise,
    noise: Noise,
}

impl<'a> Scales<'a> {
    /// From poses of averaged rotations. The `given` scales of the loss stay without redundancy, and
    /// are the largest noise that is believed.
    pub fn new(
        graph: &'a Subgraph,
        initial_weights: &'a [f64],
        given: Noise,
        poses: &Poses,
    ) -> Self {
        let mut scales = Self {
            graph,
            initial_weights,
            least: MIN_NOISE * given.rotation,
            most: given,
            noise: given.times(1.0 / LOSS_SCALE),
        };
        scales.estimate(poses, 1.0);
        scales.most.translation = scales.noise.translation;
        scales
    }

    /// From poses estimated jointly.
    pub fn update(&mut self, poses: &Poses) {
        self.estimate(poses, 2.0);
    }

    /// Residuals that count as one.
    pub fn loss(&self) -> Noise {
        self.noise.times(LOSS_SCALE)
    }

    /// `absorbed` measurements of translations for each free node.
    fn estimate(&mut self, poses: &Poses, absorbed: f64) {
        let (loss, unit) = (self.loss(), Noise::UNIT);
        let (mut count, mut angles, mut offsets, mut lengths) = (0.0, 0.0, 0.0, 0.0);
        for (m, &weight) in self.graph.measurements.iter().zip(self.initial_weights) {
            let (i, j) = (poses.get(m.i), poses.get(m.j));
            if weight > 0.0 && loss.agreement(&i, m, &j) >= MIN_AGREEMENT {
                let [angle, offset] = unit.residuals(&i, m, &j);
                count += 1.0;
                angles += angle * angle;
                offsets += offset * offset;
                lengths += m.translation.norm();
            }
        }
        let num_free = self.graph.num_nodes as f64 - 1.0;
        let deviation = |squares: f64, absorbed: f64, least: f64| {
            let redundancy = count - absorbed * num_free;
            let deviation = (squares / (3.0 * redundancy)).sqrt().max(least);
            (redundancy >= MIN_REDUNDANCY && deviation > 0.0).then_some(deviation)
        };
        if let Some(rotation) = deviation(angles, 1.0, self.least) {
            self.noise.rotation = rotation.min(self.most.rotation);
        }
        // What the least noise of rotations does to a measurement of mean length.
        if let Some(translation) = deviation(offsets, absorbed, self.least * lengths / count) {
            self.noise.translation = translation.min(self.most.translation);
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};

    use super::*;
    use crate::subgraph::Measurement;

    const GIVEN: Noise = Noise {
        rotation: 0.1,
        translation: 1.0,
    };

    /// The scales for parallel measurements between two nodes at the same pose.
    fn scales(num_measurements: usize, angle: f64, offset: f64) -> Noise {
        let measurement = |k: usize| Measurement {
            i: 0,
            j: 1,
            rotation: Rotation3::new(Vector3::ith(k % 3, angle)),
            translation: Vector3::ith(k % 3, offset),
        };
        let graph = Subgraph {
            num_nodes: 2,
            measurements: (0..num_measurements).map(measurement).collect(),
        };
        let poses = Poses::identities(2);
        Scales::new(&graph, &vec![1.0; num_measurements], GIVEN, &poses).loss()
    }

    #[test]
    fn the_scale_follows_the_residuals_where_there_is_redundancy() {
        let loss = scales(13, 0.02, 0.3);
        let factor = LOSS_SCALE * (13.0f64 / (3.0 * 12.0)).sqrt();
        assert!((loss.rotation - 0.02 * factor).abs() < 1e-12);
        assert!((loss.translation - 0.3 * factor).abs() < 1e-12);

        let loss = scales(10, 0.02, 0.3);
        assert_eq!((loss.rotation, loss.translation), (0.1, 1.0));
    }

    #[test]
    fn exact_measurements_have_the_least_noise_and_those_that_disagree_none() {
        let loss = scales(20, 0.0, 0.3);
        assert!((loss.rotation - LOSS_SCALE * MIN_NOISE * 0.1).abs() < 1e-15);
        let loss = scales(20, 2.0, 0.3);
        assert_eq!((loss.rotation, loss.translation), (0.1, 1.0));
    }
}
