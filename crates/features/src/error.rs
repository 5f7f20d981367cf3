//! What can be wrong with a cloud or a parameter.

/// Why a cloud could not be described. Each variant carries the numbers that were at fault.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A coordinate is not a number, infinite, or too large to be squared safely.
    #[error("{what} {index} has the coordinate {value}, allowed are numbers from -1e100 to 1e100")]
    Coordinate {
        /// `"point"`, `"normal"` or `"viewpoint"`.
        what: &'static str,
        /// Position in the slice that was passed.
        index: usize,
        /// The first such coordinate.
        value: f64,
    },

    /// A parameter lies outside its range.
    #[error("{name} is {value}, allowed is {allowed}")]
    Parameter {
        /// Name of the field or argument.
        name: &'static str,
        /// The value that was passed.
        value: f64,
        /// The range in words.
        allowed: &'static str,
    },

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
