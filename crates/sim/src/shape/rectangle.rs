//! A flat rectangle in the plane z = 0.

use nalgebra::{Vector2, Vector3};

use super::LocalHit;

pub(super) fn intersect(
    half: &Vector2<f64>,
    origin: &Vector3<f64>,
    direction: &Vector3<f64>,
) -> Option<LocalHit> {
    let distance = -origin.z / direction.z;
    let point = origin.xy() + distance * direction.xy();
    let inside = point.x.abs() <= half.x && point.y.abs() <= half.y;
    // A ray inside the plane divides by zero; the comparisons then leave it out.
    (distance >= 0.0 && distance.is_finite() && inside).then_some(LocalHit {
        distance,
        normal: Vector3::z(),
    })
}

pub(super) fn distance(half: &Vector2<f64>, point: &Vector3<f64>) -> f64 {
    let beyond = (point.xy().abs() - half).map(|x| x.max(0.0));
    beyond.push(point.z).norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    const HALF: Vector2<f64> = Vector2::new(1.0, 2.0);

    #[test]
    fn a_ray_meets_the_plane_from_either_side() {
        let above = intersect(&HALF, &Vector3::new(0.5, 1.5, 3.0), &-Vector3::z()).unwrap();
        let below = intersect(&HALF, &Vector3::new(0.5, 1.5, -2.0), &Vector3::z()).unwrap();
        assert_eq!((above.distance, below.distance), (3.0, 2.0));
    }

    #[test]
    fn a_ray_beside_away_or_inside_the_plane_meets_nothing() {
        assert!(intersect(&HALF, &Vector3::new(1.5, 0.0, 3.0), &-Vector3::z()).is_none());
        assert!(intersect(&HALF, &Vector3::new(0.0, 0.0, 3.0), &Vector3::z()).is_none());
        assert!(intersect(&HALF, &Vector3::new(-3.0, 0.0, 0.0), &Vector3::x()).is_none());
        assert!(intersect(&HALF, &Vector3::new(-3.0, 0.0, 1.0), &Vector3::x()).is_none());
    }

    #[test]
    fn distance_is_euclidean_to_the_edge() {
        assert_eq!(distance(&HALF, &Vector3::new(4.0, 0.0, 4.0)), 5.0);
        assert_eq!(distance(&HALF, &Vector3::new(0.0, 0.0, -4.0)), 4.0);
    }
}
