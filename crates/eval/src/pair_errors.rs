//! Errors of the relative poses of many pairs.

use nalgebra::Isometry3;

use crate::error::{Error, check_length};
use crate::ground_truth::{GroundTruthPair, check_pair};
use crate::pose_error::{PoseError, pose_error};
use crate::thresholds::{
    RECALL_DEGREES, RECALL_METERS, SCANNET_DEGREES, SCANNET_METERS, ThresholdRatios,
};
use crate::world::WorldPoses;

/// The error of one pair.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PairError {
    /// First scan.
    pub i: usize,
    /// Second scan.
    pub j: usize,
    /// Error of the relative pose; `None` where the scans share no frame.
    pub error: Option<PoseError>,
}

/// Errors of the relative poses of many pairs.
///
/// Means and medians are over the pairs that have an estimate. Ratios are over all pairs: one
/// without an estimate is under no threshold.
///
/// ```
/// use gmpcr_eval::{PairErrors, WorldPoses};
/// use nalgebra::Isometry3;
///
/// let at = |x| Isometry3::translation(x, 0.0, 0.0);
/// let ground_truth = [at(0.0), at(1.0), at(2.0)];
/// let poses = WorldPoses::of_one_frame(&[at(5.0), at(6.0), at(7.4)]);
/// let errors = PairErrors::of_all(&ground_truth, &poses)?;
/// assert_eq!(errors.pairs.len(), 3);
/// assert!(errors.median().is_some_and(|median| (median.translation - 0.4).abs() < 1e-12));
/// assert!(errors.recall().is_some_and(|recall| (recall - 1.0 / 3.0).abs() < 1e-12));
/// # Ok::<(), gmpcr_eval::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PairErrors {
    /// The pairs, in the order they were asked about.
    pub pairs: Vec<PairError>,
}

impl PairErrors {
    /// Errors on a list of pairs.
    ///
    /// # Errors
    /// [`Error::NoSuchScan`] or [`Error::SamePair`] for a pair that does not name two of the
    /// scans.
    pub fn of_pairs(pairs: &[GroundTruthPair], poses: &WorldPoses) -> Result<Self, Error> {
        let num_scans = poses.num_scans();
        Self::of_estimates(pairs, num_scans, |i, j| poses.i_from_j(i, j))
    }

    /// Errors of relative poses on a list of pairs: `i_from_j(i, j)` gives the estimate of a
    /// pair, or `None` where there is none.
    ///
    /// # Errors
    /// As [`PairErrors::of_pairs`], for scans outside `0..num_scans`.
    pub fn of_estimates(
        pairs: &[GroundTruthPair],
        num_scans: usize,
        mut i_from_j: impl FnMut(usize, usize) -> Option<Isometry3<f64>>,
    ) -> Result<Self, Error> {
        pairs
            .iter()
            .try_for_each(|pair| check_pair(pair.i, pair.j, num_scans))?;
        let pairs = pairs.iter().map(|pair| PairError {
            i: pair.i,
            j: pair.j,
            error: i_from_j(pair.i, pair.j).map(|found| pose_error(&found, &pair.i_from_j)),
        });
        Ok(Self {
            pairs: pairs.collect(),
        })
    }

    /// Errors of all pairs i < j against absolute poses of the ground truth. No alignment is needed: relative
    /// poses do not depend on the choice of the world's frame.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] unless there is one ground truth pose per scan.
    pub fn of_all(
        true_world_from_scan: &[Isometry3<f64>],
        poses: &WorldPoses,
    ) -> Result<Self, Error> {
        let num_scans = poses.num_scans();
        check_length("ground truth poses", num_scans, true_world_from_scan.len())?;
        let all = (0..num_scans).flat_map(|i| (i + 1..num_scans).map(move |j| (i, j)));
        let pairs = all.map(|(i, j)| {
            let true_i_from_j = true_world_from_scan[i].inv_mul(&true_world_from_scan[j]);
            let error = poses
                .i_from_j(i, j)
                .map(|estimate| pose_error(&estimate, &true_i_from_j));
            PairError { i, j, error }
        });
        Ok(Self {
            pairs: pairs.collect(),
        })
    }

    /// Number of pairs without an estimate.
    #[must_use]
    pub fn num_missing(&self) -> usize {
        self.pairs
            .iter()
            .filter(|pair| pair.error.is_none())
            .count()
    }

    /// Mean rotation and mean translation error; `None` where no pair has an estimate.
    #[must_use]
    pub fn mean(&self) -> Option<PoseError> {
        PoseError::mean(&self.errors().copied().collect::<Vec<_>>())
    }

    /// Median rotation and median translation error, each on its own; see [`PoseError::median`]. `None`
    /// where no pair has an estimate.
    #[must_use]
    pub fn median(&self) -> Option<PoseError> {
        PoseError::median(&self.errors().copied().collect::<Vec<_>>())
    }

