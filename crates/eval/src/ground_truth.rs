//! Pairs whose relative pose is known.

use nalgebra::{Isometry3, Matrix6};

use crate::error::{Error, check_length};

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
    /// displacements of the overlapping points `p`: `Ω = Σ GᵀG` with `G = [I | −[p]×]`.
    pub information: Matrix6<f64>,
}

impl GroundTruthPair {
    /// The pairs `(i, j, i_from_j)` of a list with their information matrices, in the same order. A list
    /// without matrices has zeros in their place: [`Protocol::of_list`](crate::Protocol::of_list) tells
    /// what judges it.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] unless there is one matrix per pair.
    ///
    /// ```
    /// use gmpcr_eval::GroundTruthPair;
    /// use nalgebra::{Isometry3, Matrix6};
    ///
    /// let list = [(0, 2, Isometry3::identity()), (1, 2, Isometry3::identity())];
    /// let pairs = GroundTruthPair::of_list(list, Some(&[Matrix6::identity(); 2]))?;
    /// assert_eq!((pairs[1].i, pairs[1].information), (1, Matrix6::identity()));
    /// assert_eq!(GroundTruthPair::of_list(list, None)?[1].information, Matrix6::zeros());
    /// # Ok::<(), gmpcr_eval::Error>(())
    /// ```
    pub fn of_list(
        pairs: impl IntoIterator<Item = (usize, usize, Isometry3<f64>)>,
        information: Option<&[Matrix6<f64>]>,
    ) -> Result<Vec<Self>, Error> {
        let pairs = pairs.into_iter().map(|(i, j, i_from_j)| Self {
            i,
            j,
            i_from_j,
            information: Matrix6::zeros(),
        });
        let mut pairs: Vec<Self> = pairs.collect();
        if let Some(information) = information {
            check_length("information matrices", pairs.len(), information.len())?;
            for (pair, information) in pairs.iter_mut().zip(information) {
                pair.information = *information;
            }
        }
        Ok(pairs)
    }

    /// All pairs `i < j` of scans whose pose is known, in order, as the protocol of ScanNet has it. Their
    /// information matrices are zero.
    ///
    /// ```
    /// use gmpcr_eval::GroundTruthPair;
    /// use nalgebra::Isometry3;
    ///
    /// let pose = |x| Some(Isometry3::translation(x, 0.0, 0.0));
    /// let pairs = GroundTruthPair::all_pairs(&[pose(1.0), None, pose(3.0)]);
    /// assert_eq!(pairs.len(), 1);
    /// assert_eq!((pairs[0].i, pairs[0].j, Some(pairs[0].i_from_j)), (0, 2, pose(2.0)));
    /// ```
    #[must_use]
    pub fn all_pairs(world_from_scan: &[Option<Isometry3<f64>>]) -> Vec<Self> {
        let num_scans = world_from_scan.len();
        let pairs = (0..num_scans).flat_map(|i| (i + 1..num_scans).map(move |j| (i, j)));
        let pairs = pairs.filter_map(|(i, j)| {
            Some(Self {
                i,
                j,
                i_from_j: world_from_scan[i]?.inv_mul(&world_from_scan[j]?),
                information: Matrix6::zeros(),
            })
        });
        pairs.collect()
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_with_too_few_matrices_is_refused() {
        let list = [(0, 1, Isometry3::identity()); 2];
        let error = GroundTruthPair::of_list(list, Some(&[Matrix6::identity()])).unwrap_err();
        let expected = Error::LengthMismatch {
            what: "information matrices",
            expected: 2,
            found: 1,
        };
        assert_eq!(error, expected);
    }
}
