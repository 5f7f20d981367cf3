//! A capped cylinder about the z axis.

use nalgebra::{Vector2, Vector3};

use super::{LocalHit, first_ahead};

/// The nearer of mantle and caps.
pub(super) fn intersect(
    radius: f64,
    half_height: f64,
    origin: &Vector3<f64>,
    direction: &Vector3<f64>,
) -> Option<LocalHit> {
    let mantle = mantle_hit(radius, half_height, origin, direction);
    let cap = cap_hit(radius, half_height, origin, direction);
    match (mantle, cap) {
        (Some(a), Some(b)) => Some(if a.distance <= b.distance { a } else { b }),
        (a, b) => a.or(b),
    }
}

/// Roots of `|(origin + t · direction).xy|² = radius²` between the caps.
fn mantle_hit(
    radius: f64,
    half_height: f64,
    origin: &Vector3<f64>,
    direction: &Vector3<f64>,
) -> Option<LocalHit> {
    let a = direction.xy().norm_squared();
    if a == 0.0 {
        return None;
    }
    let middle = -origin.xy().dot(&direction.xy()) / a;
    let closest = origin.xy() + middle * direction.xy();
    let half_chord_squared = (radius * radius - closest.norm_squared()) / a;
    if half_chord_squared < 0.0 {
        return None;
    }
    let half_chord = half_chord_squared.sqrt();
    let between_caps = |distance: f64| (origin.z + distance * direction.z).abs() <= half_height;
    [middle - half_chord, middle + half_chord]
        .into_iter()
        .find(|&distance| distance >= 0.0 && between_caps(distance))
        .map(|distance| {
            let outwards = (origin + distance * direction).xy() / radius;
            LocalHit {
                distance,
                normal: outwards.push(0.0),
            }
        })
}

fn cap_hit(
    radius: f64,
    half_height: f64,
    origin: &Vector3<f64>,
    direction: &Vector3<f64>,
) -> Option<LocalHit> {
    if direction.z == 0.0 {
        return None;
    }
    let on_disc = |distance: f64| {
        let point: Vector2<f64> = origin.xy() + distance * direction.xy();
        (distance >= 0.0 && point.norm_squared() <= radius * radius).then_some(distance)
    };
    let (a, b) = (
        (-half_height - origin.z) / direction.z,
        (half_height - origin.z) / direction.z,
    );
    let near = on_disc(a.min(b)).unwrap_or(-1.0);
    let far = on_disc(a.max(b)).unwrap_or(-1.0);
    let distance = first_ahead(near, far)?;
    Some(LocalHit {
        distance,
        normal: Vector3::z(),
    })
}

pub(super) fn signed_distance(radius: f64, half_height: f64, point: &Vector3<f64>) -> f64 {
    let beyond = Vector2::new(point.xy().norm() - radius, point.z.abs() - half_height);
    beyond.map(|x| x.max(0.0)).norm() + beyond.max().min(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_ray_meets_the_mantle() {
        let hit = intersect(0.5, 1.0, &Vector3::new(-2.0, 0.0, 0.9), &Vector3::x()).unwrap();
        assert_eq!(hit.distance, 1.5);
        assert_eq!(hit.normal, -Vector3::x());
    }

    #[test]
    fn a_ray_along_the_axis_meets_the_cap() {
        let hit = intersect(0.5, 1.0, &Vector3::new(0.1, 0.2, 4.0), &-Vector3::z()).unwrap();
        assert_eq!(hit.distance, 3.0);
    }

    #[test]
    fn a_ray_from_inside_meets_the_cap_or_the_mantle() {
        let up = intersect(0.5, 1.0, &Vector3::zeros(), &Vector3::z()).unwrap();
        let aside = intersect(0.5, 1.0, &Vector3::zeros(), &Vector3::y()).unwrap();
        assert_eq!((up.distance, aside.distance), (1.0, 0.5));
    }

    #[test]
    fn a_ray_above_the_cap_or_beside_the_mantle_meets_nothing() {
        assert!(intersect(0.5, 1.0, &Vector3::new(-2.0, 0.0, 1.1), &Vector3::x()).is_none());
        assert!(intersect(0.5, 1.0, &Vector3::new(0.6, 0.0, 4.0), &-Vector3::z()).is_none());
    }

    #[test]
    fn signed_distance_is_negative_inside_and_euclidean_at_the_rim() {
        assert_eq!(signed_distance(0.5, 1.0, &Vector3::zeros()), -0.5);
        assert_eq!(signed_distance(1.0, 1.0, &Vector3::new(4.0, 0.0, 5.0)), 5.0);
    }
}
