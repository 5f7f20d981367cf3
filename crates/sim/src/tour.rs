//! A walk through the flat: where the camera stands and looks, scan by scan.
//!
//! In each room the camera rotates about once, stepping back from the middle of the room; then it
//! walks through the passage into the next one, and back when the last room is done. Around each
//! planned stop viewpoints are drawn at random until one keeps clear of the furniture, sees more
//! than a bare wall and sees the wanted part of the scan before again; the longer this takes, the
//! nearer to the viewpoint before.

use std::f64::consts::{PI, TAU};

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use crate::building::{Building, Room};
use crate::camera::DepthCamera;
use crate::error::Error;
use crate::random::{gaussian_pair, uniform};
use crate::view::View;

/// Rotation between planned stops.
const STEP: f64 = PI / 5.0;
/// How far from the middle of the room the camera stands, as a fraction of the way to the wall.
const STEP_BACK: f64 = 0.45;
/// Distance kept from every surface, in meters.
const CLEARANCE: f64 = 0.3;
/// Viewpoints tried for one scan.
const ATTEMPTS: usize = 300;
/// Least fraction of the rays that must meet something within range.
const MIN_FILL: f64 = 0.7;
/// Least mean distance of what a view shows, in meters: no close-ups.
const MIN_DISTANCE: f64 = 1.7;
/// Fewest solids a view must show.
const MIN_SOLIDS: usize = 15;
/// Largest fraction of a view that one solid may take.
const MAX_DOMINANCE: f64 = 0.5;
/// Wanted fraction of the view before that is seen again.
const WANTED_FRACTION: [f64; 2] = [0.45, 0.65];

/// A place in the plan and the direction of sight there, counted from x towards y.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stop {
    x: f64,
    y: f64,
    yaw: f64,
}

impl Stop {
    /// From this stop (`part` 0) to the other (1), rotating the shorter way.
    fn towards(&self, other: &Self, part: f64) -> Self {
        let rotation = (other.yaw - self.yaw + PI).rem_euclid(TAU) - PI;
        Self {
            x: self.x + part * (other.x - self.x),
            y: self.y + part * (other.y - self.y),
            yaw: self.yaw + part * rotation,
        }
    }
}

/// A viewpoint and what is seen from it.
struct Sight {
    stop: Stop,
    view: View,
}

