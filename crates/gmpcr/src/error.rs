use gmpcr_correspondence::{CorrespondenceError, DescriptorsError, ScanError};
use gmpcr_geometry::InvalidParameter;
use gmpcr_retrieval::RetrievalError;

use crate::{MAX_CORRESPONDENCES, ScanId, Stage};

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
    /// The descriptors of two scans have different dimensions. Scans are named by their positions, those that
    /// were added earlier included.
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
    /// A parameter is out of range; it is named by its path within [`Params`](crate::Params).
    #[error(transparent)]
    Parameter(#[from] InvalidParameter),
    /// Two scans cannot be matched, for another reason.
    #[error(transparent)]
    Correspondence(CorrespondenceError),
    /// Pairs of scans cannot be retrieved.
    #[error(transparent)]
    Retrieval(#[from] RetrievalError),
    /// Given correspondences belong to no two scans, or to two that have some already.
    #[error(
        "correspondences of scans ({i}, {j}): two different scans of 0..{num_scans} are needed, once"
    )]
    MatchedPair {
        /// The first scan of the pair.
        i: usize,
        /// The second scan of the pair.
        j: usize,
        /// Number of scans.
        num_scans: usize,
    },
    /// A pair has more correspondences than memory for their graphs.
    #[error(
        "{count} correspondences of {}: at most {MAX_CORRESPONDENCES} are allowed; give the best ones",
        .pair.map_or("a pair".to_owned(), |(i, j)| format!("scans ({i}, {j})"))
    )]
    TooManyCorrespondences {
        /// Their number.
        count: usize,
        /// The scans, where there are several pairs.
        pair: Option<(usize, usize)>,
    },
    /// No scan has this id: it was removed, or never added.
    #[error("there is no scan {scan}")]
    UnknownScan {
        /// The id.
        scan: ScanId,
    },
    /// There is not one scan per cloud.
    #[cfg(feature = "fpfh")]
    #[error("{scans} scans for {clouds} clouds: one of each is needed")]
    ScansAndClouds {
        /// Number of scans.
        scans: usize,
        /// Number of clouds.
        clouds: usize,
    },
    /// The voxel size cannot be estimated.
    #[cfg(feature = "fpfh")]
    #[error("no cloud has two different points: nothing can be said of them")]
    NoExtent,
    /// The [`Observer`](crate::Observer) ended the registration.
    #[error("cancelled during {stage}")]
    Cancelled {
        /// The stage that was under way.
        stage: Stage,
    },
}

impl Error {
    /// Why scans `i` and `j` could not be matched.
    pub(crate) fn of_pair(i: usize, j: usize, error: CorrespondenceError) -> Self {
        match error {
            CorrespondenceError::DimensionsDiffer(differ) => Self::DimensionsDiffer {
                first: i,
                expected: differ.i,
                scan: j,
                dimension: differ.j,
            },
            other => Self::Correspondence(other),
        }
    }
}
