//! A depth camera that looks at a scene.

use nalgebra::{Isometry3, Point3, Unit, Vector3};
use rand::{Rng, RngExt};

use crate::error::{InvalidParameter, check_count, check_range};
use crate::noise::DepthNoise;
use crate::random::gaussian_pair;
use crate::ray::Ray;
use crate::scene::Scene;

/// A pinhole depth camera: x to the right, y down, z forward, the sensor at the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthCamera {
    /// Pixels per row. Default 160.
    pub width: usize,
    /// Pixels per column. Default 120.
    pub height: usize,
    /// Angle between the left and the right edge of the image, in radians. Default 60°.
    pub horizontal_fov: f64,
    /// Smallest depth z that is measured, in meters. Default 0.4.
    pub min_range: f64,
    /// Largest depth z that is measured, in meters. Default 4.5.
    pub max_range: f64,
    /// How the depths err.
    pub noise: DepthNoise,
}

impl Default for DepthCamera {
    fn default() -> Self {
        Self {
            width: 160,
            height: 120,
            horizontal_fov: 60.0_f64.to_radians(),
            min_range: 0.4,
            max_range: 4.5,
            noise: DepthNoise::default(),
        }
    }
}

impl DepthCamera {
    /// One depth image of `scene` as points in the camera's frame, row by row; pixels that
    /// return nothing are left out.
    ///
    /// A camera without pixels, or with parameters that are not numbers, sees nothing.
    pub(crate) fn scan(
        &self,
        scene: &Scene,
        world_from_camera: &Isometry3<f64>,
        rng: &mut impl Rng,
    ) -> Vec<Point3<f64>> {
        let mut points = Vec::new();
        for row in 0..self.height {
            for column in 0..self.width {
                let pixel = (column as f64 + 0.5, row as f64 + 0.5);
                points.extend(self.measure(pixel, scene, world_from_camera, rng));
            }
        }
        points
    }

    /// The point that one pixel measures.
    fn measure(
        &self,
        pixel: (f64, f64),
        scene: &Scene,
        world_from_camera: &Isometry3<f64>,
        rng: &mut impl Rng,
    ) -> Option<Point3<f64>> {
        let errors = PixelErrors::draw(&self.noise, rng);
        let looks_at = (pixel.0 + errors.lateral.0, pixel.1 + errors.lateral.1);
        let z = self.depth(looks_at, scene, world_from_camera)?;
        let measured = self
            .noise
            .quantized(z + self.noise.axial_sigma(z) * errors.axial);
        (!errors.dropped).then(|| Point3::from(measured * self.direction(pixel)))
    }

    /// Exact depth along the optical axis in the direction of `pixel`.
    fn depth(
        &self,
        pixel: (f64, f64),
        scene: &Scene,
        world_from_camera: &Isometry3<f64>,
    ) -> Option<f64> {
        let (direction, length) = Unit::new_and_get(self.direction(pixel));
        let ray = Ray {
            origin: Point3::origin(),
            direction,
        }
        .moved(world_from_camera);
        let hit = scene.cast(&ray, self.max_range * length)?;
        let z = hit.distance / length;
        let facing = hit.normal.dot(&ray.direction).abs();
        (z >= self.min_range && facing >= self.noise.grazing_limit.cos()).then_some(z)
    }

    /// Direction of an image position in the camera's frame, with unit z.
    pub(crate) fn direction(&self, pixel: (f64, f64)) -> Vector3<f64> {
        let focal = self.focal_length();
        let center = (self.width as f64 / 2.0, self.height as f64 / 2.0);
        Vector3::new(
            (pixel.0 - center.0) / focal,
            (pixel.1 - center.1) / focal,
            1.0,
        )
    }

    /// Whether a point in the camera's frame lies inside the image and the range.
    pub(crate) fn frames(&self, point: &Point3<f64>) -> bool {
        let focal = self.focal_length();
        let inside = |x: f64, size: usize| (x / point.z * focal).abs() <= size as f64 / 2.0;
        (self.min_range..=self.max_range).contains(&point.z)
            && inside(point.x, self.width)
            && inside(point.y, self.height)
    }

    /// In pixels.
    fn focal_length(&self) -> f64 {
        self.width as f64 / 2.0 / (self.horizontal_fov / 2.0).tan()
    }

    /// Checks the parameters.
    ///
    /// # Errors
    /// The first parameter that is out of range.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        check_count("width", self.width)?;
        check_count("height", self.height)?;
        let angles = 0.1..=2.8;
        check_range(
            "horizontal_fov",
            self.horizontal_fov,
            angles,
            "in [0.1, 2.8]",
        )?;
        check_range("min_range", self.min_range, 0.0..=100.0, "in [0, 100]")?;
        let depths = self.min_range..=100.0;
        check_range("max_range", self.max_range, depths, "in [min_range, 100]")?;
        self.noise.validate().map_err(|e| e.within("noise"))
    }
}

/// The errors at one pixel. Drawn for every pixel, also where nothing is seen, so that a
/// change of the scene leaves the noise of the other pixels alone.
struct PixelErrors {
    lateral: (f64, f64),
    axial: f64,
    dropped: bool,
}

