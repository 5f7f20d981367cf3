use gmpcr_geometry::InvalidParameter;
use nalgebra::Isometry3;

use crate::equations::{PairEquations, check_agreement};
use crate::icp::{Schedule, check_tolerance};
use crate::joint_system::{JointSystem, OverlappingPair, relative_pose};
use crate::posed::{check_poses, largest_voxel, spheres_meet};
use crate::verify::{check_radius, count_pair};
use crate::{Error, PairCounts, PairMap, PosedSurface, VerifyParams};

/// Overlapping pairs are found anew every so many steps.
const STEPS_BETWEEN_SEARCHES: usize = 2;

/// Joint refinement of all poses. Lengths are in voxels.
///
/// Radii and robust scales of the steps are those of [`IcpParams`](crate::IcpParams).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct JointParams {
    /// Radius of the first step, in voxels; in (0, 3]. Default 2.5.
    pub first_radius: f64,
    /// Radius of the last steps, in voxels; in (0, 3]. Default 1.5.
    pub last_radius: f64,
    /// Steps; at least 1. Default 4.
    pub steps: usize,
    /// Further steps with the last radius whose robust scale follows the residuals of each pair. Default 0.
    pub polish_steps: usize,
    /// Cosine of the angle of normals above which points correspond, in [0, 1). Default 0.5 (60°).
    pub min_normal_cosine: f64,
    /// Distance below which a query counts as overlap when pairs are searched, in voxels; in (0, 3]. Default
    /// 2.5. What violates free space is that of the default [`VerifyParams`].
    pub search_radius: f64,
    /// Cosine of the angle of normals above which it does, in [0, 1). Default 0.5 (60°).
    pub search_min_normal_cosine: f64,
    /// Overlap above which a pair takes part, unless it has as many violations. Default 60.
    pub min_overlap: usize,
    /// Resistance of each pose to steps, as a fraction of the mean weight of a scan; positive and at most 1. It
    /// keeps poses where they are that nothing determines. Default 1e-4.
    pub damping: f64,
    /// Step length, in voxels, below which the steps with the last radius end; at least 0. Default 0.001.
    pub tolerance: f64,
}

impl Default for JointParams {
    fn default() -> Self {
        Self {
            first_radius: 2.5,
            last_radius: 1.5,
            steps: 4,
            polish_steps: 0,
            min_normal_cosine: 0.5,
            search_radius: 2.5,
            search_min_normal_cosine: 0.5,
            min_overlap: 60,
            damping: 1e-4,
            tolerance: 1e-3,
        }
    }
}

impl JointParams {
    /// The default with 8 further steps down to the resolution of the data: for scans that are undistorted up
    /// to their noise. Those of depth cameras are bent by more, and gain nothing.
    #[must_use]
    pub fn precise() -> Self {
        Self {
            polish_steps: 8,
            ..Self::default()
        }
    }

    /// Checks that every parameter is in its range.
    ///
    /// # Errors
    /// [`InvalidParameter`] names the first that is not.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        let &Self {
            search_radius,
            search_min_normal_cosine,
            damping,
            tolerance,
            ..
        } = self;
        self.schedule().validate()?;
        check_radius("search_radius", search_radius)?;
        check_agreement("search_min_normal_cosine", search_min_normal_cosine)?;
        let is_damping = damping > 0.0 && damping <= 1.0;
        InvalidParameter::check(is_damping, "damping", damping, "in (0, 1]")?;
        check_tolerance(tolerance)
    }

    /// What counts as overlap when pairs are searched.
    fn search(&self) -> VerifyParams {
        VerifyParams {
            radius: self.search_radius,
            min_normal_cosine: self.search_min_normal_cosine,
            ..VerifyParams::default()
        }
    }

    fn schedule(&self) -> Schedule {
        Schedule {
            first: self.first_radius,
            last: self.last_radius,
            steps: self.steps,
            polish_steps: self.polish_steps,
            min_normal_cosine: self.min_normal_cosine,
        }
    }
}

/// An overlapping pair under the refined poses.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct JointPair {
    /// Position of the lower scan.
    pub i: usize,
    /// Position of the higher scan.
    pub j: usize,
    /// Overlap and violations, as the search counts them.
    pub counts: PairCounts,
    /// Equations of the relative pose, with the radius and the robust scale of the last step: corresponding
    /// points, their RMS and median distance, and the Hessian.
    pub equations: PairEquations,
}

/// Poses as exact as all surfaces together make them.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct JointRefinement {
    /// The pose of each scan; that of the first is the given one.
    #[cfg_attr(feature = "serde", serde(with = "gmpcr_geometry::matrix_rows::list"))]
    pub frame_from_scan: Vec<Isometry3<f64>>,
    /// All overlapping pairs under these poses, by `i`, then by `j`.
    pub pairs: Vec<JointPair>,
    /// Steps taken.
    pub steps: usize,
    /// Whether the last step moved no scan by more than the tolerance.
    pub converged: bool,
}

