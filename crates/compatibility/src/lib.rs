//! Which correspondences of a scan pair agree with each other, and how much of a pair agrees.
//!
//! A rigid transformation preserves distances. Two correspondences `m`, `n` of scans i and j are therefore
//! compatible where the distance between their points is the same in both scans:
//!
//! ```text
//! δ_mn = | ‖x_m^i − x_n^i‖ − ‖x_m^j − x_n^j‖ |       rigidity discrepancy
//! a_mn = max(0, 1 − δ_mn² / τ_c²),  a_mm = 0          first-order graph A (FCG)
//! B    = A² ∘ A                                       second-order graph (SCG)
//! B v  = λ v                                          dominant eigenvector, nonnegative
//! ```
//!
//! An entry of `B` weighs direct agreement by the support of common neighbors, which
//! outliers rarely find. The entry `|v_m|` measures how far correspondence `m` takes part in
//! the largest coherent structure: the top fraction `r_s` is retained, the graphs are built again on
//! the retained set, and the dominant eigenvalue of the refined SCG is the pair's *raw confidence*
//! (Li et al., *Spectral Consistency-Guided Multiview Point Cloud Registration for Low-Overlap Scenes*, 2026, "the
//! paper" below, section "Spectral Consistency-Guided Scan Pair Selection"). No transformation is estimated.
//!
//! | step | item |
//! |---|---|
//! | FCG and SCG | [`CompatibilityGraph`] |
//! | dominant eigenvector | [`DominantEigenpair`] |
//! | retention, refined graph, raw confidence | [`SpectralFilter`] |

mod eigen;
mod filter;
mod graph;
mod params;

pub use eigen::{DominantEigenpair, Route};
pub use filter::SpectralFilter;
pub use gmpcr_geometry::{InvalidParameter, PointPairs};
pub use graph::CompatibilityGraph;
pub use params::CompatibilityParams;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
