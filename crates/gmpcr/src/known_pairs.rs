use std::collections::BTreeMap;

use gmpcr_cliques::PoseEstimate;

use crate::{PairRegistration, ScanId};

/// What is known of pairs of scans, so that it need not be computed again: one number per scored pair, one
/// estimate per selected pair. The id of the earlier scan comes first.
#[derive(Clone, Debug, Default)]
pub(crate) struct KnownPairs {
    /// Raw confidences.
    scores: BTreeMap<(ScanId, ScanId), f64>,
    /// Of the pairs that the last run selected.
    estimates: BTreeMap<(ScanId, ScanId), EstimatedPair>,
}

/// What a selected pair has to say about its relative pose.
#[derive(Clone, Debug)]
pub(crate) struct EstimatedPair {
    pub num_correspondences: usize,
    pub num_retained: usize,
    pub estimate: PoseEstimate,
}

impl KnownPairs {
    pub fn score(&self, i: ScanId, j: ScanId) -> Option<f64> {
        self.scores.get(&(i, j)).copied()
    }

    pub fn insert_score(&mut self, i: ScanId, j: ScanId, raw_confidence: f64) {
        self.scores.insert((i, j), raw_confidence);
    }

    pub fn estimate(&self, i: ScanId, j: ScanId) -> Option<&EstimatedPair> {
        self.estimates.get(&(i, j))
    }

    /// Keeps the estimates of the pairs that were selected last, and only these.
    pub fn replace_estimates(&mut self, estimates: BTreeMap<(ScanId, ScanId), EstimatedPair>) {
        self.estimates = estimates;
    }

    /// Forgets the pairs of a scan.
    pub fn remove(&mut self, scan: ScanId) {
        self.scores.retain(|&(i, j), _| i != scan && j != scan);
        self.estimates.retain(|&(i, j), _| i != scan && j != scan);
    }
}

impl From<PairRegistration> for EstimatedPair {
    fn from(pair: PairRegistration) -> Self {
        Self {
            num_correspondences: pair.correspondences.len(),
            num_retained: pair.retained.len(),
            estimate: pair.estimate,
        }
    }
}
