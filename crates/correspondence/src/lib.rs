//! From scans to putative correspondences of a scan pair.
//!
//! A [`Scan`] holds `n` points and one local descriptor per point. Matching every point of every
//! scan with every other is redundant and grows with the square of the number of scans, so each
//! scan is first sampled: `N_s` keypoints in *descriptor* space keep rare descriptors and leave out the
//! thousandth copy of a flat wall. The keypoints of two scans are then matched mutually, and the `N_o` pairs of smallest descriptor distance become the correspondences `C_ij`
//! (Li et al., *Spectral Consistency-Guided Multiview Point Cloud Registration for Low-Overlap Scenes*, 2026, "the
//! paper" below, section "Initial Correspondence Construction").
//!
//! | step | function |
//! |---|---|
//! | farthest-point sampling in descriptor space | [`farthest_point_sampling`], [`Keypoints::sample`] |
//! | mutual nearest neighbors, ranked by distance | [`match_descriptors`] |
//! | the `N_o` best as point pairs | [`correspondences`] |
//!
//! Descriptors are `f32` of any dimension; every decision (which sample, which neighbor, which
//! order) is taken on distances in `f64`. This crate knows nothing of the geometry of a match.

mod descriptors;
mod error;
mod matching;
mod params;
mod sampling;
mod scan;

pub use descriptors::{Descriptors, DescriptorsError};
pub use error::{CorrespondenceError, DimensionsDiffer};
pub use gmpcr_geometry::{InvalidParameter, PointPairs};
pub use matching::{Match, correspondences, match_descriptors};
pub use params::CorrespondenceParams;
pub use sampling::{Keypoints, farthest_point_sampling, farthest_point_sampling_from};
pub use scan::{Scan, ScanError};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
