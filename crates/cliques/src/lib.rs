//! The relative pose of two scans from correspondences of which many may be wrong.
//!
//! Correspondences that obey one rigid transformation are pairwise compatible: they form a clique of the
//! compatibility graph. So every large maximal clique is a hypothesis (Zhang et al., "3D
//! registration with maximal cliques", CVPR 2023; paper, section "Clique-Based Transformation
//! Estimation"):
//!
//! ```text
//! q(M)    = Σ_{m≠n ∈ M} b_mn / (|M| (|M| − 1))                    mean affinity ranks the cliques
//! R, t    = argmin Σ_{m ∈ M} |v_m| ‖x_m^i − (R x_m^j + t)‖²       weighted Kabsch
//! IR(R,t) = share of all correspondences with ‖x_m^i − (R x_m^j + t)‖ < τ_in
//! ```
//!
//! The hypothesis of highest inlier ratio among the top `K_c` cliques wins.
//!
//! | step | item |
//! |---|---|
//! | clique graph | [`BitGraph`] |
//! | enumeration with pivoting over a degeneracy order, under a work budget | [`for_each_maximal_clique`] |
//! | streaming top `K_c` by mean affinity | [`rank_cliques`] |
//! | weighted Kabsch | [`kabsch`] |
//! | hypothesis choice | [`estimate_pose`] |
//!
//! This crate knows one pair at a time. Of the larger libraries it needs nalgebra only.

mod enumeration;
mod graph;
mod kabsch;
mod pose;
mod ranking;

pub use enumeration::{Enumeration, for_each_maximal_clique};
pub use gmpcr_geometry::PointPairs;
pub use graph::BitGraph;
pub use kabsch::{Degenerate, kabsch};
pub use pose::{Compatibility, PoseEstimate, RelativePose, estimate_pose, inlier_ratio};
pub use ranking::{RankedClique, RankedCliques, rank_cliques};

/// Parameters of this stage. The default is the paper's setting for 3DMatch.
#[derive(Clone, Debug, PartialEq)]
pub struct CliqueParams {
    /// Cliques that generate hypotheses, `K_c`; at least 1. Default 10.
    pub max_cliques: usize,
    /// Distance below which a correspondence supports a transformation, `τ_in`, in the unit of the points;
    /// positive. Default 0.10 (meters, indoor scans).
    pub inlier_threshold: f64,
    /// First-order affinity above which two correspondences may share a clique, in [0, 1). The
    /// default 0 keeps every compatible pair; higher values thin out dense graphs.
    pub min_affinity: f64,
    /// Enumeration steps per pair before the best cliques so far are used; at least 1. A graph may
    /// have `3^(M/3)` maximal cliques (Moon and Moser 1965). Default 200 000, which takes some tens
    /// of milliseconds; ordinary pairs need a few hundred.
    pub work_budget: usize,
}

impl Default for CliqueParams {
    fn default() -> Self {
        Self {
            max_cliques: 10,
            inlier_threshold: 0.10,
            min_affinity: 0.0,
            work_budget: 200_000,
        }
    }
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
