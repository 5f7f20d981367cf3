//! Which scan pairs are worth a pose estimate, and the pose graph that they form.
//!
//! Every candidate pair has a raw confidence `ŝ_ij` from the geometry of its correspondences.
//! Normalized, `s = ŝ / ‖ŝ‖₂`, the confidences choose the edges *before* any pose is estimated: an
//! edge is kept if either scan counts the other among its `K` most confident neighbors,
//!
//! ```text
//! E_p = {(i, j) : i < j, j ∈ N_K(i) or i ∈ N_K(j)}
//! ```
//!
//! (Li et al., *Spectral Consistency-Guided Multiview Point Cloud Registration for Low-Overlap Scenes*, 2026, "the
//! paper" below, section "Spectral Consistency-Guided Scan Pair Selection").
//!
//! | step | item |
//! |---|---|
//! | normalized confidences, top-K union | [`PairConfidences`], [`PoseGraphParams`] |
//! | connected components | [`Components`] |
//! | connectivity figures of the paper's table | [`Connectivity`] |
//! | weakest connections | [`maximum_spanning_forest`] |
//! | edges that alone connect parts of a graph | [`bridges`] |
//! | the graph of relative poses | [`PoseGraph`], [`PoseEdge`] |
//!
//! This crate knows scans by their index only: no points, no descriptors. With the feature `serde`,
//! parameters and results can be written to and read from files.

mod bridges;
mod components;
mod confidence;
mod connectivity;
mod disjoint_sets;
mod graph;
mod params;
mod spanning_forest;

pub use bridges::{Bridge, bridges};
pub use components::Components;
pub use confidence::{ConfidenceError, PairConfidences, ScoredPair};
pub use connectivity::Connectivity;
pub use gmpcr_geometry::InvalidParameter;
pub use graph::{PoseEdge, PoseGraph, PoseGraphError};
pub use params::PoseGraphParams;
pub use spanning_forest::maximum_spanning_forest;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
