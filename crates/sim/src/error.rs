//! What can be wrong with the parameters of a simulation.

use thiserror::Error;

/// Why a scene or its scans could not be made.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// A count that must be at least one is zero.
    #[error("{name} is 0; at least 1 is needed")]
    Zero {
        /// The parameter.
        name: &'static str,
    },
    /// A parameter lies outside its range, or is not a number.
    #[error("{name} is {value}; it must lie in {min}..={max}")]
    OutOfRange {
        /// The parameter.
        name: &'static str,
        /// The value found.
        value: f64,
        /// Smallest admissible value.
        min: f64,
        /// Largest admissible value.
        max: f64,
    },
    /// A solid whose size is negative or whose size or place is not finite.
    #[error("primitive {index} has a negative or non-finite size or place")]
    BadPrimitive {
        /// Its place in the list.
        index: usize,
    },
    /// No viewpoint was found that keeps clear of the furniture and sees enough.
    #[error("no usable viewpoint for scan {scan} in {attempts} attempts")]
    NoViewpoint {
        /// The scan.
        scan: usize,
        /// Viewpoints tried.
        attempts: usize,
    },
}

/// `Ok` where `value` is a number in `min..=max`.
pub(crate) fn check_range(name: &'static str, value: f64, min: f64, max: f64) -> Result<(), Error> {
    if (min..=max).contains(&value) {
        Ok(())
    } else {
        Err(Error::OutOfRange {
            name,
            value,
            min,
            max,
        })
    }
}

/// Largest admissible count of anything.
const MAX_COUNT: f64 = 1e6;

/// `Ok` where `count` is at least one and not absurdly large.
pub(crate) fn check_count(name: &'static str, count: usize) -> Result<(), Error> {
    if count == 0 {
        Err(Error::Zero { name })
    } else {
        check_range(name, count as f64, 1.0, MAX_COUNT)
    }
}
