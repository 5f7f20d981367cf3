//! Which pairs of many scans are worth scoring.
//!
//! The confidence of a pair costs a matching of all its descriptors, and `N` scans have `N (N − 1) / 2`
//! pairs, most of which do not overlap. This crate proposes candidates in less than quadratic work, in
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
//! // Five scans in a row: each has a descriptor in common with the next.
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
//! assert_eq!(further_pairs(&scored, &params)?, [(0, 2), (1, 3), (2, 4)]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | step | item |
//! |---|---|
//! | candidates by descriptors | [`candidate_pairs`] |
//! | candidates by neighbors, round by round | [`further_pairs`] |
//! | the ranked candidates of one scan, as for place recognition | [`Index`] |
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
//! scored in it. With the default numbers of candidates, 400 scans of eight rooms have a fifth of their pairs scored, after
//! about ten rounds.

mod candidates;
mod error;
mod further;
mod index;
mod leaf;
mod params;
mod ranking;
mod rows;
mod tree;

pub use candidates::candidate_pairs;
pub use error::RetrievalError;
pub use further::further_pairs;
pub use gmpcr_geometry::InvalidParameter;
pub use index::Index;
pub use params::RetrievalParams;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
