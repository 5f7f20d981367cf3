//! Evaluation protocols of multiview point cloud registration on plain values.
//!
//! A table in a paper is only as clear as the function that filled it. Each protocol here is one
//! function on poses, pairs and matrices, with its formula and its source:
//!
//! | question | item |
//! |---|---|
//! | which scan has which pose, which scans share a frame | [`WorldPoses`] |
//! | which pairs have a known relative pose | [`GroundTruthPair::of_list`], [`GroundTruthPair::all_pairs`] |
//! | which protocol judges a list of pairs | [`Protocol::of_list`] |
//! | ratio of registered pairs, 3DMatch and 3DLoMatch | [`registration_recall`], [`pairwise_recall`] |
//! | error of a relative pose as the recalls count it | [`registration_error`] |
//! | recall of many scenes | [`mean_recall`], [`pooled_recall`] |
//! | mean and deviation of repeated runs | [`Spread`] |
//! | rotation and translation errors of relative poses | [`pose_error`], [`PairErrors`] |
//! | tables of ratios under thresholds | [`PairErrors::scannet_ratios`], [`PairErrors::recall`] |
//! | errors of absolute poses | [`absolute_errors`], [`Gauge`], [`PoseError`] |
//! | how much scans overlap | [`OverlapIndex`], [`overlap_matrix`] |
//! | do the most confident neighbors overlap most, R@K and Regret | [`retrieval`], [`mean_retrieval`] |
//! | do the chosen pairs connect the scans | [`ConnectivitySummary`] |
//! | does a score tell inliers from outliers | [`auc`] |
//! | does the overlap grow with the confidence | [`overlap_deciles`], [`DecileSummary`] |
//!
//! ```
//! use gmpcr_eval::{GroundTruthPair, Protocol, WorldPoses, registration_recall};
//! use nalgebra::{Isometry3, Matrix6};
//!
//! let pair = GroundTruthPair {
//!     i: 0,
//!     j: 2,
//!     i_from_j: Isometry3::translation(1.0, 0.0, 0.0),
//!     information: Matrix6::identity(),
//! };
//! let world_from_scan = [0.0, 0.5, 1.1].map(|x| Isometry3::translation(x, 0.0, 0.0));
//! let poses = WorldPoses::of_one_frame(&world_from_scan);
//! let recall = registration_recall(&[pair], &poses, Protocol::ThreeDMatch)?;
//! assert_eq!(recall.ratio(), Some(1.0));
//! # Ok::<(), gmpcr_eval::Error>(())
//! ```
//!
//! `i_from_j` maps scan j's coordinates into scan i's frame, `world_from_scan` into the world:
//! `i_from_j = world_from_i⁻¹ · world_from_j`. Lengths are meters, angles radians unless a name
//! says degrees. Recalls and ratios lie between 0 and 1 and are `None` where there is nothing to
//! count.
//!
//! The feature `serde`, off by default, lets results, pairs and protocols be written to and read from
//! files.

mod absolute;
mod auc;
mod connectivity;
mod deciles;
mod error;
mod grid;
mod ground_truth;
mod information;
mod outcome;
mod overlap;
mod pair_errors;
mod pooling;
mod pose_error;
mod recall;
mod retrieval;
mod spread;
mod thresholds;
mod world;

pub use absolute::{Gauge, absolute_errors};
pub use auc::auc;
pub use connectivity::ConnectivitySummary;
pub use deciles::{DecileSummary, OverlapDeciles, SceneMean, overlap_deciles};
pub use error::Error;
pub use ground_truth::GroundTruthPair;
pub use information::registration_error;
pub use outcome::{Outcome, PairOutcome, Recall};
pub use overlap::{OverlapIndex, overlap_matrix};
pub use pair_errors::{PairError, PairErrors};
pub use pooling::{mean_recall, mean_retrieval, pooled_recall};
pub use pose_error::{PoseError, pose_error};
pub use recall::{Protocol, RECALL_DISTANCE, pairwise_recall, registration_recall};
pub use retrieval::{Retrieval, retrieval};
pub use spread::Spread;
pub use thresholds::{SCANNET_DEGREES, SCANNET_METERS, ThresholdRatios};
pub use world::WorldPoses;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
