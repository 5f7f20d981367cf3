use nalgebra::{Isometry3, Point3, Translation3, Vector3};

use crate::middle::{median, median_point};

/// Distance from zero, in sizes of the cloud, beyond which a cloud is georeferenced.
const REMOTE: f64 = 1000.0;

/// A cloud whose coordinates are counted from an origin of its own.
///
/// Numbers of seven digits before the point, as of georeferenced clouds, have none left behind it in single
/// precision, and rotations about zero move such points far. So [`localize_georeferenced`] shifts them
/// to their median point, and [`original_from_local`](Self::original_from_local) leads back.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct LocalCloud {
    /// The original points less the origin.
    pub points: Vec<Point3<f64>>,
    /// Where the coordinates are counted from, in the original frame: zero for a cloud that was not shifted.
    pub origin: Vector3<f64>,
    /// Where the sensor is taken to be, to orient normals, in the frame of `points`.
    pub viewpoint: Point3<f64>,
}

impl LocalCloud {
    /// A cloud in its original frame, with the origin zero.
    ///
    /// A viewpoint that is not known is taken to be zero, where the sensor of a scan usually is.
    pub fn new(points: Vec<Point3<f64>>, viewpoint: Option<Point3<f64>>) -> Self {
        Self {
            points,
            origin: Vector3::zeros(),
            viewpoint: viewpoint.unwrap_or_else(Point3::origin),
        }
    }

    /// The translation by the origin: from the frame of `points` to the original one.
    pub fn original_from_local(&self) -> Isometry3<f64> {
        Translation3::from(self.origin).into()
    }

    /// Counts coordinates from the median point.
    fn localize(&mut self) {
        self.origin = median_point(&self.points).coords;
        for point in &mut self.points {
            *point -= self.origin;
        }
        self.viewpoint = match self.viewpoint == Point3::origin() {
            true => Point3::from(Vector3::new(0.3, 0.5, 0.8) * self.origin.norm()),
            false => self.viewpoint - self.origin,
        };
    }
}

/// Shifts clouds in their original frame to origins of their own if most of them are georeferenced, that
/// is a thousand times as remote from zero as they are large. Returns whether it did.
///
/// Clouds without points have no say. Then *all* clouds are shifted: each to its own
/// median point. A known viewpoint moves with the points. One at zero is not known:
/// georeferenced files do not tell where the sensor stood, and zero is no guess. But such clouds have their
/// axes in common. So a viewpoint far above and to a side that is no wall's, at `(0.3, 0.5, 0.8) ‖origin‖`
/// from the origin, gives a surface the same normals in all of them.
///
/// ```
/// use gmpcr_features::{LocalCloud, localize_georeferenced};
/// use nalgebra::Point3;
///
/// let corner = Point3::new(448_262.0, 5_411_932.0, 120.0);
/// let points: Vec<_> = (0..8).map(|k| corner + Point3::new((k & 1) as f64, (k & 2) as f64, 0.0).coords).collect();
/// let mut clouds = [LocalCloud::new(points.clone(), None)];
/// assert!(localize_georeferenced(&mut clouds));
/// assert!(clouds[0].points.iter().all(|point| point.coords.norm() < 3.0));
/// assert_eq!(clouds[0].original_from_local() * clouds[0].points[5], points[5]);
/// ```
pub fn localize_georeferenced<'a>(clouds: impl IntoIterator<Item = &'a mut LocalCloud>) -> bool {
    let clouds: Vec<_> = clouds.into_iter().collect();
    let filled = || clouds.iter().filter(|cloud| !cloud.points.is_empty());
    let num_remote = filled()
        .filter(|cloud| remoteness(&cloud.points) > REMOTE)
        .count();
    let are_remote = 2 * num_remote > filled().count();
    if are_remote {
        clouds.into_iter().for_each(LocalCloud::localize);
    }
    are_remote
}

/// How far a cloud is from zero, relative to its size: the distance of its median point
/// from zero, divided by the median distance of its points from there.
///
/// About one where the sensor is at zero, and a thousand and more of georeferenced clouds. `O(n)`.
fn remoteness(points: &[Point3<f64>]) -> f64 {
    let center = median_point(points);
    let mut distances: Vec<_> = points.iter().map(|point| (point - center).norm()).collect();
    center.coords.norm() / median(&mut distances).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    const UTM: [f64; 3] = [448_262.0, 5_411_932.0, 120.0];

    /// The corners of a cube of 5 m.
    fn cube(corner: [f64; 3]) -> Vec<Point3<f64>> {
        let place = |k: usize| Vector3::from_fn(|axis, _| ((k >> axis) & 1) as f64 * 5.0);
        (0..8).map(|k| Point3::from(corner) + place(k)).collect()
    }

    fn cloud(corner: [f64; 3]) -> LocalCloud {
        LocalCloud::new(cube(corner), None)
    }

    #[test]
    fn georeferenced_clouds_are_counted_from_an_origin_of_their_own() {
        let mut clouds = [cloud(UTM), cloud([448_300.0, 5_411_932.0, 120.0])];
        assert!(localize_georeferenced(&mut clouds));
        let near = |point: &Point3<f64>| point.coords.norm() < 10.0;
        assert!(clouds.iter().all(|cloud| cloud.points.iter().all(near)));
        assert_ne!(clouds[0].origin, clouds[1].origin);
        let back = clouds[0].original_from_local() * clouds[0].points[7];
        assert_eq!(back, cube(UTM)[7]);
    }

    #[test]
    fn one_remote_cloud_among_others_changes_nothing() {
        let mut clouds = [cloud([3.0, 0.0, 40.0]), cloud([0.0; 3]), cloud(UTM)];
        let before = clouds.clone();
        assert!(!localize_georeferenced(&mut clouds));
        assert_eq!(clouds, before);
        assert!(!localize_georeferenced(&mut []));
    }

    #[test]
    fn clouds_without_points_have_no_say_and_a_median_point_at_zero() {
        let mut clouds = [cloud(UTM), LocalCloud::default(), LocalCloud::default()];
        assert!(localize_georeferenced(&mut clouds));
        assert_eq!(clouds[1].origin, Vector3::zeros());
    }

    #[test]
    fn a_known_viewpoint_moves_with_the_points_and_another_is_far_above() {
        let viewpoint = Some(cube(UTM)[0]);
        let mut clouds = [LocalCloud::new(cube(UTM), viewpoint), cloud(UTM)];
        localize_georeferenced(&mut clouds);
        assert_eq!(clouds[0].viewpoint, clouds[0].points[0]);
        assert!(clouds[1].viewpoint.z > 1e6);
    }

    #[test]
    fn a_point_alone_is_infinitely_remote_unless_it_is_at_zero() {
        assert_eq!(remoteness(&[Point3::origin()]), 0.0);
        assert!(remoteness(&[Point3::new(1.0, 0.0, 0.0)]) > 1e300);
    }
}
