//! What can be invalid about the parameters of a simulation.

use std::ops::RangeInclusive;

pub use gmpcr_geometry::InvalidParameter;
use thiserror::Error;

/// Why scans or a pose graph could not be simulated.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter is out of range.
    #[error(transparent)]
    Parameter(#[from] InvalidParameter),
    /// No viewpoint was found that keeps clear of the furniture and sees enough.
    #[error("no usable viewpoint for scan {scan} in {attempts} attempts")]
    NoViewpoint {
        /// The scan.
        scan: usize,
        /// Viewpoints tried.
        attempts: usize,
    },
}

/// `Ok` where `value` is a number of the range.
pub(crate) fn check_range(
    name: &str,
    value: f64,
    range: RangeInclusive<f64>,
    allowed: &'static str,
) -> Result<(), InvalidParameter> {
    InvalidParameter::check(range.contains(&value), name, value, allowed)
}

/// `Ok` where `count` is at least one and not absurdly large.
pub(crate) fn check_count(name: &str, count: usize) -> Result<(), InvalidParameter> {
    check_range(name, count as f64, 1.0..=1e6, "in [1, 1e6]")
}
