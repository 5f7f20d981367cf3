//! The thresholds of published tables.

/// Rotation errors that ScanNet tables count pairs under, in degrees.
pub const SCANNET_DEGREES: [f64; 5] = [3.0, 5.0, 10.0, 30.0, 45.0];

/// Translation errors that ScanNet tables count pairs under, in meters.
pub const SCANNET_METERS: [f64; 5] = [0.05, 0.1, 0.25, 0.5, 0.75];

/// Rotation error under which a pair counts as recalled, in degrees.
pub(crate) const RECALL_DEGREES: f64 = 15.0;

/// Translation error under which a pair counts as recalled, in meters.
pub(crate) const RECALL_METERS: f64 = 0.3;

/// Ratios of pairs under each threshold, between 0 and 1.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct ThresholdRatios {
    /// Under each of [`SCANNET_DEGREES`].
    pub rotation: [f64; 5],
    /// Under each of [`SCANNET_METERS`].
    pub translation: [f64; 5],
}
