//! A scene of solids and the rays cast against it.

use nalgebra::Point3;

use crate::bvh::Bvh;
use crate::primitive::Primitive;
use crate::ray::{Hit, Ray};

/// Solids in one frame, ready to be seen.
#[derive(Debug, Clone)]
pub(crate) struct Scene {
    primitives: Vec<Primitive>,
    tree: Bvh,
}

impl Scene {
    /// A scene of the given solids; an empty one is allowed.
    pub(crate) fn new(primitives: Vec<Primitive>) -> Self {
        Self {
            tree: Bvh::new(&primitives),
            primitives,
        }
    }

    /// The solids, in the order that [`Hit::primitive`] counts.
    #[cfg(test)]
    pub(crate) fn primitives(&self) -> &[Primitive] {
        &self.primitives
    }

    /// What `ray` meets first, closer than `limit`. Logarithmic in the number of solids, usually.
    pub(crate) fn cast(&self, ray: &Ray, limit: f64) -> Option<Hit> {
        self.tree.first_hit(&self.primitives, ray, limit)
    }

    /// Distance from `point` to the nearest surface: negative inside a solid, infinite in an
    /// empty scene. Linear in the number of solids.
    pub(crate) fn signed_distance(&self, point: &Point3<f64>) -> f64 {
        self.primitives
            .iter()
            .map(|primitive| primitive.signed_distance(point))
            .fold(f64::INFINITY, f64::min)
    }

    /// The scene after a rigid transformation.
    #[cfg(test)]
    pub(crate) fn moved(&self, target_from_source: &nalgebra::Isometry3<f64>) -> Self {
        let moved = |primitive: &Primitive| primitive.moved(target_from_source);
        Self::new(self.primitives.iter().map(moved).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn an_empty_scene_shows_nothing() {
        let scene = Scene::new(Vec::new());
        let ray = Ray {
            origin: Point3::origin(),
            direction: Vector3::z_axis(),
        };
        assert_eq!(scene.cast(&ray, 10.0), None);
        assert_eq!(scene.signed_distance(&Point3::origin()), f64::INFINITY);
    }

    #[test]
    fn the_nearer_of_two_solids_hides_the_other() {
        let ball = |z| Primitive::sphere(Point3::new(0.0, 0.0, z), 0.5);
        let scene = Scene::new(vec![ball(5.0), ball(2.0)]);
        let ray = Ray {
            origin: Point3::origin(),
            direction: Vector3::z_axis(),
        };
        assert_eq!(scene.cast(&ray, 10.0).map(|hit| hit.primitive), Some(1));
        assert_eq!(scene.cast(&ray, 1.4), None);
    }
}
