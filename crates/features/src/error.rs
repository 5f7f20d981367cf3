//! Why there are no features.

use gmpcr_geometry::InvalidParameter;

/// Why the features of a cloud could not be computed. Each variant carries the numbers that were at fault.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A coordinate is not a number, infinite, or too large to be squared safely.
    #[error("{what} {index} has the coordinate {value}, allowed are numbers from -1e100 to 1e100")]
    Coordinate {
        /// `"point"` or `"normal"`.
        what: &'static str,
        /// Position in the slice that was passed.
        index: usize,
        /// The first such coordinate.
        value: f64,
    },

    /// A parameter is out of range.
    #[error(transparent)]
    Parameter(#[from] InvalidParameter),

    /// Points and normals do not come in pairs.
    #[error("{num_points} points but {num_normals} normals, need one normal for each point")]
    LengthMismatch {
        /// Number of points.
        num_points: usize,
        /// Number of normals.
        num_normals: usize,
    },

    /// The cloud spans more than 2^31 - 1 voxels along an axis.
    #[error("extent {extent} along axis {axis} exceeds 2147483647 voxels of size {voxel_size}")]
    ExtentTooLarge {
        /// 0, 1 or 2 for x, y or z.
        axis: usize,
        /// Largest minus smallest coordinate along that axis.
        extent: f64,
        /// The voxel size that was passed.
        voxel_size: f64,
    },

    /// More points than the neighbor search can number.
    #[error("{num_points} points, the neighbor search can number 4294967295")]
    TooManyPoints {
        /// Number of points.
        num_points: usize,
    },
}
