//! What hangs on walls and ceilings.

use nalgebra::{Isometry3, Point3, Vector3};
use rand_chacha::ChaCha8Rng;

use super::plan::Room;
use super::shell::Hole;
use crate::furniture::{self, Piece};
use crate::random::{chance, count, uniform};

/// Hangs things beside the holes of every wall, and lamps and beams under the ceiling.
pub(super) fn decorate(solids: &mut Piece, room: &Room, holes: &[Hole; 4], rng: &mut ChaCha8Rng) {
    for (wall, hole) in room.walls().iter().zip(holes) {
        let mut hung = Piece::default();
        hang_between(&mut hung, 0.15, hole.x[0] - 0.2, rng);
        hang_between(&mut hung, hole.x[1] + 0.2, wall.length - 0.15, rng);
        solids.put(hung, &wall.building_from_wall);
    }
    under_ceiling(solids, room, rng);
}

fn hang_between(hung: &mut Piece, start: f64, end: f64, rng: &mut ChaCha8Rng) {
    let mut x = start + uniform(rng, 0.0, 0.3);
    loop {
        let width = uniform(rng, 0.25, 0.9);
        if x + width > end {
            return;
        }
        let item = match count(rng, 0, 5) {
            0 | 1 => picture(width, rng),
            2 => wall_shelf(width, rng),
            3 => clock(rng),
            4 => coat_hooks(width, rng),
            _ => sconce(rng),
        };
        hung.put(
            item,
            &Isometry3::translation(x + width / 2.0, 0.0, uniform(rng, 1.35, 1.85)),
        );
        x += width + uniform(rng, 0.1, 0.5);
    }
}

/// A framed picture, its middle at the origin.
fn picture(width: f64, rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let half = [width / 2.0, width * uniform(rng, 0.3, 0.7)];
    let board = uniform(rng, 0.025, 0.06);
    let depth = uniform(rng, 0.025, 0.06);
    piece.between([-half[0], 0.0, -half[1]], [half[0], 0.01, half[1]]);
    for side in [-1.0, 1.0] {
        piece.block(
            [side * half[0], depth / 2.0, 0.0],
            [board, depth, 2.0 * half[1]],
        );
        piece.block(
            [0.0, depth / 2.0, side * half[1]],
            [2.0 * half[0] + board, depth, board],
        );
    }
    piece
}

/// A board on brackets with things on it.
fn wall_shelf(width: f64, rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let depth = uniform(rng, 0.15, 0.26);
    piece.between([-width / 2.0, 0.0, -0.025], [width / 2.0, depth, 0.0]);
    for side in [-0.35, 0.35] {
        let foot = Point3::new(side * width, 0.01, -0.16);
        piece.bar(foot, foot + Vector3::new(0.0, 0.8 * depth, 0.14), 0.012);
    }
    let items = furniture::tabletop_items(width, depth, 3, rng);
    piece.put(items, &Isometry3::identity());
    piece
}

fn clock(rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let radius = uniform(rng, 0.11, 0.2);
    let front = uniform(rng, 0.03, 0.06);
    piece.bar(Point3::origin(), Point3::new(0.0, front, 0.0), radius);
    piece.bar(
        Point3::origin(),
        Point3::new(0.0, front + 0.02, 0.0),
        0.3 * radius,
    );
    piece
}

/// A rail with coats and bags.
fn coat_hooks(width: f64, rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    piece.block([0.0, 0.015, 0.0], [width, 0.03, 0.1]);
    let mut x = -width / 2.0 + 0.08;
    while x < width / 2.0 {
        piece.bar(Point3::new(x, 0.0, 0.0), Point3::new(x, 0.09, 0.02), 0.012);
        if chance(rng, 0.6) {
            let drop = uniform(rng, 0.3, 0.75);
            let size = [uniform(rng, 0.12, 0.3), uniform(rng, 0.05, 0.12), drop];
            let lean = uniform(rng, -0.25, 0.25);
            piece.rotated_block([x, 0.09, -drop / 2.0], size, lean);
            piece.ball([x, 0.09, -0.02], uniform(rng, 0.04, 0.07));
        }
        x += uniform(rng, 0.12, 0.3);
    }
    piece
}

fn sconce(rng: &mut ChaCha8Rng) -> Piece {
    let mut piece = Piece::default();
    let reach = uniform(rng, 0.08, 0.18);
    piece.block([0.0, 0.01, 0.0], [0.09, 0.02, 0.14]);
    piece.bar(Point3::origin(), Point3::new(0.0, reach, 0.05), 0.015);
    piece.ball([0.0, reach, 0.1], uniform(rng, 0.06, 0.11));
    piece
}

/// Hanging lamps, and a beam or a duct across the room.
fn under_ceiling(solids: &mut Piece, room: &Room, rng: &mut ChaCha8Rng) {
    let inside = |u: f64, v: f64| {
        let x = room.min[0] + u * (room.max[0] - room.min[0]);
        let y = room.min[1] + v * (room.max[1] - room.min[1]);
        Point3::new(x, y, room.height)
    };
    for _ in 0..count(rng, 1, 3) {
        let top = inside(uniform(rng, 0.2, 0.8), uniform(rng, 0.2, 0.8));
        let bottom = top - Vector3::z() * uniform(rng, 0.2, 0.6);
        solids.bar(bottom, top, 0.012);
        if chance(rng, 0.5) {
            solids.ball(bottom.coords.into(), uniform(rng, 0.1, 0.2));
        } else {
            let shade = bottom - Vector3::z() * uniform(rng, 0.08, 0.2);
            solids.bar(shade, bottom, uniform(rng, 0.12, 0.25));
        }
    }
    for _ in 0..count(rng, 1, 2) {
        let across = uniform(rng, 0.1, 0.9);
        let drop = uniform(rng, 0.1, 0.2);
        let width = uniform(rng, 0.1, 0.25);
        let middle = inside(across, 0.5);
        let depth = room.max[1] - room.min[1];
        solids.block(
            [middle.x, middle.y, room.height - drop / 2.0],
            [width, depth, drop],
        );
    }
}
