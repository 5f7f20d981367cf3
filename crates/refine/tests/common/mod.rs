//! A room of known planes, sampled at random as scans see it.
#![allow(dead_code)] // Not every test uses everything.

use gmpcr_refine::{Surface, SurfaceParams};
use nalgebra::{Isometry3, Point3, Vector3};

/// A generator of random numbers, the same on every machine.
pub struct Random(pub u64);

impl Random {
    /// Uniform in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Standard normal, about: the sum of twelve uniform numbers.
    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// A rectangle with a normal.
#[derive(Clone, Copy)]
pub struct Rectangle {
    pub corner: Vector3<f64>,
    pub along: [Vector3<f64>; 2],
    pub normal: Vector3<f64>,
}

impl Rectangle {
    pub fn new(corner: [f64; 3], first: [f64; 3], second: [f64; 3], normal: [f64; 3]) -> Self {
        Self {
            corner: corner.into(),
            along: [first.into(), second.into()],
            normal: normal.into(),
        }
    }
}

/// Floor and walls of a room of 24 × 20 × 12 voxels, seen from inside, and a cupboard.
pub fn room() -> Vec<Rectangle> {
    let (x, y, z) = (24.0, 20.0, 12.0);
    vec![
        Rectangle::new([0.0; 3], [x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, 1.0]),
        Rectangle::new([0.0; 3], [0.0, y, 0.0], [0.0, 0.0, z], [1.0, 0.0, 0.0]),
        Rectangle::new([0.0; 3], [x, 0.0, 0.0], [0.0, 0.0, z], [0.0, 1.0, 0.0]),
        Rectangle::new(
            [x, 0.0, 0.0],
            [0.0, y, 0.0],
            [0.0, 0.0, z],
            [-1.0, 0.0, 0.0],
        ),
        Rectangle::new(
            [14.0, 6.0, 0.0],
            [5.0, 0.0, 0.0],
            [0.0, 0.0, 7.0],
            [0.0, 1.0, 0.0],
        ),
        Rectangle::new(
            [14.0, 0.0, 0.0],
            [0.0, 6.0, 0.0],
            [0.0, 0.0, 7.0],
            [-1.0, 0.0, 0.0],
        ),
    ]
}

/// Points with normals: one at a random place of each cell of the rectangles, noise along the normal, in the
/// frame of a scan.
pub fn sample(
    rectangles: &[Rectangle],
    scan_from_room: &Isometry3<f64>,
    noise: f64,
    seed: u64,
) -> (Vec<Point3<f64>>, Vec<Vector3<f64>>) {
    let mut random = Random(seed);
    let (mut points, mut normals) = (Vec::new(), Vec::new());
    for rectangle in rectangles {
        let [first, second] = rectangle
            .along
            .map(|along| (along.normalize(), along.norm() as i32));
        for k in 0..first.1 * second.1 {
            let a = f64::from(k % first.1) + random.uniform();
            let b = f64::from(k / first.1) + random.uniform();
            let off = rectangle.normal * (noise * random.normal());
            let point = Point3::from(rectangle.corner + first.0 * a + second.0 * b + off);
            points.push(scan_from_room * point);
            normals.push(scan_from_room * rectangle.normal);
        }
    }
    (points, normals)
}

pub fn surface(points: &[Point3<f64>], normals: &[Vector3<f64>]) -> Surface {
    Surface::new(points, normals, &SurfaceParams::from_voxel_size(1.0)).unwrap()
}

/// A scan of rectangles, voxel size 1.
pub fn scan(
    rectangles: &[Rectangle],
    scan_from_room: &Isometry3<f64>,
    noise: f64,
    seed: u64,
) -> Surface {
    let (points, normals) = sample(rectangles, scan_from_room, noise, seed);
    surface(&points, &normals)
}

/// How far two transformations take a point of a room apart, at most about.
pub fn distance(a: &Isometry3<f64>, b: &Isometry3<f64>) -> f64 {
    let corners = [
        [0.0, 0.0, 0.0],
        [24.0, 0.0, 0.0],
        [0.0, 20.0, 0.0],
        [0.0, 0.0, 12.0],
    ];
    let apart = |corner: [f64; 3]| (a * Point3::from(corner) - b * Point3::from(corner)).norm();
    corners.map(apart).into_iter().fold(0.0, f64::max)
}

/// A transformation by a rotation vector around the middle of the room, and a translation.
pub fn nudge(rotation: [f64; 3], translation: [f64; 3]) -> Isometry3<f64> {
    let middle = nalgebra::Translation3::new(12.0, 10.0, 5.0);
    middle * Isometry3::new(translation.into(), rotation.into()) * middle.inverse()
}
