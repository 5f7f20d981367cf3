//! A potted plant.

use nalgebra::{Point3, Vector3};
use rand_chacha::ChaCha8Rng;

use super::piece::Piece;
use crate::random::{count, uniform};

/// A pot, leaning stems with balls of foliage, long leaves.
pub(super) fn plant(rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let (radius, pot) = (uniform(rng, 0.12, 0.2), uniform(rng, 0.2, 0.38));
    piece.post([0.0, 0.0, 0.0], 0.8 * radius, pot);
    piece.post([0.0, 0.0, pot - 0.05], radius, 0.06);
    for _ in 0..count(rng, 2, 4) {
        let lean = [(); 2].map(|()| uniform(rng, -0.22, 0.22));
        let tip = Point3::new(lean[0], lean[1], uniform(rng, 0.7, 1.4));
        piece.bar(Point3::new(0.0, 0.0, pot), tip, 0.015);
        for _ in 0..count(rng, 1, 3) {
            let center = tip + Vector3::from([(); 3].map(|()| uniform(rng, -0.12, 0.12)));
            piece.ball(center.coords.into(), uniform(rng, 0.07, 0.17));
        }
    }
    for _ in 0..count(rng, 3, 6) {
        let angle = uniform(rng, 0.0, std::f64::consts::TAU);
        let rotation = Vector3::new(uniform(rng, 0.5, 1.2), 0.0, angle);
        let center = [
            0.16 * angle.cos(),
            0.16 * angle.sin(),
            pot + uniform(rng, 0.1, 0.3),
        ];
        piece.tilted_block(center, [0.07, 0.02, uniform(rng, 0.25, 0.45)], rotation);
    }
    piece
}
