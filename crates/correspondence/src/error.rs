use gmpcr_geometry::InvalidParameter;

/// Descriptors of two sets that cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("descriptors of dimension {i} do not compare with descriptors of dimension {j}")]
pub struct DimensionsDiffer {
    /// Dimension of the first set.
    pub i: usize,
    /// Dimension of the second set.
    pub j: usize,
}

/// Why two scans have no correspondences.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CorrespondenceError {
    /// Their descriptors cannot be compared.
    #[error(transparent)]
    DimensionsDiffer(#[from] DimensionsDiffer),
    /// A parameter is out of range.
    #[error(transparent)]
    Parameter(#[from] InvalidParameter),
}
