//! What a viewpoint would see, judged by a few rays before the full scan is paid for.

use nalgebra::{Isometry3, Point3, Unit};

use crate::camera::DepthCamera;
use crate::ray::{Hit, Ray};
use crate::scene::Scene;

/// Sample rays per row and per column.
const COLUMNS: usize = 24;
const ROWS: usize = 18;

/// A point behind a surface by less than this counts as seen, in meters.
const OCCLUSION_SLACK: f64 = 0.02;

/// The points that a coarse grid of rays meets within the camera's range.
#[derive(Debug, Clone)]
pub(crate) struct View {
    pub world_from_camera: Isometry3<f64>,
    hits: Vec<(Point3<f64>, Hit)>,
}

impl View {
    pub(crate) fn sample(
        camera: &DepthCamera,
        scene: &Scene,
        world_from_camera: Isometry3<f64>,
    ) -> Self {
        let pixels = (0..COLUMNS * ROWS).map(|k| {
            let column = ((k % COLUMNS) as f64 + 0.5) / COLUMNS as f64;
            let row = ((k / COLUMNS) as f64 + 0.5) / ROWS as f64;
            (column * camera.width as f64, row * camera.height as f64)
        });
        let hits = pixels.filter_map(|pixel| {
            let (direction, length) = Unit::new_and_get(camera.direction(pixel));
            let ray = Ray {
                origin: Point3::origin(),
                direction,
            }
            .moved(&world_from_camera);
            let hit = scene.cast(&ray, camera.max_range * length)?;
            (hit.distance >= camera.min_range * length).then(|| (ray.at(hit.distance), hit))
        });
        let hits = hits.collect();
        Self {
            world_from_camera,
            hits,
        }
    }

    /// Fraction of the rays that meet something within range.
    pub(crate) fn fill(&self) -> f64 {
        self.hits.len() as f64 / (COLUMNS * ROWS) as f64
    }

    /// Mean distance of what is seen, in meters; 0 where nothing is.
    pub(crate) fn mean_distance(&self) -> f64 {
        let sum: f64 = self.hits.iter().map(|(_, hit)| hit.distance).sum();
        sum / self.hits.len().max(1) as f64
    }

    /// How many different solids are seen.
    pub(crate) fn num_solids(&self) -> usize {
        self.solids().chunk_by(|a, b| a == b).count()
    }

    /// Fraction of the hits on the one solid that is seen most; 1 where nothing is seen.
    pub(crate) fn dominance(&self) -> f64 {
        let largest = self
            .solids()
            .chunk_by(|a, b| a == b)
            .map(<[usize]>::len)
            .max();
        largest.map_or(1.0, |count| count as f64 / self.hits.len() as f64)
    }

    fn solids(&self) -> Vec<usize> {
        let mut solids: Vec<usize> = self.hits.iter().map(|(_, hit)| hit.primitive).collect();
        solids.sort_unstable();
        solids
    }

    /// Fraction of what one view sees that the other sees too; the mean of both directions.
    pub(crate) fn covisible_fraction(
        &self,
        other: &Self,
        camera: &DepthCamera,
        scene: &Scene,
    ) -> f64 {
        (self.fraction_seen_by(other, camera, scene) + other.fraction_seen_by(self, camera, scene))
            / 2.0
    }

    fn fraction_seen_by(&self, other: &Self, camera: &DepthCamera, scene: &Scene) -> f64 {
        let seen = |(point, _): &&(Point3<f64>, Hit)| other.sees(point, camera, scene);
        self.hits.iter().filter(seen).count() as f64 / self.hits.len().max(1) as f64
    }

    /// `point` is inside the image and nothing stands before it.
    fn sees(&self, point: &Point3<f64>, camera: &DepthCamera, scene: &Scene) -> bool {
        if !camera.frames(&self.world_from_camera.inverse_transform_point(point)) {
            return false;
        }
        let origin = Point3::from(self.world_from_camera.translation.vector);
        let (direction, distance) = Unit::new_and_get(point - origin);
        scene
            .cast(&Ray { origin, direction }, distance - OCCLUSION_SLACK)
            .is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::primitive::Primitive;
    use nalgebra::Vector3;

    fn wall() -> Primitive {
        Primitive::oriented_box(
            Vector3::new(20.0, 20.0, 0.0),
            Isometry3::translation(0.0, 0.0, 3.0),
        )
    }

    fn covisible(scene: &Scene, distance: f64) -> f64 {
        let camera = DepthCamera::default();
        let view = |x| View::sample(&camera, scene, Isometry3::translation(x, 0.0, 0.0));
        view(0.0).covisible_fraction(&view(distance), &camera, scene)
    }

    #[test]
    fn a_step_along_a_wall_loses_the_part_that_leaves_the_image() {
        let scene = Scene::new(vec![wall()]);
        let width = 2.0 * 3.0 * 30.0_f64.to_radians().tan();
        assert_eq!(covisible(&scene, 0.0), 1.0);
        assert!((covisible(&scene, width / 2.0) - 0.5).abs() < 0.03);
        assert_eq!(covisible(&scene, 1.1 * width), 0.0);
    }

    #[test]
    fn what_stands_between_hides_the_wall() {
        let screen = Primitive::oriented_box(
            Vector3::new(0.01, 2.0, 2.0),
            Isometry3::translation(0.5, 0.0, 1.4),
        );
        let open = covisible(&Scene::new(vec![wall()]), 1.0);
        let screened = covisible(&Scene::new(vec![wall(), screen]), 1.0);
        assert!(screened < open - 0.1, "{screened} {open}");
    }

    #[test]
    fn a_bare_wall_is_one_dominant_solid() {
        let scene = Scene::new(vec![wall()]);
        let view = View::sample(&DepthCamera::default(), &scene, Isometry3::identity());
        assert_eq!(
            (view.fill(), view.num_solids(), view.dominance()),
            (1.0, 1, 1.0)
        );
        let away = Isometry3::translation(0.0, 0.0, 4.0);
        let blind = View::sample(&DepthCamera::default(), &scene, away);
        assert_eq!(
            (blind.fill(), blind.num_solids(), blind.dominance()),
            (0.0, 0, 1.0)
        );
    }
}
