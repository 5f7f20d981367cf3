//! How each pair of a list fared.

/// How one pair fared.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Outcome {
    /// The error is within the limit.
    Registered {
        /// Squared error in m².
        error: f64,
    },
    /// The error is beyond the limit, or not a number.
    Missed {
        /// Squared error in m².
        error: f64,
    },
    /// The two scans share no frame.
    NoEstimate,
    /// The pair's information matrix is empty. Counts as not registered.
    Unjudgeable,
}

/// One pair of the list and how it fared.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PairOutcome {
    /// First scan.
    pub i: usize,
    /// Second scan.
    pub j: usize,
    /// How it fared.
    pub outcome: Outcome,
}

/// Registration recall of one scene, pair by pair.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Recall {
    /// Registered pairs.
    pub registered: usize,
    /// Pairs that count: all of the list but those the protocol leaves out.
    pub total: usize,
    /// The counted pairs, in the order of the list.
    pub pairs: Vec<PairOutcome>,
    /// Counted pairs that could not be judged, in the order of the list.
    pub unjudgeable: Vec<(usize, usize)>,
}

impl Recall {
    pub(crate) fn of(pairs: Vec<PairOutcome>) -> Self {
        let is_registered =
            |pair: &&PairOutcome| matches!(pair.outcome, Outcome::Registered { .. });
        let is_unjudgeable = |pair: &&PairOutcome| pair.outcome == Outcome::Unjudgeable;
        Self {
            registered: pairs.iter().filter(is_registered).count(),
            total: pairs.len(),
            unjudgeable: pairs
                .iter()
                .filter(is_unjudgeable)
                .map(|pair| (pair.i, pair.j))
                .collect(),
            pairs,
        }
    }

    /// `registered / total`, between 0 and 1; `None` where no pair counts.
    #[must_use]
    pub fn ratio(&self) -> Option<f64> {
        (self.total > 0).then(|| self.registered as f64 / self.total as f64)
    }
}
