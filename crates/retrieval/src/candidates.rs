use std::collections::BTreeSet;

use gmpcr_correspondence::Descriptors;

use crate::{Index, RetrievalError, RetrievalParams};

/// The pairs `(i, j)`, `i < j`, of which either scan proposes the other by its descriptors, ascending:
/// [`Index::candidates_of`] of every scan. All pairs where there are fewer scans than
/// [`RetrievalParams::min_scans`].
///
/// # Errors
/// [`RetrievalError`] if a parameter is out of range, or if descriptors of two scans have different
/// dimensions and pairs are retrieved. A scan without descriptors has no dimension and no candidates.
///
/// # Panics
/// If there are 2³² scans or descriptors, or more.
pub fn candidate_pairs(
    scans: &[&Descriptors],
    params: &RetrievalParams,
) -> Result<Vec<(usize, usize)>, RetrievalError> {
    params.validate()?;
    if scans.len() < params.min_scans {
        let pairs = (0..scans.len()).flat_map(|i| (i + 1..scans.len()).map(move |j| (i, j)));
        return Ok(pairs.collect());
    }
    let index = Index::new(scans)?;
    let proposals =
        (0..scans.len()).map(|scan| index.candidates_of(scan, params.candidates_per_scan));
    Ok(union(proposals).into_iter().collect())
}

/// The pairs of the scans, in order, with those that they propose.
pub(crate) fn union(proposals: impl Iterator<Item = Vec<usize>>) -> BTreeSet<(usize, usize)> {
    let pairs = proposals
        .enumerate()
        .flat_map(|(scan, partners)| partners.into_iter().map(move |partner| (scan, partner)));
    pairs.map(|(a, b)| (a.min(b), a.max(b))).collect()
}
