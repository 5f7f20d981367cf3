//! How far an error of a relative pose moves the overlapping points.
//!
//! The information matrix of a pair is `Ω = Σ_p GᵀG` with `G = [I | −[p]×]` over the overlapping points (Choi, Zhou,
//! Koltun: Robust reconstruction of indoor scenes, CVPR 2015). A transformation of translation t and small rotation
//! vector θ moves p by `t + θ × p = G · (t, θ)`, so `(t, θ)ᵀ Ω (t, θ)` sums the squared displacements, and `Ω₀₀`
//! counts the points.

use nalgebra::{Isometry3, Matrix6, Vector6};

/// Squared error of a relative pose as the 3DMatch benchmark counts it, in m².
///
/// `eᵀ Ω e / Ω₀₀` with e = (t, q) of `true_i_from_j⁻¹ · estimated_i_from_j`, where t is the translation and
/// q = sin(θ/2) · axis is the vector part of the unit quaternion with w ≥ 0. With the rotation vector in
/// the place of q this would be the mean squared displacement of the overlapping points; q is half as
/// long, and so a rotation counts half.
///
/// Source: `mrEvaluateRegistration.m` of Choi, Zhou, Koltun (CVPR 2015), which 3DMatch took over
/// (Zeng et al., CVPR 2017). That program writes `−qt(2:4)`, but its `dcm2quat` returns the conjugate of the
/// ordinary quaternion: both minus signs cancel, as the signs of `Ω` require.
///
/// `None` where `Ω₀₀` is not positive: without overlapping points there is nothing to judge by.
///
/// ```
/// use gmpcr_eval::registration_error;
/// use nalgebra::{Isometry3, Matrix6};
///
/// let off = Isometry3::translation(0.3, 0.0, 0.4);
/// let error = registration_error(&off, &Isometry3::identity(), &(7.0 * Matrix6::identity()));
/// assert!(error.is_some_and(|error| (error - 0.25).abs() < 1e-12));
/// assert_eq!(registration_error(&off, &off, &Matrix6::zeros()), None);
/// ```
#[must_use]
pub fn registration_error(
    estimated_i_from_j: &Isometry3<f64>,
    true_i_from_j: &Isometry3<f64>,
    information: &Matrix6<f64>,
) -> Option<f64> {
    let num_points = information.m11;
    if num_points.is_nan() || num_points <= 0.0 {
        return None;
    }
    let e = deviation(&true_i_from_j.inv_mul(estimated_i_from_j));
    Some(e.dot(&(information * e)) / num_points)
}

/// (translation, vector part of the unit quaternion with w ≥ 0).
fn deviation(transformation: &Isometry3<f64>) -> Vector6<f64> {
    let t = transformation.translation.vector;
    let quaternion = transformation.rotation.quaternion();
    let sign = if quaternion.w < 0.0 { -1.0 } else { 1.0 };
    let q = quaternion.imag() * sign;
    Vector6::new(t.x, t.y, t.z, q.x, q.y, q.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use gmpcr_geometry::PointPairs;
    use nalgebra::{Point3, Quaternion, UnitQuaternion, Vector3};

    /// `Ω = Σ GᵀG` over points, `G = [I | −[p]×]`, as in the `gt.info` files.
    fn information_matrix(points: &[Point3<f64>]) -> Matrix6<f64> {
        let pairs = PointPairs::new(points.to_vec(), points.to_vec()).unwrap();
        gmpcr_cliques::information_matrix(&pairs, 1.0)
    }

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
    fn small_transformations_cost_the_squared_displacements_of_the_points() {
        let points = [(0.5, -1.0, 2.0), (1.5, 0.3, 2.5), (-0.7, 0.1, 3.0)]
            .map(|(x, y, z)| Point3::new(x, y, z));
        let (translation, rotation) = (
            Vector3::new(1e-3, -2e-3, 5e-4),
            Vector3::new(-1e-3, 3e-3, 2e-3),
        );
        let moved: f64 = points
            .iter()
            .map(|p| (translation + rotation.cross(&p.coords)).norm_squared())
            .sum();
        let e = Vector6::new(
            translation.x,
            translation.y,
            translation.z,
            rotation.x,
            rotation.y,
            rotation.z,
        );
        assert_relative_eq!(
            e.dot(&(information_matrix(&points) * e)),
            moved,
            max_relative = 1e-12
        );
    }

    /// `mrComputeTransformationError` of the benchmark, line by line.
    fn benchmark_error(transformation: &Isometry3<f64>, information: &Matrix6<f64>) -> f64 {
        let (t, r) = (
            transformation.translation.vector,
            transformation.rotation.to_rotation_matrix(),
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
        for rotation in [
            Vector3::new(0.1, -0.2, 0.05),
            Vector3::new(-1.0, 0.4, 2.0),
            Vector3::zeros(),
        ] {
            let off = Isometry3::new(Vector3::new(0.2, 0.1, -0.3), rotation);
            let found = registration_error(&off, &Isometry3::identity(), &information).unwrap();
            assert_relative_eq!(found, benchmark_error(&off, &information), epsilon = 1e-12);
        }
    }

    #[test]
    fn a_rotation_about_the_points_costs_less_than_one_about_the_sensor() {
        let center = Vector3::new(0.0, 0.0, 2.0);
        let points = [-0.1, 0.1].map(|x| Point3::from(center + Vector3::x() * x));
        let rotation = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.1);
        // Half the lever, since the benchmark counts half of the rotation.
        let about_points =
            Isometry3::from_parts((center / 2.0 - rotation * center / 2.0).into(), rotation);
        let about_sensor = Isometry3::from_parts(Vector3::zeros().into(), rotation);
        let information = information_matrix(&points);
        let error = |off| registration_error(off, &Isometry3::identity(), &information).unwrap();
        assert!(error(&about_points) < 0.01 * error(&about_sensor));
    }

    #[test]
    fn both_quaternions_of_a_rotation_cost_the_same() {
        let quaternion = Quaternion::new(0.9, 0.1, -0.3, 0.2).normalize();
        let [plus, minus] = [quaternion, -quaternion]
            .map(|q| Isometry3::from_parts(Vector3::x().into(), UnitQuaternion::new_unchecked(q)));
        let information = information_matrix(&[Point3::new(1.0, 2.0, 3.0)]);
        let error = |off| registration_error(off, &Isometry3::identity(), &information).unwrap();
        assert_relative_eq!(error(&plus), error(&minus), epsilon = 1e-14);
    }

    #[test]
    fn no_points_leave_nothing_to_judge_by() {
        let here = Isometry3::identity();
        assert_eq!(
            registration_error(&here, &here, &information_matrix(&[])),
            None
        );
        assert_eq!(
            registration_error(&here, &here, &Matrix6::from_element(f64::NAN)),
            None
        );
    }
}
