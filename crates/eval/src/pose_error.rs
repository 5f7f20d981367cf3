//! How far one motion is from another.

use gmpcr_geometry::angular_distance;
use nalgebra::Isometry3;

/// Rotation and translation error of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseError {
    /// Angle of `R_true⁻¹ · R_estimated` in radians, between 0 and π.
    pub rotation: f64,
    /// `|t_estimated − t_true|` in metres.
    pub translation: f64,
}

impl PoseError {
    /// The rotation error in degrees.
    #[must_use]
    pub fn rotation_degrees(&self) -> f64 {
        self.rotation.to_degrees()
    }
}

/// Rotation error RE and translation error TE of an estimated motion.
///
/// RE is the angle of `R_true⁻¹ · R_estimated`, TE is `|t_estimated − t_true|`, the usual figures
/// of pairwise registration (e.g. Choy, Dong, Koltun: Deep global registration, CVPR 2020).
/// Inverting both motions keeps RE; TE then compares the positions of the other scan.
///
/// ```
/// use gmpcr_eval::pose_error;
/// use nalgebra::{Isometry3, Vector3};
///
/// let truth = Isometry3::translation(1.0, 2.0, 3.0);
/// let estimate = Isometry3::new(Vector3::new(1.3, 2.0, 3.4), Vector3::new(0.0, 0.0, 0.1));
/// let error = pose_error(&estimate, &truth);
/// assert!((error.rotation - 0.1).abs() < 1e-12);
/// assert!((error.translation - 0.5).abs() < 1e-12);
/// ```
#[must_use]
pub fn pose_error(estimated: &Isometry3<f64>, truth: &Isometry3<f64>) -> PoseError {
    let [from, to] = [truth, estimated].map(|motion| motion.rotation.to_rotation_matrix());
    PoseError {
        rotation: angular_distance(&from, &to),
        translation: (estimated.translation.vector - truth.translation.vector).norm(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::Vector3;

    #[test]
    fn the_error_of_the_truth_is_zero() {
        let truth = Isometry3::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.3, 0.2, -2.0));
        let error = pose_error(&truth, &truth);
        assert!(error.rotation < 1e-15 && error.translation == 0.0);
    }

    #[test]
    fn a_quarter_turn_is_ninety_degrees_whichever_motion_comes_first() {
        let quarter = Isometry3::rotation(Vector3::y() * std::f64::consts::FRAC_PI_2);
        let there = pose_error(&quarter, &Isometry3::identity());
        let back = pose_error(&Isometry3::identity(), &quarter);
        assert_relative_eq!(there.rotation_degrees(), 90.0, epsilon = 1e-12);
        assert_relative_eq!(back.rotation_degrees(), 90.0, epsilon = 1e-12);
    }

    #[test]
    fn inverting_both_motions_keeps_the_rotation_error() {
        let a = Isometry3::new(Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.3, 0.2, -2.0));
        let b = Isometry3::new(Vector3::new(0.0, 1.0, 0.0), Vector3::new(-0.3, 0.8, 1.0));
        let forth = pose_error(&a, &b).rotation;
        let back = pose_error(&a.inverse(), &b.inverse()).rotation;
        assert_relative_eq!(forth, back, epsilon = 1e-12);
    }
}
