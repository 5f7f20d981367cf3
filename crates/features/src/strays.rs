use nalgebra::Point3;

use crate::middle::median_point;

/// Distance from the median point, in voxel sizes, beyond which a point is astray.
const STRAY: f64 = 1e6;

/// Removes the points that are a million voxel sizes or more from the point of the median coordinates, and
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_a_million_voxels_away_are_astray() {
        let at = |x: f64| Point3::new(5.0 + x, 5.0, 5.0);
        let mut points: Vec<_> = (0..8).map(|k| at(f64::from(k % 2))).collect();
        points.extend([at(0.99e6), at(1.01e6), at(f64::NAN)]);
        assert_eq!(remove_stray_points(&mut points, 1.0), 2);
        assert_eq!(points.len(), 9);
        assert_eq!(remove_stray_points(&mut Vec::new(), 1.0), 0);
    }
}
