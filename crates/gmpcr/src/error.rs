use gmpcr_correspondence::{DescriptorsError, DimensionsDiffer, ScanError};

use crate::Stage;

/// Why scans could not be registered at all.
///
/// Data that merely does not register (no overlap, too few points) is no error: see
/// [`Registration`](crate::Registration).
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Points and descriptors do not form a scan.
    #[error(transparent)]
    Scan(#[from] ScanError),
    /// Numbers do not form descriptors.
    #[error(transparent)]
    Descriptors(#[from] DescriptorsError),
    /// The list of scans is empty.
    #[error("no scans: at least one is needed")]
    NoScans,
    /// The descriptors of two scans have different dimensions.
    #[error(
        "scan {scan} has descriptors of dimension {dimension}, but scan {first} of dimension {expected}"
    )]
    DimensionsDiffer {
        /// The first scan with descriptors.
        first: usize,
        /// Its dimension.
        expected: usize,
        /// A scan that differs from it.
        scan: usize,
        /// The dimension of that scan.
        dimension: usize,
    },
    /// A parameter is out of range.
    #[error("parameter {name} is {value}: it must be {allowed}")]
    Parameter {
        /// The parameter, as its path within [`Params`](crate::Params).
        name: &'static str,
        /// Its value.
        value: f64,
        /// The admissible values.
        allowed: &'static str,
    },
    /// The [`Observer`](crate::Observer) ended the registration.
    #[error("cancelled during {stage}")]
    Cancelled {
        /// The stage that was under way.
        stage: Stage,
    },
    /// Features of a cloud could not be computed.
    #[cfg(feature = "features")]
    #[error("cloud {cloud}: {source}")]
    Features {
        /// Index of the cloud.
        cloud: usize,
        /// The reason.
        source: gmpcr_features::Error,
    },
}

impl Error {
    /// The dimensions of scans `i` and `j`.
    pub(crate) fn of_pair(i: usize, j: usize, differ: DimensionsDiffer) -> Self {
        Self::DimensionsDiffer {
            first: i,
            expected: differ.i,
            scan: j,
            dimension: differ.j,
        }
    }
}
