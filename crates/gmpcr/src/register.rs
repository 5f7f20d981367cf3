use gmpcr_correspondence::Scan;

use crate::{Error, Observer, Params, Registration, Registry};

/// Registers scans: one pose per scan, consistent over all of them, with the evidence.
///
/// The pipeline of the paper, stage by stage; each stage is a crate of its own. `N (N − 1) / 2` pairs
/// are scored, or from [`retrieval.min_scans`](gmpcr_retrieval::RetrievalParams::min_scans) scans on `O(N)`
/// retrieved ones; at most `N K` of them get a pose. Memory holds the keypoints, one confidence per pair
/// and one motion per edge.
///
/// Scans that share no reliable pair stay in components of their own; a single scan, and a scan
/// without points, are such components. A scan with fewer points than `N_s` uses all of them, and
/// `K` at or above the number of scans selects every pair of positive confidence.
///
/// # Errors
/// [`Error`] if there is no scan, a parameter is out of range, or the descriptors differ in
/// dimension (a scan without points has none).
pub fn register(scans: &[Scan], params: &Params) -> Result<Registration, Error> {
    register_observed(scans, params, &())
}

/// As [`register`], with an observer that is told of the progress and may end the work.
///
/// # Errors
/// Those of [`register`], and [`Error::Cancelled`] if the observer says so.
pub fn register_observed(
    scans: &[Scan],
    params: &Params,
    observer: &dyn Observer,
) -> Result<Registration, Error> {
    let mut registry = Registry::new(params.clone())?;
    registry.add(scans, observer)?;
    registry.registration(observer)
}
