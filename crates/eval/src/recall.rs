//! Registration recall of 3DMatch and 3DLoMatch.

use nalgebra::Isometry3;

use crate::error::Error;
use crate::ground_truth::{GroundTruthPair, check_pair};
use crate::information::registration_error;
use crate::outcome::{Outcome, PairOutcome, Recall};
use crate::world::WorldPoses;

/// Root mean square displacement up to which a pair counts as registered, in meters.
pub const RECALL_DISTANCE: f64 = 0.2;

/// The protocol that judges a list of pairs by their information matrices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Protocol {
    /// Pairs of consecutive scans, |i − j| = 1, are left out: they are too easy
    /// (Zeng et al., CVPR 2017).
    ThreeDMatch,
    /// All pairs count (Huang et al.: Predator, CVPR 2021).
    ThreeDLoMatch,
}

impl Protocol {
    /// The protocol of a list: which pairs count for registration recall. `None` for a list without
    /// information matrices, which [`PairErrors::recall`](crate::PairErrors::recall) judges: a pair within
    /// 15° and 0.3 m is registered, and all pairs count.
    ///
    /// Consecutive pairs are left out of the list of 3DMatch only. It is called `gt` in 3DMatch's own
    /// release, and elsewhere has `3dmatch` in its name, in any case. Lists of other names are counted in
    /// full.
    ///
    /// ```
    /// use gmpcr_eval::Protocol;
    ///
    /// for name in ["gt", "3dmatch", "official_3DMatch"] {
    ///     assert_eq!(Protocol::of_list(name, true), Some(Protocol::ThreeDMatch));
    /// }
    /// for name in ["3dlomatch", "gtLo", "office"] {
    ///     assert_eq!(Protocol::of_list(name, true), Some(Protocol::ThreeDLoMatch));
    /// }
    /// assert_eq!(Protocol::of_list("gt", false), None);
    /// ```
    #[must_use]
    pub fn of_list(name: &str, has_information: bool) -> Option<Self> {
        let name = name.to_ascii_lowercase();
        let is_of_3dmatch = name == "gt" || name.contains("3dmatch");
        has_information.then_some(if is_of_3dmatch {
            Self::ThreeDMatch
        } else {
            Self::ThreeDLoMatch
        })
    }

    /// Whether the pair (i, j) counts.
    #[must_use]
    pub fn counts(self, i: usize, j: usize) -> bool {
        match self {
            Self::ThreeDMatch => i.abs_diff(j) != 1,
            Self::ThreeDLoMatch => true,
        }
    }
}

/// Registration recall of absolute poses on a benchmark's list of pairs.
///
/// A pair is registered where [`registration_error`] of its relative pose is at most
/// [`RECALL_DISTANCE`]². Scans of different components, or without a pose, are not registered;
/// pairs with `Ω₀₀ ≤ 0` cannot be judged, are named, and count as not registered. A common
/// transformation of all poses changes nothing.
///
/// # Errors
/// [`Error::NoSuchScan`] or [`Error::SamePair`] for a pair that names other scans than two of
/// those that `poses` holds, whether it counts or not.
///
/// ```
/// use gmpcr_eval::{GroundTruthPair, Protocol, WorldPoses, registration_recall};
/// use nalgebra::{Isometry3, Matrix6};
///
/// let at = |x| Isometry3::translation(x, 0.0, 0.0);
/// let pair = |i, j, x| GroundTruthPair { i, j, i_from_j: at(x), information: Matrix6::identity() };
/// let poses = WorldPoses::of_one_frame(&[at(0.0), at(1.0), at(2.3)]);
/// let ground_truth = [pair(0, 1, 1.0), pair(0, 2, 2.0)];
/// let lomatch = registration_recall(&ground_truth, &poses, Protocol::ThreeDLoMatch)?;
/// let threedmatch = registration_recall(&ground_truth, &poses, Protocol::ThreeDMatch)?;
/// assert_eq!((lomatch.ratio(), threedmatch.ratio()), (Some(0.5), Some(0.0)));
/// # Ok::<(), gmpcr_eval::Error>(())
/// ```
pub fn registration_recall(
    pairs: &[GroundTruthPair],
    poses: &WorldPoses,
    protocol: Protocol,
) -> Result<Recall, Error> {
    pairwise_recall(pairs, poses.num_scans(), protocol, |i, j| {
        poses.i_from_j(i, j)
    })
}

/// [`registration_recall`] of relative poses: `i_from_j(i, j)` gives the estimate of a pair, or
/// `None` where there is none. Called once for each pair that counts.
///
/// # Errors
/// As [`registration_recall`], for scans outside `0..num_scans`.
pub fn pairwise_recall(
    pairs: &[GroundTruthPair],
    num_scans: usize,
    protocol: Protocol,
    mut i_from_j: impl FnMut(usize, usize) -> Option<Isometry3<f64>>,
) -> Result<Recall, Error> {
    pairs
        .iter()
        .try_for_each(|pair| check_pair(pair.i, pair.j, num_scans))?;
    let counted = pairs.iter().filter(|pair| protocol.counts(pair.i, pair.j));
    let outcomes = counted.map(|pair| PairOutcome {
        i: pair.i,
        j: pair.j,
        outcome: judge(pair, i_from_j(pair.i, pair.j)),
    });
    Ok(Recall::of(outcomes.collect()))
}

fn judge(ground_truth: &GroundTruthPair, estimate: Option<Isometry3<f64>>) -> Outcome {
    let GroundTruthPair {
        i_from_j: true_i_from_j,
        information,
        ..
    } = ground_truth;
    let error_of = |i_from_j| registration_error(&i_from_j, true_i_from_j, information);
    // Asked of the ground truth itself, so that a pair without an estimate is judged alike.
    if error_of(*true_i_from_j).is_none() {
        return Outcome::Unjudgeable;
    }
    match estimate.and_then(error_of) {
        Some(error) if error <= RECALL_DISTANCE * RECALL_DISTANCE => Outcome::Registered { error },
        Some(error) => Outcome::Missed { error },
        None => Outcome::NoEstimate,
    }
}
