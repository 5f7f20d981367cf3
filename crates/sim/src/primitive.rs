//! A shape somewhere in the world.

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3};

use crate::bvh::Bounds;
use crate::ray::Ray;
use crate::shape::{LocalHit, Shape};

/// A [`Shape`] at a place in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Primitive {
    shape: Shape,
    world_from_local: Isometry3<f64>,
    /// The rotation of `world_from_local`; its transpose takes rays into the shape's frame.
    rotation: Matrix3<f64>,
}

impl Primitive {
    /// `shape` in the frame that `world_from_local` maps into the world.
    pub(crate) fn new(shape: Shape, world_from_local: Isometry3<f64>) -> Self {
        let rotation = world_from_local.rotation.to_rotation_matrix().into_inner();
        Self {
            shape,
            world_from_local,
            rotation,
        }
    }

    /// A box with the given edge lengths, placed by `world_from_local`.
    pub(crate) fn oriented_box(size: Vector3<f64>, world_from_local: Isometry3<f64>) -> Self {
        Self::new(
            Shape::Cuboid {
                half_extents: size / 2.0,
            },
            world_from_local,
        )
    }

    /// The box between two opposite corners, `min` below `max` along each axis.
    pub(crate) fn axis_aligned_box(min: Point3<f64>, max: Point3<f64>) -> Self {
        let center = Translation3::from((min.coords + max.coords) / 2.0);
        Self::oriented_box(max - min, center.into())
    }

    /// A ball.
    pub(crate) fn sphere(center: Point3<f64>, radius: f64) -> Self {
        Self::new(
            Shape::Sphere { radius },
            Translation3::from(center.coords).into(),
        )
    }

    /// A capped cylinder whose axis runs from `base` to `top`.
    pub(crate) fn cylinder(base: Point3<f64>, top: Point3<f64>, radius: f64) -> Self {
        let axis = top - base;
        let half_turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
        let rotation = UnitQuaternion::rotation_between(&Vector3::z(), &axis).unwrap_or(half_turn);
        let center = Translation3::from((base.coords + top.coords) / 2.0);
        let shape = Shape::Cylinder {
            radius,
            half_height: axis.norm() / 2.0,
        };
        Self::new(shape, Isometry3::from_parts(center, rotation))
    }

    /// The transformation that maps the shape's frame into the world.
    #[cfg(test)]
    pub(crate) fn world_from_local(&self) -> &Isometry3<f64> {
        &self.world_from_local
    }

    /// The same solid after a rigid transformation.
    pub(crate) fn moved(&self, target_from_source: &Isometry3<f64>) -> Self {
        Self::new(self.shape, target_from_source * self.world_from_local)
    }

    /// Distance from `point` to the surface: negative inside.
    pub(crate) fn signed_distance(&self, point: &Point3<f64>) -> f64 {
        self.shape.signed_distance(&self.local_point(point))
    }

    /// Where `ray` first meets the surface, its normal in the world's frame.
    pub(crate) fn intersect(&self, ray: &Ray) -> Option<LocalHit> {
        let origin = self.local_point(&ray.origin);
        let direction = self.rotation.tr_mul(ray.direction.as_ref());
        let hit = self.shape.intersect(&origin, &direction)?;
        Some(LocalHit {
            normal: self.rotation * hit.normal,
            ..hit
        })
    }

    pub(crate) fn bounds(&self) -> Bounds {
        let reach = self.rotation.abs() * self.shape.half_extents();
        let center = self.world_from_local.translation.vector;
        Bounds {
            min: center - reach,
            max: center + reach,
        }
    }

    fn local_point(&self, point: &Point3<f64>) -> Vector3<f64> {
        let from_center = point.coords - self.world_from_local.translation.vector;
        self.rotation.tr_mul(&from_center)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Stream, generator, rigid_transformation};
    use approx::assert_relative_eq;

    #[test]
    fn a_cylinder_reaches_from_base_to_top_also_upside_down() {
        for top in [Point3::new(0.0, 3.0, 1.0), Point3::new(0.0, 0.0, -2.0)] {
            let base = Point3::new(0.0, 0.0, 1.0);
            let post = Primitive::cylinder(base, top, 0.1);
            assert!(post.signed_distance(&base).abs() < 1e-12);
            assert!(post.signed_distance(&top).abs() < 1e-12);
            assert_relative_eq!(post.signed_distance(&nalgebra::center(&base, &top)), -0.1);
        }
    }

    #[test]
    fn moving_a_primitive_and_a_ray_together_keeps_the_distance() {
        let mut rng = generator(5, Stream::World);
        let ray = Ray {
            origin: Point3::new(-3.0, 0.05, 0.1),
            direction: Vector3::x_axis(),
        };
        let place = Isometry3::rotation(Vector3::new(0.3, 0.2, 0.1));
        for primitive in [
            Primitive::oriented_box(Vector3::new(1.0, 0.5, 0.7), place),
            Primitive::sphere(Point3::origin(), 0.4),
            Primitive::cylinder(Point3::new(0.0, -1.0, 0.0), Point3::new(0.2, 1.0, 0.0), 0.3),
            Primitive::oriented_box(
                Vector3::new(1.0, 1.0, 0.0),
                Isometry3::rotation(Vector3::y()),
            ),
        ] {
            let transformation = rigid_transformation(&mut rng, 4.0);
            let before = primitive.intersect(&ray).unwrap();
            let after = primitive
                .moved(&transformation)
                .intersect(&ray.moved(&transformation))
                .unwrap();
            assert_relative_eq!(before.distance, after.distance, epsilon = 1e-12);
            assert_relative_eq!(
                transformation * before.normal,
                after.normal,
                epsilon = 1e-12
            );
        }
    }
}
