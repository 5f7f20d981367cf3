use gmpcr_geometry::InvalidParameter;

/// Why surfaces could not be built or compared. Each variant carries the numbers that were at fault.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A coordinate is not a number, infinite, or too large to be squared safely.
    #[error("{what} {index} has the coordinate {value}, allowed are numbers from -1e100 to 1e100")]
    Coordinate {
        /// `"point"`, `"normal"`, `"raw point"`, `"viewpoint"` or `"transformation"`.
        what: &'static str,
        /// Position in the slice that was passed; 0 for a single value.
        index: usize,
        /// The first such coordinate.
        value: f64,
    },

    /// Points and normals do not come in pairs.
    #[error("{num_points} points but {num_normals} normals, need one normal for each point")]
    LengthMismatch {
        /// Number of points.
        num_points: usize,
        /// Number of normals.
        num_normals: usize,
    },

    /// A normal is neither of length 1 nor zero.
    #[error("normal {index} has length {length}, allowed are 1, or 0 for unknown")]
    NormalLength {
        /// Position in the slice that was passed.
        index: usize,
        /// Its length.
        length: f64,
    },

    /// The points span more voxels along an axis than the grid can number.
    #[error("extent {extent} along axis {axis} exceeds 2097000 voxels of size {voxel_size}")]
    ExtentTooLarge {
        /// 0, 1 or 2 for x, y or z.
        axis: usize,
        /// Largest minus smallest coordinate along that axis.
        extent: f64,
        /// The voxel size that was passed.
        voxel_size: f64,
    },

    /// More points than the grid can number.
    #[error("{num_points} points, a surface can have 4294967294")]
    TooManyPoints {
        /// Number of points.
        num_points: usize,
    },

    /// A parameter is out of range.
    #[error(transparent)]
    Parameter(#[from] InvalidParameter),
}
