use gmpcr_geometry::InvalidParameter;

use crate::params::PoseGraphParams;

/// A candidate scan pair and its raw geometric confidence.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ScoredPair {
    /// The lower scan index.
    pub i: usize,
    /// The higher scan index.
    pub j: usize,
    /// Raw confidence `ŝ_ij ≥ 0`.
    pub raw_confidence: f64,
}

/// The confidences of all candidate pairs of a set of scans, raw and normalized.
///
/// ```
/// use gmpcr_posegraph::{PairConfidences, PoseGraphParams, ScoredPair};
///
/// let pair = |i, j, raw_confidence| ScoredPair { i, j, raw_confidence };
/// let pairs = vec![pair(0, 1, 3.0), pair(0, 2, 0.0), pair(1, 2, 4.0)];
/// let confidences = PairConfidences::new(3, pairs)?;
/// assert_eq!(confidences.normalized(), [0.6, 0.0, 0.8]);
/// let edges = confidences.top_k_union(&PoseGraphParams { neighbors: 1 })?;
/// assert_eq!(edges, [0, 2]); // positions in the list: (0, 1) and (1, 2)
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// In files they are the number of scans and the pairs with their raw confidences.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "ScoredPairs")
)]
pub struct PairConfidences {
    num_scans: usize,
    pairs: Vec<ScoredPair>,
    #[cfg_attr(feature = "serde", serde(skip_serializing))]
    normalized: Vec<f64>,
}

/// Why a list of scored pairs is no [`PairConfidences`].
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ConfidenceError {
    /// A pair is not of the form `i < j < num_scans`.
    #[error("pair ({i}, {j}) is not of the form i < j < {num_scans}")]
    InvalidPair {
        /// First scan of the pair.
        i: usize,
        /// Second scan of the pair.
        j: usize,
        /// Number of scans.
        num_scans: usize,
    },
    /// The pairs are not strictly ascending by (i, j).
    #[error("pair ({i}, {j}) repeats or precedes the pair before it: pairs must ascend")]
    NotAscending {
        /// First scan of the pair.
        i: usize,
        /// Second scan of the pair.
        j: usize,
    },
    /// A confidence is negative or not finite.
    #[error("pair ({i}, {j}) has confidence {raw_confidence}: it must be finite and not negative")]
    InvalidConfidence {
        /// First scan of the pair.
        i: usize,
        /// Second scan of the pair.
        j: usize,
        /// Its confidence.
        raw_confidence: f64,
    },
}

impl PairConfidences {
    /// Normalizes the raw confidences of candidate pairs over all of them, `s = ŝ / ‖ŝ‖₂`; where
    /// all are zero they stay zero. The pairs need not be all pairs.
    ///
    /// # Errors
    /// [`ConfidenceError`] unless the pairs are strictly ascending by (i, j) with
    /// `i < j < num_scans`, and the confidences finite and not negative.
    pub fn new(num_scans: usize, pairs: Vec<ScoredPair>) -> Result<Self, ConfidenceError> {
        pairs
            .iter()
            .try_for_each(|pair| validate(pair, num_scans))?;
        if let Some(w) = pairs
            .windows(2)
            .find(|w| (w[0].i, w[0].j) >= (w[1].i, w[1].j))
        {
            let ScoredPair { i, j, .. } = w[1];
            return Err(ConfidenceError::NotAscending { i, j });
        }
        // Scaling by the largest first keeps the squares finite.
        let largest = pairs.iter().map(|p| p.raw_confidence).fold(0.0, f64::max);
        let scaled = pairs.iter().map(|p| p.raw_confidence / largest);
        let norm = scaled.map(|s| s * s).sum::<f64>().sqrt();
        let normalize = |raw: f64| {
            if largest > 0.0 {
                raw / largest / norm
            } else {
                0.0
            }
        };
        Ok(Self {
            num_scans,
            normalized: pairs.iter().map(|p| normalize(p.raw_confidence)).collect(),
            pairs,
        })
    }

