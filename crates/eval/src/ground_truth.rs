//! Pairs whose relative pose is known.

use nalgebra::{Isometry3, Matrix6};

use crate::error::Error;

/// A pair of a benchmark's list: an entry of `gt.log` and of `gt.info`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GroundTruthPair {
    /// First scan.
    pub i: usize,
    /// Second scan.
    pub j: usize,
    /// Ground truth of the relative pose, which maps scan j's coordinates into scan i's frame, in meters.
    #[cfg_attr(feature = "serde", serde(with = "gmpcr_geometry::matrix_rows"))]
    pub i_from_j: Isometry3<f64>,
    /// 6×6 matrix Ω, translation first, that takes a small transformation to summed squared
    /// displacements of the overlapping points; see [`information_matrix`](crate::information_matrix).
    pub information: Matrix6<f64>,
}

/// `Ok` where `i` and `j` are two of `num_scans` scans.
pub(crate) fn check_pair(i: usize, j: usize, num_scans: usize) -> Result<(), Error> {
    if i >= num_scans || j >= num_scans {
        Err(Error::NoSuchScan { i, j, num_scans })
    } else if i == j {
        Err(Error::SamePair { scan: i })
    } else {
        Ok(())
    }
}
