//! What can be wrong with the values to judge.

use thiserror::Error;

/// Why a protocol could not be applied.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Error {
    /// A pair names a scan that does not exist.
    #[error("pair ({i}, {j}) names a scan outside 0..{num_scans}")]
    NoSuchScan {
        /// First scan of the pair.
        i: usize,
        /// Second scan of the pair.
        j: usize,
        /// Number of scans.
        num_scans: usize,
    },
    /// A pair names the same scan twice.
    #[error("pair ({scan}, {scan}) names one scan twice")]
    SamePair {
        /// The scan.
        scan: usize,
    },
    /// Two lists that belong together differ in length.
    #[error("{expected} {what} are needed, one per scan, but there are {found}")]
    LengthMismatch {
        /// What the second list holds.
        what: &'static str,
        /// Its expected length.
        expected: usize,
        /// Its length.
        found: usize,
    },
}
