//! Registration recall of 3DMatch and 3DLoMatch.

use nalgebra::Isometry3;

use crate::error::Error;
use crate::information::{RotationSign, registration_error};
use crate::outcome::{Outcome, PairOutcome, Recall};
use crate::truth::{GroundTruthPair, check_pair};
use crate::world::WorldPoses;

/// Root mean square displacement up to which a pair counts as registered, in metres.
pub const RECALL_DISTANCE: f64 = 0.2;

/// Which pairs of a list count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Protocol {
    /// Pairs of consecutive scans, |i − j| = 1, are left out: they are too easy
    /// (Zeng et al., CVPR 2017).
    ThreeDMatch,
    /// All pairs count (Huang et al.: Predator, CVPR 2021).
    ThreeDLoMatch,
}

impl Protocol {
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
/// rigid motion of all poses changes nothing.
///
/// # Errors
/// [`Error::NoSuchScan`] or [`Error::SamePair`] for a pair that names other scans than two of
/// those that `poses` holds, whether it counts or not.
///
/// ```
/// use gmpcr_eval::{GroundTruthPair, Protocol, RotationSign, WorldPoses, registration_recall};
/// use nalgebra::{Isometry3, Matrix6};
///
/// let at = |x| Isometry3::translation(x, 0.0, 0.0);
/// let pair = |i, j, x| GroundTruthPair { i, j, i_from_j: at(x), information: Matrix6::identity() };
/// let poses = WorldPoses::of_one_frame(&[at(0.0), at(1.0), at(2.3)]);
/// let truth = [pair(0, 1, 1.0), pair(0, 2, 2.0)];
/// let lomatch = registration_recall(&truth, &poses, Protocol::ThreeDLoMatch, RotationSign::Benchmark)?;
/// let threedmatch = registration_recall(&truth, &poses, Protocol::ThreeDMatch, RotationSign::Benchmark)?;
/// assert_eq!((lomatch.share(), threedmatch.share()), (Some(0.5), Some(0.0)));
/// # Ok::<(), gmpcr_eval::Error>(())
/// ```
pub fn registration_recall(
    pairs: &[GroundTruthPair],
    poses: &WorldPoses,
    protocol: Protocol,
    sign: RotationSign,
) -> Result<Recall, Error> {
    pairwise_recall(pairs, poses.num_scans(), protocol, sign, |i, j| {
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
    sign: RotationSign,
    mut i_from_j: impl FnMut(usize, usize) -> Option<Isometry3<f64>>,
) -> Result<Recall, Error> {
    pairs
        .iter()
        .try_for_each(|pair| check_pair(pair.i, pair.j, num_scans))?;
    let counted = pairs.iter().filter(|pair| protocol.counts(pair.i, pair.j));
    let outcomes = counted.map(|truth| PairOutcome {
        i: truth.i,
        j: truth.j,
        outcome: judge(truth, i_from_j(truth.i, truth.j), sign),
    });
    Ok(Recall::of(outcomes.collect()))
}

fn judge(truth: &GroundTruthPair, estimate: Option<Isometry3<f64>>, sign: RotationSign) -> Outcome {
    let error_of = |motion| registration_error(&motion, &truth.i_from_j, &truth.information, sign);
    // Asked of the truth itself, so that a pair without an estimate is judged alike.
    if error_of(truth.i_from_j).is_none() {
        return Outcome::Unjudgeable;
    }
    match estimate.and_then(error_of) {
        Some(error) if error <= RECALL_DISTANCE * RECALL_DISTANCE => Outcome::Registered { error },
        Some(error) => Outcome::Missed { error },
        None => Outcome::NoEstimate,
    }
}
