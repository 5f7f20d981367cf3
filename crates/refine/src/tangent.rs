//! Small transformations around a point: the coordinates in which equations are solved.

use nalgebra::{Isometry3, Matrix3, Matrix6, Translation3, UnitQuaternion, Vector3, Vector6};

/// Coordinates `η` of small transformations, well scaled for points around a center:
///
/// ```text
/// η = (v, s ω):   x ↦ c + exp(v, ω) (x − c)
/// ```
///
/// so that a unit of each coordinate moves points at the distance `s` from the center `c` by about a unit of
/// length. In them, results do not depend on where the origin of the frame is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tangent {
    pub center: Vector3<f64>,
    pub scale: f64,
}

impl Tangent {
    /// `ξ = A η`, where `exp(ξ)` is the same transformation about the origin of the frame.
    pub fn basis(&self) -> Matrix6<f64> {
        let mut basis = Matrix6::identity();
        let lever = self.center.cross_matrix() / self.scale;
        basis.fixed_view_mut::<3, 3>(0, 3).copy_from(&lever);
        let rotation = Matrix3::identity() / self.scale;
        basis.fixed_view_mut::<3, 3>(3, 3).copy_from(&rotation);
        basis
    }

    /// The transformation of coordinates `η`.
    pub fn transformation(&self, eta: &Vector6<f64>) -> Isometry3<f64> {
        let v = eta.fixed_rows::<3>(0).into_owned();
        let omega = eta.fixed_rows::<3>(3) / self.scale;
        let about_center = exp(&v, &omega);
        let there = Translation3::from(self.center);
        there * about_center * there.inverse()
    }
}

/// The exponential map of SE(3).
pub(crate) fn exp(v: &Vector3<f64>, omega: &Vector3<f64>) -> Isometry3<f64> {
    let (angle, cross) = (omega.norm(), omega.cross_matrix());
    let squared = angle * angle;
    // The closed form loses digits of small angles.
    let (first, second) = match angle < 1e-2 {
        true => (
            0.5 - squared / 24.0 * (1.0 - squared / 30.0),
            1.0 / 6.0 - squared / 120.0 * (1.0 - squared / 42.0),
        ),
        false => (
            (1.0 - angle.cos()) / squared,
            (angle - angle.sin()) / (squared * angle),
        ),
    };
    let left_jacobian = Matrix3::identity() + cross * first + cross * cross * second;
    let rotation = UnitQuaternion::from_scaled_axis(*omega);
    Isometry3::from_parts(Translation3::from(left_jacobian * v), rotation)
}

/// `T exp(ξ) = exp(Ad_T ξ) T`, translation first.
pub(crate) fn adjoint(transformation: &Isometry3<f64>) -> Matrix6<f64> {
    let rotation = transformation.rotation.to_rotation_matrix().into_inner();
    let mut adjoint = Matrix6::zeros();
    adjoint.fixed_view_mut::<3, 3>(0, 0).copy_from(&rotation);
    adjoint.fixed_view_mut::<3, 3>(3, 3).copy_from(&rotation);
    let lever = transformation.translation.vector.cross_matrix() * rotation;
    adjoint.fixed_view_mut::<3, 3>(0, 3).copy_from(&lever);
    adjoint
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn vector(limit: f64) -> impl Strategy<Value = Vector3<f64>> {
        prop::array::uniform3(-limit..limit).prop_map(Vector3::from)
    }

    fn exp6(xi: &Vector6<f64>) -> Isometry3<f64> {
        exp(&xi.fixed_rows::<3>(0).into(), &xi.fixed_rows::<3>(3).into())
    }

    fn distance(a: &Isometry3<f64>, b: &Isometry3<f64>) -> f64 {
        (a.to_matrix() - b.to_matrix()).norm()
    }

    proptest! {
        #[test]
        fn the_basis_leads_to_the_origin_of_the_frame(
            center in vector(3.0), scale in 0.1..10.0f64, v in vector(1.0), omega in vector(1.0),
        ) {
            let tangent = Tangent { center, scale };
            let eta = Vector6::from_iterator(v.iter().chain(&omega).copied());
            let expected = exp6(&(tangent.basis() * eta));
            prop_assert!(distance(&tangent.transformation(&eta), &expected) < 1e-10);
        }

        #[test]
        fn the_adjoint_leads_to_the_other_side(
            t in vector(3.0), r in vector(1.5), v in vector(1.0), omega in vector(1.0),
        ) {
            let transformation = Isometry3::new(t, r);
            let xi = Vector6::from_iterator(v.iter().chain(&omega).copied());
            let left = exp6(&(adjoint(&transformation) * xi)) * transformation;
            prop_assert!(distance(&left, &(transformation * exp6(&xi))) < 1e-12);
        }

        #[test]
        fn the_inverse_has_the_opposite_coordinates(v in vector(1.0), omega in vector(0.02)) {
            let product = exp(&v, &omega) * exp(&-v, &-omega);
            prop_assert!(distance(&product, &Isometry3::identity()) < 1e-13);
        }
    }
}
