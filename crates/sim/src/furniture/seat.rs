//! What people sit on.

use nalgebra::{Point3, Vector3};
use rand_chacha::ChaCha8Rng;

use super::piece::Piece;
use crate::random::{chance, count, uniform};

/// A chair with a back of slats or a panel; its back at y = 0.
pub(super) fn chair(rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let (width, depth) = (uniform(rng, 0.4, 0.5), uniform(rng, 0.4, 0.48));
    let seat = uniform(rng, 0.42, 0.48);
    let top = uniform(rng, 0.78, 1.05);
    piece.between([-width / 2.0, 0.0, seat - 0.04], [width / 2.0, depth, seat]);
    for x in [-width / 2.0 + 0.03, width / 2.0 - 0.03] {
        piece.post([x, depth - 0.03, 0.0], 0.018, seat);
        piece.bar(Point3::new(x, 0.03, 0.0), Point3::new(x, -0.05, top), 0.018);
    }
    back_rest(&mut piece, width, seat, top, rng);
    if chance(rng, 0.4) {
        let cushion = [width - 0.04, depth - 0.06, uniform(rng, 0.03, 0.07)];
        piece.rotated_block(
            [0.0, depth / 2.0 + 0.02, seat + cushion[2] / 2.0],
            cushion,
            0.06,
        );
    }
    piece
}

fn back_rest(piece: &mut Piece, width: f64, seat: f64, top: f64, rng: &mut ChaCha8Rng) {
    let tilt = Vector3::new(0.12, 0.0, 0.0);
    if chance(rng, 0.5) {
        let high = uniform(rng, 0.15, top - seat - 0.08);
        piece.tilted_block([0.0, -0.04, top - high / 2.0], [width, 0.025, high], tilt);
        return;
    }
    let mut z = seat + uniform(rng, 0.1, 0.2);
    while z < top {
        let high = uniform(rng, 0.03, 0.09);
        piece.tilted_block([0.0, -0.03, z], [width, 0.02, high], tilt);
        z += high + uniform(rng, 0.05, 0.12);
    }
}

/// A seat with arms and one cushion.
pub(super) fn armchair(rng: &mut ChaCha8Rng) -> Piece {
    upholstered(uniform(rng, 0.5, 0.65), 1, rng)
}

/// A seat for two or three.
pub(super) fn sofa(rng: &mut ChaCha8Rng) -> Piece {
    let seats = count(rng, 2, 3);
    upholstered(seats as f64 * uniform(rng, 0.52, 0.65), seats, rng)
}

/// `inner` is the width between the arms.
fn upholstered(inner: f64, seats: usize, rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let depth = uniform(rng, 0.7, 0.85);
    let base = uniform(rng, 0.24, 0.32);
    let half = inner / 2.0;
    piece.between([-half, 0.05, 0.06], [half, depth, base]);
    let lean = Vector3::new(uniform(rng, 0.1, 0.25), 0.0, 0.0);
    let back = uniform(rng, 0.4, 0.6);
    piece.tilted_block([0.0, 0.16, base + back / 2.0], [inner, 0.18, back], lean);
    arms(&mut piece, half, depth, rng);
    cushions(&mut piece, half, depth, base, seats, rng);
    for _ in 0..count(rng, 0, seats + 1) {
        let center = [uniform(rng, -0.8, 0.8) * half, 0.38, base + 0.3];
        let rotation = Vector3::new(
            uniform(rng, 0.2, 0.7),
            uniform(rng, -0.5, 0.5),
            uniform(rng, -0.5, 0.5),
        );
        let side = uniform(rng, 0.3, 0.42);
        piece.tilted_block(center, [side, 0.12, side], rotation);
    }
    piece
}

fn arms(piece: &mut Piece, half: f64, depth: f64, rng: &mut ChaCha8Rng) {
    let thick = uniform(rng, 0.1, 0.2);
    let high = uniform(rng, 0.5, 0.65);
    let rolled = chance(rng, 0.5);
    for side in [-1.0, 1.0] {
        let x = side * (half + thick / 2.0);
        piece.block([x, depth / 2.0, high / 2.0], [thick, depth, high]);
        if rolled {
            piece.bar(
                Point3::new(x, 0.0, high),
                Point3::new(x, depth, high),
                0.55 * thick,
            );
        }
    }
}

fn cushions(
    piece: &mut Piece,
    half: f64,
    depth: f64,
    base: f64,
    seats: usize,
    rng: &mut ChaCha8Rng,
) {
    let width = 2.0 * half / seats as f64;
    for k in 0..seats {
        let x = -half + (k as f64 + 0.5) * width;
        let thick = uniform(rng, 0.12, 0.2);
        let size = [width - 0.02, depth - 0.25, thick];
        let overhang = uniform(rng, 0.0, 0.06);
        piece.block([x, depth / 2.0 + 0.12 + overhang, base + thick / 2.0], size);
    }
}
