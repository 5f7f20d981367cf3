//! Clouds for the tests.

use nalgebra::{Point3, Vector3};

/// Numbers in 0..1 from a seed (splitmix64).
pub fn uniform(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A curved sheet of one by one, about one in front of the origin, with a step across it.
pub fn bumpy_sheet(num_points: usize, seed: u64) -> Vec<Point3<f64>> {
    let mut next = uniform(seed);
    let mut point = || {
        let (x, y) = (next() - 0.5, next() - 0.5);
        let step = if x > 0.1 { 0.1 } else { 0.0 };
        Point3::new(x, y, 1.0 + 0.1 * (6.0 * x).sin() * (5.0 * y).cos() + step)
    };
    (0..num_points).map(|_| point()).collect()
}

#[allow(dead_code, reason = "each test file uses its own part of this module")]
pub fn unit_vectors(count: usize, seed: u64) -> Vec<Vector3<f64>> {
    let mut next = uniform(seed);
    let mut vector = || Vector3::from_fn(|_, _| next() - 0.5).normalize();
    (0..count).map(|_| vector()).collect()
}
