//! Errors of absolute poses.

use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};

use crate::error::Error;
use crate::pose_error::{PoseError, pose_error};

/// Errors of absolute poses after the estimated world is moved onto the true one.
///
/// Poses are known up to a common rigid motion (R, t), the gauge. It is removed by the best fit:
/// R minimises `Σ |R · R̂_k − R_k|²` over the rotations (chordal mean, from the singular value
/// decomposition of `Σ R_k R̂_kᵀ`), t then minimises `Σ |R · t̂_k + t − t_k|²`. Unlike a fit to the
/// positions alone, this is unique also where all scans stand in a line. Each error compares
/// `(R, t) · (R̂_k, t̂_k)` with the true pose.
///
/// The scans must share one frame: call once per connected component. No scans give no errors.
/// To judge without any gauge, see [`PairErrors::of_all`](crate::PairErrors::of_all).
///
/// # Errors
/// [`Error::LengthMismatch`] unless both lists have the same length.
///
/// ```
/// use gmpcr_eval::absolute_errors;
/// use nalgebra::{Isometry3, Vector3};
///
/// let truth = [0.0, 1.0, 3.0].map(|x| Isometry3::translation(x, 0.0, 0.0));
/// let gauge = Isometry3::new(Vector3::new(5.0, 6.0, 7.0), Vector3::new(0.1, 0.2, 0.3));
/// let errors = absolute_errors(&truth.map(|pose| gauge * pose), &truth)?;
/// assert!(errors.iter().all(|e| e.rotation < 1e-12 && e.translation < 1e-12));
/// # Ok::<(), gmpcr_eval::Error>(())
/// ```
pub fn absolute_errors(
    estimated_world_from_scan: &[Isometry3<f64>],
    true_world_from_scan: &[Isometry3<f64>],
) -> Result<Vec<PoseError>, Error> {
    let (expected, found) = (estimated_world_from_scan.len(), true_world_from_scan.len());
    if expected != found {
        return Err(Error::LengthMismatch {
            what: "true poses",
            expected,
            found,
        });
    }
    let true_from_estimated = best_gauge(estimated_world_from_scan, true_world_from_scan);
    let poses = estimated_world_from_scan.iter().zip(true_world_from_scan);
    Ok(poses
        .map(|(estimate, truth)| pose_error(&(true_from_estimated * estimate), truth))
        .collect())
}

/// The rigid motion that best maps the estimated world onto the true one.
fn best_gauge(estimated: &[Isometry3<f64>], truth: &[Isometry3<f64>]) -> Isometry3<f64> {
    let pairs = || estimated.iter().zip(truth);
    let correlation: Matrix3<f64> = pairs()
        .map(|(estimate, truth)| {
            (truth.rotation * estimate.rotation.inverse())
                .to_rotation_matrix()
                .into_inner()
        })
        .sum();
    let rotation = nearest_rotation(&correlation);
    let shift: Vector3<f64> = pairs()
        .map(|(estimate, truth)| truth.translation.vector - rotation * estimate.translation.vector)
        .sum();
    let shift = shift / estimated.len().max(1) as f64;
    Isometry3::from_parts(shift.into(), rotation)
}

/// `U · diag(1, 1, ±1) · Vᵀ`, a rotation; the identity where the decomposition fails.
fn nearest_rotation(matrix: &Matrix3<f64>) -> UnitQuaternion<f64> {
    let svd = matrix.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
        return UnitQuaternion::identity();
    };
    let sign = (u * v_t).determinant().signum();
    // nalgebra sorts the singular values: the last one is the smallest.
    let nearest = u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * v_t;
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(nearest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn poses() -> Vec<Isometry3<f64>> {
        (0..7)
            .map(|k| {
                let k = f64::from(k);
                let turn = Vector3::new(k.sin(), 0.4 * k, 1.0 - k);
                Isometry3::new(Vector3::new(k, k * k, -k), turn)
            })
            .collect()
    }

    #[test]
    fn a_common_motion_of_the_estimate_changes_no_error() {
        let truth = poses();
        let mut estimate = poses();
        estimate[2] *= Isometry3::new(Vector3::new(0.2, 0.1, 0.0), Vector3::new(0.0, 0.3, 0.0));
        let gauge = Isometry3::new(Vector3::new(9.0, -4.0, 2.0), Vector3::new(2.0, -1.0, 0.5));
        let moved: Vec<_> = estimate.iter().map(|pose| gauge * pose).collect();
        let plain = absolute_errors(&estimate, &truth).unwrap();
        let gauged = absolute_errors(&moved, &truth).unwrap();
        for (a, b) in plain.iter().zip(&gauged) {
            assert_relative_eq!(a.rotation, b.rotation, epsilon = 1e-10);
            assert_relative_eq!(a.translation, b.translation, epsilon = 1e-10);
        }
        assert!(plain[2].rotation > 0.2);
    }

    #[test]
    fn errors_in_opposite_directions_stay_as_they_are() {
        let truth = [Isometry3::identity(); 2];
        let estimate = [0.1, -0.1].map(|x| Isometry3::translation(x, 0.0, 0.0));
        for error in absolute_errors(&estimate, &truth).unwrap() {
            assert_relative_eq!(error.translation, 0.1, epsilon = 1e-12);
        }
    }

    #[test]
    fn one_scan_alone_is_never_wrong_and_no_scans_have_no_errors() {
        let alone = absolute_errors(&poses()[3..4], &poses()[4..5]).unwrap();
        assert!(alone[0].rotation < 1e-12 && alone[0].translation < 1e-12);
        assert!(absolute_errors(&[], &[]).unwrap().is_empty());
    }

    #[test]
    fn lists_of_different_length_are_refused() {
        let error = absolute_errors(&poses(), &[]).unwrap_err();
        assert_eq!(
            error,
            Error::LengthMismatch {
                what: "true poses",
                expected: 7,
                found: 0
            }
        );
    }
}
