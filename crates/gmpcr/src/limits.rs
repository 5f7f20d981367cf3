use gmpcr_geometry::PointPairs;

use crate::Error;

/// Correspondences of a pair, at most: their matrices take about a gigabyte for every thread.
pub const MAX_CORRESPONDENCES: usize = 5_000;

/// Refuses more correspondences than that, naming the pair where there are several.
pub(crate) fn check_number(
    correspondences: &PointPairs,
    pair: Option<(usize, usize)>,
) -> Result<(), Error> {
    match correspondences.len() {
        0..=MAX_CORRESPONDENCES => Ok(()),
        count => Err(Error::TooManyCorrespondences { count, pair }),
    }
}