    /// Number of scans.
    pub fn num_scans(&self) -> usize {
        self.num_scans
    }

    /// The candidate pairs with their raw confidences, ascending by (i, j).
    pub fn pairs(&self) -> &[ScoredPair] {
        &self.pairs
    }

    /// The normalized confidences `s_ij`, one per pair.
    pub fn normalized(&self) -> &[f64] {
        &self.normalized
    }

    /// Positions in [`pairs`](Self::pairs) of the union of the directed top-K neighborhoods,
    /// ascending.
    ///
    /// Each scan selects its `K` neighbors of highest confidence (ties: lower neighbor index); a
    /// pair that either scan selects is kept. Pairs of zero confidence are never selected, so that
    /// a scan may have fewer neighbors, or none. `O(P)` for `P` pairs.
    ///
    /// # Errors
    /// [`InvalidParameter`] if `params` are [out of range](PoseGraphParams::validate).
    pub fn top_k_union(&self, params: &PoseGraphParams) -> Result<Vec<usize>, InvalidParameter> {
        params.validate()?;
        let k = params.neighbors;
        let mut neighborhoods = vec![Vec::new(); self.num_scans];
        for (position, pair) in self.pairs.iter().enumerate() {
            if pair.raw_confidence > 0.0 {
                neighborhoods[pair.i].push((pair.raw_confidence, pair.j, position));
                neighborhoods[pair.j].push((pair.raw_confidence, pair.i, position));
            }
        }
        let mut selected = vec![false; self.pairs.len()];
        for mut neighbors in neighborhoods {
            if k < neighbors.len() {
                neighbors.select_nth_unstable_by(k, |a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
            }
            for &(_, _, position) in neighbors.iter().take(k) {
                selected[position] = true;
            }
        }
        let positions = (0..selected.len()).filter(|&position| selected[position]);
        Ok(positions.collect())
    }
}

/// The confidences as they stand in files.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
struct ScoredPairs {
    num_scans: usize,
    pairs: Vec<ScoredPair>,
}

#[cfg(feature = "serde")]
impl TryFrom<ScoredPairs> for PairConfidences {
    type Error = ConfidenceError;

