use gmpcr_cliques::{Compatibility, PoseEstimate, estimate_pose};
use gmpcr_compatibility::SpectralFilter;
use gmpcr_correspondence::{DimensionsDiffer, Keypoints, Scan, correspondences};
use gmpcr_geometry::PointPairs;

use crate::{Error, Params};

/// What two scans say about their relative pose.
#[derive(Clone, Debug, PartialEq)]
pub struct PairRegistration {
    /// Correspondences before spectral filtering, `C_ij` (target: scan i, source: scan j).
    pub correspondences: PointPairs,
    /// Which of them the spectral filter retained, ascending.
    pub retained: Vec<usize>,
    /// Raw geometric confidence of the pair, `ŝ_ij`: comparable between pairs under equal
    /// parameters. Wrong pairs reach a few tens with `N_o = 100`, good ones hundreds.
    pub raw_confidence: f64,
    /// The motion from scan j's frame into scan i's, if one was found, and its support.
    pub estimate: PoseEstimate,
}

/// Registers two scans: sampling, matching, spectral filter, cliques. Only the parameters of these
/// stages matter.
///
/// That the scans do not overlap shows in a low confidence and inlier ratio or in a missing pose,
/// not in an error.
///
/// # Errors
/// [`Error`] if a parameter is out of range or the descriptors have different dimensions.
///
/// ```
/// use gmpcr::nalgebra::{Point3, Vector3};
/// use gmpcr::{Descriptors, Params, Scan, register_pair};
///
/// let points: Vec<_> = (0..40)
///     .map(|k| Point3::new((k as f64).sin(), (k as f64 * 2.3).cos(), k as f64 * 0.05))
///     .collect();
/// let rows = Descriptors::new((0..40).map(|k| k as f32).collect(), 1).unwrap();
/// let moved = points.iter().map(|p| p - Vector3::new(0.0, 0.0, 1.0)).collect();
/// let scan_i = Scan::new(points, rows.clone()).unwrap();
/// let scan_j = Scan::new(moved, rows).unwrap();
///
/// let pair = register_pair(&scan_i, &scan_j, &Params::default())?;
/// let pose = pair.estimate.pose.unwrap();
/// assert_eq!(pose.inlier_ratio, 1.0);
/// assert!((pose.target_from_source.translation.z - 1.0).abs() < 1e-12);
/// # Ok::<(), gmpcr::Error>(())
/// ```
pub fn register_pair(
    scan_i: &Scan,
    scan_j: &Scan,
    params: &Params,
) -> Result<PairRegistration, Error> {
    params.validate()?;
    let num_samples = params.correspondence.num_samples;
    let [keypoints_i, keypoints_j] =
        [scan_i, scan_j].map(|scan| Keypoints::sample(scan, num_samples));
    register_keypoints(&keypoints_i, &keypoints_j, params)
        .map_err(|differ| Error::of_pair(0, 1, differ))
}

/// Raw confidence of a pair of sampled scans.
pub(crate) fn raw_confidence(
    keypoints_i: &Keypoints,
    keypoints_j: &Keypoints,
    params: &Params,
) -> Result<f64, DimensionsDiffer> {
    let (_, filter) = filtered_correspondences(keypoints_i, keypoints_j, params)?;
    Ok(filter.raw_confidence())
}

/// Confidence and motion of a pair of sampled scans.
pub(crate) fn register_keypoints(
    keypoints_i: &Keypoints,
    keypoints_j: &Keypoints,
    params: &Params,
) -> Result<PairRegistration, DimensionsDiffer> {
    let (correspondences, filter) = filtered_correspondences(keypoints_i, keypoints_j, params)?;
    let compatibility = Compatibility {
        fcg: filter.graph.fcg(),
        scg: filter.graph.scg(),
        response: &filter.dominant.vector,
    };
    let retained = correspondences.select(&filter.retained);
    Ok(PairRegistration {
        estimate: estimate_pose(&retained, compatibility, &params.cliques),
        raw_confidence: filter.raw_confidence(),
        correspondences,
        retained: filter.retained,
    })
}

fn filtered_correspondences(
    keypoints_i: &Keypoints,
    keypoints_j: &Keypoints,
    params: &Params,
) -> Result<(PointPairs, SpectralFilter), DimensionsDiffer> {
    let max_correspondences = params.correspondence.max_correspondences;
    let pairs = correspondences(keypoints_i, keypoints_j, max_correspondences)?;
    let filter = SpectralFilter::new(&pairs, &params.compatibility);
    Ok((pairs, filter))
}