    /// Ratio of the pairs with RE under 15° and TE under 0.3 m, the usual recall of pairwise
    /// registration indoors (Choy, Dong, Koltun, CVPR 2020). `None` where there are no pairs.
    #[must_use]
    pub fn recall(&self) -> Option<f64> {
        self.recall_within(RECALL_DEGREES.to_radians(), RECALL_METERS)
    }

    /// Ratio of the pairs with a rotation error under `rotation` radians and a translation error
    /// under `translation` meters. `None` where there are no pairs.
    #[must_use]
    pub fn recall_within(&self, rotation: f64, translation: f64) -> Option<f64> {
        self.ratio(|error| error.rotation < rotation && error.translation < translation)
    }

    /// Ratios of the pairs under 3, 5, 10, 30, 45° and under 0.05, 0.1, 0.25, 0.5, 0.75 m, as
    /// multiview registration reports them on ScanNet (Gojcic et al.: Learning multiview 3D
    /// point cloud registration, CVPR 2020). `None` where there are no pairs.
    #[must_use]
    pub fn scannet_ratios(&self) -> Option<ThresholdRatios> {
        let under_angle = |degrees: f64| self.ratio(|error| error.rotation_degrees() < degrees);
        let under_length = |meters: f64| self.ratio(|error| error.translation < meters);
        // All of the ratios exist or none does: they count the same pairs.
        (!self.pairs.is_empty()).then(|| ThresholdRatios {
            rotation: SCANNET_DEGREES.map(|degrees| under_angle(degrees).unwrap_or_default()),
            translation: SCANNET_METERS.map(|meters| under_length(meters).unwrap_or_default()),
        })
    }

    fn ratio(&self, is_under: impl Fn(&PoseError) -> bool) -> Option<f64> {
        let under = self.errors().filter(|error| is_under(error)).count();
        (!self.pairs.is_empty()).then(|| under as f64 / self.pairs.len() as f64)
    }

    fn errors(&self) -> impl Iterator<Item = &PoseError> {
        self.pairs.iter().filter_map(|pair| pair.error.as_ref())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn errors(values: &[Option<(f64, f64)>]) -> PairErrors {
        let pose_error = |(degrees, translation): (f64, f64)| PoseError {
            rotation: degrees.to_radians(),
            translation,
        };
        let pair = |&value: &Option<(f64, f64)>| PairError {
            i: 0,
            j: 1,
            error: value.map(pose_error),
        };
        PairErrors {
            pairs: values.iter().map(pair).collect(),
        }
    }

    #[test]
    fn mean_and_median_leave_missing_pairs_out() {
        let found = errors(&[Some((1.0, 0.4)), None, Some((9.0, 0.1)), Some((2.0, 0.1))]);
        let (mean, median) = (found.mean().unwrap(), found.median().unwrap());
        assert_relative_eq!(mean.rotation_degrees(), 4.0, epsilon = 1e-12);
        assert_relative_eq!(mean.translation, 0.2, epsilon = 1e-12);
        assert_relative_eq!(median.rotation_degrees(), 2.0, epsilon = 1e-12);
        assert_eq!((median.translation, found.num_missing()), (0.1, 1));
    }

    #[test]
    fn the_median_of_an_even_number_is_the_mean_of_the_middle_two() {
        let found = errors(&[
            Some((1.0, 0.0)),
            Some((2.0, 1.0)),
            Some((4.0, 3.0)),
            Some((9.0, 5.0)),
        ]);
        let median = found.median().unwrap();
        assert_relative_eq!(median.rotation_degrees(), 3.0, epsilon = 1e-12);
        assert_eq!(median.translation, 2.0);
    }

    #[test]
    fn ratios_count_missing_pairs_and_thresholds_are_strict() {
        let found = errors(&[Some((4.0, 0.05)), Some((1.0, 0.2)), Some((40.0, 0.6)), None]);
        let ratios = found.scannet_ratios().unwrap();
        assert_eq!(ratios.rotation, [0.25, 0.5, 0.5, 0.5, 0.75]);
        assert_eq!(ratios.translation, [0.0, 0.25, 0.5, 0.5, 0.75]);
        assert_eq!(found.recall(), Some(0.5));
        assert_eq!(found.recall_within(1.0, 0.1), Some(0.25));
    }

    #[test]
    fn no_pairs_and_no_estimates_have_no_statistics() {
        let none = errors(&[]);
        assert_eq!(
            (none.mean(), none.median(), none.recall()),
            (None, None, None)
        );
        assert_eq!(none.scannet_ratios(), None);
        let missing = errors(&[None, None]);
        assert_eq!((missing.mean(), missing.recall()), (None, Some(0.0)));
        assert_eq!(
            missing.scannet_ratios().map(|ratios| ratios.rotation),
            Some([0.0; 5])
        );
    }

    #[test]
    fn another_number_of_ground_truth_poses_is_refused() {
        let poses = WorldPoses::of_one_frame(&[Isometry3::identity(); 3]);
        let error = PairErrors::of_all(&[Isometry3::identity(); 2], &poses).unwrap_err();
        assert_eq!(
            error,
            Error::LengthMismatch {
                what: "ground truth poses",
                expected: 3,
                found: 2
            }
        );
    }
}
