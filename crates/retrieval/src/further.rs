use std::cmp::Reverse;
use std::collections::BTreeMap;

use gmpcr_geometry::InvalidParameter;
use gmpcr_posegraph::{PairConfidences, PoseGraphParams};

use crate::RetrievalParams;
use crate::candidates::union;

/// Pairs that are not scored yet, of which either scan proposes the other because they have confident
/// neighbors in common: `(i, j)`, `i < j`, ascending.
///
/// Two scans are neighbors where either is among the `k = candidates_per_expansion` most confident of the
/// other ([`PairConfidences::top_k_union`]). Scan `i` proposes the `k` scans of largest `Σ s_im s_mj` over the neighbors `m` of both. Pairs of
/// zero confidence are no neighbors; ties go to the lower index. `O(P log P + Σ_m deg(m)² log N)` for `P`
/// scored pairs and `deg(m)` neighbors, at most `2 k` on average.
///
/// An empty result says that further rounds have nothing to add, as where there are fewer scans than
/// [`RetrievalParams::min_scans`] and all pairs were candidates.
///
/// # Errors
/// [`InvalidParameter`] if a parameter is out of range.
///
/// ```
/// use gmpcr_posegraph::{PairConfidences, ScoredPair};
/// use gmpcr_retrieval::{RetrievalParams, further_pairs};
///
/// let scored = [(0, 1, 9.0), (1, 2, 8.0), (2, 3, 0.0)];
/// let scored = scored.map(|(i, j, raw_confidence)| ScoredPair { i, j, raw_confidence });
/// let scored = PairConfidences::new(4, scored.to_vec())?;
/// let params = RetrievalParams { min_scans: 0, ..RetrievalParams::default() };
/// assert_eq!(further_pairs(&scored, &params)?, [(0, 2)]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn further_pairs(
    scored: &PairConfidences,
    params: &RetrievalParams,
) -> Result<Vec<(usize, usize)>, InvalidParameter> {
    params.validate()?;
    if scored.num_scans() < params.min_scans {
        return Ok(Vec::new());
    }
    let max_candidates = params.candidates_per_expansion;
    let neighborhoods = neighborhoods(scored, max_candidates)?;
    let proposals = (0..scored.num_scans()).map(|scan| {
        let is_new = |other| other != scan && !is_scored(scored, scan, other);
        let mut affinities = two_steps_away(scan, &neighborhoods);
        affinities.retain(|&(other, _)| is_new(other));
        best(affinities, max_candidates)
    });
    Ok(union(proposals).into_iter().collect())
}

/// A scan and how strong the tie to it is.
type Tie = (usize, f64);

/// The neighbors of each scan, ascending.
fn neighborhoods(scored: &PairConfidences, k: usize) -> Result<Vec<Vec<Tie>>, InvalidParameter> {
    let mut neighborhoods = vec![Vec::new(); scored.num_scans()];
    for position in scored.top_k_union(&PoseGraphParams { neighbors: k })? {
        let (pair, confidence) = (&scored.pairs()[position], scored.normalized()[position]);
        neighborhoods[pair.i].push((pair.j, confidence));
        neighborhoods[pair.j].push((pair.i, confidence));
    }
    Ok(neighborhoods)
}

/// Products of confidences, summed over the neighbors that lead to each scan.
fn two_steps_away(scan: usize, neighborhoods: &[Vec<Tie>]) -> Vec<Tie> {
    let mut sums = BTreeMap::new();
    for &(middle, first) in &neighborhoods[scan] {
        for &(other, second) in &neighborhoods[middle] {
            *sums.entry(other).or_insert(0.0) += first * second;
        }
    }
    sums.into_iter().collect()
}

/// The `k` strongest; equal ones: the lower scan.
fn best(mut ties: Vec<Tie>, k: usize) -> Vec<usize> {
    // Confidences are not negative, and the bits of such numbers are ordered as the numbers are.
    ties.sort_by_key(|&(scan, strength)| (Reverse(strength.to_bits()), scan));
    ties.into_iter().take(k).map(|(scan, _)| scan).collect()
}

fn is_scored(scored: &PairConfidences, a: usize, b: usize) -> bool {
    let pair = (a.min(b), a.max(b));
    let position = scored
        .pairs()
        .binary_search_by_key(&pair, |known| (known.i, known.j));
    position.is_ok()
}
