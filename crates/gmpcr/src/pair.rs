use gmpcr_cliques::{Compatibility, PoseEstimate, estimate_pose, information_matrix, inliers};
use gmpcr_compatibility::SpectralFilter;
use gmpcr_correspondence::{Keypoints, Scan};
use gmpcr_geometry::PointPairs;
use nalgebra::Matrix6;

use crate::limits::check_number;
use crate::source::Source;
use crate::{Error, Params};

/// What two scans say about their relative pose.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PairRegistration {
    /// Correspondences before spectral filtering, `C_ij` (target: scan i, source: scan j).
    pub correspondences: PointPairs,
    /// Which of them the spectral filter retained, ascending.
    pub retained: Vec<usize>,
    /// Raw geometric confidence of the pair, `ŝ_ij`: comparable between pairs under equal
    /// parameters. Outlier pairs reach a few tens with `N_o = 100`, inlier pairs hundreds.
    pub raw_confidence: f64,
    /// The transformation from scan j's frame into scan i's, if one was found, and its support.
    pub estimate: PoseEstimate,
    /// Distance below which a correspondence is an inlier, `τ_in`, in the unit of the points.
    pub inlier_threshold: f64,
}

impl PairRegistration {
    /// The correspondences that the spectral filter retained.
    pub fn retained_pairs(&self) -> PointPairs {
        self.correspondences.select(&self.retained)
    }

    /// The retained correspondences that the transformation explains; none without a transformation.
    pub fn inlier_pairs(&self) -> PointPairs {
        let Some(pose) = &self.estimate.pose else {
            return PointPairs::default();
        };
        let retained = self.retained_pairs();
        let explained = inliers(&retained, &pose.target_from_source, self.inlier_threshold);
        retained.select(&explained)
    }

    /// The 6×6 information of the transformation, from its inliers, with the inlier threshold as the standard
    /// deviation of a coordinate: order and tangent are those of [`information_matrix`]. `None` without a
    /// transformation.
    pub fn information(&self) -> Option<Matrix6<f64>> {
        self.estimate.pose.as_ref()?;
        Some(information_matrix(
            &self.inlier_pairs(),
            self.inlier_threshold,
        ))
    }
}

/// Registers two scans: sampling, matching, spectral filter, cliques. Only the parameters of these
/// stages matter.
///
/// That the scans do not overlap shows in a low confidence and inlier ratio or in a missing transformation,
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
/// let pose = pair.estimate.pose.as_ref().unwrap();
/// assert_eq!(pose.inlier_ratio, 1.0);
/// assert!((pose.target_from_source.translation.z - 1.0).abs() < 1e-12);
/// assert_eq!(pair.inlier_pairs().len(), pair.retained.len());
/// # Ok::<(), gmpcr::Error>(())
/// ```
pub fn register_pair(
    scan_i: &Scan,
    scan_j: &Scan,
    params: &Params,
) -> Result<PairRegistration, Error> {
    params.validate()?;
    let sample = |scan| Keypoints::sample(scan, &params.correspondence);
    let keypoints = [sample(scan_i)?, sample(scan_j)?];
    let correspondences = Source::Keypoints(&keypoints).correspondences(0, 1, params)?;
    register_correspondences_unchecked(correspondences, params)
}

/// Registers two scans whose correspondences another front end found: spectral filter and cliques. Any
/// fraction of them may be outliers.
///
/// All of them are used, also beyond [`max_correspondences`](gmpcr_correspondence::CorrespondenceParams):
/// `M` of them take `O(M³)` time and `8 M²` bytes for each of about five matrices (1000: half a second, 40 MB),
/// in [`register_matches`](crate::register_matches) on every thread.
/// With many inliers a few hundred of the best are as good.
///
/// # Errors
/// [`Error::Parameter`] if one is out of range, [`Error::TooManyCorrespondences`] above
/// [`MAX_CORRESPONDENCES`](crate::MAX_CORRESPONDENCES).
///
/// ```
/// use gmpcr::geometry::PointPairs;
/// use gmpcr::nalgebra::{Isometry3, Point3, Vector3};
/// use gmpcr::{Params, register_correspondences};
///
/// let source: Vec<_> = (0..40)
///     .map(|k| Point3::new((k as f64).sin(), (k as f64 * 2.3).cos(), k as f64 * 0.05))
///     .collect();
/// let target_from_source = Isometry3::new(Vector3::new(2.0, 0.0, 1.0), Vector3::z() * 0.5);
/// let mut target: Vec<_> = source.iter().map(|p| target_from_source * p).collect();
/// target[..20].reverse(); // half of the matches are outliers
///
/// let pair = register_correspondences(&PointPairs::new(target, source)?, &Params::default())?;
/// let pose = pair.estimate.pose.as_ref().ok_or("no transformation")?;
/// let error = pose.target_from_source.inverse() * target_from_source;
/// assert!(error.translation.vector.norm() < 1e-9);
/// let information = pair.information().ok_or("no transformation")?;
/// assert!(information.symmetric_eigenvalues().min() > 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn register_correspondences(
    correspondences: &PointPairs,
    params: &Params,
) -> Result<PairRegistration, Error> {
    params.validate()?;
    check_number(correspondences, None)?;
    register_correspondences_unchecked(correspondences.clone(), params)
}

/// Raw confidence of a pair, without its transformation.
pub(crate) fn raw_confidence(correspondences: &PointPairs, params: &Params) -> Result<f64, Error> {
    let filter = SpectralFilter::new(correspondences, &params.compatibility)?;
    Ok(filter.raw_confidence())
}

/// As [`register_correspondences`], of parameters that are known to be in range.
pub(crate) fn register_correspondences_unchecked(
    correspondences: PointPairs,
    params: &Params,
) -> Result<PairRegistration, Error> {
    let filter = SpectralFilter::new(&correspondences, &params.compatibility)?;
    let compatibility = Compatibility {
        fcg: filter.graph.fcg(),
        scg: filter.graph.scg(),
        response: &filter.dominant.vector,
    };
    let retained = correspondences.select(&filter.retained);
    Ok(PairRegistration {
        estimate: estimate_pose(&retained, compatibility, &params.cliques)?,
        raw_confidence: filter.raw_confidence(),
        correspondences,
        retained: filter.retained,
        inlier_threshold: params.cliques.inlier_threshold,
    })
}
