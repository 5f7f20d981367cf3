//! Whether the most confident neighbors of a scan are those that overlap it most.

use std::cmp::Ordering;

use crate::pooling::mean_retrieval;

/// How well confidences rank the neighbors of the scans.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Retrieval {
    /// Recall@K (R@K): fraction of the chosen neighbors that are among those of highest overlap, between 0
    /// and 1.
    pub recall: f64,
    /// Mean overlap that the choice gives away, at least 0; in the unit of the overlaps.
    pub regret: f64,
}

/// R@K and Regret of one scene with the scans `0..num_scans`.
///
/// Each scan chooses the K others of highest confidence, `N(i)`. The best choice `T(i)` are the K
/// others of highest overlap o. With K = min(`k`, n − 1),
///
/// ```text
/// R@K    = 1/n · Σ_i |N(i) ∩ T(i)| / K
/// Regret = 1/n · Σ_i 1/K · (Σ_{j ∈ T(i)} o_ij − Σ_{j ∈ N(i)} o_ij)
/// ```
///
/// (paper, section "Pose Graph Construction Quality"). Of equal values the lower index comes
/// first, in both rankings; a value that is not a number comes last.
///
/// `confidence` and `overlap` are symmetric: they are asked for pairs i < j only, each pair twice.
/// `None` where there are fewer than two scans or `k` is 0. `O(n² log n)`.
///
/// ```
/// use gmpcr_eval::retrieval;
///
/// // Three scans. Scan 0 takes scan 2 for its nearest, but scan 1 overlaps it more.
/// let confidence = |i: usize, j: usize| [[0.0_f64, 5.0, 9.0], [0.0, 0.0, 1.0]][i][j];
/// let overlap = |i: usize, j: usize| [[0.0_f64, 0.75, 0.5], [0.0, 0.0, 0.25]][i][j];
/// let found = retrieval(3, 1, confidence, overlap);
/// assert!(found.is_some_and(|found| (found.recall - 2.0 / 3.0).abs() < 1e-12));
/// assert!(found.is_some_and(|found| (found.regret - 0.25 / 3.0).abs() < 1e-12));
/// ```
#[must_use]
pub fn retrieval(
    num_scans: usize,
    k: usize,
    confidence: impl Fn(usize, usize) -> f64,
    overlap: impl Fn(usize, usize) -> f64,
) -> Option<Retrieval> {
    if num_scans < 2 || k == 0 {
        return None;
    }
    let neighbor = |scan: usize, index: usize| {
        let (i, j) = (scan.min(index), scan.max(index));
        Neighbor {
            index,
            confidence: confidence(i, j),
            overlap: overlap(i, j),
        }
    };
    let scans = (0..num_scans).map(|scan| {
        let others = (0..num_scans).filter(|&other| other != scan);
        let neighbors = others.map(|other| neighbor(scan, other)).collect();
        retrieval_of_scan(neighbors, k.min(num_scans - 1))
    });
    // A mean over the scans is taken in the same way as one over scenes.
    mean_retrieval(&scans.collect::<Vec<_>>())
}

/// Another scan, as seen from the one that chooses.
struct Neighbor {
    index: usize,
    confidence: f64,
    overlap: f64,
}

fn retrieval_of_scan(mut neighbors: Vec<Neighbor>, k: usize) -> Retrieval {
    neighbors.sort_by(|a, b| descending(a.overlap, b.overlap).then(a.index.cmp(&b.index)));
    let chosen = overlap_ranks_of_chosen(&neighbors, k);
    let hits = chosen.iter().filter(|&&rank| rank < k).count();
    // Best against best, second against second: no term is negative, not even by rounding.
    let pairs = neighbors.iter().zip(&chosen);
    let given_away: f64 = pairs
        .map(|(best, &rank)| best.overlap - neighbors[rank].overlap)
        .sum();
    Retrieval {
        recall: hits as f64 / k as f64,
        regret: given_away / k as f64,
    }
}

