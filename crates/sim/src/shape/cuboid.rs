//! A box with faces across the axes.

use nalgebra::Vector3;

use super::LocalHit;

/// Slab method (Kay and Kajiya, SIGGRAPH 1986): the ray is inside the box between the last
/// entry into and the first exit out of the three pairs of parallel planes.
pub(super) fn intersect(
    half: &Vector3<f64>,
    origin: &Vector3<f64>,
    direction: &Vector3<f64>,
) -> Option<LocalHit> {
    let (mut enter, mut enter_axis) = (f64::NEG_INFINITY, 0);
    let (mut exit, mut exit_axis) = (f64::INFINITY, 0);
    for axis in 0..3 {
        let (near, far) = slab(half[axis], origin[axis], direction[axis])?;
        if near > enter {
            (enter, enter_axis) = (near, axis);
        }
        if far < exit {
            (exit, exit_axis) = (far, axis);
        }
    }
    if enter > exit || exit < 0.0 {
        return None;
    }
    let (distance, axis) = if enter >= 0.0 {
        (enter, enter_axis)
    } else {
        (exit, exit_axis)
    };
    Some(LocalHit {
        distance,
        normal: Vector3::ith(axis, -direction[axis].signum()),
    })
}

/// Entry and exit of the slab `|x| ≤ half`; `None` for a parallel ray outside.
fn slab(half: f64, origin: f64, direction: f64) -> Option<(f64, f64)> {
    if direction == 0.0 {
        return (origin.abs() <= half).then_some((f64::NEG_INFINITY, f64::INFINITY));
    }
    let (a, b) = ((-half - origin) / direction, (half - origin) / direction);
    Some(if a <= b { (a, b) } else { (b, a) })
}

pub(super) fn signed_distance(half: &Vector3<f64>, point: &Vector3<f64>) -> f64 {
    let beyond = point.abs() - half;
    beyond.map(|x| x.max(0.0)).norm() + beyond.max().min(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HALF: Vector3<f64> = Vector3::new(1.0, 2.0, 3.0);

    #[test]
    fn a_ray_along_x_meets_the_face_across_x() {
        let hit = intersect(&HALF, &Vector3::new(-5.0, 0.5, 0.5), &Vector3::x()).unwrap();
        assert_eq!(hit.distance, 4.0);
        assert_eq!(hit.normal, -Vector3::x());
    }

    #[test]
    fn a_ray_from_inside_meets_the_far_face() {
        let hit = intersect(&HALF, &Vector3::zeros(), &Vector3::y()).unwrap();
        assert_eq!(hit.distance, 2.0);
    }

    #[test]
    fn a_ray_that_passes_beside_or_heads_away_meets_nothing() {
        assert!(intersect(&HALF, &Vector3::new(-5.0, 2.5, 0.0), &Vector3::x()).is_none());
        assert!(intersect(&HALF, &Vector3::new(5.0, 0.0, 0.0), &Vector3::x()).is_none());
    }

    #[test]
    fn signed_distance_is_negative_inside_and_euclidean_at_corners() {
        assert_eq!(signed_distance(&HALF, &Vector3::zeros()), -1.0);
        assert_eq!(signed_distance(&HALF, &Vector3::new(4.0, 6.0, 0.0)), 5.0);
    }
}
