//! A floor lamp.

use nalgebra::Point3;
use rand_chacha::ChaCha8Rng;

use super::piece::Piece;
use crate::random::{chance, uniform};

/// A foot, a leaning stem, a shade.
pub(super) fn floor_lamp(rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let height = uniform(rng, 1.3, 1.7);
    let lean = uniform(rng, 0.0, 0.25);
    piece.post([0.0, 0.0, 0.0], uniform(rng, 0.13, 0.2), 0.04);
    let head = Point3::new(lean, 0.5 * lean, height);
    piece.bar(Point3::origin(), head, 0.02);
    if chance(rng, 0.5) {
        piece.ball(head.coords.into(), uniform(rng, 0.13, 0.22));
    } else {
        let base = [head.x, head.y, height - 0.15];
        piece.post(base, uniform(rng, 0.15, 0.24), uniform(rng, 0.18, 0.32));
    }
    piece
}
