//! A kitchen counter and a radiator.

use nalgebra::{Isometry3, Point3, Vector3};
use rand_chacha::ChaCha8Rng;

use super::piece::Piece;
use super::tabletop::tabletop_items;
use crate::random::{count, uniform};

/// A worktop with cupboards below and above, a tap, an extractor and utensils.
pub(super) fn counter(rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let width = uniform(rng, 1.5, 2.2);
    let half = width / 2.0;
    let (depth, height) = (uniform(rng, 0.55, 0.65), uniform(rng, 0.86, 0.94));
    piece.between([-half, 0.0, 0.0], [half, depth - 0.05, 0.1]);
    piece.between([-half, 0.0, 0.1], [half, depth, height - 0.04]);
    piece.between([-half, 0.0, height - 0.04], [half, depth + 0.03, height]);
    under_cupboards(&mut piece, half, depth, height, rng);
    tap(&mut piece, uniform(rng, -0.5, -0.1) * half, height, rng);
    let on_top = Isometry3::translation(0.3 * half, 0.1, height);
    piece.put(
        tabletop_items(1.2 * half, 0.35, count(rng, 3, 5), rng),
        &on_top,
    );
    hanging(&mut piece, half, rng);
    piece
}

fn under_cupboards(piece: &mut Piece, half: f64, depth: f64, height: f64, rng: &mut ChaCha8Rng) {
    let mut x = -half;
    while x + 0.25 < half {
        let right = (x + uniform(rng, 0.3, 0.65)).min(half);
        let split = uniform(rng, 0.3, 0.75);
        let stand_out = uniform(rng, 0.015, 0.03);
        piece.between(
            [x + 0.01, depth, 0.12],
            [right - 0.01, depth + stand_out, split],
        );
        piece.between(
            [x + 0.01, depth, split + 0.02],
            [right - 0.01, depth + 0.02, height - 0.06],
        );
        let (from, to) = (x + 0.1, right - 0.1);
        let bar = [from, to].map(|x| Point3::new(x, depth + 0.05, split - 0.06));
        piece.bar(bar[0], bar[1], 0.012);
        x = right;
    }
}

/// A bent tap beside a draining rack of plates.
fn tap(piece: &mut Piece, x: f64, height: f64, rng: &mut ChaCha8Rng) {
    let rise = uniform(rng, 0.2, 0.35);
    let top = Point3::new(x, 0.08, height + rise);
    piece.post([x, 0.08, height], 0.02, rise);
    piece.bar(top, top + Vector3::new(0.0, 0.2, -0.03), 0.018);
    for k in 0..count(rng, 3, 6) {
        let y = 0.12 + 0.05 * k as f64;
        let radius = uniform(rng, 0.06, 0.13);
        let center = Point3::new(x - 0.35, y, height + radius);
        piece.bar(center, center + Vector3::new(0.0, 0.015, 0.004), radius);
    }
}

/// Cupboards on the wall and a tilted extractor hood between them.
fn hanging(piece: &mut Piece, half: f64, rng: &mut ChaCha8Rng) {
    let mut x = -half;
    let hood_at = uniform(rng, -0.3, 0.5) * half;
    while x + 0.25 < half {
        let right = (x + uniform(rng, 0.3, 0.7)).min(half);
        let low = uniform(rng, 1.4, 1.55);
        let depth = uniform(rng, 0.28, 0.36);
        if (x..right).contains(&hood_at) {
            let middle = (x + right) / 2.0;
            let tilt = Vector3::new(uniform(rng, -0.6, -0.3), 0.0, 0.0);
            piece.tilted_block(
                [middle, 0.2, low + 0.15],
                [right - x - 0.04, 0.4, 0.06],
                tilt,
            );
            piece.between([middle - 0.12, 0.0, low + 0.1], [middle + 0.12, 0.24, 2.2]);
        } else {
            piece.between(
                [x + 0.005, 0.0, low],
                [right - 0.005, depth, uniform(rng, 1.95, 2.2)],
            );
            piece.block([right - 0.06, depth, low + 0.1], [0.02, 0.04, 0.12]);
        }
        x = right;
    }
}

/// Ribs of uneven width with pipes.
pub(super) fn radiator(rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let (low, high) = (uniform(rng, 0.1, 0.18), uniform(rng, 0.55, 0.75));
    let half = uniform(rng, 0.35, 0.7);
    let mut x = -half;
    while x < half {
        let rib = uniform(rng, 0.04, 0.09);
        let depth = uniform(rng, 0.08, 0.14);
        piece.between([x, 0.04, low], [x + rib, 0.04 + depth, high]);
        x += rib + uniform(rng, 0.02, 0.06);
    }
    for z in [low + 0.06, high - 0.06] {
        piece.bar(
            Point3::new(-half - 0.08, 0.08, z),
            Point3::new(half, 0.08, z),
            0.018,
        );
    }
    piece.post([-half - 0.08, 0.08, 0.0], 0.016, high);
    piece.bar(
        Point3::new(-half - 0.16, 0.08, high),
        Point3::new(-half, 0.08, high),
        0.035,
    );
    piece
}