impl PixelErrors {
    fn draw(noise: &DepthNoise, rng: &mut impl Rng) -> Self {
        let (right, down) = gaussian_pair(rng);
        let (axial, _) = gaussian_pair(rng);
        Self {
            lateral: (noise.lateral_sigma * right, noise.lateral_sigma * down),
            axial,
            dropped: rng.random::<f64>() < noise.dropout,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::building::{Building, RoomParams};
    use crate::primitive::Primitive;
    use crate::random::{Stream, generator, rigid_transformation};
    use nalgebra::distance;

    fn wall_at(z: f64) -> Scene {
        let place = Isometry3::translation(0.0, 0.0, z);
        Scene::new(vec![Primitive::oriented_box(
            Vector3::new(20.0, 20.0, 0.0),
            place,
        )])
    }

    fn depth_spread(z: f64) -> f64 {
        let mut rng = generator(2, Stream::World);
        let points = DepthCamera::default().scan(&wall_at(z), &Isometry3::identity(), &mut rng);
        let sum: f64 = points.iter().map(|p| (p.z - z).powi(2)).sum();
        (sum / points.len() as f64).sqrt()
    }

    #[test]
    fn noise_grows_with_range_as_the_model_says() {
        for z in [1.0, 2.0, 3.0, 4.0] {
            let expected = DepthNoise::default().axial_sigma(z);
            let found = depth_spread(z);
            assert!(
                (found / expected - 1.0).abs() < 0.05,
                "{found} for {expected} at {z}"
            );
        }
    }

    #[test]
    fn noise_free_points_lie_on_a_surface() {
        let scene = Building::generate(4, &RoomParams::default()).scene;
        let camera = DepthCamera {
            noise: DepthNoise::none(),
            ..DepthCamera::default()
        };
        let mut rng = generator(9, Stream::World);
        let eye = Isometry3::translation(2.0, 2.0, 1.4);
        for _ in 0..8 {
            let world_from_camera = eye * rigid_transformation(&mut rng, 0.1);
            for point in camera.scan(&scene, &world_from_camera, &mut rng) {
                let world = world_from_camera * point;
                let nearest = scene
                    .primitives()
                    .iter()
                    .map(|p| p.signed_distance(&world).abs());
                assert!(nearest.fold(f64::INFINITY, f64::min) < 1e-9);
            }
        }
    }

    #[test]
    fn moving_scene_and_camera_together_leaves_the_scan_unchanged() {
        let scene = Building::generate(4, &RoomParams::default()).scene;
        let camera = DepthCamera {
            noise: DepthNoise::none(),
            ..DepthCamera::default()
        };
        let transformation = rigid_transformation(&mut generator(1, Stream::World), 5.0);
        let eye = Isometry3::translation(2.0, 2.0, 1.4);
        let mut rng = generator(3, Stream::World);
        let still = camera.scan(&scene, &eye, &mut rng.clone());
        let moved = camera.scan(
            &scene.moved(&transformation),
            &(transformation * eye),
            &mut rng,
        );
        assert!(still.len() > 1000);
        assert_eq!(still.len(), moved.len());
        let agree = still
            .iter()
            .zip(&moved)
            .filter(|(a, b)| distance(a, b) < 1e-9)
            .count();
        // A ray that grazes an edge may fall on the other side of it by rounding.
        assert!(agree + 5 >= still.len(), "{agree} of {}", still.len());
    }

    #[test]
    fn depths_outside_the_range_and_dropped_pixels_are_left_out() {
        let mut rng = generator(2, Stream::World);
        let camera = DepthCamera::default();
        for z in [0.3, 4.6] {
            assert!(
                camera
                    .scan(&wall_at(z), &Isometry3::identity(), &mut rng)
                    .is_empty()
            );
        }
        let noise = DepthNoise {
            dropout: 0.25,
            ..DepthNoise::none()
        };
        let camera = DepthCamera { noise, ..camera };
        let kept = camera
            .scan(&wall_at(2.0), &Isometry3::identity(), &mut rng)
            .len() as f64;
        assert!((kept / (160.0 * 120.0) - 0.75).abs() < 0.02);
    }

    #[test]
    fn surfaces_at_grazing_angles_return_nothing() {
        let floor = Isometry3::rotation(Vector3::x() * std::f64::consts::FRAC_PI_2);
        let place = Isometry3::translation(0.0, 0.2, 0.0) * floor;
        let floor = Primitive::oriented_box(Vector3::new(20.0, 20.0, 0.0), place);
        let scene = Scene::new(vec![floor]);
        let mut rng = generator(2, Stream::World);
        let noise = DepthNoise {
            grazing_limit: 70.0_f64.to_radians(),
            ..DepthNoise::none()
        };
        let camera = DepthCamera {
            noise,
            ..DepthCamera::default()
        };
        let points = camera.scan(&scene, &Isometry3::identity(), &mut rng);
        assert!(!points.is_empty());
        assert!(
            points
                .iter()
                .all(|p| p.y / p.coords.norm() >= 70.0_f64.to_radians().cos())
        );
    }

    #[test]
    fn a_camera_without_pixels_sees_nothing() {
        let camera = DepthCamera {
            width: 0,
            ..DepthCamera::default()
        };
        let mut rng = generator(2, Stream::World);
        assert!(
            camera
                .scan(&wall_at(2.0), &Isometry3::identity(), &mut rng)
                .is_empty()
        );
    }

    #[test]
    fn framed_points_are_those_that_pixels_look_at() {
        let camera = DepthCamera::default();
        let corner = camera.direction((0.0, 0.0));
        assert!(camera.frames(&Point3::from(corner * 1.999)));
        assert!(!camera.frames(&Point3::from(corner * 5.0)));
        assert!(!camera.frames(&Point3::new(corner.x * 2.02, 0.0, 2.0)));
    }
}