/// Poses `building_from_camera` along the walk.
pub(crate) fn walk(
    building: &Building,
    camera: &DepthCamera,
    num_scans: usize,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<Isometry3<f64>>, Error> {
    let mut poses = Vec::with_capacity(num_scans);
    let mut before: Option<Sight> = None;
    for (scan, stop) in plan(&building.rooms, num_scans).iter().enumerate() {
        let sight = choose_sight(building, camera, stop, before.as_ref(), rng).ok_or(
            Error::NoViewpoint {
                scan,
                attempts: ATTEMPTS,
            },
        )?;
        poses.push(sight.view.world_from_camera);
        before = Some(sight);
    }
    Ok(poses)
}

/// The first `num_scans` stops of the walk.
fn plan(rooms: &[Room], num_scans: usize) -> Vec<Stop> {
    let mut stops = Vec::with_capacity(num_scans);
    let (mut room, mut heading, mut direction) = (0, 1.0, 1.0);
    while stops.len() < num_scans {
        let next_heading = match room {
            _ if rooms.len() == 1 => heading,
            0 => 1.0,
            last if last + 1 == rooms.len() => -1.0,
            _ => heading,
        };
        let half_revolutions = if heading == next_heading { 2.0 } else { 3.0 };
        rotate(
            &mut stops,
            &rooms[room],
            heading,
            direction * half_revolutions * PI,
        );
        heading = next_heading;
        direction = -direction;
        if rooms.len() > 1 {
            room = walk_on(&mut stops, room, rooms, heading);
        }
    }
    stops.truncate(num_scans);
    stops
}

/// Stops on an ellipse, each looking over the middle of the room.
fn rotate(stops: &mut Vec<Stop>, plan: &Room, heading: f64, angle: f64) {
    let start: f64 = if heading > 0.0 { 0.0 } else { PI };
    let [x, y] = plan.center();
    let [half_x, half_y] = [0, 1].map(|k| (plan.max[k] - plan.min[k]) / 2.0);
    let steps = (angle.abs() / STEP).ceil() as usize;
    for k in 0..steps {
        let yaw = start + angle * k as f64 / steps as f64;
        let (x, y) = (
            x - STEP_BACK * half_x * yaw.cos(),
            y - STEP_BACK * half_y * yaw.sin(),
        );
        stops.push(Stop { x, y, yaw });
    }
}

/// Two stops that look through the passage and one behind it; returns the room behind it.
fn walk_on(stops: &mut Vec<Stop>, room: usize, rooms: &[Room], heading: f64) -> usize {
    let plan = &rooms[room];
    let (edge, passage, next) = if heading > 0.0 {
        (plan.max[0], plan.passage_ahead, room + 1)
    } else {
        (plan.min[0], plan.passage_behind, room.saturating_sub(1))
    };
    let Some([low, high]) = passage else {
        return room;
    };
    let middle = (low + high) / 2.0;
    let yaw = if heading > 0.0 { 0.0 } else { PI };
    for distance in [1.8, 0.6, -0.7] {
        stops.push(Stop {
            x: edge - heading * distance,
            y: middle,
            yaw,
        });
    }
    next
}

/// Draws viewpoints around a stop, then ever nearer to the viewpoint before, until one suits;
/// failing that, the usable one whose fraction is nearest to the wanted range.
fn choose_sight(
    building: &Building,
    camera: &DepthCamera,
    stop: &Stop,
    before: Option<&Sight>,
    rng: &mut ChaCha8Rng,
) -> Option<Sight> {
    let mut best: Option<(f64, Sight)> = None;
    for attempt in 0..ATTEMPTS {
        let progress = attempt as f64 / ATTEMPTS as f64;
        let aim = before.map_or(*stop, |before| stop.towards(&before.stop, progress));
        let (stop, pose) = draw_pose(&aim, 1.0 + progress, rng);
        let Some(view) = usable_view(building, camera, pose) else {
            continue;
        };
        let fraction =
            before.map(|before| view.covisible_fraction(&before.view, camera, &building.scene));
        let miss = fraction.map_or(0.0, distance_to_wanted);
        if best.as_ref().is_none_or(|(least, _)| miss < *least) {
            best = Some((miss, Sight { stop, view }));
        }
        if miss == 0.0 {
            break;
        }
    }
    best.map(|(_, sight)| sight)
}

fn distance_to_wanted(fraction: f64) -> f64 {
    (WANTED_FRACTION[0] - fraction)
        .max(fraction - WANTED_FRACTION[1])
        .max(0.0)
}

/// A hand-held pose near a stop, and the stop it makes; `spread` widens the draw.
fn draw_pose(aim: &Stop, spread: f64, rng: &mut ChaCha8Rng) -> (Stop, Isometry3<f64>) {
    let (reach, angle) = (0.25 * spread, spread * 8.0_f64.to_radians());
    let stop = Stop {
        x: aim.x + uniform(rng, -reach, reach),
        y: aim.y + uniform(rng, -reach, reach),
        yaw: aim.yaw + uniform(rng, -angle, angle),
    };
    let eye = Point3::new(stop.x, stop.y, uniform(rng, 1.0, 1.8));
    let pitch = uniform(rng, -35.0, 10.0).to_radians();
    let roll = 4.0_f64.to_radians() * gaussian_pair(rng).0;
    (stop, look(eye, stop.yaw, pitch, roll))
}

/// A camera at `eye` that looks along `yaw` (from x towards y) and `pitch` (up is positive),
/// rolled about its line of sight.
fn look(eye: Point3<f64>, yaw: f64, pitch: f64, roll: f64) -> Isometry3<f64> {
    let forward = Vector3::new(
        yaw.cos() * pitch.cos(),
        yaw.sin() * pitch.cos(),
        pitch.sin(),
    );
    let right = Vector3::new(yaw.sin(), -yaw.cos(), 0.0);
    let down = forward.cross(&right);
    let axes = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[right, down, forward]));
    let level = UnitQuaternion::from_rotation_matrix(&axes);
    let rolled = level * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), roll);
    Isometry3::from_parts(eye.into(), rolled)
}

