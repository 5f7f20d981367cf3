//! Globally consistent poses from measured relative poses of which some may be wrong.
//!
//! Given edges `T̂_ij ≈ T_i⁻¹ T_j` with initial weights, each iteration solves for all rotations,
//! then judges every edge by how well it agrees with them, and reweights it (paper, section
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
//! | everything, component by component | [`synchronize`] |
//! | rotations under given weights | [`average_rotations`] |
//! | translations under given rotations and weights | [`solve_translations`] |
//! | reweighting schemes | [`History`], [`EdgeHistory`] |
//! | other methods, same graph | [`Method`] |
//!
//! Every system is sparse and factored by faer's Cholesky decomposition, whose ordering is found once for
//! all iterations: thousands of poses take seconds. Where the factor would have more than 128 numbers for
//! each of the matrix, as in graphs of thousands of scans joined at random, conjugate gradients and
//! polynomials of the matrix take its place, so that memory is linear in the edges ([`Method::EigSe3`],
//! whose matrix joins neighbours of neighbours, needs `Σ deg²`). Nothing here is random, threaded or global: the same graph gives the same bits.

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
mod method;
mod pattern;
mod subgraph;
mod synchronize;
mod translations;
mod triangles;

pub use averaging::{AveragedRotations, average_rotations};
pub use gmpcr_posegraph::{Components, PoseEdge, PoseGraph, PoseGraphError};
pub use history::{AdaptiveHistory, EdgeHistory, History, Update};
pub use method::{Method, RobustLoss, UnknownMethod};
pub use synchronize::{ComponentReport, EdgeReport, Iteration, Synchronization, synchronize};
pub use translations::{SolvedTranslations, solve_translations};

/// Parameters of this stage. The default is the paper's setting for 3DMatch.
#[derive(Clone, Debug, PartialEq)]
pub struct SyncParams {
    /// Reweighting iterations, `L`, at most 100 000; 0 solves once with the initial weights.
    /// Default 10.
    pub iterations: usize,
    /// Rotation residual that counts as one, `s_r`, in radians; positive. Default 5°.
    pub residual_scale: f64,
    /// How the graph is synchronised. Default: the paper's adaptive history.
    pub method: Method,
}

impl Default for SyncParams {
    fn default() -> Self {
        Self {
            iterations: 10,
            residual_scale: 5f64.to_radians(),
            method: Method::default(),
        }
    }
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
