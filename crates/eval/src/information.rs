//! How far a wrong relative pose moves the overlapping points.

use nalgebra::{Isometry3, Matrix3, Matrix6, Point3, Vector6};

/// Information matrix of a pair from its overlapping points, as in the `gt.info` files.
///
/// `Ω = Σ_p GᵀG` with `G = [I | −[p]×]`, where `[p]×` is the matrix of the cross product with p
/// (Choi, Zhou, Koltun: Robust reconstruction of indoor scenes, CVPR 2015). A motion that shifts
/// by t and turns by a small rotation vector θ moves p by `t + θ × p = G · (t, θ)`, so
/// `(t, θ)ᵀ Ω (t, θ)` sums the squared displacements, and `Ω₀₀` counts the points.
///
/// The official files sum over points of scan i, in its frame, that have a neighbour in scan j
/// under the true motion. No points give a matrix of zeros, which no pair can be judged with.
///
/// ```
/// use gmpcr_eval::information_matrix;
/// use nalgebra::{Point3, Vector3, Vector6};
///
/// let information = information_matrix(&[Point3::new(1.0, 2.0, 3.0)]);
/// let shift_and_turn = Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.1);
/// let moved: Vector3<f64> = Vector3::z().cross(&Vector3::new(1.0, 2.0, 3.0)) * 0.1;
/// let squared = shift_and_turn.dot(&(information * shift_and_turn));
/// assert!((squared - moved.norm_squared()).abs() < 1e-12);
/// ```
#[must_use]
pub fn information_matrix(points_in_i: &[Point3<f64>]) -> Matrix6<f64> {
    points_in_i.iter().map(information_of_point).sum()
}

fn information_of_point(point: &Point3<f64>) -> Matrix6<f64> {
    let turn = -point.coords.cross_matrix();
    let mut information = Matrix6::identity();
    information.fixed_view_mut::<3, 3>(0, 3).copy_from(&turn);
    information
        .fixed_view_mut::<3, 3>(3, 0)
        .copy_from(&turn.transpose());
    let squared: Matrix3<f64> = turn.transpose() * turn;
    information.fixed_view_mut::<3, 3>(3, 3).copy_from(&squared);
    information
}

/// Squared error of a relative pose as the 3DMatch benchmark counts it, in m².
///
/// `eᵀ Ω e / Ω₀₀` with e = (translation, ±q) of `true_i_from_j⁻¹ · estimated_i_from_j`, where
/// q = sin(θ/2) · axis is the vector part of the unit quaternion with w ≥ 0, and the sign is that of
/// [`RotationSign`]. With `+` and the rotation vector in the place of q this would be the mean
/// squared displacement of the overlapping points; q is half as long, and so a rotation counts half.
///
/// Source: `mrEvaluateRegistration.m` of Choi, Zhou, Koltun (CVPR 2015), which 3DMatch took over
/// (Zeng et al., CVPR 2017).
///
/// `None` where `Ω₀₀` is not positive: without overlapping points there is nothing to judge by.
///
/// ```
/// use gmpcr_eval::{RotationSign, registration_error};
/// use nalgebra::{Isometry3, Matrix6};
///
/// let off = Isometry3::translation(0.3, 0.0, 0.4);
/// let (here, sign) = (Isometry3::identity(), RotationSign::Benchmark);
/// let error = registration_error(&off, &here, &(7.0 * Matrix6::identity()), sign);
/// assert!(error.is_some_and(|error| (error - 0.25).abs() < 1e-12));
/// assert_eq!(registration_error(&off, &off, &Matrix6::zeros(), sign), None);
/// ```
#[must_use]
pub fn registration_error(
    estimated_i_from_j: &Isometry3<f64>,
    true_i_from_j: &Isometry3<f64>,
    information: &Matrix6<f64>,
    sign: RotationSign,
) -> Option<f64> {
    let num_points = information.m11;
    if num_points.is_nan() || num_points <= 0.0 {
        return None;
    }
    let e = deviation(&true_i_from_j.inv_mul(estimated_i_from_j), sign);
    Some(e.dot(&(information * e)) / num_points)
}

/// Sign of the rotation in the error vector of [`registration_error`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum RotationSign {
    /// `+q`, as the benchmark computes it. Its program writes `−qt(2:4)`, but its `dcm2quat` returns
    /// the conjugate of the usual quaternion, `qt(2) = −(R₃₂ − R₂₃) / (4 w)`: both minus signs
    /// cancel, as the signs in [`information_matrix`] require, and ports to other languages with an
    /// ordinary quaternion have a plus.
    #[default]
    Benchmark,
    /// `−q`, the letter of that program read with an ordinary quaternion. A rotation then counts
    /// with the wrong lever, and recalls come out lower. For comparison with figures computed so.
    Conjugate,
}

