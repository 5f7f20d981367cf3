//! Shelves, cabinets, wardrobes.

use nalgebra::{Isometry3, Vector3};
use rand_chacha::ChaCha8Rng;

use super::piece::Piece;
use super::tabletop::tabletop_items;
use crate::random::{chance, count, uniform};

/// Thickness of boards, in meters.
const BOARD: f64 = 0.025;

/// Uneven shelves full of books and odds and ends.
pub(super) fn bookshelf(rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let (width, depth) = (uniform(rng, 0.7, 1.3), uniform(rng, 0.25, 0.38));
    let height = uniform(rng, 1.3, 2.15);
    for side in [-1.0, 1.0] {
        piece.block(
            [side * width / 2.0, depth / 2.0, height / 2.0],
            [BOARD, depth, height],
        );
    }
    piece.between([-width / 2.0, 0.0, 0.0], [width / 2.0, 0.01, height]);
    let mut z = uniform(rng, 0.03, 0.1);
    while z < height - 0.2 {
        let clear = uniform(rng, 0.24, 0.42);
        piece.block([0.0, depth / 2.0, z], [width, depth, BOARD]);
        let content = shelf_content(width - 0.06, depth, clear.min(height - z) - 0.04, rng);
        piece.put(content, &Isometry3::translation(0.0, 0.0, z + BOARD / 2.0));
        z += clear;
    }
    piece.block([0.0, depth / 2.0, height], [width, depth, BOARD]);
    let on_top = Isometry3::translation(0.0, 0.0, height + BOARD / 2.0);
    piece.put(tabletop_items(width, depth, 2, rng), &on_top);
    piece
}

/// Runs of books with gaps, sometimes something else.
fn shelf_content(width: f64, depth: f64, clear: f64, rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let mut x = -width / 2.0 + uniform(rng, 0.0, 0.1);
    while x < width / 2.0 - 0.2 {
        if chance(rng, 0.3) {
            let side = uniform(rng, 0.12, 0.25).min(clear);
            let things = tabletop_items(side, depth.min(side), 1, rng);
            if things.extent().1.z < clear {
                piece.put(things, &Isometry3::translation(x + side / 2.0, 0.05, 0.0));
            }
            x += side + 0.03;
        } else {
            x = books(&mut piece, x, width / 2.0, [depth, clear], rng);
        }
        x += uniform(rng, 0.0, 0.15);
    }
    piece
}

/// Stands books side by side from `x` on; returns where they end.
fn books(
    piece: &mut Piece,
    mut x: f64,
    end: f64,
    [depth, clear]: [f64; 2],
    rng: &mut ChaCha8Rng,
) -> f64 {
    for _ in 0..count(rng, 3, 9) {
        let thick = uniform(rng, 0.02, 0.07);
        if x + thick > end {
            break;
        }
        let high = uniform(rng, 0.55, 0.98) * clear;
        let front = uniform(rng, 0.55, 0.98) * depth;
        let lean = if chance(rng, 0.15) {
            uniform(rng, 0.05, 0.2)
        } else {
            0.0
        };
        let center = [x + thick / 2.0, front / 2.0, high / 2.0];
        piece.tilted_block(center, [thick, front, high], Vector3::y() * lean);
        x += thick + lean * 0.3;
    }
    x
}

/// A waist-high cabinet with things on top.
pub(super) fn cabinet(rng: &mut ChaCha8Rng) -> Piece {
    let size = [
        uniform(rng, 0.6, 1.1),
        uniform(rng, 0.35, 0.5),
        uniform(rng, 0.8, 1.2),
    ];
    let mut piece = body(size, rng);
    let on_top = Isometry3::translation(0.0, 0.02, size[2]);
    piece.put(
        tabletop_items(0.95 * size[0], size[1], count(rng, 2, 4), rng),
        &on_top,
    );
    piece
}

/// A long low cabinet with things on top.
pub(super) fn sideboard(rng: &mut ChaCha8Rng) -> Piece {
    let size = [
        uniform(rng, 1.2, 1.8),
        uniform(rng, 0.35, 0.5),
        uniform(rng, 0.5, 0.8),
    ];
    let mut piece = body(size, rng);
    let on_top = Isometry3::translation(0.0, 0.02, size[2]);
    piece.put(
        tabletop_items(0.95 * size[0], size[1], count(rng, 4, 6), rng),
        &on_top,
    );
    piece
}

/// A tall cupboard with cartons on top.
pub(super) fn wardrobe(rng: &mut ChaCha8Rng) -> Piece {
    let size = [
        uniform(rng, 0.8, 1.4),
        uniform(rng, 0.5, 0.62),
        uniform(rng, 1.8, 2.1),
    ];
    let mut piece = body(size, rng);
    let mut x = -size[0] / 2.0 + 0.2;
    while x < size[0] / 2.0 - 0.15 {
        let carton = [
            uniform(rng, 0.2, 0.45),
            uniform(rng, 0.25, 0.45),
            uniform(rng, 0.1, 0.3),
        ];
        let angle = uniform(rng, -0.3, 0.3);
        piece.rotated_block([x, size[1] / 2.0, size[2] + carton[2] / 2.0], carton, angle);
        x += 0.5;
    }
    piece
}

/// A box on feet with uneven fronts and handles.
fn body(size: [f64; 3], rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let [width, depth, height] = size;
    let foot = uniform(rng, 0.04, 0.14);
    for x in [-width / 2.0 + 0.05, width / 2.0 - 0.05] {
        piece.post([x, depth - 0.06, 0.0], 0.025, foot);
        piece.post([x, 0.06, 0.0], 0.025, foot);
    }
    piece.between([-width / 2.0, 0.0, foot], [width / 2.0, depth, height]);
    piece.between(
        [-width / 2.0 - 0.02, 0.0, height - 0.03],
        [width / 2.0 + 0.02, depth + 0.03, height],
    );
    let columns = count(rng, 2, 3);
    let step = width / columns as f64;
    for column in 0..columns {
        let left = -width / 2.0 + column as f64 * step;
        fronts(
            &mut piece,
            [left, left + step],
            depth,
            [foot, height - 0.03],
            rng,
        );
    }
    piece
}

/// Doors and drawers of one column.
fn fronts(piece: &mut Piece, x: [f64; 2], depth: f64, z: [f64; 2], rng: &mut ChaCha8Rng) {
    let mut low = z[0];
    while low + 0.12 < z[1] {
        let high = (low + uniform(rng, 0.15, 0.8)).min(z[1]);
        let stand_out = uniform(rng, 0.015, 0.035);
        piece.between(
            [x[0] + 0.012, depth, low + 0.012],
            [x[1] - 0.012, depth + stand_out, high - 0.012],
        );
        let handle = [
            x[0] + uniform(rng, 0.2, 0.8) * (x[1] - x[0]),
            depth + stand_out,
            (low + high) / 2.0,
        ];
        if chance(rng, 0.5) {
            piece.ball(handle, 0.022);
        } else {
            piece.block(handle, [0.02, 0.06, 0.12]);
        }
        low = high;
    }
}