    fn try_from(ScoredPairs { num_scans, pairs }: ScoredPairs) -> Result<Self, ConfidenceError> {
        Self::new(num_scans, pairs)
    }
}

fn validate(pair: &ScoredPair, num_scans: usize) -> Result<(), ConfidenceError> {
    let &ScoredPair {
        i,
        j,
        raw_confidence,
    } = pair;
    if i >= j || j >= num_scans {
        return Err(ConfidenceError::InvalidPair { i, j, num_scans });
    }
    if !(raw_confidence.is_finite() && raw_confidence >= 0.0) {
        return Err(ConfidenceError::InvalidConfidence {
            i,
            j,
            raw_confidence,
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn pair(i: usize, j: usize, raw_confidence: f64) -> ScoredPair {
        ScoredPair {
            i,
            j,
            raw_confidence,
        }
    }

    fn confidences() -> impl Strategy<Value = PairConfidences> {
        let value = prop_oneof![Just(0.0), Just(1.0), 0.0..9.0f64];
        (1..9usize, prop::collection::vec(value, 36)).prop_map(|(n, values)| {
            let pairs = (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j)));
            let scored = pairs.zip(values).map(|((i, j), v)| pair(i, j, v)).collect();
            PairConfidences::new(n, scored).unwrap()
        })
    }

    fn selected(confidences: &PairConfidences, neighbors: usize) -> Vec<usize> {
        let params = PoseGraphParams { neighbors };
        confidences.top_k_union(&params).unwrap()
    }

    proptest! {
        #[test]
        fn the_union_is_its_definition(c in confidences(), k in 1..10usize) {
            let confidence = |i: usize, j: usize| {
                let (i, j) = (i.min(j), i.max(j));
                c.pairs().iter().find(|p| (p.i, p.j) == (i, j)).map_or(0.0, |p| p.raw_confidence)
            };
            let selects = |i: usize, j: usize| {
                let is_ahead = |l: &usize| {
                    let (a, b) = (confidence(i, *l), confidence(i, j));
                    *l != i && (a > b || (a == b && *l < j))
                };
                confidence(i, j) > 0.0 && (0..c.num_scans()).filter(is_ahead).count() < k
            };
            let expected: Vec<usize> = (0..c.pairs().len())
                .filter(|&p| {
                    let ScoredPair { i, j, .. } = c.pairs()[p];
                    selects(i, j) || selects(j, i)
                })
                .collect();
            prop_assert_eq!(selected(&c, k), expected);
        }

        #[test]
        fn a_larger_neighborhood_keeps_the_smaller_ones_edges(c in confidences(), k in 1..8usize) {
            let larger = selected(&c, k + 1);
            prop_assert!(selected(&c, k).iter().all(|p| larger.contains(p)));
        }

        #[test]
        fn normalized_confidences_have_unit_norm_and_keep_their_order(c in confidences()) {
            let norm: f64 = c.normalized().iter().map(|s| s * s).sum();
            let all_zero = c.pairs().iter().all(|p| p.raw_confidence == 0.0);
            let expected = if all_zero { 0.0 } else { 1.0 };
            prop_assert!((norm - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn k_beyond_the_number_of_scans_keeps_every_positive_pair() {
        let pairs = vec![pair(0, 1, 1.0), pair(0, 2, 0.0), pair(1, 2, 2.0)];
        let c = PairConfidences::new(3, pairs).unwrap();
        assert_eq!(selected(&c, usize::MAX), [0, 2]);
    }

    #[test]
    fn huge_confidences_normalize_without_overflow() {
        let pairs = [(0, 1), (0, 2), (1, 2), (1, 3)].map(|(i, j)| pair(i, j, 1.7e308));
        let c = PairConfidences::new(4, pairs.to_vec()).unwrap();
        assert_eq!(c.normalized(), [0.5; 4]);
    }

    #[test]
    fn no_scan_and_one_scan_have_no_pairs() {
        for n in 0..2 {
            let c = PairConfidences::new(n, vec![]).unwrap();
            assert!(selected(&c, 6).is_empty());
        }
    }

    #[test]
    fn a_neighborhood_has_one_neighbor_at_least() {
        let c = PairConfidences::new(2, vec![pair(0, 1, 1.0)]).unwrap();
        let error = c.top_k_union(&PoseGraphParams { neighbors: 0 });
        assert_eq!(error.unwrap_err().name, "neighbors");
    }

    #[cfg(feature = "serde")]
    #[test]
    fn confidences_of_files_are_checked() {
        let pairs = vec![pair(0, 1, 1.5), pair(1, 2, 0.0)];
        let confidences = PairConfidences::new(3, pairs).unwrap();
        let text = serde_json::to_string(&confidences).unwrap();
        let read: PairConfidences = serde_json::from_str(&text).unwrap();
        assert_eq!(read, confidences);
        let fewer_scans = text.replace(r#""num_scans":3"#, r#""num_scans":2"#);
        let error = serde_json::from_str::<PairConfidences>(&fewer_scans).unwrap_err();
        assert!(error.to_string().contains("pair (1, 2)"), "{error}");
    }

    #[test]
    fn names_what_is_wrong_with_a_pair() {
        let error = |pairs| PairConfidences::new(3, pairs).unwrap_err().to_string();
        assert_eq!(
            error(vec![pair(1, 1, 0.0)]),
            "pair (1, 1) is not of the form i < j < 3"
        );
        assert_eq!(
            error(vec![pair(1, 3, 0.0)]),
            "pair (1, 3) is not of the form i < j < 3"
        );
        assert!(error(vec![pair(0, 1, -1.0)]).contains("confidence -1"));
        assert!(error(vec![pair(0, 1, f64::NAN)]).contains("confidence NaN"));
        assert!(error(vec![pair(0, 1, 1.0), pair(0, 1, 1.0)]).contains("pair (0, 1) repeats"));
    }
}
