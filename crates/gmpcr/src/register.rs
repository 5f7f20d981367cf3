use std::collections::BTreeMap;

use gmpcr_correspondence::Scan;
use gmpcr_geometry::PointPairs;

use crate::known_pairs::KnownPairs;
use crate::limits::check_number;
use crate::pipeline::Pipeline;
use crate::source::{Pair, Source};
use crate::{Error, IncrementalRegistration, Observer, Params, Registration, ScanId, StageTimes};

/// Registers scans: one pose per scan, consistent over all of them, with its support and diagnostics.
///
/// The pipeline of the paper, stage by stage; each stage is a crate of its own. `N (N − 1) / 2` pairs
/// are scored, or from [`retrieval.min_scans`](gmpcr_retrieval::RetrievalParams::min_scans) scans on `O(N)`
/// retrieved ones; at most `N K` of them get a relative pose. Memory holds the keypoints, one confidence per
/// pair and one relative pose per edge.
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
    let mut registration = IncrementalRegistration::new(params.clone())?;
    registration.add_observed(scans, observer)?;
    registration.register_observed(observer)
}

/// Registers a set of scans from correspondences that another front end found: everything that
/// [`register`] does after matching.
///
/// `matches` holds `(i, j, correspondences)` with target scan `i` and source scan `j`, at most once for each two
/// scans, in any order and direction. Pairs without an entry are never edges. The parameters of sampling,
/// matching and retrieval do not matter. For the number of correspondences of a pair see
/// [`register_correspondences`](crate::register_correspondences).
///
/// # Errors
/// [`Error::NoScans`] if `num_scans` is 0, [`Error::MatchedPair`] if a pair is not two different scans of
/// `0..num_scans`, or comes twice, [`Error::TooManyCorrespondences`], and [`Error::Parameter`].
///
/// ```
/// use gmpcr::geometry::PointPairs;
/// use gmpcr::nalgebra::{Isometry3, Point3, Vector3};
/// use gmpcr::{Params, register_matches};
///
/// let world: Vec<Point3<f64>> = (0..30)
///     .map(|k| f64::from(k))
///     .map(|k| Point3::new(k.sin() * 2.0, (k * 1.7).cos() * 2.0, (k * 0.9).sin()))
///     .collect();
/// let pose = |k: usize| Isometry3::new(Vector3::x() * k as f64, Vector3::z() * (0.3 * k as f64));
/// let seen = |k: usize| world.iter().map(|p| pose(k).inverse_transform_point(p)).collect();
/// let mut matches = Vec::new();
/// for (i, j) in [(0, 1), (2, 1), (0, 2)] {
///     matches.push((i, j, PointPairs::new(seen(i), seen(j))?));
/// }
///
/// let registration = register_matches(3, matches, &Params::default())?;
/// let error = registration.world_from_scan[2].inverse() * pose(2);
/// assert!(error.translation.vector.norm() < 1e-9 && error.rotation.angle() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn register_matches(
    num_scans: usize,
    matches: Vec<(usize, usize, PointPairs)>,
    params: &Params,
) -> Result<Registration, Error> {
    register_matches_observed(num_scans, matches, params, &())
}

/// As [`register_matches`], with an observer that is told of the progress and may end the work.
///
/// # Errors
/// Those of [`register_matches`], and [`Error::Cancelled`] if the observer says so.
pub fn register_matches_observed(
    num_scans: usize,
    matches: Vec<(usize, usize, PointPairs)>,
    params: &Params,
    observer: &dyn Observer,
) -> Result<Registration, Error> {
    params.validate()?;
    if num_scans == 0 {
        return Err(Error::NoScans);
    }
    let matches = by_pair(num_scans, matches)?;
    let pipeline = Pipeline {
        ids: &ScanId::first(num_scans),
        source: Source::Matches(&matches),
        params,
        observer,
    };
    pipeline.run(&mut KnownPairs::default(), &mut StageTimes::default())
}

/// The matches of each pair `i < j`.
fn by_pair(
    num_scans: usize,
    matches: Vec<(usize, usize, PointPairs)>,
) -> Result<BTreeMap<Pair, PointPairs>, Error> {
    let mut by_pair = BTreeMap::new();
    for (i, j, pairs) in matches {
        check_number(&pairs, Some((i, j)))?;
        let (pair, pairs) = match i <= j {
            true => ((i, j), pairs),
            false => ((j, i), pairs.swapped()),
        };
        let is_pair = i != j && i.max(j) < num_scans;
        if !is_pair || by_pair.insert(pair, pairs).is_some() {
            return Err(Error::MatchedPair { i, j, num_scans });
        }
    }
    Ok(by_pair)
}
