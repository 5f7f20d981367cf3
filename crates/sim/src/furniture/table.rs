//! Tables, alone and with what belongs to them.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use super::piece::Piece;
use super::seat;
use super::tabletop::tabletop_items;
use crate::random::{chance, count, uniform};

/// A top on legs or on two panels, around x = 0, from y = 0 to `depth`.
fn frame(width: f64, depth: f64, height: f64, rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let top = uniform(rng, 0.02, 0.05);
    piece.between(
        [-width / 2.0, 0.0, height - top],
        [width / 2.0, depth, height],
    );
    let inset = uniform(rng, 0.04, 0.12);
    let leg = uniform(rng, 0.02, 0.045);
    let panels = chance(rng, 0.3);
    for side in [-1.0, 1.0] {
        let x = side * (width / 2.0 - inset);
        if panels {
            piece.between(
                [x - leg, inset, 0.0],
                [x + leg, depth - inset, height - top],
            );
        } else {
            for y in [inset, depth - inset] {
                piece.post([x, y, 0.0], leg, height - top);
            }
        }
    }
    let rail = [width - 2.0 * inset, 0.03, uniform(rng, 0.05, 0.12)];
    piece.block([0.0, inset, height - top - rail[2] / 2.0], rail);
    piece
}

/// A desk with a screen, drawers, clutter and a chair.
pub(super) fn desk(rng: &mut ChaCha8Rng) -> Piece {
    let (width, depth) = (uniform(rng, 1.2, 1.7), uniform(rng, 0.6, 0.8));
    let height = uniform(rng, 0.7, 0.76);
    let mut piece = frame(width, depth, height, rng);
    drawers(&mut piece, width, depth, rng);
    let on_top = Isometry3::translation(uniform(rng, -0.3, 0.3), 0.12, height);
    piece.put(screen(rng), &on_top);
    let beside = Isometry3::translation(-width / 3.5, 0.05, height);
    piece.put(tabletop_items(0.4 * width, 0.4, 3, rng), &beside);
    let front = Isometry3::translation(0.05, depth - 0.3, height);
    piece.put(tabletop_items(0.8 * width, 0.25, 3, rng), &front);
    piece.put(
        seat::chair(rng),
        &turned(uniform(rng, -0.2, 0.2), depth + 0.1, rng),
    );
    piece
}

/// A block of drawers under the right end.
fn drawers(piece: &mut Piece, width: f64, depth: f64, rng: &mut ChaCha8Rng) {
    let right = width / 2.0 - 0.1;
    let left = right - uniform(rng, 0.3, 0.45);
    let top = uniform(rng, 0.45, 0.6);
    piece.between([left, 0.05, 0.05], [right, depth - 0.08, top]);
    let mut z = 0.08;
    while z + 0.1 < top {
        let high = uniform(rng, 0.1, 0.22).min(top - z);
        piece.between(
            [left + 0.01, depth - 0.09, z],
            [right - 0.01, depth - 0.06, z + high - 0.02],
        );
        piece.ball([(left + right) / 2.0, depth - 0.05, z + high / 2.0], 0.02);
        z += high;
    }
}

/// A monitor on a stand, its foot at the origin, facing y > 0.
fn screen(rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let width = uniform(rng, 0.45, 0.75);
    let high = uniform(rng, 0.28, 0.42);
    let lift = uniform(rng, 0.1, 0.2);
    piece.block([0.0, 0.02, 0.01], [0.26, 0.2, 0.02]);
    piece.post([0.0, 0.0, 0.0], 0.025, lift + high / 2.0);
    let rotation = Vector3::new(uniform(rng, -0.2, 0.0), 0.0, uniform(rng, -0.4, 0.4));
    piece.tilted_block(
        [0.0, 0.03, lift + high / 2.0],
        [width, 0.03, high],
        rotation,
    );
    piece
}

/// A table with chairs around it.
pub(super) fn dining_group(rng: &mut ChaCha8Rng) -> Piece {
    let (width, depth) = (uniform(rng, 1.1, 1.6), uniform(rng, 0.75, 0.95));
    let height = uniform(rng, 0.72, 0.78);
    let mut piece = frame(width, depth, height, rng);
    let on_top = Isometry3::translation(0.0, 0.1, height);
    piece.put(
        tabletop_items(0.9 * width, depth - 0.2, count(rng, 4, 6), rng),
        &on_top,
    );
    let sit_at = uniform(rng, 0.2, 0.3) * width;
    piece.put(seat::chair(rng), &turned(-sit_at, depth - 0.15, rng));
    piece.put(seat::chair(rng), &turned(sit_at, depth + 0.1, rng));
    if chance(rng, 0.7) {
        let across = Isometry3::rotation(Vector3::z() * std::f64::consts::PI);
        piece.put(
            seat::chair(rng),
            &(across * turned(uniform(rng, -0.4, 0.4), 0.0, rng)),
        );
    }
    piece
}

/// A low table with things on it and under it.
pub(super) fn coffee_table(rng: &mut ChaCha8Rng) -> Piece {
    let (width, depth) = (uniform(rng, 0.7, 1.2), uniform(rng, 0.45, 0.7));
    let height = uniform(rng, 0.32, 0.5);
    let mut piece = frame(width, depth, height, rng);
    let on_top = Isometry3::translation(0.0, 0.05, height);
    piece.put(
        tabletop_items(width, depth - 0.1, count(rng, 3, 5), rng),
        &on_top,
    );
    let under = Isometry3::translation(0.0, 0.15, 0.0);
    piece.put(tabletop_items(0.7 * width, 0.2, 2, rng), &under);
    piece
}

/// A place at (x, y) for a seat whose front edge faces y < 0, carelessly pushed in.
fn turned(x: f64, y: f64, rng: &mut ChaCha8Rng) -> Isometry3<f64> {
    let angle = std::f64::consts::PI + uniform(rng, -0.5, 0.5);
    let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
    let set_back = Translation3::new(x, y + 0.4, 0.0);
    Isometry3::from_parts(set_back, rotation)
}
