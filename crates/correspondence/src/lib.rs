//! From described scans to putative correspondences of a scan pair.
//!
//! A [`Scan`] holds `n` points and one local descriptor per point. Matching every point of every
//! scan with every other is redundant and grows with the square of the number of scans, so each
//! scan is first thinned to `N_s` representative points in *descriptor* space, which keeps rare
//! descriptors and drops the thousandth copy of a flat wall. Two thinned scans are then matched
//! mutually, and the `N_o` pairs of smallest descriptor distance become the correspondences `C_ij`
//! (paper, section "Initial Correspondence Construction").
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
mod matching;
mod sampling;
mod scan;

pub use descriptors::{Descriptors, DescriptorsError};
pub use gmpcr_geometry::PointPairs;
pub use matching::{DimensionsDiffer, Match, correspondences, match_descriptors};
pub use sampling::{Keypoints, farthest_point_sampling, farthest_point_sampling_from};
pub use scan::{Scan, ScanError};

/// Parameters of this stage. The default is the paper's setting for 3DMatch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CorrespondenceParams {
    /// Keypoints kept per scan, `N_s`; at least 3. A smaller scan keeps all its points.
    /// Default 200.
    pub num_samples: usize,
    /// Matches kept per scan pair, `N_o`; at least 3. Default 100.
    pub max_correspondences: usize,
}

impl Default for CorrespondenceParams {
    fn default() -> Self {
        Self {
            num_samples: 200,
            max_correspondences: 100,
        }
    }
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
