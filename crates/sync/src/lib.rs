//! Globally consistent poses from measured relative poses of which some may be outliers.
//!
//! Given edges `T̂_ij ≈ T_i⁻¹ T_j` with initial weights, each iteration solves for all rotations,
//! then compares every edge with them, and reweights it (Li et al., *Spectral
//! Consistency-Guided Multiview Point Cloud Registration for Low-Overlap Scenes*, 2026, "the paper" below, section
//! "Adaptive History-aware Pose Synchronization"):
//!
//! ```text
//! {R_i} = argmin Σ w_ij ‖R̂_ij − R_iᵀ R_j‖_F²          three smallest eigenvectors of the
//!                                                     connection Laplacian, projected to SO(3)
//! r_ij  = d_R(R_iᵀ R_j, R̂_ij) / s_r                    rotation residual
//! w_ij  = w⁰_ij exp(−h_ij + ρ g_ij) ≤ w⁰_ij            residual history h, recovery g
//! {t_i} = argmin Σ w_ij ‖R_i t̂_ij + t_i − t_j‖²        weighted least squares, once at the end
//! ```
//!
//! The translations do not enter the weights, so they are solved once, under the final ones.
//!
//! | step | item |
//! |---|---|
//! | everything, component by component | [`synchronize`], [`SyncParams`] |
//! | other methods, same graph | [`Method`] |
//! | rotations under given weights | [`average_rotations`] |
//! | translations under given rotations and weights | [`solve_translations`] |
//! | how far edges are from given poses | [`edge_residuals`] |
//!
//! Every system is sparse and factored by faer's Cholesky decomposition, whose ordering is found once for
//! all iterations: thousands of poses take seconds. Where the factor would have more than 128 numbers for
//! each of the matrix, as in graphs of thousands of scans joined at random, conjugate gradients and
//! polynomials of the matrix take its place, so that memory is linear in the edges ([`Method::EigSe3`],
//! whose matrix joins neighbors of neighbors, needs `Σ deg²`). Nothing here is random, threaded or
//! global: the same graph gives the same bits.
//!
//! With the feature `serde`, parameters and results can be written to and read from files.

mod averaging;
mod cholesky;
mod conjugate_gradients;
mod consensus;
mod eigenspace;
mod eigse3;
mod hara;
mod history;
mod history_aware;
mod laplacian;
mod lie_averaging;
mod loss;
mod method;
mod params;
mod parts;
mod pattern;
mod report;
mod residuals;
mod reweighting;
#[cfg(feature = "serde")]
mod rotation_rows;
mod solution;
mod subgraph;
mod synchronize;
mod translations;
mod triangles;

pub use averaging::{AveragedRotations, average_rotations};
pub use gmpcr_geometry::InvalidParameter;
pub use method::{Method, UnknownMethod};
pub use params::{AdaptiveHistory, SyncParams};
pub use report::{ComponentReport, EdgeReport, Iteration, Synchronization};
pub use residuals::{EdgeResidual, edge_residuals};
pub use synchronize::synchronize;
pub use translations::{SolvedTranslations, solve_translations};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
