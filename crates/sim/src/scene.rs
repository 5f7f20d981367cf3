//! A scene of solids and the rays cast against it.

use nalgebra::{Isometry3, Point3};

use crate::building::{Building, RoomParams};
use crate::bvh::Bvh;
use crate::error::Error;
use crate::primitive::Primitive;
use crate::ray::{Hit, Ray};

/// Solids in one frame, ready to be seen.
///
/// ```
/// use gmpcr_sim::{Primitive, Ray, Scene};
/// use nalgebra::{Point3, Vector3};
///
/// let ball = Primitive::sphere(Point3::new(0.0, 0.0, 2.0), 0.5);
/// let scene = Scene::new(vec![ball])?;
/// let ray = Ray { origin: Point3::origin(), direction: Vector3::z_axis() };
/// assert_eq!(scene.cast(&ray, 4.0).map(|hit| hit.distance), Some(1.5));
/// # Ok::<(), gmpcr_sim::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Scene {
    primitives: Vec<Primitive>,
    tree: Bvh,
}

impl Scene {
    /// A scene of the given solids; an empty one is allowed.
    ///
    /// # Errors
    /// [`Error::BadPrimitive`] for a negative or non-finite size or a non-finite place.
    pub fn new(primitives: Vec<Primitive>) -> Result<Self, Error> {
        match primitives
            .iter()
            .position(|primitive| !primitive.is_sound())
        {
            Some(index) => Err(Error::BadPrimitive { index }),
            None => Ok(Self {
                tree: Bvh::new(&primitives),
                primitives,
            }),
        }
    }

    /// A generated flat: rooms in a row, joined by passages, with windows, furniture and clutter.
    ///
    /// z points up, the floor is z = 0. The same seed gives the same bits.
    ///
    /// # Errors
    /// [`Error::Zero`] or [`Error::OutOfRange`] for parameters outside their documented ranges.
    pub fn furnished_room(seed: u64, params: &RoomParams) -> Result<Self, Error> {
        Building::generate(seed, params).map(|building| building.scene)
    }

    /// The solids, in the order that [`Hit::primitive`] counts.
    #[must_use]
    pub fn primitives(&self) -> &[Primitive] {
        &self.primitives
    }

    /// What `ray` meets first, closer than `limit`. Logarithmic in the number of solids, usually.
    #[must_use]
    pub fn cast(&self, ray: &Ray, limit: f64) -> Option<Hit> {
        self.tree.first_hit(&self.primitives, ray, limit)
    }

    /// Distance from `point` to the nearest surface: negative inside a solid, infinite in an
    /// empty scene. Linear in the number of solids.
    #[must_use]
    pub fn signed_distance(&self, point: &Point3<f64>) -> f64 {
        self.primitives
            .iter()
            .map(|primitive| primitive.signed_distance(point))
            .fold(f64::INFINITY, f64::min)
    }

    /// The scene after a rigid motion.
    #[must_use]
    pub fn moved(&self, target_from_source: &Isometry3<f64>) -> Self {
        let primitives: Vec<Primitive> = self
            .primitives
            .iter()
            .map(|primitive| primitive.moved(target_from_source))
            .collect();
        Self {
            tree: Bvh::new(&primitives),
            primitives,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn an_empty_scene_shows_nothing() {
        let scene = Scene::new(Vec::new()).unwrap();
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
        let scene = Scene::new(vec![ball(5.0), ball(2.0)]).unwrap();
        let ray = Ray {
            origin: Point3::origin(),
            direction: Vector3::z_axis(),
        };
        assert_eq!(scene.cast(&ray, 10.0).map(|hit| hit.primitive), Some(1));
        assert_eq!(scene.cast(&ray, 1.4), None);
    }

    #[test]
    fn a_broken_solid_is_named() {
        let ball = Primitive::sphere(Point3::origin(), 0.5);
        let negative = Primitive::sphere(Point3::origin(), -0.5);
        let lost = Primitive::sphere(Point3::new(f64::NAN, 0.0, 0.0), 0.5);
        for broken in [negative, lost] {
            let error = Scene::new(vec![ball, broken]).unwrap_err();
            assert_eq!(error, Error::BadPrimitive { index: 1 });
        }
    }
}