/// The view from a pose that stands free in a room and sees enough.
fn usable_view(building: &Building, camera: &DepthCamera, pose: Isometry3<f64>) -> Option<View> {
    let eye = Point3::from(pose.translation.vector);
    let stands_free = building
        .rooms
        .iter()
        .any(|room| room.contains(eye.x, eye.y))
        && building.scene.signed_distance(&eye) >= CLEARANCE;
    if !stands_free {
        return None;
    }
    let view = View::sample(camera, &building.scene, pose);
    let sees_enough = view.fill() >= MIN_FILL
        && view.mean_distance() >= MIN_DISTANCE
        && view.num_solids() >= MIN_SOLIDS
        && view.dominance() <= MAX_DOMINANCE;
    sees_enough.then_some(view)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::building::RoomParams;
    use crate::random::{Stream, generator};
    use approx::assert_relative_eq;

    #[test]
    fn a_level_camera_keeps_its_y_axis_down_and_looks_along_its_yaw() {
        let pose = look(Point3::new(1.0, 2.0, 1.5), 0.5, 0.0, 0.0);
        assert_relative_eq!(pose * Vector3::y(), -Vector3::z(), epsilon = 1e-12);
        let forward = Vector3::new(0.5_f64.cos(), 0.5_f64.sin(), 0.0);
        assert_relative_eq!(pose * Vector3::z(), forward, epsilon = 1e-12);
    }

    #[test]
    fn a_positive_pitch_looks_up() {
        let pose = look(Point3::origin(), 2.0, 0.3, 0.1);
        assert_relative_eq!((pose * Vector3::z()).z, 0.3_f64.sin(), epsilon = 1e-12);
    }

    #[test]
    fn every_stop_lies_in_its_room_and_all_rooms_are_visited() {
        let params = RoomParams {
            num_rooms: 3,
            ..RoomParams::default()
        };
        let rooms = Building::generate(1, &params).rooms;
        let stops = plan(&rooms, 120);
        assert_eq!(stops.len(), 120);
        let room_of = |stop: &Stop| rooms.iter().position(|room| room.contains(stop.x, stop.y));
        let visited: Vec<usize> = stops.iter().map(|stop| room_of(stop).unwrap()).collect();
        for room in 0..3 {
            assert!(visited.iter().filter(|&&visit| visit == room).count() > 20);
        }
        assert!(
            visited
                .windows(2)
                .all(|pair| pair[0].abs_diff(pair[1]) <= 1)
        );
    }

    #[test]
    fn a_stop_halfway_turns_the_shorter_way() {
        let from = Stop {
            x: 0.0,
            y: 2.0,
            yaw: 3.0,
        };
        let to = Stop {
            x: 1.0,
            y: 4.0,
            yaw: -3.0,
        };
        let halfway = from.towards(&to, 0.5);
        assert_eq!((halfway.x, halfway.y), (0.5, 3.0));
        assert_relative_eq!(halfway.yaw, PI, epsilon = 1e-12);
        assert_eq!(from.towards(&to, 0.0), from);
    }

    #[test]
    fn viewpoints_keep_clear_of_everything() {
        let building = Building::generate(3, &RoomParams::default());
        let mut rng = generator(3, Stream::Tour);
        let poses = walk(&building, &DepthCamera::default(), 24, &mut rng).unwrap();
        for pose in poses {
            let eye = Point3::from(pose.translation.vector);
            assert!(building.scene.signed_distance(&eye) >= CLEARANCE);
            assert!((1.0..=1.8).contains(&eye.z));
        }
    }

    #[test]
    fn a_camera_that_sees_too_little_is_reported() {
        let building = Building::generate(3, &RoomParams::default());
        let blind = DepthCamera {
            max_range: 0.5,
            ..DepthCamera::default()
        };
        let mut rng = generator(3, Stream::Tour);
        let error = walk(&building, &blind, 4, &mut rng).unwrap_err();
        assert_eq!(
            error,
            Error::NoViewpoint {
                scan: 0,
                attempts: ATTEMPTS
            }
        );
    }
}
