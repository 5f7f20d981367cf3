//! The floor plan.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use crate::error::{InvalidParameter, check_count, check_range};
use crate::random::uniform;

/// Thickness of the walls between rooms, in meters.
pub(crate) const PARTITION: f64 = 0.15;

/// Size of a generated flat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoomParams {
    /// Rooms in the row, 1 to a million. Default 1. Walks through several rooms are connected by the
    /// few scans taken in the passages: a much harder problem.
    pub num_rooms: usize,
    /// Shortest side a room may have, in meters, 3 to 20. Default 4.4.
    pub min_side: f64,
    /// Longest side a room may have, in meters, `min_side` to 20. Default 5.8.
    pub max_side: f64,
}

impl Default for RoomParams {
    fn default() -> Self {
        Self {
            num_rooms: 1,
            min_side: 4.4,
            max_side: 5.8,
        }
    }
}

impl RoomParams {
    /// Checks the parameters.
    ///
    /// # Errors
    /// The first parameter that is out of range.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        check_count("num_rooms", self.num_rooms)?;
        check_range("min_side", self.min_side, 3.0..=20.0, "in [3, 20]")?;
        let sides = self.min_side..=20.0;
        check_range("max_side", self.max_side, sides, "in [min_side, 20]")
    }
}

/// A room: a rectangle of the plan, and the passage to the next room.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Room {
    pub min: [f64; 2],
    pub max: [f64; 2],
    pub height: f64,
    /// Range of y left open in the wall at `min[0]`; none in the first room.
    pub passage_behind: Option<[f64; 2]>,
    /// Range of y left open in the wall at `max[0]`; none in the last room.
    pub passage_ahead: Option<[f64; 2]>,
}

/// A wall of a room, seen from inside: x runs to the right as one faces away from it, y points
/// into the room, z up; the origin lies on the floor at the wall's left end.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wall {
    pub building_from_wall: Isometry3<f64>,
    pub length: f64,
    /// Range of x that a passage leaves open.
    pub passage: Option<[f64; 2]>,
}

impl Room {
    pub(crate) fn center(&self) -> [f64; 2] {
        [0, 1].map(|k| (self.min[k] + self.max[k]) / 2.0)
    }

    pub(crate) fn contains(&self, x: f64, y: f64) -> bool {
        (self.min[0]..=self.max[0]).contains(&x) && (self.min[1]..=self.max[1]).contains(&y)
    }

    /// The walls at low y, high x, high y, low x.
    pub(crate) fn walls(&self) -> [Wall; 4] {
        let [x0, y0] = self.min;
        let [x1, y1] = self.max;
        let quarter = std::f64::consts::FRAC_PI_2;
        let wall = |corner: [f64; 2], quarters: f64, length: f64, passage| Wall {
            building_from_wall: Isometry3::from_parts(
                Translation3::new(corner[0], corner[1], 0.0),
                UnitQuaternion::from_axis_angle(&Vector3::z_axis(), quarters * quarter),
            ),
            length,
            passage,
        };
        let ahead = self.passage_ahead.map(|[low, high]| [low - y0, high - y0]);
        let behind = self.passage_behind.map(|[low, high]| [y1 - high, y1 - low]);
        [
            wall([x0, y0], 0.0, x1 - x0, None),
            wall([x1, y0], 1.0, y1 - y0, ahead),
            wall([x1, y1], 2.0, x1 - x0, None),
            wall([x0, y1], 3.0, y1 - y0, behind),
        ]
    }
}

/// Rooms of random size, each moved sideways against the one before, with wide passages.
pub(super) fn draw_rooms(params: &RoomParams, rng: &mut ChaCha8Rng) -> Vec<Room> {
    let mut rooms: Vec<Room> = Vec::with_capacity(params.num_rooms);
    let mut x = 0.0;
    for _ in 0..params.num_rooms {
        let length = uniform(rng, params.min_side, params.max_side);
        let depth = uniform(rng, params.min_side, params.max_side);
        let y = rooms.last().map_or(0.0, |before| before.min[1]) + uniform(rng, -0.8, 0.8);
        let mut room = Room {
            min: [x, y],
            max: [x + length, y + depth],
            height: uniform(rng, 2.5, 2.9),
            passage_behind: None,
            passage_ahead: None,
        };
        if let Some(before) = rooms.last_mut() {
            let passage = draw_passage(before, &room, rng);
            before.passage_ahead = Some(passage);
            room.passage_behind = Some(passage);
        }
        rooms.push(room);
        x += length + PARTITION;
    }
    rooms
}

/// An opening inside the part of the wall that both rooms have in common.
fn draw_passage(before: &Room, after: &Room, rng: &mut ChaCha8Rng) -> [f64; 2] {
    let low = before.min[1].max(after.min[1]);
    let high = before.max[1].min(after.max[1]);
    let width = uniform(rng, 1.3, 1.7).min(high - low);
    let start = low + uniform(rng, 0.25, 0.75) * (high - low - width);
    [start, start + width]
}
