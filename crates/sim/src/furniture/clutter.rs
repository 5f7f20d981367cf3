//! Things that lie about.

use nalgebra::{Point3, Vector3};
use rand_chacha::ChaCha8Rng;

use super::piece::Piece;
use crate::random::{chance, count, uniform};

/// Cartons, one upon the other and one beside.
pub(super) fn box_pile(rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let mut z = 0.0;
    let mut side = uniform(rng, 0.45, 0.6);
    for _ in 0..count(rng, 2, 4) {
        let high = uniform(rng, 0.15, 0.4);
        let size = [side, side * uniform(rng, 0.6, 0.9), high];
        piece.rotated_block([0.0, 0.0, z + high / 2.0], size, uniform(rng, -0.4, 0.4));
        z += high;
        side *= uniform(rng, 0.65, 0.95);
    }
    let beside = [(); 3].map(|()| uniform(rng, 0.2, 0.4));
    piece.rotated_block(
        [0.5, uniform(rng, -0.1, 0.1), beside[2] / 2.0],
        beside,
        uniform(rng, 0.0, 1.0),
    );
    piece
}

/// One small thing on the floor.
pub(crate) fn floor_clutter(rng: &mut ChaCha8Rng) -> Piece {
    match count(rng, 0, 5) {
        0 => bin(rng),
        1 => toy_balls(rng),
        2 => suitcase(rng),
        3 => stool(rng),
        4 => basket(rng),
        _ => vacuum_cleaner(rng),
    }
}

fn bin(rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let (radius, high) = (uniform(rng, 0.1, 0.18), uniform(rng, 0.25, 0.5));
    piece.post([0.0, 0.0, 0.0], radius, high);
    for _ in 0..count(rng, 1, 4) {
        let offset = [(); 2].map(|()| uniform(rng, -0.5, 0.5) * radius);
        piece.ball([offset[0], offset[1], high], uniform(rng, 0.04, 0.08));
    }
    piece
}

fn toy_balls(rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    for _ in 0..count(rng, 1, 3) {
        let radius = uniform(rng, 0.06, 0.16);
        piece.ball(
            [uniform(rng, -0.2, 0.2), uniform(rng, -0.2, 0.2), radius],
            radius,
        );
    }
    piece
}

fn suitcase(rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let size = [
        uniform(rng, 0.35, 0.5),
        uniform(rng, 0.18, 0.26),
        uniform(rng, 0.45, 0.65),
    ];
    let lean = Vector3::x() * uniform(rng, -0.15, 0.15);
    piece.tilted_block([0.0, 0.0, size[2] / 2.0 + 0.03], size, lean);
    let grip = uniform(rng, 0.1, 0.3);
    piece.block([0.0, 0.0, size[2] + grip], [0.2, 0.03, 0.03]);
    for x in [-0.09, 0.09] {
        piece.post([x, 0.0, size[2]], 0.01, grip);
    }
    piece
}

fn stool(rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let high = uniform(rng, 0.4, 0.65);
    piece.post([0.0, 0.0, high - 0.05], uniform(rng, 0.15, 0.21), 0.05);
    for k in 0..3 {
        let angle = f64::from(k) * std::f64::consts::TAU / 3.0;
        let foot = Point3::new(0.2 * angle.cos(), 0.2 * angle.sin(), 0.0);
        piece.bar(foot, Point3::new(0.4 * foot.x, 0.4 * foot.y, high), 0.016);
    }
    piece
}

/// A basket of rolled-up things.
fn basket(rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let size = [
        uniform(rng, 0.3, 0.5),
        uniform(rng, 0.25, 0.35),
        uniform(rng, 0.2, 0.35),
    ];
    piece.block([0.0, 0.0, size[2] / 2.0], size);
    for _ in 0..count(rng, 2, 5) {
        let foot = Point3::new(
            uniform(rng, -0.4, 0.4) * size[0],
            uniform(rng, -0.3, 0.3) * size[1],
            size[2] - 0.05,
        );
        let lean = Vector3::new(uniform(rng, -0.1, 0.1), uniform(rng, -0.1, 0.1), 0.0);
        let tip = foot + lean + Vector3::z() * uniform(rng, 0.1, 0.35);
        piece.bar(foot, tip, uniform(rng, 0.02, 0.06));
    }
    piece
}

fn vacuum_cleaner(rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let radius = uniform(rng, 0.11, 0.16);
    piece.bar(
        Point3::new(-0.15, 0.0, radius),
        Point3::new(0.12, 0.0, radius),
        radius,
    );
    piece.ball([0.12, 0.0, radius], radius);
    let bend = Point3::new(0.3, uniform(rng, 0.05, 0.2), uniform(rng, 0.5, 0.8));
    piece.bar(Point3::new(0.2, 0.0, radius), bend, 0.025);
    piece.bar(bend, Point3::new(0.42, 0.25, 0.04), 0.022);
    if chance(rng, 0.8) {
        piece.block([0.44, 0.25, 0.03], [0.12, 0.28, 0.06]);
    }
    piece
}
