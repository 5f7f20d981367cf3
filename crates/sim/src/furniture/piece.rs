//! Solids put together in a frame of their own.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use crate::bvh::Bounds;
use crate::primitive::Primitive;

/// A group of solids; x to the right, y away from the wall, z up.
#[derive(Debug, Clone, Default)]
pub(crate) struct Piece {
    primitives: Vec<Primitive>,
}

impl Piece {
    pub(crate) fn into_primitives(self) -> Vec<Primitive> {
        self.primitives
    }

    pub(crate) fn add(&mut self, primitive: Primitive) {
        self.primitives.push(primitive);
    }

    /// Adds the parts of `other`, whose frame `self_from_other` maps into this one.
    pub(crate) fn put(&mut self, other: Self, self_from_other: &Isometry3<f64>) {
        self.primitives.extend(
            other
                .primitives
                .iter()
                .map(|part| part.moved(self_from_other)),
        );
    }

    /// A box between opposite corners.
    pub(crate) fn between(&mut self, min: [f64; 3], max: [f64; 3]) {
        self.add(Primitive::axis_aligned_box(min.into(), max.into()));
    }

    /// A box with the given middle and edge lengths.
    pub(crate) fn block(&mut self, center: [f64; 3], size: [f64; 3]) {
        self.rotated_block(center, size, 0.0);
    }

    /// A box rotated about the vertical through its middle.
    pub(crate) fn rotated_block(&mut self, center: [f64; 3], size: [f64; 3], angle: f64) {
        self.tilted_block(center, size, Vector3::z() * angle);
    }

    /// A box rotated about its middle by a rotation vector.
    pub(crate) fn tilted_block(
        &mut self,
        center: [f64; 3],
        size: [f64; 3],
        rotation_vector: Vector3<f64>,
    ) {
        let rotation = UnitQuaternion::from_scaled_axis(rotation_vector);
        let place = Isometry3::from_parts(Translation3::from(Vector3::from(center)), rotation);
        self.add(Primitive::oriented_box(size.into(), place));
    }

    pub(crate) fn ball(&mut self, center: [f64; 3], radius: f64) {
        self.add(Primitive::sphere(center.into(), radius));
    }

    /// An upright cylinder.
    pub(crate) fn post(&mut self, base: [f64; 3], radius: f64, height: f64) {
        let base = Point3::from(base);
        self.bar(base, base + Vector3::z() * height, radius);
    }

    /// A cylinder between two points.
    pub(crate) fn bar(&mut self, from: Point3<f64>, to: Point3<f64>, radius: f64) {
        self.add(Primitive::cylinder(from, to, radius));
    }

    /// Opposite corners of the smallest box around the piece.
    pub(crate) fn extent(&self) -> (Point3<f64>, Point3<f64>) {
        let all = Bounds::around(self.primitives.iter().map(Primitive::bounds));
        (all.min.into(), all.max.into())
    }
}
