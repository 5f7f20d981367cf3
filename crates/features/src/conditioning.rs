//! What raw clouds need before features are computed: no stray points, and coordinates of few digits.

use nalgebra::{Isometry3, Point3, Translation3, Vector3};

/// Distance from zero, in sizes of the cloud, beyond which a cloud is georeferenced.
const REMOTE: f64 = 1000.0;

/// Distance from the median point, in voxel sizes, beyond which a point is astray.
const STRAY: f64 = 1e6;

/// The point of the median coordinates: the middle of a cloud that no outlier moves far.
///
/// The upper median of each axis; the origin where there are no points. `O(n)`.
///
/// ```
/// use gmpcr_features::median_point;
/// use nalgebra::Point3;
///
/// let points = [[1.0, 5.0, 0.0], [2.0, 4.0, 0.0], [1e9, 3.0, 0.0]].map(Point3::from);
/// assert_eq!(median_point(&points), Point3::new(2.0, 4.0, 0.0));
/// ```
pub fn median_point(points: &[Point3<f64>]) -> Point3<f64> {
    Vector3::from_fn(|axis, _| {
        let mut values: Vec<_> = points.iter().map(|point| point[axis]).collect();
        median(&mut values)
    })
    .into()
}

/// Removes the points that are a million voxel sizes or more from the [median point](median_point), and
/// those that are not finite. Returns how many.
///
/// Some sensors write a huge number where nothing returned. Such a point makes the extent of a cloud so
/// large that [`voxel_grid`](crate::voxel_grid) refuses it. `O(n)`.
///
/// ```
/// use gmpcr_features::remove_stray_points;
/// use nalgebra::Point3;
///
/// let mut points = [0.0, 1.0, 2.0, f64::from(f32::MAX)].map(|x| Point3::new(x, 0.0, 0.0)).to_vec();
/// assert_eq!(remove_stray_points(&mut points, 0.05), 1);
/// assert_eq!(points.len(), 3);
/// ```
pub fn remove_stray_points(points: &mut Vec<Point3<f64>>, voxel_size: f64) -> usize {
    let before = points.len();
    let center = median_point(points);
    points.retain(|point| (point - center).norm() < STRAY * voxel_size);
    before - points.len()
}

/// Size of the box around the points, along each axis; zero of no points.
///
/// ```
/// use gmpcr_features::extent;
/// use nalgebra::{Point3, Vector3};
///
/// let points = [Point3::new(1.0, 2.0, 3.0), Point3::new(-1.0, 2.5, 3.0)];
/// assert_eq!(extent(&points), Vector3::new(2.0, 0.5, 0.0));
/// ```
pub fn extent(points: &[Point3<f64>]) -> Vector3<f64> {
    let coordinates = || points.iter().map(|point| point.coords);
    let min = coordinates().reduce(|a, b| a.inf(&b)).unwrap_or_default();
    let max = coordinates().reduce(|a, b| a.sup(&b)).unwrap_or_default();
    max - min
}

/// How far a cloud is from zero, relative to its size: the distance of its [median point](median_point)
/// from zero, divided by the median distance of its points from there.
///
/// About one where the sensor is at zero, and a thousand and more of georeferenced clouds. `O(n)`.
///
/// ```
/// use gmpcr_features::remoteness;
/// use nalgebra::Point3;
///
/// let at = |x: f64| Point3::new(x, 0.0, 0.0);
/// assert_eq!(remoteness(&[at(98.0), at(100.0), at(102.0)]), 50.0);
/// ```
pub fn remoteness(points: &[Point3<f64>]) -> f64 {
    let center = median_point(points);
    let mut distances: Vec<_> = points.iter().map(|point| (point - center).norm()).collect();
    center.coords.norm() / median(&mut distances).max(f64::MIN_POSITIVE)
}

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
/// is a thousand times as [remote](remoteness) from zero as they are large. Returns whether it did.
///
/// Clouds without points have no say. Then *all* clouds are shifted: each to its own
/// [median point](median_point). A known viewpoint moves with the points. One at zero is not known:
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

/// The upper median; 0 of nothing.
fn median(values: &mut [f64]) -> f64 {
    match values.len() {
        0 => 0.0,
        n => *values.select_nth_unstable_by(n / 2, f64::total_cmp).1,
    }
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
        assert_eq!(median_point(&[]), Point3::origin());
        assert_eq!(remove_stray_points(&mut Vec::new(), 1.0), 0);
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
    fn points_a_million_voxels_away_are_astray() {
        let mut points = cube([0.0; 3]);
        let at = |x: f64| Point3::new(5.0 + x, 5.0, 5.0);
        points.extend([at(0.99e6), at(1.01e6), at(f64::NAN)]);
        assert_eq!(remove_stray_points(&mut points, 1.0), 2);
        assert_eq!(points.len(), 9);
    }

    #[test]
    fn a_point_alone_is_infinitely_remote_unless_it_is_at_zero() {
        assert_eq!(remoteness(&[Point3::origin()]), 0.0);
        assert!(remoteness(&[Point3::new(1.0, 0.0, 0.0)]) > 1e300);
    }
}