/// Refines all poses of a set at once: symmetric point-to-plane ICP over all pairs that overlap.
///
/// With `T_ij = P_i⁻¹ P_j` and the [`pair_equations`](crate::pair_equations) `(H, g)` of a pair in the
/// tangent of `T_ij`, steps `P_k ← P_k exp(ξ_k)` change that pose by
///
/// ```text
/// δ_ij = ξ_j − Ad(T_ij⁻¹) ξ_i,     argmin_ξ Σ_ij ½ δ_ijᵀ H_ij δ_ij + g_ijᵀ δ_ij + damping,     ξ_0 = 0
/// ```
///
/// These are sparse equations of `6 (N − 1)` unknowns, solved by one Cholesky decomposition a step. The points that
/// correspond are found anew in each step, the pairs that overlap in every other one: pairs whose
/// bounding spheres meet, with more overlap than `min_overlap` and than violations.
///
/// The first pose is fixed. Scans that overlap with nothing stay where they are, and so does a group of
/// scans that overlap with each other only, as a whole. Translating a scan's frame, or moving the shared frame,
/// moves the result.
///
/// Time of a step is that of the pairs, plus that of the decomposition; memory is linear in the pairs as long as
/// each scan overlaps with few others. `map` decides who works on the pairs; the equations are
/// added in a fixed order, so it does not change the bits.
///
/// # Errors
/// [`Error::Parameter`] if a parameter is out of range, [`Error::Coordinate`] if a pose is not of finite
/// numbers.
///
/// ```
/// use gmpcr_refine::{JointParams, PosedSurface, Sequential, Surface, SurfaceParams, refine_jointly};
/// use nalgebra::{Isometry3, Point3, Vector3};
///
/// let sheet: Vec<_> = (0..400).map(|k| Point3::new(f64::from(k % 20), f64::from(k / 20), 9.0)).collect();
/// let surface = Surface::new(&sheet, &vec![-Vector3::z(); 400], &SurfaceParams::from_voxel_size(1.0))?;
/// let heights = [0.0, 0.5, -0.25];
/// let scans = heights.map(|z| PosedSurface::new(&surface, Isometry3::translation(0.0, 0.0, z)));
/// let refined = refine_jointly(&scans, &JointParams::default(), &Sequential)?;
/// assert_eq!(refined.pairs.len(), 3);
/// for pose in &refined.frame_from_scan {
///     assert!(pose.translation.vector.norm() < 1e-3);
/// }
/// # Ok::<(), gmpcr_refine::Error>(())
/// ```
pub fn refine_jointly(
    scans: &[PosedSurface],
    params: &JointParams,
    map: &impl PairMap,
) -> Result<JointRefinement, Error> {
    params.validate()?;
    check_poses(scans)?;
    let mut scans = scans.to_vec();
    let (steps, converged) = descend(&mut scans, params, map);
    let found = overlapping_pairs(&scans, params, map);
    let last = params.schedule().last();
    let equations = map.map(found.len(), |k| found[k].equations(&scans, &last));
    let pair = |(pair, equations): (OverlappingPair, PairEquations)| JointPair {
        i: pair.i,
        j: pair.j,
        counts: pair.counts,
        equations,
    };
    Ok(JointRefinement {
        frame_from_scan: scans.iter().map(|scan| scan.frame_from_scan).collect(),
        pairs: found.into_iter().zip(equations).map(pair).collect(),
        steps,
        converged,
    })
}

/// Steps as the schedule says. Returns their number, and whether the last one was short enough.
fn descend(scans: &mut [PosedSurface], params: &JointParams, map: &impl PairMap) -> (usize, bool) {
    let schedule = params.schedule();
    let tolerance = params.tolerance * largest_voxel(scans);
    let (mut k, mut steps, mut converged) = (0, 0, false);
    let mut system = None;
    while k < schedule.len() {
        if steps % STEPS_BETWEEN_SEARCHES == 0 {
            let pairs = overlapping_pairs(scans, params, map);
            system = JointSystem::new(scans, pairs);
        }
        let Some(system) = &system else {
            return (steps, true);
        };
        let settings = schedule.at(k);
        let pairs = &system.pairs;
        let equations = map.map(pairs.len(), |k| pairs[k].equations(scans, &settings));
        let Some(length) = system.step(scans, &equations, params.damping) else {
            return (steps, false);
        };
        steps += 1;
        converged = length < tolerance;
        k = match schedule.after_convergence(k) {
            Some(next) if converged => next,
            _ => k + 1,
        };
    }
    (steps, converged)
}

/// All pairs that overlap, by `i`, then by `j`.
fn overlapping_pairs(
    scans: &[PosedSurface],
    params: &JointParams,
    map: &impl PairMap,
) -> Vec<OverlappingPair> {
    let mut near = Vec::new();
    for (j, of_j) in scans.iter().enumerate() {
        for (i, of_i) in scans[..j].iter().enumerate() {
            if spheres_meet(of_i.surface, of_j.surface, &relative_pose(of_i, of_j)) {
                near.push((i, j));
            }
        }
    }
    near.sort_unstable();
    let search = params.search();
    let counted = map.map(near.len(), |k| {
        let (i, j) = near[k];
        let (of_i, of_j) = (&scans[i], &scans[j]);
        let pose = relative_pose(of_i, of_j);
        let counts = count_pair(of_i.surface, of_j.surface, &pose, &search);
        OverlappingPair { i, j, counts }
    });
    let takes_part = |pair: &OverlappingPair| {
        let overlap = pair.counts.overlap();
        overlap > params.min_overlap && overlap > pair.counts.violations()
    };
    counted.into_iter().filter(takes_part).collect()
}
