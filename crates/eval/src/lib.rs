//! Evaluation protocols of multiview point cloud registration on plain values.
//!
//! A table in a paper is only as clear as the function that filled it. Each protocol here is one
//! function on poses, pairs and matrices, with its formula and its source:
//!
//! | question | item |
//! |---|---|
//! | which scan has which pose, which scans share a frame | [`WorldPoses`] |
//! | share of registered pairs, 3DMatch and 3DLoMatch | [`registration_recall`], [`pairwise_recall`], [`Protocol`] |
//! | the same for scenes without official matrices | [`information_matrix`], [`registration_error`] |
//! | recall of many scenes | [`mean_recall`], [`pooled_recall`] |
//! | mean and deviation of repeated runs | [`Spread`] |
//! | rotation and translation errors of relative motions | [`pose_error`], [`PairErrors`] |
//! | tables of shares under thresholds | [`PairErrors::scannet_shares`], [`PairErrors::recall`] |
//! | errors of absolute poses | [`absolute_errors`], [`Gauge`] |
//! | do the most confident neighbours overlap most, R@K and Regret | [`retrieval`], [`mean_retrieval`] |
//! | do the chosen pairs connect the scans | [`ConnectivitySummary`] |
//! | does a score tell inliers from outliers | [`auc`] |
//! | does the overlap grow with the confidence | [`overlap_deciles`], [`DecileSummary`] |
//!
//! ```
//! use gmpcr_eval::{GroundTruthPair, Protocol, RotationSign, WorldPoses, registration_recall};
//! use nalgebra::{Isometry3, Matrix6};
//!
//! let truth = GroundTruthPair {
//!     i: 0,
//!     j: 2,
//!     i_from_j: Isometry3::translation(1.0, 0.0, 0.0),
//!     information: Matrix6::identity(),
//! };
//! let world_from_scan = [0.0, 0.5, 1.1].map(|x| Isometry3::translation(x, 0.0, 0.0));
//! let poses = WorldPoses::of_one_frame(&world_from_scan);
//! let recall = registration_recall(&[truth], &poses, Protocol::ThreeDMatch, RotationSign::Benchmark)?;
//! assert_eq!(recall.share(), Some(1.0));
//! # Ok::<(), gmpcr_eval::Error>(())
//! ```
//!
//! `i_from_j` maps scan j's coordinates into scan i's frame, `world_from_scan` into the world:
//! `i_from_j = world_from_i⁻¹ · world_from_j`. Lengths are metres, angles radians unless a name
//! says degrees. Recalls and shares lie between 0 and 1 and are `None` where there is nothing to
//! count.

mod absolute;
mod connectivity;
mod error;
mod evidence;
mod information;
mod outcome;
mod pair_errors;
mod pooling;
mod pose_error;
mod recall;
mod retrieval;
mod shares;
mod spread;
mod truth;
mod world;

pub use absolute::{Gauge, absolute_errors};
pub use connectivity::ConnectivitySummary;
pub use error::Error;
pub use evidence::{DecileSummary, OverlapDeciles, SceneMean, auc, overlap_deciles};
pub use information::{RotationSign, information_matrix, registration_error};
pub use outcome::{Outcome, PairOutcome, Recall};
pub use pair_errors::{PairError, PairErrors};
pub use pooling::{mean_recall, mean_retrieval, pooled_recall};
pub use pose_error::{PoseError, pose_error};
pub use recall::{Protocol, RECALL_DISTANCE, pairwise_recall, registration_recall};
pub use retrieval::{Retrieval, retrieval};
pub use shares::{SCANNET_DEGREES, SCANNET_METRES, ThresholdShares};
pub use spread::Spread;
pub use truth::GroundTruthPair;
pub use world::WorldPoses;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
