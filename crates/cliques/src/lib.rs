//! The relative pose of two scans from correspondences of which many may be outliers.
//!
//! Correspondences that obey one rigid transformation are pairwise compatible: they form a clique of the
//! compatibility graph. So every large maximal clique is a hypothesis (Zhang et al., "3D
//! registration with maximal cliques", CVPR 2023; Li et al., *Spectral Consistency-Guided Multiview Point Cloud
//! Registration for Low-Overlap Scenes*, 2026, "the paper" below, section "Clique-Based Transformation
//! Estimation"):
//!
//! ```text
//! q(M)    = Σ_{m≠n ∈ M} b_mn / (|M| (|M| − 1))                    mean affinity ranks the cliques
//! R, t    = argmin Σ_{m ∈ M} |v_m| ‖x_m^i − (R x_m^j + t)‖²       weighted Kabsch
//! IR(R,t) = fraction of all correspondences with ‖x_m^i − (R x_m^j + t)‖ < τ_in
//! ```
//!
//! The hypothesis of highest inlier ratio among the top `K_c` cliques wins.
//!
//! | step | item |
//! |---|---|
//! | clique graph | [`BitGraph`] |
//! | enumeration with pivoting over a degeneracy order, under a work budget | [`for_each_maximal_clique`] |
//! | weighted Kabsch | [`kabsch`] |
//! | all of it: the best of the top `K_c` cliques | [`estimate_pose`] |
//! | what a transformation explains | [`inliers`], [`inlier_ratio`] |
//! | how well the points determine it | [`information_matrix`] |
//!
//! This crate knows one pair at a time. Of the larger libraries it needs nalgebra only.

mod enumeration;
#[cfg(test)]
mod golden;
mod graph;
mod information;
mod inliers;
mod kabsch;
mod params;
mod pose;
mod ranking;

pub use enumeration::{Enumeration, for_each_maximal_clique};
pub use gmpcr_geometry::{InvalidParameter, PointPairs};
pub use graph::BitGraph;
pub use information::information_matrix;
pub use inliers::{inlier_ratio, inliers};
pub use kabsch::{Degenerate, kabsch};
pub use params::CliqueParams;
pub use pose::{Compatibility, PoseEstimate, RelativePose, estimate_pose};
pub use ranking::RankedClique;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
