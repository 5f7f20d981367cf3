//! A half-line, and where it meets a surface.

use nalgebra::{Isometry3, Point3, Unit, Vector3};

/// A half-line `origin + distance · direction` with `distance ≥ 0`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ray {
    /// Where it starts.
    pub origin: Point3<f64>,
    /// Where it heads, of unit length.
    pub direction: Unit<Vector3<f64>>,
}

impl Ray {
    /// The point at `distance` along the ray.
    pub(crate) fn at(&self, distance: f64) -> Point3<f64> {
        self.origin + distance * self.direction.as_ref()
    }

    /// The same ray in another frame.
    pub(crate) fn moved(&self, target_from_source: &Isometry3<f64>) -> Self {
        Self {
            origin: target_from_source * self.origin,
            direction: target_from_source * self.direction,
        }
    }
}

/// Where a ray first meets a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hit {
    /// Distance from the ray's origin.
    pub distance: f64,
    /// Unit normal of the surface there; the side it points to is not fixed.
    pub normal: Vector3<f64>,
    /// Index of the primitive that was hit, in the scene's order.
    pub primitive: usize,
}
