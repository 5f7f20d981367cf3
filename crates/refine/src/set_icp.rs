use gmpcr_geometry::InvalidParameter;
use nalgebra::{Isometry3, Matrix6, Point3, Vector3, Vector6};

use crate::equations::{PairEquations, check_agreement, equations};
use crate::icp::descend;
use crate::posed::largest_voxel;
use crate::set_support::{check_sets, cross_pairs, relative_pose};
use crate::tangent::adjoint;
use crate::verify::check_radius;
use crate::{CrossPair, EquationParams, Error, IcpParams, PairMap, PosedSurface, VerifyParams};

/// Pairs are found anew at the first step and at this one.
const STEP_OF_NEW_PAIRS: usize = 2;

/// Pooled ICP of two rigid sets. Lengths are in voxels.
///
/// Radii and robust scales of the steps are those of [`IcpParams`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct SetIcpParams {
    /// Radius of the first step, in voxels; in (0, 3]. Default 3.
    pub first_radius: f64,
    /// Radius of the last steps, in voxels; in (0, 3]. Default 1.5.
    pub last_radius: f64,
    /// Steps; at least 1. Default 5.
    pub steps: usize,
    /// Further steps with the last radius whose robust scale follows the residuals of each pair. Default 0.
    pub polish_steps: usize,
    /// Cosine of the angle of normals above which points correspond, in [0, 1). Default 0.5 (60°).
    pub min_normal_cosine: f64,
    /// Corresponding points without which nothing is refined; at least 6. Default 20.
    pub min_correspondences: usize,
    /// The smallest eigenvalue of a direction that is refined, as in [`IcpParams`]; in [0, 1). Default 0.001.
    pub min_stability: f64,
    /// Step length, in voxels, below which the steps with the last radius end; at least 0. Default 0.001.
    pub tolerance: f64,
    /// Distance below which a query counts as overlap when pairs are chosen, in voxels; in (0, 3]. Default 2.5.
    pub search_radius: f64,
    /// Cosine of the angle of normals above which it does, in [0, 1). Default 0.3 (73°).
    pub search_min_normal_cosine: f64,
    /// Overlap above which a pair takes part. Default 40.
    pub min_overlap: usize,
    /// Pairs of largest overlap that take part, at most; at least 1. Default 40.
    pub max_pairs: usize,
}

impl Default for SetIcpParams {
    fn default() -> Self {
        let icp = IcpParams::default();
        Self {
            first_radius: 3.0,
            last_radius: icp.last_radius,
            steps: 5,
            polish_steps: icp.polish_steps,
            min_normal_cosine: icp.min_normal_cosine,
            min_correspondences: 20,
            min_stability: icp.min_stability,
            tolerance: icp.tolerance,
            search_radius: 2.5,
            search_min_normal_cosine: 0.3,
            min_overlap: 40,
            max_pairs: 40,
        }
    }
}

impl SetIcpParams {
    /// Checks that every parameter is in its range.
    ///
    /// # Errors
    /// [`InvalidParameter`] names the first that is not.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        self.icp().validate()?;
        check_radius("search_radius", self.search_radius)?;
        check_agreement("search_min_normal_cosine", self.search_min_normal_cosine)?;
        let pairs = self.max_pairs as f64;
        InvalidParameter::check(self.max_pairs >= 1, "max_pairs", pairs, "at least 1")
    }

    /// The steps.
    fn icp(&self) -> IcpParams {
        IcpParams {
            first_radius: self.first_radius,
            last_radius: self.last_radius,
            steps: self.steps,
            polish_steps: self.polish_steps,
            min_normal_cosine: self.min_normal_cosine,
            min_correspondences: self.min_correspondences,
            min_stability: self.min_stability,
            tolerance: self.tolerance,
        }
    }

    /// What counts as overlap when pairs are chosen.
    fn search(&self) -> VerifyParams {
        VerifyParams {
            radius: self.search_radius,
            min_normal_cosine: self.search_min_normal_cosine,
            ..VerifyParams::default()
        }
    }
}

/// The transformation between two sets of scans, as exact as their surfaces make it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct SetRefinement {
    /// The transformation from the frame of set B into that of set A.
    #[cfg_attr(feature = "serde", serde(with = "gmpcr_geometry::matrix_rows"))]
    pub a_from_b: Isometry3<f64>,
    /// Directions that the points did not determine, as in [`PairRefinement`](crate::PairRefinement), with
    /// the tangent at the right of `a_from_b`.
    pub undetermined: Vec<Vector6<f64>>,
    /// Pairs that took part in the last step.
    pub num_pairs: usize,
    /// Steps taken.
    pub steps: usize,
    /// Whether the last step was shorter than the tolerance.
    pub converged: bool,
}

