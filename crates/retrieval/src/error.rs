use gmpcr_correspondence::DimensionsDiffer;
use gmpcr_geometry::InvalidParameter;

/// Why scans have no candidates.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RetrievalError {
    /// Descriptors of two scans cannot be compared.
    #[error(transparent)]
    DimensionsDiffer(#[from] DimensionsDiffer),
    /// A parameter is out of range.
    #[error(transparent)]
    Parameter(#[from] InvalidParameter),
}
