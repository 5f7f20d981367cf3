//! How far a sensor saw in each direction.

use crate::rigid::minus;

/// Pixels of 3×3 that must be known for a depth to be stated.
const MIN_FILLED: usize = 5;

/// Depths around a viewpoint, as the six faces of a cube.
///
/// The depth of a direction is measured along the axis of its face, as a depth camera does. Each pixel has
/// the smallest depth of the raw points in its 3×3 neighborhood, where at least 5 of these 9 pixels hold
/// points; elsewhere it is unknown. The smallest, because a surface seen at an angle is nearer at one side of
/// a pixel than at the other.
#[derive(Clone, Debug)]
pub(crate) struct RangeImage {
    viewpoint: [f64; 3],
    inverse_pixel: f64,
    width: usize,
    /// Depths row by row, 0 where unknown; of a face without any, nothing. Faces +x, −x, +y, −y, +z, −z.
    faces: [Vec<f32>; 6],
}

/// Depth of a point and of what the sensor saw in its direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Depths {
    pub point: f64,
    pub seen: f64,
}

impl RangeImage {
    /// `pixel` is the tangent of a pixel's width; raw points nearer than `min_depth` are left out.
    pub fn new(
        viewpoint: [f64; 3],
        raw: impl Iterator<Item = [f64; 3]>,
        pixel: f64,
        min_depth: f64,
    ) -> Self {
        let width = (2.0 / pixel).ceil() as usize;
        let inverse_pixel = 1.0 / pixel;
        let mut raster = Raster {
            width: width + 2,
            inverse_pixel,
            reach: 1.0 + pixel,
            min_depth,
            faces: Default::default(),
        };
        for point in raw {
            raster.add(&minus(&point, &viewpoint));
        }
        Self {
            viewpoint,
            inverse_pixel,
            width,
            faces: raster.faces.map(|face| smallest_of_neighbors(&face, width)),
        }
    }

    /// `None` where the depth in the direction of `position` is not known.
    #[inline(always)]
    pub fn depths(&self, position: &[f64; 3]) -> Option<Depths> {
        let offset = minus(position, &self.viewpoint);
        let size = offset.map(f64::abs);
        let axis = match (size[2] >= size[1], size[2] >= size[0], size[1] >= size[0]) {
            (true, true, _) => 2,
            (false, _, true) => 1,
            _ => 0,
        };
        let face = &self.faces[face_number(axis, offset[axis])];
        let depth = size[axis];
        if face.is_empty() || depth <= 0.0 {
            return None;
        }
        let pixel = |other: usize| {
            let along = (offset[(axis + other) % 3] / depth + 1.0) * self.inverse_pixel;
            (along as usize).min(self.width - 1)
        };
        let seen = f64::from(face[pixel(2) * self.width + pixel(1)]);
        (seen > 0.0).then_some(Depths { point: depth, seen })
    }
}

#[inline(always)]
fn face_number(axis: usize, along: f64) -> usize {
    2 * axis + usize::from(along < 0.0)
}

/// The smallest depths of raw points, with a margin of one pixel around each face.
struct Raster {
    width: usize,
    inverse_pixel: f64,
    /// Tangent up to which a face reaches, the margin included.
    reach: f64,
    min_depth: f64,
    faces: [Vec<f32>; 6],
}

impl Raster {
    fn add(&mut self, offset: &[f64; 3]) {
        for axis in 0..3 {
            let depth = offset[axis].abs();
            let (right, up) = (offset[(axis + 1) % 3], offset[(axis + 2) % 3]);
            let limit = depth * self.reach;
            if depth < self.min_depth || right.abs() >= limit || up.abs() >= limit {
                continue;
            }
            let face = &mut self.faces[face_number(axis, offset[axis])];
            if face.is_empty() {
                face.resize(self.width * self.width, f32::INFINITY);
            }
            let pixel = |along: f64| {
                let place = (along / depth + self.reach) * self.inverse_pixel;
                (place as usize).min(self.width - 1)
            };
            let smallest = &mut face[pixel(up) * self.width + pixel(right)];
            *smallest = smallest.min(depth as f32);
        }
    }
}

/// The smallest depth of each pixel's neighborhood, 0 where too little of it is known.
fn smallest_of_neighbors(raster: &[f32], width: usize) -> Vec<f32> {
    if raster.is_empty() {
        return Vec::new();
    }
    let mut face = vec![0.0; width * width];
    for row in 0..width {
        for column in 0..width {
            let (mut filled, mut smallest) = (0, f32::INFINITY);
            for line in row..row + 3 {
                let start = line * (width + 2) + column;
                for &depth in &raster[start..start + 3] {
                    filled += usize::from(depth.is_finite());
                    smallest = smallest.min(depth);
                }
            }
            if filled >= MIN_FILLED {
                face[row * width + column] = smallest;
            }
        }
    }
    face
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Points on a sphere around the viewpoint, evenly enough to fill all pixels.
    fn sphere(center: [f64; 3], radius: f64) -> Vec<[f64; 3]> {
        let count = 300_000;
        let point = |k: usize| {
            let z = 1.0 - (2 * k + 1) as f64 / count as f64;
            let (r, azimuth) = ((1.0 - z * z).sqrt(), k as f64 * 2.399_963_229_728_653);
            [r * azimuth.cos(), r * azimuth.sin(), z]
        };
        let moved = |p: [f64; 3]| [0, 1, 2].map(|k| center[k] + radius * p[k]);
        (0..count).map(|k| moved(point(k))).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(8))]
        #[test]
        fn a_sphere_is_seen_in_all_directions(direction in prop::array::uniform3(-1.0..1.0f64)) {
            let center = [1.0, -2.0, 0.5];
            let image = RangeImage::new(center, sphere(center, 2.0).into_iter(), 0.025, 0.2);
            let length = direction.iter().map(|c| c * c).sum::<f64>().sqrt();
            let position = [0, 1, 2].map(|k| center[k] + direction[k] / length);
            let depths = image.depths(&position).unwrap();
            // The nearest of the neighborhood: two pixels further outwards at most.
            prop_assert!((depths.seen / depths.point - 2.0).abs() < 0.1, "{depths:?}");
            prop_assert!(depths.seen / depths.point <= 2.0 + 1e-6);
        }
    }

    #[test]
    fn directions_without_enough_points_are_unknown() {
        let wall = (0..160_000).map(|k| {
            [
                f64::from(k % 400) * 0.005 - 1.0,
                f64::from(k / 400) * 0.005 - 1.0,
                2.0,
            ]
        });
        let image = RangeImage::new([0.0; 3], wall, 0.025, 0.2);
        let seen = |position| image.depths(&position).map(|depths| depths.seen);
        assert_eq!(seen([0.0, 0.0, 1.0]), Some(2.0));
        assert_eq!(seen([0.4, 0.4, 1.0]), Some(2.0));
        assert_eq!(seen([0.6, 0.0, 1.0]), None);
        assert_eq!(seen([0.0, 0.0, -1.0]), None);
        assert_eq!(seen([0.0, 0.0, 0.0]), None);
        assert_eq!(seen([f64::NAN, 0.0, 1.0]), None);
    }
}
