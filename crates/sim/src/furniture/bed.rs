//! A bed.

use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;

use super::piece::Piece;
use crate::random::{count, uniform};

/// A bed with its head at the wall, pillows and a crumpled blanket.
pub(super) fn bed(rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let (half, length) = (uniform(rng, 0.45, 0.75), uniform(rng, 1.8, 2.0));
    let (frame, top) = (uniform(rng, 0.22, 0.32), uniform(rng, 0.42, 0.55));
    piece.between(
        [-half - 0.03, 0.0, 0.1],
        [half + 0.03, length + 0.04, frame],
    );
    piece.between([-half, 0.05, frame], [half, length, top]);
    piece.between(
        [-half - 0.05, 0.0, 0.0],
        [half + 0.05, 0.05, uniform(rng, 0.8, 1.15)],
    );
    for x in [-half, half] {
        piece.post([x, length, 0.0], 0.035, uniform(rng, 0.35, 0.6));
    }
    pillows(&mut piece, half, top, rng);
    blanket(&mut piece, half, length, top, rng);
    piece
}

fn pillows(piece: &mut Piece, half: f64, top: f64, rng: &mut ChaCha8Rng) {
    for x in [-half / 2.0, half / 2.0] {
        let size = [
            half * uniform(rng, 0.7, 0.95),
            uniform(rng, 0.35, 0.5),
            uniform(rng, 0.1, 0.16),
        ];
        let rotation = Vector3::new(uniform(rng, 0.2, 0.5), 0.0, uniform(rng, -0.2, 0.2));
        piece.tilted_block([x, 0.28, top + 0.1], size, rotation);
    }
}

/// Folds that lie across the lower half.
fn blanket(piece: &mut Piece, half: f64, length: f64, top: f64, rng: &mut ChaCha8Rng) {
    let mut y = uniform(rng, 0.4, 0.6) * length;
    for _ in 0..count(rng, 4, 7) {
        let fold = uniform(rng, 0.1, 0.3);
        let size = [
            2.0 * half * uniform(rng, 0.6, 1.05),
            fold,
            uniform(rng, 0.03, 0.12),
        ];
        let rotation = Vector3::new(uniform(rng, -0.2, 0.2), 0.0, uniform(rng, -0.25, 0.25));
        piece.tilted_block(
            [uniform(rng, -0.1, 0.1), y.min(length - 0.1), top + 0.02],
            size,
            rotation,
        );
        y += fold;
    }
}
