//! Where a cloud is, and how large.

use nalgebra::{Point3, Vector3};

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

/// The point of the median coordinates: the middle of a cloud that no outlier moves far.
///
/// The upper median of each axis; the origin where there are no points. `O(n)`.
pub(crate) fn median_point(points: &[Point3<f64>]) -> Point3<f64> {
    Vector3::from_fn(|axis, _| {
        let mut values: Vec<_> = points.iter().map(|point| point[axis]).collect();
        median(&mut values)
    })
    .into()
}

/// The upper median; 0 of nothing.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    match values.len() {
        0 => 0.0,
        n => *values.select_nth_unstable_by(n / 2, f64::total_cmp).1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_outlier_does_not_move_the_median_point() {
        let points = [[1.0, 5.0, 0.0], [2.0, 4.0, 0.0], [1e9, 3.0, 0.0]].map(Point3::from);
        assert_eq!(median_point(&points), Point3::new(2.0, 4.0, 0.0));
        assert_eq!(median_point(&[]), Point3::origin());
    }
}
