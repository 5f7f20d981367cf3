//! A generated flat: rooms in a row along x, joined by passages, furnished at random.

mod decoration;
mod furnish;
mod plan;
mod shell;

pub(crate) use plan::Room;
pub use plan::RoomParams;

use crate::furniture::Piece;
use crate::random::{Stream, generator};
use crate::scene::Scene;

/// The solids of a flat and the plan they follow. z points up, the floor is z = 0.
#[derive(Debug, Clone)]
pub(crate) struct Building {
    pub scene: Scene,
    pub rooms: Vec<Room>,
}

impl Building {
    /// The flat of a seed, by valid parameters.
    pub(crate) fn generate(seed: u64, params: &RoomParams) -> Self {
        let mut rng = generator(seed, Stream::Building);
        let rooms = plan::draw_rooms(params, &mut rng);
        let mut solids = Piece::default();
        for room in &rooms {
            let holes = shell::raise(&mut solids, room, &mut rng);
            decoration::decorate(&mut solids, room, &holes, &mut rng);
            furnish::furnish(&mut solids, room, &holes, &mut rng);
        }
        Self {
            scene: Scene::new(solids.into_primitives()),
            rooms,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    #[test]
    fn the_same_seed_builds_the_same_flat_and_another_seed_another() {
        let flat = |seed| Building::generate(seed, &RoomParams::default()).scene;
        assert_eq!(flat(1).primitives(), flat(1).primitives());
        assert_ne!(flat(1).primitives(), flat(2).primitives());
    }

    #[test]
    fn every_room_is_furnished_and_leaves_space_to_stand() {
        for seed in 0..5 {
            let flat = Building::generate(seed, &RoomParams::default());
            for room in &flat.rooms {
                let inside = |p: &&crate::primitive::Primitive| {
                    let center = p.world_from_local().translation.vector;
                    room.contains(center.x, center.y)
                };
                assert!(flat.scene.primitives().iter().filter(inside).count() > 150);
                let free = (0..400).filter(|k| {
                    let (u, v) = (f64::from(k % 20) / 20.0, f64::from(k / 20) / 20.0);
                    let x = room.min[0] + u * (room.max[0] - room.min[0]);
                    let y = room.min[1] + v * (room.max[1] - room.min[1]);
                    flat.scene.signed_distance(&Point3::new(x, y, 1.4)) > 0.3
                });
                assert!(free.count() > 100, "seed {seed}");
            }
        }
    }

    #[test]
    fn parameters_out_of_range_are_named() {
        let default = RoomParams::default();
        #[rustfmt::skip]
        let cases = [
            (RoomParams { num_rooms: 0, ..default }, "num_rooms"),
            (RoomParams { min_side: 1.0, ..default }, "min_side"),
            (RoomParams { max_side: f64::NAN, ..default }, "max_side"),
            (RoomParams { max_side: 4.0, min_side: 5.0, ..default }, "max_side"),
        ];
        for (params, name) in cases {
            assert_eq!(params.validate().unwrap_err().name, name);
        }
    }
}
