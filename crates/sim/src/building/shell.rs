//! Floor, ceilings, walls, windows and doors.

use nalgebra::{Point3, Vector3};
use rand_chacha::ChaCha8Rng;

use super::plan::{PARTITION, Room, Wall};
use crate::furniture::Piece;
use crate::primitive::Primitive;
use crate::random::{chance, uniform};

/// Thickness of the outer walls, in meters.
const OUTER: f64 = 0.3;

/// A hole in a wall, in the wall's frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hole {
    pub x: [f64; 2],
    pub z: [f64; 2],
}

/// Adds floor, ceiling and walls of a room; returns the hole in each wall.
pub(super) fn raise(solids: &mut Piece, room: &Room, rng: &mut ChaCha8Rng) -> [Hole; 4] {
    let ([x0, y0], [x1, y1]) = (room.min, room.max);
    // The slabs reach under and over the walls, into the passages.
    let slab = |low: f64, high: f64| {
        let min = Point3::new(x0 - PARTITION, y0 - OUTER, low);
        let max = Point3::new(x1 + PARTITION, y1 + OUTER, high);
        Primitive::axis_aligned_box(min, max)
    };
    solids.add(slab(-0.1, 0.0));
    solids.add(slab(room.height, room.height + 0.1));
    room.walls()
        .map(|wall| raise_wall(solids, &wall, room.height, rng))
}

/// One wall with its holes and what fills them.
fn raise_wall(solids: &mut Piece, wall: &Wall, height: f64, rng: &mut ChaCha8Rng) -> Hole {
    let mut built = Piece::default();
    let hole = match wall.passage {
        Some(x) => passage(&mut built, x, rng),
        None if chance(rng, 0.7) => window(&mut built, wall.length, rng),
        None => door(&mut built, wall.length, rng),
    };
    let thickness = if wall.passage.is_some() {
        PARTITION / 2.0
    } else {
        OUTER
    };
    masonry(&mut built, wall.length, height, thickness, hole);
    solids.put(built, &wall.building_from_wall);
    hole
}

/// The wall around its hole, behind the plane y = 0.
fn masonry(built: &mut Piece, length: f64, height: f64, thickness: f64, hole: Hole) {
    let mut block = |x: [f64; 2], z: [f64; 2]| {
        built.between([x[0], -thickness, z[0]], [x[1], 0.0, z[1]]);
    };
    block([0.0, hole.x[0]], [0.0, height]);
    block([hole.x[1], length], [0.0, height]);
    if hole.z[0] > 0.0 {
        block(hole.x, [0.0, hole.z[0]]);
    }
    block(hole.x, [hole.z[1], height]);
}

/// An opening without a door, framed.
fn passage(built: &mut Piece, x: [f64; 2], rng: &mut ChaCha8Rng) -> Hole {
    let hole = Hole {
        x,
        z: [0.0, uniform(rng, 2.05, 2.25)],
    };
    casing(built, &hole, uniform(rng, 0.06, 0.1));
    hole
}

/// A window: recessed pane, bars, a sill that stands out.
fn window(built: &mut Piece, length: f64, rng: &mut ChaCha8Rng) -> Hole {
    let width = uniform(rng, 0.9, 1.8);
    let start = uniform(rng, 0.4, length - width - 0.4);
    let sill = uniform(rng, 0.75, 1.0);
    let hole = Hole {
        x: [start, start + width],
        z: [sill, uniform(rng, 1.9, 2.2)],
    };
    let [left, right] = hole.x;
    let [low, high] = hole.z;
    built.between([left, -0.24, low], [right, -0.2, high]);
    let upright = uniform(rng, 0.3, 0.7) * width;
    let bar = uniform(rng, 0.05, 0.09);
    for x in [left, left + upright, right - bar] {
        built.between([x, -0.21, low], [x + bar, -0.14, high]);
    }
    let crossbar = low + uniform(rng, 0.55, 0.8) * (high - low);
    for z in [low, crossbar, high - bar] {
        built.between([left, -0.2, z], [right, -0.15, z + bar]);
    }
    let nose = uniform(rng, 0.06, 0.18);
    built.between([left - 0.06, -0.2, low - 0.04], [right + 0.06, nose, low]);
    hole
}

/// A closed door in a shallow recess, with a casing, panels and a handle.
fn door(built: &mut Piece, length: f64, rng: &mut ChaCha8Rng) -> Hole {
    let width = uniform(rng, 0.8, 1.0);
    let start = uniform(rng, 0.3, length - width - 0.3);
    let hole = Hole {
        x: [start, start + width],
        z: [0.0, uniform(rng, 2.0, 2.15)],
    };
    let [left, right] = hole.x;
    built.between([left, -0.16, 0.0], [right, -0.12, hole.z[1]]);
    casing(built, &hole, uniform(rng, 0.07, 0.12));
    let split = uniform(rng, 0.7, 1.2);
    for z in [[0.15, split - 0.08], [split + 0.08, hole.z[1] - 0.15]] {
        built.between([left + 0.14, -0.13, z[0]], [right - 0.14, -0.1, z[1]]);
    }
    let handle = Point3::new(left + 0.07, -0.06, 1.03);
    built.bar(handle, handle + Vector3::x() * 0.13, 0.012);
    hole
}

/// Boards around a hole, standing out of the wall.
fn casing(built: &mut Piece, hole: &Hole, width: f64) {
    let ([left, right], top) = (hole.x, hole.z[1]);
    built.between([left - width, -0.05, 0.0], [left, 0.025, top + width]);
    built.between([right, -0.05, 0.0], [right + width, 0.025, top + width]);
    built.between([left, -0.05, top], [right, 0.025, top + width]);
}