/// Places of the `k` most confident neighbors in the list by overlap, ascending.
fn overlap_ranks_of_chosen(by_overlap: &[Neighbor], k: usize) -> Vec<usize> {
    let mut ranks: Vec<usize> = (0..by_overlap.len()).collect();
    ranks.sort_by(|&a, &b| {
        let (a, b) = (&by_overlap[a], &by_overlap[b]);
        descending(a.confidence, b.confidence).then(a.index.cmp(&b.index))
    });
    ranks.truncate(k);
    ranks.sort_unstable();
    ranks
}

/// The higher value first, NaN last; both zeros are equal.
fn descending(a: f64, b: f64) -> Ordering {
    b.partial_cmp(&a)
        .unwrap_or_else(|| a.is_nan().cmp(&b.is_nan()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Entry (i, j) above the diagonal of a 4×4 table, its rows written one after the other.
    fn upper(values: [f64; 6]) -> impl Fn(usize, usize) -> f64 {
        move |i, j| {
            assert!(i < j && j < 4);
            values[[0, 3, 5][i] + j - i - 1]
        }
    }

    /// Pairs (0,1) (0,2) (0,3) (1,2) (1,3) (2,3).
    const OVERLAP: [f64; 6] = [0.6, 0.4, 0.1, 0.5, 0.3, 0.2];

    #[test]
    fn four_scans_are_judged_as_by_hand() {
        // Chosen: {1, 3}, {2, 0}, {1, 3}, {0, 2}; best: {1, 2}, {0, 2}, {1, 0}, {1, 2}.
        let confidence = upper([0.8, 0.1, 0.9, 0.7, 0.2, 0.3]);
        let found = retrieval(4, 2, confidence, upper(OVERLAP)).unwrap();
        assert_relative_eq!(found.recall, (0.5 + 1.0 + 0.5 + 0.5) / 4.0);
        // Given away: 0.4 − 0.1, nothing, 0.4 − 0.2, 0.3 − 0.1, halved.
        assert_relative_eq!(
            found.regret,
            (0.15 + 0.0 + 0.1 + 0.1) / 4.0,
            epsilon = 1e-15
        );
    }

    #[test]
    fn a_scan_chooses_all_others_where_k_is_too_large() {
        let all = Some(Retrieval {
            recall: 1.0,
            regret: 0.0,
        });
        for k in [3, 4, usize::MAX] {
            assert_eq!(retrieval(4, k, |_, _| 0.0, upper(OVERLAP)), all);
        }
    }

    #[test]
    fn nothing_to_choose_from_has_no_retrieval() {
        for (num_scans, k) in [(0, 1), (1, 1), (4, 0)] {
            assert_eq!(retrieval(num_scans, k, |_, _| 1.0, |_, _| 1.0), None);
        }
    }

    #[test]
    fn of_equal_values_the_lower_index_comes_first() {
        let everywhere_alike = retrieval(4, 1, |_, _| 0.0, |_, _| -0.0);
        assert_eq!(everywhere_alike.map(|found| found.recall), Some(1.0));
        // Without any confidence scan 0 is chosen by all, and scan 1 by scan 0.
        let blind = retrieval(4, 1, |_, _| 0.0, upper([0.1, 0.6, 0.1, 0.5, 0.3, 0.2]));
        assert_eq!(blind.map(|found| found.recall), Some(0.25));
    }

    #[test]
    fn a_confidence_that_is_not_a_number_is_chosen_last() {
        let confidence = upper([f64::NAN, 0.4, 0.1, 0.5, 0.3, 0.2]);
        let lowest = upper([f64::NEG_INFINITY, 0.4, 0.1, 0.5, 0.3, 0.2]);
        let found = retrieval(4, 2, confidence, upper(OVERLAP));
        assert_eq!(found, retrieval(4, 2, lowest, upper(OVERLAP)));
        assert!(found.is_some_and(|found| found.recall < 1.0));
    }
}
