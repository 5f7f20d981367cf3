//! Seeded draws: uniform, Gaussian, rotations, rigid transformations.

use nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Independent generators of one seed, so that drawing more of one thing leaves the others alone.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Stream {
    Building,
    Tour,
    World,
    PoseGraph,
    Scan(usize),
}

pub(crate) fn generator(seed: u64, stream: Stream) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(match stream {
        Stream::Building => 0,
        Stream::Tour => 1,
        Stream::World => 2,
        // Scans count up from 3, so this one is out of their reach.
        Stream::PoseGraph => u64::MAX,
        Stream::Scan(scan) => 3 + scan as u64,
    });
    rng
}

/// Uniform in `low..high`.
pub(crate) fn uniform(rng: &mut impl Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.random::<f64>()
}

/// Uniform in `low..=high`.
pub(crate) fn count(rng: &mut impl Rng, low: usize, high: usize) -> usize {
    rng.random_range(low..=high.max(low))
}

/// True with the given probability.
pub(crate) fn chance(rng: &mut impl Rng, probability: f64) -> bool {
    rng.random::<f64>() < probability
}

/// Two independent standard normal numbers (Marsaglia's polar method).
pub(crate) fn gaussian_pair(rng: &mut impl Rng) -> (f64, f64) {
    loop {
        let (u, v) = (uniform(rng, -1.0, 1.0), uniform(rng, -1.0, 1.0));
        let s = u * u + v * v;
        if s > 0.0 && s < 1.0 {
            let scale = (-2.0 * s.ln() / s).sqrt();
            return (u * scale, v * scale);
        }
    }
}

/// A vector of independent standard normal numbers.
pub(crate) fn gaussian(rng: &mut impl Rng) -> Vector3<f64> {
    let ((x, y), (z, _)) = (gaussian_pair(rng), gaussian_pair(rng));
    Vector3::new(x, y, z)
}

/// Uniform in the cube of this side around the origin.
pub(crate) fn point_in_cube(rng: &mut impl Rng, side: f64) -> Vector3<f64> {
    let half = 0.5 * side;
    Vector3::from_fn(|_, _| uniform(rng, -half, half))
}

/// Uniformly distributed over SO(3): the direction of a Gaussian in quaternion space.
pub(crate) fn rotation(rng: &mut impl Rng) -> UnitQuaternion<f64> {
    let (w, x) = gaussian_pair(rng);
    let (y, z) = gaussian_pair(rng);
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}

/// A random rotation, then a translation of up to `reach` along each axis.
pub(crate) fn rigid_transformation(rng: &mut impl Rng, reach: f64) -> Isometry3<f64> {
    let rotation = rotation(rng);
    Isometry3::from_parts(point_in_cube(rng, 2.0 * reach).into(), rotation)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaussian_pairs_have_zero_mean_and_unit_variance() {
        let mut rng = generator(1, Stream::World);
        let samples: Vec<f64> = (0..20_000).map(|_| gaussian_pair(&mut rng).0).collect();
        let mean = samples.iter().sum::<f64>() / samples.len() as f64;
        let variance = samples.iter().map(|x| x * x).sum::<f64>() / samples.len() as f64;
        assert!(mean.abs() < 0.03, "{mean}");
        assert!((variance - 1.0).abs() < 0.05, "{variance}");
    }

    #[test]
    fn streams_of_one_seed_differ() {
        let first = generator(3, Stream::Scan(0)).random::<u64>();
        let second = generator(3, Stream::Scan(1)).random::<u64>();
        assert_ne!(first, second);
    }
}