/// Refines the transformation between two rigid sets of scans: ICP as in
/// [`refine_pair`](crate::refine_pair), with the corresponding points of all overlapping pairs pooled.
///
/// The pairs of largest overlap are chosen at the start, and once more after two steps. Where nothing overlaps
/// or a direction is not determined, the transformation stays as it was.
///
/// # Errors
/// [`Error::Parameter`] if a parameter is out of range, [`Error::Coordinate`] if a pose is not of finite
/// numbers.
///
/// ```
/// use gmpcr_refine::{PosedSurface, Sequential, SetIcpParams, Surface, SurfaceParams, refine_sets};
/// use nalgebra::{Isometry3, Point3, Vector3};
///
/// let sheet: Vec<_> = (0..400).map(|k| Point3::new(f64::from(k % 20), f64::from(k / 20), 9.0)).collect();
/// let surface = Surface::new(&sheet, &vec![-Vector3::z(); 400], &SurfaceParams::from_voxel_size(1.0))?;
/// let set = [0.0, 10.0].map(|x| PosedSurface::new(&surface, Isometry3::translation(x, 0.0, 0.0)));
/// let start = Isometry3::translation(0.5, 0.0, 0.5);
/// let found = refine_sets(&set, &set, &start, &SetIcpParams::default(), &Sequential)?;
/// // The sheet can be pulled back, but not along itself.
/// assert!((found.a_from_b.translation.vector - Vector3::new(0.5, 0.0, 0.0)).norm() < 1e-6);
/// assert_eq!((found.num_pairs, found.undetermined.len()), (4, 3));
/// # Ok::<(), gmpcr_refine::Error>(())
/// ```
pub fn refine_sets(
    a: &[PosedSurface],
    b: &[PosedSurface],
    a_from_b: &Isometry3<f64>,
    params: &SetIcpParams,
    map: &impl PairMap,
) -> Result<SetRefinement, Error> {
    params.validate()?;
    check_sets(a, b, a_from_b)?;
    let voxel = largest_voxel(a).max(largest_voxel(b));
    let (mut pairs, mut step) = (Vec::new(), 0);
    let descent = descend(a_from_b, voxel, &params.icp(), |pose, settings| {
        if step == 0 || step == STEP_OF_NEW_PAIRS {
            pairs = best_pairs(a, b, pose, params, map);
        }
        step += 1;
        pooled(map.map(pairs.len(), |k| {
            let CrossPair { i, j, .. } = pairs[k];
            in_frame_of_set(&a[i], &b[j], pose, settings)
        }))
    });
    Ok(SetRefinement {
        a_from_b: descent.pose,
        undetermined: descent.undetermined,
        num_pairs: pairs.len(),
        steps: descent.steps,
        converged: descent.converged,
    })
}

/// The pairs of largest overlap, by position where equal.
fn best_pairs(
    a: &[PosedSurface],
    b: &[PosedSurface],
    a_from_b: &Isometry3<f64>,
    params: &SetIcpParams,
    map: &impl PairMap,
) -> Vec<CrossPair> {
    let mut pairs = cross_pairs(a, b, a_from_b, &params.search(), map);
    pairs.retain(|pair| pair.counts.overlap() > params.min_overlap);
    pairs.sort_by_key(|pair| std::cmp::Reverse(pair.counts.overlap()));
    pairs.truncate(params.max_pairs);
    pairs
}

/// The equations of a pair for the transformation between the sets: `T exp(ξ) P = T P exp(Ad(P⁻¹) ξ)`.
fn in_frame_of_set(
    scan_i: &PosedSurface,
    scan_j: &PosedSurface,
    a_from_b: &Isometry3<f64>,
    settings: &EquationParams,
) -> PairEquations {
    let i_from_j = relative_pose(scan_i, scan_j, a_from_b);
    let mut pair = equations(scan_i.surface, scan_j.surface, &i_from_j, settings);
    let change = adjoint(&scan_j.frame_from_scan.inverse());
    pair.hessian = change.transpose() * pair.hessian * change;
    pair.gradient = change.transpose() * pair.gradient;
    pair.center = scan_j.frame_from_scan * pair.center;
    pair
}

/// The sum of equations in one frame, in their order. The median is that of the pairs' medians.
fn pooled(all: Vec<PairEquations>) -> PairEquations {
    let weight: f64 = all.iter().map(|pair| pair.weight).sum();
    let total = |f: &dyn Fn(&PairEquations) -> f64| -> f64 {
        let weighted = all.iter().map(|pair| pair.weight * f(pair));
        weighted.sum::<f64>() / weight.max(f64::MIN_POSITIVE)
    };
    let center = Vector3::from([0, 1, 2].map(|k| total(&|pair| pair.center[k])));
    let spread =
        |pair: &PairEquations| pair.spread.powi(2) + (pair.center.coords - center).norm_squared();
    let mut medians: Vec<_> = all.iter().map(|pair| pair.median).collect();
    medians.sort_by(f64::total_cmp);
    PairEquations {
        hessian: all.iter().map(|pair| pair.hessian).sum::<Matrix6<f64>>(),
        gradient: all.iter().map(|pair| pair.gradient).sum::<Vector6<f64>>(),
        correspondences: all.iter().map(|pair| pair.correspondences).sum(),
        weight,
        rms: total(&|pair| pair.rms.powi(2)).sqrt(),
        median: medians.get(medians.len() / 2).copied().unwrap_or(0.0),
        center: Point3::from(center),
        spread: total(&spread).sqrt(),
    }
}
