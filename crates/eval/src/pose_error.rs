//! How far one transformation is from another.

use gmpcr_geometry::angular_distance;
use nalgebra::Isometry3;

/// Rotation and translation error of a transformation, or a statistic of such errors.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PoseError {
    /// Angle of `R_true⁻¹ · R_estimated` in radians, between 0 and π.
    pub rotation: f64,
    /// `|t_estimated − t_true|` in meters.
    pub translation: f64,
}

impl PoseError {
    /// The rotation error in degrees.
    #[must_use]
    pub fn rotation_degrees(&self) -> f64 {
        self.rotation.to_degrees()
    }

    /// Mean rotation and mean translation error; `None` of no errors.
    #[must_use]
    pub fn mean(errors: &[Self]) -> Option<Self> {
        Self::statistic(errors, |values| {
            values.iter().sum::<f64>() / values.len() as f64
        })
    }

    /// Median rotation and median translation error, each on its own: the middle value, or the mean of
    /// the middle two. `None` of no errors. `O(n log n)`.
    ///
    /// ```
    /// use gmpcr_eval::{Gauge, PoseError, absolute_errors};
    /// use nalgebra::Isometry3;
    ///
    /// let [ground_truth, estimate] = [[0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 2.0, 7.0]]
    ///     .map(|scans| scans.map(|x| Isometry3::translation(x, 0.0, 0.0)));
    /// let errors = absolute_errors(&estimate, &ground_truth, Gauge::LeastAbsolute)?;
    /// assert!(PoseError::median(&errors).is_some_and(|error| error.translation < 1e-6));
    /// assert!(PoseError::mean(&errors).is_some_and(|error| (error.translation - 1.0).abs() < 1e-6));
    /// # Ok::<(), gmpcr_eval::Error>(())
    /// ```
    #[must_use]
    pub fn median(errors: &[Self]) -> Option<Self> {
        Self::statistic(errors, |values| {
            let (low, high) = ((values.len() - 1) / 2, values.len() / 2);
            (values[low] + values[high]) / 2.0
        })
    }

    /// A statistic of the ascending errors.
    fn statistic(errors: &[Self], statistic: impl Fn(&[f64]) -> f64) -> Option<Self> {
        let sorted = |component: fn(&Self) -> f64| {
            let mut values: Vec<f64> = errors.iter().map(component).collect();
            values.sort_by(f64::total_cmp);
            values
        };
        (!errors.is_empty()).then(|| Self {
            rotation: statistic(&sorted(|error| error.rotation)),
            translation: statistic(&sorted(|error| error.translation)),
        })
    }
}

/// Rotation error RE and translation error TE of an estimated transformation.
///
/// RE is the angle of `R_true⁻¹ · R_estimated`, TE is `|t_estimated − t_true|`, the usual figures
/// of pairwise registration (e.g. Choy, Dong, Koltun: Deep global registration, CVPR 2020).
/// Inverting both transformations keeps RE; TE then compares the positions of the other scan.
///
/// ```
/// use gmpcr_eval::pose_error;
/// use nalgebra::{Isometry3, Vector3};
///
/// let ground_truth = Isometry3::translation(1.0, 2.0, 3.0);
/// let estimate = Isometry3::new(Vector3::new(1.3, 2.0, 3.4), Vector3::new(0.0, 0.0, 0.1));
/// let error = pose_error(&estimate, &ground_truth);
/// assert!((error.rotation - 0.1).abs() < 1e-12);
/// assert!((error.translation - 0.5).abs() < 1e-12);
/// ```
#[must_use]
pub fn pose_error(estimated: &Isometry3<f64>, ground_truth: &Isometry3<f64>) -> PoseError {
    let [from, to] = [ground_truth, estimated]
        .map(|transformation| transformation.rotation.to_rotation_matrix());
    PoseError {
        rotation: angular_distance(&from, &to),
        translation: (estimated.translation.vector - ground_truth.translation.vector).norm(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::Vector3;

    #[test]
    fn the_error_of_the_ground_truth_is_zero() {
        let ground_truth =
            Isometry3::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.3, 0.2, -2.0));
        let error = pose_error(&ground_truth, &ground_truth);
        assert!(error.rotation < 1e-15 && error.translation == 0.0);
    }

    #[test]
    fn a_quarter_revolution_is_ninety_degrees_whichever_comes_first() {
        let quarter = Isometry3::rotation(Vector3::y() * std::f64::consts::FRAC_PI_2);
        let there = pose_error(&quarter, &Isometry3::identity());
        let back = pose_error(&Isometry3::identity(), &quarter);
        assert_relative_eq!(there.rotation_degrees(), 90.0, epsilon = 1e-12);
        assert_relative_eq!(back.rotation_degrees(), 90.0, epsilon = 1e-12);
    }

    #[test]
    fn inverting_both_transformations_keeps_the_rotation_error() {
        let a = Isometry3::new(Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.3, 0.2, -2.0));
        let b = Isometry3::new(Vector3::new(0.0, 1.0, 0.0), Vector3::new(-0.3, 0.8, 1.0));
        let forth = pose_error(&a, &b).rotation;
        let back = pose_error(&a.inverse(), &b.inverse()).rotation;
        assert_relative_eq!(forth, back, epsilon = 1e-12);
    }
}
