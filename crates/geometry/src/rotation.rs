use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};

use crate::SignedSvd3;

/// Angle of a rotation in radians, in [0, π].
///
/// `atan2(‖skew part‖, (tr R − 1)/2)`: exact for small angles, where the arc cosine of the trace
/// loses half of the digits, and finite at 180°.
///
/// ```
/// use gmpcr_geometry::rotation_angle;
/// use nalgebra::{Rotation3, Vector3};
///
/// let tiny = Rotation3::new(Vector3::x() * 1e-9);
/// assert!((rotation_angle(&tiny) - 1e-9).abs() < 1e-20);
/// ```
pub fn rotation_angle(rotation: &Rotation3<f64>) -> f64 {
    let r = rotation.matrix();
    let skew = Vector3::new(
        r[(2, 1)] - r[(1, 2)],
        r[(0, 2)] - r[(2, 0)],
        r[(1, 0)] - r[(0, 1)],
    );
    (0.5 * skew.norm()).atan2(0.5 * (r.trace() - 1.0))
}

/// Angle in radians, in [0, π], of the rotation that leads from `a` to `b`: `d_R(a, b)`.
pub fn angular_distance(a: &Rotation3<f64>, b: &Rotation3<f64>) -> f64 {
    rotation_angle(&a.rotation_to(b))
}

/// The rotation that is nearest to `matrix` in the Frobenius norm.
///
/// `U diag(1, 1, det(U Vᵀ)) Vᵀ` of the singular value decomposition, which maximizes
/// `tr(Rᵀ M)` over SO(3). It is unique if the second singular value exceeds the third one's
/// reflection, `σ₂ + sign(det M) σ₃ > 0`; otherwise one of the nearest is returned.
pub fn nearest_rotation(matrix: &Matrix3<f64>) -> Rotation3<f64> {
    SignedSvd3::new(matrix).nearest_rotation()
}

/// The rigid transformation `x ↦ rotation · x + translation`.
pub fn isometry(rotation: &Rotation3<f64>, translation: &Vector3<f64>) -> Isometry3<f64> {
    Isometry3::from_parts(
        (*translation).into(),
        UnitQuaternion::from_rotation_matrix(rotation),
    )
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_angle_of_a_half_turn_is_pi() {
        for axis in [Vector3::x(), Vector3::y(), Vector3::new(0.6, 0.0, 0.8)] {
            let half_turn = Rotation3::new(axis * PI);
            assert!((rotation_angle(&half_turn) - PI).abs() < 1e-7);
        }
    }

    #[test]
    fn the_distance_of_a_rotation_to_itself_vanishes() {
        let r = Rotation3::new(Vector3::new(0.1, 2.0, -0.7));
        assert!(angular_distance(&r, &r) < 1e-15);
    }

    fn rotation_vector(max_angle: f64) -> impl Strategy<Value = Vector3<f64>> {
        (-1.0..1.0f64, 0.0..2.0 * PI, 1e-12..max_angle).prop_map(|(z, azimuth, angle)| {
            let r = (1.0 - z * z).sqrt();
            Vector3::new(r * azimuth.cos(), r * azimuth.sin(), z) * angle
        })
    }

    proptest! {
        #[test]
        fn the_angle_is_the_length_of_the_rotation_vector(v in rotation_vector(PI)) {
            let angle = rotation_angle(&Rotation3::new(v));
            prop_assert!((angle - v.norm()).abs() < 1e-14);
        }

        #[test]
        fn the_distance_is_symmetric_and_invariant(a in rotation_vector(PI), b in rotation_vector(PI), g in rotation_vector(PI)) {
            let [a, b, g] = [a, b, g].map(Rotation3::new);
            let d = angular_distance(&a, &b);
            prop_assert!((d - angular_distance(&b, &a)).abs() < 1e-14);
            prop_assert!((d - angular_distance(&(g * a), &(g * b))).abs() < 1e-13);
            prop_assert!((d - angular_distance(&(a * g), &(b * g))).abs() < 1e-13);
        }

        #[test]
        fn the_isometry_acts_as_its_parts(v in rotation_vector(PI), t in -1e3..1e3f64) {
            let (rotation, translation) = (Rotation3::new(v), Vector3::new(t, -t, 1.0));
            let x = nalgebra::Point3::new(1.0, -2.0, 0.5);
            let difference = isometry(&rotation, &translation) * x - (rotation * x + translation);
            prop_assert!(difference.norm() < 1e-12);
        }
    }
}
