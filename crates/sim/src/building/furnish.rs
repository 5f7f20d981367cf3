//! Where furniture stands.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::plan::{Room, Wall};
use super::shell::Hole;
use crate::furniture::{self, Maker, Piece};
use crate::random::{count, uniform};

/// Attempts to find a free place for a free-standing piece.
const ATTEMPTS: usize = 40;

/// An axis-aligned rectangle of the floor.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Footprint {
    min: [f64; 2],
    max: [f64; 2],
}

impl Footprint {
    fn of(piece: &Piece) -> Self {
        let (min, max) = piece.extent();
        Self {
            min: [min.x, min.y],
            max: [max.x, max.y],
        }
    }

    fn grown(self, margin: f64) -> Self {
        Self {
            min: self.min.map(|x| x - margin),
            max: self.max.map(|x| x + margin),
        }
    }

    fn meets(&self, other: &Self) -> bool {
        (0..2).all(|k| self.min[k] < other.max[k] && other.min[k] < self.max[k])
    }

    fn lies_in(&self, room: &Room) -> bool {
        (0..2).all(|k| self.min[k] >= room.min[k] && self.max[k] <= room.max[k])
    }
}

/// Furniture along the walls, groups in the middle, clutter on the floor.
pub(super) fn furnish(solids: &mut Piece, room: &Room, holes: &[Hole; 4], rng: &mut ChaCha8Rng) {
    let mut site = Site {
        room,
        taken: Vec::new(),
        standing: Piece::default(),
    };
    site.keep_ways_free(holes);
    site.line_walls(holes, rng);
    site.fill_middle(rng);
    solids.put(site.standing, &Isometry3::identity());
}

/// A room while it is being furnished.
struct Site<'a> {
    room: &'a Room,
    taken: Vec<Footprint>,
    standing: Piece,
}

impl Site<'_> {
    /// Nothing stands before doors and passages.
    fn keep_ways_free(&mut self, holes: &[Hole; 4]) {
        for (wall, hole) in self.room.walls().iter().zip(holes) {
            if hole.z[0] == 0.0 {
                let mut way = Piece::default();
                way.between([hole.x[0] - 0.1, 0.0, 0.0], [hole.x[1] + 0.1, 0.9, 1.0]);
                let mut placed = Piece::default();
                placed.put(way, &wall.building_from_wall);
                self.taken.push(Footprint::of(&placed));
            }
        }
    }

    fn line_walls(&mut self, holes: &[Hole; 4], rng: &mut ChaCha8Rng) {
        let mut deck: Vec<Maker> = furniture::ALONG_WALLS.to_vec();
        deck.shuffle(rng);
        for (wall, hole) in self.room.walls().iter().zip(holes) {
            let stop = if hole.z[0] == 0.0 {
                hole.x
            } else {
                [wall.length; 2]
            };
            self.line_up(wall, [0.05, stop[0] - 0.1], &mut deck, rng);
            self.line_up(wall, [stop[1] + 0.1, wall.length - 0.05], &mut deck, rng);
        }
    }

    /// Sets pieces side by side along a stretch of wall, trying each of the deck once.
    fn line_up(
        &mut self,
        wall: &Wall,
        [mut x, end]: [f64; 2],
        deck: &mut Vec<Maker>,
        rng: &mut ChaCha8Rng,
    ) {
        let mut left_over = Vec::new();
        while let Some(make) = deck.pop() {
            let piece = make(rng);
            let (min, max) = piece.extent();
            let width = max.x - min.x;
            let rotation =
                UnitQuaternion::from_axis_angle(&Vector3::z_axis(), uniform(rng, -0.04, 0.04));
            let translation = Translation3::new(x - min.x, uniform(rng, 0.02, 0.08) - min.y, 0.0);
            let place = wall.building_from_wall * Isometry3::from_parts(translation, rotation);
            if x + width <= end && self.stand(piece, &place, 0.0) {
                x += width + uniform(rng, 0.05, 0.6);
            } else {
                left_over.push(make);
            }
        }
        left_over.reverse();
        *deck = left_over;
    }

    fn fill_middle(&mut self, rng: &mut ChaCha8Rng) {
        let mut groups: Vec<Maker> = furniture::FREE_STANDING.to_vec();
        groups.shuffle(rng);
        for make in groups {
            self.find_place(make(rng), 0.3, rng);
        }
        for _ in 0..count(rng, 8, 14) {
            self.find_place(furniture::floor_clutter(rng), 0.03, rng);
        }
    }

    /// Tries random places and rotations; gives up where the room is full.
    fn find_place(&mut self, piece: Piece, margin: f64, rng: &mut ChaCha8Rng) {
        for _ in 0..ATTEMPTS {
            let angle = uniform(rng, 0.0, std::f64::consts::TAU);
            let x = uniform(rng, self.room.min[0], self.room.max[0]);
            let y = uniform(rng, self.room.min[1], self.room.max[1]);
            let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
            let place = Isometry3::from_parts(Translation3::new(x, y, 0.0), rotation);
            if self.stand(piece.clone(), &place, margin) {
                return;
            }
        }
    }

    /// Puts a piece down if its place is free.
    fn stand(&mut self, piece: Piece, place: &Isometry3<f64>, margin: f64) -> bool {
        let mut placed = Piece::default();
        placed.put(piece, place);
        let footprint = Footprint::of(&placed);
        let wide = footprint.grown(margin);
        let free = footprint.lies_in(self.room) && !self.taken.iter().any(|t| t.meets(&wide));
        if free {
            self.taken.push(footprint);
            self.standing.put(placed, &Isometry3::identity());
        }
        free
    }
}
