//! Which scan pairs are worth a pose estimate, and the pose graph that they form.
//!
//! Every candidate pair has a raw confidence `ŝ_ij` from the geometry of its correspondences.
//! Normalised, `s = ŝ / ‖ŝ‖₂`, the confidences choose the edges *before* any pose is estimated: an
//! edge is kept if either scan counts the other among its `K` most confident neighbours,
//!
//! ```text
//! E_p = {(i, j) : i < j, j ∈ N_K(i) or i ∈ N_K(j)}
//! ```
//!
//! (paper, section "Spectral Consistency-Guided Scan Pair Selection").
//!
//! | step | item |
//! |---|---|
//! | normalised confidences, top-K union | [`PairConfidences`] |
//! | connected components | [`Components`] |
//! | connectivity figures of the paper's table | [`Connectivity`] |
//! | the graph of relative poses | [`PoseGraph`], [`PoseEdge`] |
//!
//! This crate knows scans by their index only: no points, no descriptors.

mod components;
mod confidence;
mod graph;

pub use components::{Components, Connectivity};
pub use confidence::{ConfidenceError, PairConfidences, ScoredPair};
pub use graph::{PoseEdge, PoseGraph, PoseGraphError};

/// Parameters of this stage. The default is the paper's setting for 3DMatch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PoseGraphParams {
    /// Most confident neighbours that each scan proposes as edges, `K`; at least 1. Default 6.
    pub neighbors: usize,
}

impl Default for PoseGraphParams {
    fn default() -> Self {
        Self { neighbors: 6 }
    }
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
