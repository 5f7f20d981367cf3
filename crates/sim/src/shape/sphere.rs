//! A ball.

use nalgebra::Vector3;

use super::{LocalHit, first_ahead};

/// Roots of `|origin + t · direction|² = radius²`.
pub(super) fn intersect(
    radius: f64,
    origin: &Vector3<f64>,
    direction: &Vector3<f64>,
) -> Option<LocalHit> {
    let middle = -origin.dot(direction);
    let closest = origin + middle * direction;
    let half_chord_squared = radius * radius - closest.norm_squared();
    if half_chord_squared < 0.0 {
        return None;
    }
    let half_chord = half_chord_squared.sqrt();
    let distance = first_ahead(middle - half_chord, middle + half_chord)?;
    Some(LocalHit {
        distance,
        normal: (origin + distance * direction) / radius,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_through_the_center_meets_the_near_side() {
        let hit = intersect(0.5, &Vector3::new(0.0, 0.0, -3.0), &Vector3::z()).unwrap();
        assert_eq!(hit.distance, 2.5);
        assert_eq!(hit.normal, -Vector3::z());
    }

    #[test]
    fn a_ray_from_the_center_meets_the_surface_one_radius_away() {
        let hit = intersect(0.5, &Vector3::zeros(), &Vector3::x()).unwrap();
        assert_eq!(hit.distance, 0.5);
    }

    #[test]
    fn a_ray_that_passes_beside_or_heads_away_meets_nothing() {
        assert!(intersect(0.5, &Vector3::new(0.6, 0.0, -3.0), &Vector3::z()).is_none());
        assert!(intersect(0.5, &Vector3::new(0.0, 0.0, 3.0), &Vector3::z()).is_none());
    }
}