/// (translation, ± vector part of the unit quaternion with w ≥ 0).
fn deviation(motion: &Isometry3<f64>, sign: RotationSign) -> Vector6<f64> {
    let shift = motion.translation.vector;
    let quaternion = motion.rotation.quaternion();
    let is_flipped = (quaternion.w < 0.0) != (sign == RotationSign::Conjugate);
    let factor = if is_flipped { -1.0 } else { 1.0 };
    let turn = quaternion.imag() * factor;
    Vector6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::{Quaternion, UnitQuaternion, Vector3};

    const SIGN: RotationSign = RotationSign::Benchmark;

    #[test]
    fn a_point_gives_the_rows_that_the_official_files_show() {
        let information = information_matrix(&[Point3::new(1.0, 2.0, 3.0)]);
        let expected = Matrix6::from_row_slice(&[
            1.0, 0.0, 0.0, 0.0, 3.0, -2.0, //
            0.0, 1.0, 0.0, -3.0, 0.0, 1.0, //
            0.0, 0.0, 1.0, 2.0, -1.0, 0.0, //
            0.0, -3.0, 2.0, 13.0, -2.0, -3.0, //
            3.0, 0.0, -1.0, -2.0, 10.0, -6.0, //
            -2.0, 1.0, 0.0, -3.0, -6.0, 5.0,
        ]);
        assert_eq!(information, expected);
    }

    #[test]
    fn small_motions_cost_the_squared_displacements_of_the_points() {
        let points = [(0.5, -1.0, 2.0), (1.5, 0.3, 2.5), (-0.7, 0.1, 3.0)]
            .map(|(x, y, z)| Point3::new(x, y, z));
        let (shift, turn) = (
            Vector3::new(1e-3, -2e-3, 5e-4),
            Vector3::new(-1e-3, 3e-3, 2e-3),
        );
        let moved: f64 = points
            .iter()
            .map(|p| (shift + turn.cross(&p.coords)).norm_squared())
            .sum();
        let e = Vector6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z);
        assert_relative_eq!(
            e.dot(&(information_matrix(&points) * e)),
            moved,
            max_relative = 1e-12
        );
    }

    /// `mrComputeTransformationError` of the benchmark, line by line.
    fn benchmark_error(motion: &Isometry3<f64>, information: &Matrix6<f64>) -> f64 {
        let (t, r) = (
            motion.translation.vector,
            motion.rotation.to_rotation_matrix(),
        );
        let qt_1 = 0.5 * (1.0 + r[(0, 0)] + r[(1, 1)] + r[(2, 2)]).sqrt();
        let qt_2 = -(r[(2, 1)] - r[(1, 2)]) / (4.0 * qt_1);
        let qt_3 = -(r[(0, 2)] - r[(2, 0)]) / (4.0 * qt_1);
        let qt_4 = -(r[(1, 0)] - r[(0, 1)]) / (4.0 * qt_1);
        let e = Vector6::new(t.x, t.y, t.z, -qt_2, -qt_3, -qt_4);
        e.dot(&(information * e)) / information.m11
    }

    #[test]
    fn the_error_is_that_of_the_benchmarks_own_evaluation() {
        let information =
            information_matrix(&[Point3::new(1.0, 2.0, 3.0), Point3::new(0.0, -1.0, 2.0)]);
        for turn in [
            Vector3::new(0.1, -0.2, 0.05),
            Vector3::new(-1.0, 0.4, 2.0),
            Vector3::zeros(),
        ] {
            let off = Isometry3::new(Vector3::new(0.2, 0.1, -0.3), turn);
            let found =
                registration_error(&off, &Isometry3::identity(), &information, SIGN).unwrap();
            assert_relative_eq!(found, benchmark_error(&off, &information), epsilon = 1e-12);
        }
    }

    #[test]
    fn a_turn_about_the_points_costs_less_than_one_about_the_sensor() {
        let centre = Vector3::new(0.0, 0.0, 2.0);
        let points = [-0.1, 0.1].map(|x| Point3::from(centre + Vector3::x() * x));
        let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.1);
        // Half the lever, since the benchmark counts half of the turn.
        let about_points = Isometry3::from_parts((centre / 2.0 - turn * centre / 2.0).into(), turn);
        let about_sensor = Isometry3::from_parts(Vector3::zeros().into(), turn);
        let information = information_matrix(&points);
        let error =
            |off| registration_error(off, &Isometry3::identity(), &information, SIGN).unwrap();
        assert!(error(&about_points) < 0.01 * error(&about_sensor));
    }

    #[test]
    fn the_conjugate_sign_is_the_inverse_turn() {
        let information = information_matrix(&[Point3::new(1.0, 2.0, 3.0)]);
        let shift = Vector3::new(0.2, 0.1, -0.3);
        let turn = Vector3::new(0.1, -0.2, 0.05);
        let [off, inverse] = [turn, -turn].map(|turn| Isometry3::new(shift, turn));
        let here = Isometry3::identity();
        let conjugate = registration_error(&off, &here, &information, RotationSign::Conjugate);
        assert_eq!(
            conjugate,
            registration_error(&inverse, &here, &information, SIGN)
        );
        assert_ne!(
            conjugate,
            registration_error(&off, &here, &information, SIGN)
        );
    }

    #[test]
    fn both_quaternions_of_a_rotation_cost_the_same() {
        let quaternion = Quaternion::new(0.9, 0.1, -0.3, 0.2).normalize();
        let [plus, minus] = [quaternion, -quaternion]
            .map(|q| Isometry3::from_parts(Vector3::x().into(), UnitQuaternion::new_unchecked(q)));
        let information = information_matrix(&[Point3::new(1.0, 2.0, 3.0)]);
        let error =
            |off| registration_error(off, &Isometry3::identity(), &information, SIGN).unwrap();
        assert_relative_eq!(error(&plus), error(&minus), epsilon = 1e-14);
    }

    #[test]
    fn no_points_leave_nothing_to_judge_by() {
        let here = Isometry3::identity();
        assert_eq!(
            registration_error(&here, &here, &information_matrix(&[]), SIGN),
            None
        );
        assert_eq!(
            registration_error(&here, &here, &Matrix6::from_element(f64::NAN), SIGN),
            None
        );
    }
}
