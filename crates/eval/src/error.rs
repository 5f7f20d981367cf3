//! What can be invalid about the values to judge.

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
    #[error("{expected} {what} are needed, but there are {found}")]
    LengthMismatch {
        /// What the second list holds.
        what: &'static str,
        /// Its expected length: that of the first.
        expected: usize,
        /// Its length.
        found: usize,
    },
    /// A value that has to be ranked or averaged is not a number.
    #[error("{what}[{index}] is not a number")]
    NotANumber {
        /// What the list holds.
        what: &'static str,
        /// Place of the first such value, from 0.
        index: usize,
    },
}

/// `Ok` where a list of `what` has the length of the one that it belongs to.
pub(crate) fn check_length(what: &'static str, expected: usize, found: usize) -> Result<(), Error> {
    if expected == found {
        Ok(())
    } else {
        Err(Error::LengthMismatch {
            what,
            expected,
            found,
        })
    }
}

/// `Ok` where no value is NaN; infinities pass.
pub(crate) fn check_numbers(what: &'static str, values: &[f64]) -> Result<(), Error> {
    match values.iter().position(|value| value.is_nan()) {
        Some(index) => Err(Error::NotANumber { what, index }),
        None => Ok(()),
    }
}
