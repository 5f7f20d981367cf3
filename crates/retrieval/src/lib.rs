//! Which pairs of many scans are worth scoring.
//!
//! The confidence of a pair costs a matching of all its descriptors, and `N` scans have `N (N − 1) / 2`
//! pairs, most of which share nothing. This crate proposes candidates in less than quadratic work, in
//! two steps:
//!
//! 1. **By descriptors.** Each descriptor looks for the scans that hold its nearest neighbors and
//!    votes for them; each scan proposes those with most votes ([`Index`], [`candidate_pairs`]). The
//!    neighbors are approximate: those within the leaves of a few random-projection trees (Dasgupta
//!    and Freund, STOC 2008).
//! 2. **By neighbors.** Descriptors alone miss many pairs of partial overlap. But a scan that overlaps
//!    a neighbor's neighbor is common, so once the candidates are scored, each scan proposes the
//!    neighbors of its most confident neighbors ([`further_pairs`]), which are scored in turn, and so
//!    on until nothing new is proposed or the rounds are over: neighbors of neighbors as in NN-descent (Dong, Moses and Li,
//!    WWW 2011), with the pair confidence as the similarity.
//!
//! ```
//! use gmpcr_correspondence::Descriptors;
//! use gmpcr_posegraph::{PairConfidences, ScoredPair};
//! use gmpcr_retrieval::{RetrievalParams, candidate_pairs, further_pairs};
//!
//! // Five scans in a row: each shares a descriptor with the next.
//! let scans: Vec<_> = [[0.0, 1.0], [1.0, 2.0], [2.0, 3.0], [3.0, 4.0], [4.0, 5.0]]
//!     .map(|values| Descriptors::new(values.to_vec(), 1))
//!     .into_iter()
//!     .collect::<Result<_, _>>()?;
//! let params = RetrievalParams { min_scans: 0, candidates_per_scan: 1, ..RetrievalParams::default() };
//! let pairs = candidate_pairs(&scans.iter().collect::<Vec<_>>(), &params)?;
//! assert_eq!(pairs, [(0, 1), (1, 2), (2, 3), (3, 4)]);
//!
//! let scored = pairs.iter().map(|&(i, j)| ScoredPair { i, j, raw_confidence: 7.0 });
//! let scored = PairConfidences::new(5, scored.collect())?;
//! assert_eq!(further_pairs(&scored, &params), [(0, 2), (1, 3), (2, 4)]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Everything is deterministic: the directions of the trees are fixed numbers, votes are whole numbers,
//! and ties go to the lower scan. Another order of the scans gives the same candidates, except where
//! descriptors or votes are equal.
//!
//! # Cost
//! For `N` scans of `n` descriptors of dimension `d`: a row takes part in 8 trees with leaves of at most
//! 64 rows, so that less than `8 · 63 / 2 · N n` distances are computed, and the trees take
//! `O(N n (d + 1) log(N n))`: as good as linear in the number of scans. Counting votes touches `N²` small
//! numbers (4 ms for 400 scans). A round of neighbors takes `O(P log P + N k² log N)` with `P` pairs scored and
//! `k` neighbors chosen by each scan, unless many scans choose the same one, and at most `N k` pairs are
//! scored in it. With the default, 400 scans of eight rooms have a fifth of their pairs scored, after
//! about ten rounds.

mod further;
mod index;
mod leaf;
mod ranking;
mod rows;
mod tree;

pub use further::further_pairs;
pub use index::Index;

use std::collections::BTreeSet;

use gmpcr_correspondence::{Descriptors, DimensionsDiffer};

/// How many pairs are proposed. More of them miss less.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RetrievalParams {
    /// Number of scans from which on pairs are retrieved; fewer scans have all their pairs scored.
    /// 0 always retrieves, [`usize::MAX`] never. Default 500; time is saved from about 150 on.
    pub min_scans: usize,
    /// Partners that each scan proposes by its descriptors, at least 1. Default 15.
    pub candidates_per_scan: usize,
    /// Rounds, at most, in which scans then propose neighbors of their neighbors, until there are no new
    /// ones; may be 0. Default 20.
    pub expansions: usize,
    /// Most confident partners of each scan that count as its neighbors in such a round, as do scans that
    /// count it as theirs; and partners that it then proposes, at least 1. Default 8.
    pub candidates_per_expansion: usize,
}

impl Default for RetrievalParams {
    fn default() -> Self {
        Self {
            min_scans: 500,
            candidates_per_scan: 15,
            expansions: 20,
            candidates_per_expansion: 8,
        }
    }
}

/// The pairs `(i, j)`, `i < j`, of which either scan proposes the other by its descriptors, ascending:
/// [`Index::candidates_of`] of every scan. All pairs where there are fewer scans than
/// [`RetrievalParams::min_scans`].
///
/// # Errors
/// [`DimensionsDiffer`] if descriptors of two scans have different dimensions, and pairs are retrieved. A
/// scan without descriptors has no dimension and no candidates.
///
/// # Panics
/// If there are 2³² scans or descriptors, or more.
pub fn candidate_pairs(
    scans: &[&Descriptors],
    params: &RetrievalParams,
) -> Result<Vec<(usize, usize)>, DimensionsDiffer> {
    if scans.len() < params.min_scans {
        let pairs = (0..scans.len()).flat_map(|i| (i + 1..scans.len()).map(move |j| (i, j)));
        return Ok(pairs.collect());
    }
    let index = Index::new(scans)?;
    let proposals =
        (0..scans.len()).map(|scan| index.candidates_of(scan, params.candidates_per_scan));
    Ok(union(proposals).into_iter().collect())
}

/// The pairs of the scans, in order, with those that they propose.
fn union(proposals: impl Iterator<Item = Vec<usize>>) -> BTreeSet<(usize, usize)> {
    let pairs = proposals
        .enumerate()
        .flat_map(|(scan, partners)| partners.into_iter().map(move |partner| (scan, partner)));
    pairs.map(|(a, b)| (a.min(b), a.max(b))).collect()
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
