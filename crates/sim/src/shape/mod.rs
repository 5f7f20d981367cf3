//! The solids that scenes are made of, each in its own frame.

mod cuboid;
mod cylinder;
mod sphere;

use nalgebra::Vector3;

/// A solid centered at the origin of its own frame. Lengths in meters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Shape {
    /// A box with faces across the axes.
    Cuboid {
        /// Half the edge lengths.
        half_extents: Vector3<f64>,
    },
    /// A ball.
    Sphere {
        /// Distance from the center to the surface.
        radius: f64,
    },
    /// A capped cylinder about the z axis.
    Cylinder {
        /// Distance from the axis to the mantle.
        radius: f64,
        /// Half the distance between the caps.
        half_height: f64,
    },
}

/// Where a ray meets a shape, in the shape's frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LocalHit {
    pub distance: f64,
    pub normal: Vector3<f64>,
}

impl Shape {
    /// First meeting with a ray that starts at `origin` and heads along the unit `direction`.
    pub(crate) fn intersect(
        &self,
        origin: &Vector3<f64>,
        direction: &Vector3<f64>,
    ) -> Option<LocalHit> {
        match self {
            Self::Cuboid { half_extents } => cuboid::intersect(half_extents, origin, direction),
            Self::Sphere { radius } => sphere::intersect(*radius, origin, direction),
            Self::Cylinder {
                radius,
                half_height,
            } => cylinder::intersect(*radius, *half_height, origin, direction),
        }
    }

    /// Distance from `point` to the surface, negative inside.
    pub(crate) fn signed_distance(&self, point: &Vector3<f64>) -> f64 {
        match self {
            Self::Cuboid { half_extents } => cuboid::signed_distance(half_extents, point),
            Self::Sphere { radius } => point.norm() - radius,
            Self::Cylinder {
                radius,
                half_height,
            } => cylinder::signed_distance(*radius, *half_height, point),
        }
    }

    /// Half the size of the smallest axis-aligned box around the shape in its own frame.
    pub(crate) fn half_extents(&self) -> Vector3<f64> {
        match self {
            Self::Cuboid { half_extents } => *half_extents,
            Self::Sphere { radius } => Vector3::repeat(*radius),
            Self::Cylinder {
                radius,
                half_height,
            } => Vector3::new(*radius, *radius, *half_height),
        }
    }
}

/// The smaller of two roots that is not behind the ray's origin.
fn first_ahead(near: f64, far: f64) -> Option<f64> {
    [near, far].into_iter().find(|&distance| distance >= 0.0)
}
