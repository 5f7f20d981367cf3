//! Errors of absolute poses.

use gmpcr_geometry::nearest_rotation;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use crate::error::{Error, check_length};
use crate::pose_error::{PoseError, pose_error};

/// How the estimated world is aligned with the ground truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Gauge {
    /// The transformation of least squared errors: R minimizes `Σ |R · R̂_k − R_k|²` over the rotations
    /// (chordal mean, from the singular value decomposition of `Σ R_k R̂_kᵀ`), t then minimizes
    /// `Σ |R · t̂_k + t − t_k|²`.
    LeastSquares,
    /// The transformation of least absolute errors, to which scans that are far off matter little: the
    /// geodesic median of the rotations `R_k R̂_kᵀ`, then the geometric median of the translations, both by
    /// Weiszfeld's iteration (Hartley, Aftab and Trumpf, CVPR 2011).
    LeastAbsolute,
}

/// Errors of absolute poses after the estimated world is aligned with the ground truth.
///
/// Poses are known up to a common rigid transformation (R, t), the gauge, which the best fit removes.
/// Unlike a fit to the positions alone, this is unique also where all scans stand in a line. Each
/// error compares `(R, t) · (R̂_k, t̂_k)` with the pose (R_k, t_k) of the ground truth.
///
/// The scans must share one frame: call once per connected component. No scans give no errors.
/// To judge without any gauge, see [`PairErrors::of_all`](crate::PairErrors::of_all).
///
/// # Errors
/// [`Error::LengthMismatch`] unless both lists have the same length.
///
/// ```
/// use gmpcr_eval::{Gauge, absolute_errors};
/// use nalgebra::{Isometry3, Vector3};
///
/// let ground_truth = [0.0, 1.0, 3.0].map(|x| Isometry3::translation(x, 0.0, 0.0));
/// let gauge = Isometry3::new(Vector3::new(5.0, 6.0, 7.0), Vector3::new(0.1, 0.2, 0.3));
/// let transformed = ground_truth.map(|pose| gauge * pose);
/// let errors = absolute_errors(&transformed, &ground_truth, Gauge::LeastSquares)?;
/// assert!(errors.iter().all(|e| e.rotation < 1e-12 && e.translation < 1e-12));
/// # Ok::<(), gmpcr_eval::Error>(())
/// ```
pub fn absolute_errors(
    estimated_world_from_scan: &[Isometry3<f64>],
    true_world_from_scan: &[Isometry3<f64>],
    gauge: Gauge,
) -> Result<Vec<PoseError>, Error> {
    check_length(
        "ground truth poses",
        estimated_world_from_scan.len(),
        true_world_from_scan.len(),
    )?;
    let true_from_estimated = best_gauge(estimated_world_from_scan, true_world_from_scan, gauge);
    let poses = estimated_world_from_scan.iter().zip(true_world_from_scan);
    Ok(poses
        .map(|(estimate, ground_truth)| pose_error(&(true_from_estimated * estimate), ground_truth))
        .collect())
}

/// The rigid transformation that best aligns the estimated world with the ground truth.
fn best_gauge(
    estimated: &[Isometry3<f64>],
    ground_truth: &[Isometry3<f64>],
    gauge: Gauge,
) -> Isometry3<f64> {
    let pairs = || estimated.iter().zip(ground_truth);
    let rotations: Vec<_> = pairs()
        .map(|(estimate, ground_truth)| ground_truth.rotation * estimate.rotation.inverse())
        .collect();
    let mean = mean_rotation(&rotations);
    let rotation = match gauge {
        Gauge::LeastSquares => mean,
        Gauge::LeastAbsolute => median_rotation(&rotations, mean),
    };
    let translations: Vec<Vector3<f64>> = pairs()
        .map(|(estimate, ground_truth)| {
            ground_truth.translation.vector - rotation * estimate.translation.vector
        })
        .collect();
    let mean = translations.iter().sum::<Vector3<f64>>() / translations.len().max(1) as f64;
    let translation = match gauge {
        Gauge::LeastSquares => mean,
        Gauge::LeastAbsolute => median_vector(&translations, mean),
    };
    Isometry3::from_parts(translation.into(), rotation)
}

fn mean_rotation(rotations: &[UnitQuaternion<f64>]) -> UnitQuaternion<f64> {
    let matrices = rotations
        .iter()
        .map(|r| r.to_rotation_matrix().into_inner());
    UnitQuaternion::from_rotation_matrix(&nearest_rotation(&matrices.sum()))
}

/// Steps of a median; a few dozen are usual.
const MAX_STEPS: usize = 100;
/// Step, in radians or relative to the spread, at which a median has converged.
const STEP_TOLERANCE: f64 = 1e-9;

/// The rotation of least summed angle to the others. The start is the one of them that is best.
fn median_rotation(
    rotations: &[UnitQuaternion<f64>],
    mean: UnitQuaternion<f64>,
) -> UnitQuaternion<f64> {
    let cost = |r: &UnitQuaternion<f64>| rotations.iter().map(|o| r.angle_to(o)).sum::<f64>();
    let starts = rotations.iter().take(MAX_STEPS).copied().chain([mean]);
    let best = starts.min_by(|a, b| cost(a).total_cmp(&cost(b)));
    let mut median = best.unwrap_or(mean);
    for _ in 0..MAX_STEPS {
        let offsets: Vec<_> = rotations
            .iter()
            .map(|rotation| (rotation * median.inverse()).scaled_axis())
            .collect();
        let step = weiszfeld_step(&offsets, STEP_TOLERANCE);
        median = UnitQuaternion::from_scaled_axis(step) * median;
        if step.norm() < STEP_TOLERANCE {
            break;
        }
    }
    median
}

/// The point of least summed distance to the others.
fn median_vector(points: &[Vector3<f64>], mean: Vector3<f64>) -> Vector3<f64> {
    let spread = points.iter().map(|p| (p - mean).norm()).fold(0.0, f64::max);
    let mut median = mean;
    for _ in 0..MAX_STEPS {
        let offsets: Vec<_> = points.iter().map(|point| point - median).collect();
        let step = weiszfeld_step(&offsets, STEP_TOLERANCE * spread);
        median += step;
        if step.norm() <= STEP_TOLERANCE * spread {
            break;
        }
    }
    median
}

/// Mean of the offsets weighted by their inverse lengths, of which none counts as below `least`.
fn weiszfeld_step(offsets: &[Vector3<f64>], least: f64) -> Vector3<f64> {
    let weights = offsets.iter().map(|offset| 1.0 / offset.norm().max(least));
    let (mut sum, mut total) = (Vector3::zeros(), 0.0);
    for (offset, weight) in offsets.iter().zip(weights.filter(|w| w.is_finite())) {
        sum += offset * weight;
        total += weight;
    }
    if total > 0.0 { sum / total } else { sum }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn poses() -> Vec<Isometry3<f64>> {
        (0..7)
            .map(|k| {
                let k = f64::from(k);
                let rotation = Vector3::new(k.sin(), 0.4 * k, 1.0 - k);
                Isometry3::new(Vector3::new(k, k * k, -k), rotation)
            })
            .collect()
    }

    #[test]
    fn a_common_transformation_of_the_estimate_changes_no_error() {
        for gauge_of in [Gauge::LeastSquares, Gauge::LeastAbsolute] {
            let ground_truth = poses();
            let mut estimate = poses();
            estimate[2] *= Isometry3::new(Vector3::new(0.2, 0.1, 0.0), Vector3::new(0.0, 0.3, 0.0));
            let gauge = Isometry3::new(Vector3::new(9.0, -4.0, 2.0), Vector3::new(2.0, -1.0, 0.5));
            let transformed: Vec<_> = estimate.iter().map(|pose| gauge * pose).collect();
            let plain = absolute_errors(&estimate, &ground_truth, gauge_of).unwrap();
            let gauged = absolute_errors(&transformed, &ground_truth, gauge_of).unwrap();
            for (a, b) in plain.iter().zip(&gauged) {
                assert_relative_eq!(a.rotation, b.rotation, epsilon = 1e-10);
                assert_relative_eq!(a.translation, b.translation, epsilon = 1e-10);
            }
            assert!(plain[2].rotation > 0.2);
        }
    }

    #[test]
    fn least_absolute_errors_leave_an_outlier_alone() {
        let ground_truth = poses();
        let gauge = Isometry3::new(Vector3::new(9.0, -4.0, 2.0), Vector3::new(2.0, -1.0, 0.5));
        let mut estimate: Vec<_> = ground_truth.iter().map(|pose| gauge * pose).collect();
        estimate[4] *= Isometry3::new(Vector3::new(5.0, 0.0, 0.0), Vector3::new(0.0, 1.0, 0.0));
        let errors = absolute_errors(&estimate, &ground_truth, Gauge::LeastAbsolute).unwrap();
        for (scan, error) in errors.iter().enumerate() {
            let is_outlier = scan == 4;
            assert_eq!(error.rotation > 1e-6, is_outlier, "{scan}: {error:?}");
            assert_eq!(error.translation > 1e-6, is_outlier, "{scan}: {error:?}");
        }
        assert_relative_eq!(errors[4].rotation, 1.0, epsilon = 1e-6);
        let distorted = absolute_errors(&estimate, &ground_truth, Gauge::LeastSquares).unwrap();
        assert!(distorted[0].rotation > 0.1);
    }

    #[test]
    fn errors_in_opposite_directions_stay_as_they_are() {
        let ground_truth = [Isometry3::identity(); 2];
        let estimate = [0.1, -0.1].map(|x| Isometry3::translation(x, 0.0, 0.0));
        for error in absolute_errors(&estimate, &ground_truth, Gauge::LeastSquares).unwrap() {
            assert_relative_eq!(error.translation, 0.1, epsilon = 1e-12);
        }
    }

    #[test]
    fn one_scan_alone_has_no_error_and_no_scans_have_no_errors() {
        let alone = absolute_errors(&poses()[3..4], &poses()[4..5], Gauge::LeastAbsolute).unwrap();
        assert!(alone[0].rotation < 1e-12 && alone[0].translation < 1e-12);
        assert!(
            absolute_errors(&[], &[], Gauge::LeastAbsolute)
                .unwrap()
                .is_empty()
        );
    }

    #[test]
    fn lists_of_different_length_are_refused() {
        let error = absolute_errors(&poses(), &[], Gauge::LeastSquares).unwrap_err();
        assert_eq!(
            error,
            Error::LengthMismatch {
                what: "ground truth poses",
                expected: 7,
                found: 0
            }
        );
    }
}
