use gmpcr_geometry::InvalidParameter;
use nalgebra::{Isometry3, Matrix6, Vector6};

use crate::equations::{PairEquations, check_agreement, equations};
use crate::step::{Step, smallest_eigenvalue};
use crate::surface::Surface;
use crate::tangent::Tangent;
use crate::verify::check_radius;
use crate::{EquationParams, Error, check};

/// Robust scale by the radius.
const SCALE_BY_RADIUS: f64 = 0.5;
/// Length of a step, in radii, that is not exceeded: what weak directions ask for beyond it is noise.
const MAX_STEP: f64 = 4.0;
/// Distance at which rotations are measured for the smallest eigenvalue, in voxels.
const LEVER: f64 = 20.0;
/// The smallest standard deviation that the information matrix is based on, in voxels.
const MIN_SIGMA: f64 = 1e-3;

/// Steps of ICP. Lengths are in voxels.
///
/// Step `k` of `n` looks for corresponding points within
/// `first_radius + (last_radius − first_radius) · min(1, k / (n − 2))` and weights them with half of that as
/// the robust scale.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct IcpParams {
    /// Radius of the first step, in voxels; in (0, 3]. Default 2.5.
    pub first_radius: f64,
    /// Radius of the last steps, in voxels; in (0, 3]. Default 1.5.
    pub last_radius: f64,
    /// Steps; at least 1. Default 8.
    pub steps: usize,
    /// Further steps with the last radius whose robust scale follows the residuals, down to the
    /// resolution of the data: three standard deviations. Default 0.
    pub polish_steps: usize,
    /// Cosine of the angle of normals above which points correspond, in [0, 1). Default 0.5 (60°).
    pub min_normal_cosine: f64,
    /// Corresponding points without which nothing is refined; at least 6. Default 10.
    pub min_correspondences: usize,
    /// The smallest eigenvalue, as a fraction of the weight of all corresponding points, of a direction that is
    /// refined; in [0, 1). Others are left as they were. Default 0.001, which is what noise of 2° in the
    /// normals makes of a direction in which nothing resists.
    pub min_stability: f64,
    /// Step length, in voxels, below which the steps with the last radius end; at least 0. Default 0.001.
    pub tolerance: f64,
}

impl Default for IcpParams {
    fn default() -> Self {
        Self {
            first_radius: 2.5,
            last_radius: 1.5,
            steps: 8,
            polish_steps: 0,
            min_normal_cosine: 0.5,
            min_correspondences: 10,
            min_stability: 1e-3,
            tolerance: 1e-3,
        }
    }
}

impl IcpParams {
    /// The default with 12 further steps down to the resolution of the data: for scans that are undistorted up
    /// to their noise. Those of depth cameras are bent by more, and gain nothing.
    #[must_use]
    pub fn precise() -> Self {
        Self {
            polish_steps: 12,
            ..Self::default()
        }
    }

    /// Checks that every parameter is in its range.
    ///
    /// # Errors
    /// [`InvalidParameter`] names the first that is not.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        let &Self {
            min_correspondences,
            min_stability,
            tolerance,
            ..
        } = self;
        self.schedule().validate()?;
        let (name, value) = ("min_correspondences", min_correspondences as f64);
        InvalidParameter::check(min_correspondences >= 6, name, value, "at least 6")?;
        let is_fraction = (0.0..1.0).contains(&min_stability);
        InvalidParameter::check(is_fraction, "min_stability", min_stability, "in [0, 1)")?;
        check_tolerance(tolerance)
    }

    /// The equations of each step.
    pub(crate) fn schedule(&self) -> Schedule {
        Schedule {
            first: self.first_radius,
            last: self.last_radius,
            steps: self.steps,
            polish_steps: self.polish_steps,
            min_normal_cosine: self.min_normal_cosine,
        }
    }
}

/// The check of the step length below which steps end.
pub(crate) fn check_tolerance(tolerance: f64) -> Result<(), InvalidParameter> {
    let is_length = tolerance.is_finite() && tolerance >= 0.0;
    InvalidParameter::check(is_length, "tolerance", tolerance, "finite and at least 0")
}

/// Radii and robust scales of the steps of a refinement.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Schedule {
    pub first: f64,
    pub last: f64,
    pub steps: usize,
    pub polish_steps: usize,
    pub min_normal_cosine: f64,
}

impl Schedule {
    /// Checks the parameters of which the schedule is made, by their names in the structs that make it.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        check_radius("first_radius", self.first)?;
        check_radius("last_radius", self.last)?;
        let steps = self.steps as f64;
        InvalidParameter::check(self.steps >= 1, "steps", steps, "at least 1")?;
        check_agreement("min_normal_cosine", self.min_normal_cosine)
    }

    pub fn len(&self) -> usize {
        self.steps + self.polish_steps
    }

    pub fn at(&self, step: usize) -> EquationParams {
        let steps_that_shrink = self.steps.saturating_sub(2).max(1);
        let progress = (step as f64 / steps_that_shrink as f64).min(1.0);
        let radius = self.first + (self.last - self.first) * progress;
        EquationParams {
            radius,
            min_normal_cosine: self.min_normal_cosine,
            robust_scale: (step < self.steps).then_some(SCALE_BY_RADIUS * radius),
        }
    }

    /// The step after one that has converged: the next with another robust scale, or none. `None` while the
    /// radius still shrinks.
    pub fn after_convergence(&self, step: usize) -> Option<usize> {
        let end = if step < self.steps {
            self.steps
        } else {
            self.len()
        };
        (self.at(step).radius == self.last).then_some(end)
    }

    /// The equations of the last step.
    pub fn last(&self) -> EquationParams {
        self.at(self.len() - 1)
    }
}

/// A relative pose as exact as two surfaces make it, and how exact that is.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PairRefinement {
    /// The transformation from scan j's frame into scan i's.
    #[cfg_attr(feature = "serde", serde(with = "gmpcr_geometry::matrix_rows"))]
    pub i_from_j: Isometry3<f64>,
    /// The equations at this pose, with the radius and the robust scale of the last step.
    pub equations: PairEquations,
    /// Directions in which the points did not determine the pose, such as sliding along a plane. They were left
    /// as they were. Each is a tangent `ξ` at the right, translation before rotation vector, that moves the
    /// corresponding points by about one unit of length.
    pub undetermined: Vec<Vector6<f64>>,
    /// The smallest eigenvalue of the Hessian, in units that suit all data: rotations are taken about the center
    /// of the corresponding points, and measured by how far they move a point at the distance of 20 voxels. Neither
    /// the unit of length nor the frames matter. It grows with the number of queries.
    pub smallest_eigenvalue: f64,
    /// Steps taken.
    pub steps: usize,
    /// Whether the last step was shorter than the tolerance. `false`, too, if corresponding points are too
    /// few; the pose is the initial one then if they were so from the beginning.
    pub converged: bool,
    /// The variance on which [`information`](Self::information) is based.
    pub variance: f64,
}

impl PairRefinement {
    /// Information matrix (inverse covariance) of the relative pose: the Hessian of the cost, divided by
    /// the variance of the residuals.
    ///
    /// The conventions are those of `gmpcr_cliques::information_matrix`: tangent at the right, `i_from_j ·
    /// exp(ξ)`, rows and columns 0–2 for translation in 1 / length², 3–5 for rotation in 1 / radian². The
    /// standard deviation is the weighted root mean square of the residuals, at least a thousandth of a
    /// voxel. Residuals are taken as independent; noise that neighbors have in common, and errors that
    /// scans have as a whole, make the matrix too large.
    pub fn information(&self) -> Matrix6<f64> {
        self.equations.hessian / self.variance
    }
}

/// Refines a relative pose by symmetric point-to-plane ICP: the [`pair_equations`](crate::pair_equations)
/// are set up anew and solved, step after step, while the radius shrinks.
///
/// Where the surfaces do not determine a direction – both are one plane, or a corridor – the pose is left as it was
/// in that direction, and the direction is [reported](PairRefinement::undetermined). Surfaces without overlap
/// leave all of it as it was.
///
/// Swapping the scans and inverting the pose inverts the result, up to rounding. Noise-free planar surfaces
/// converge to the exact pose; the fewer robust weights reach into false correspondences at edges, the
/// faster, so use [`IcpParams::precise`] where millimeters matter. Noise of the standard deviation σ in
/// each point leaves errors of about the inverse of [`PairRefinement::information`]. The pose must be near:
/// within about two voxels at most points. Time is linear in queries and steps, some 40 µs for a step with 600 of
/// each scan.
///
/// # Errors
/// [`Error::Parameter`] if a parameter is out of range, [`Error::Coordinate`] if the pose is not of finite
/// numbers.
///
/// ```
/// use gmpcr_refine::{IcpParams, Surface, SurfaceParams, refine_pair};
/// use nalgebra::{Isometry3, Point3, Vector3};
///
/// // The corner of a room: three walls, a point per voxel.
/// let (mut points, mut normals) = (Vec::new(), Vec::new());
/// for (axis, k) in (0..3).flat_map(|axis| (0..900).map(move |k| (axis, k))) {
///     let on_wall = Vector3::new(0.0, f64::from(k % 30) + 0.5, f64::from(k / 30) + 0.5);
///     points.push(Point3::from([0, 1, 2].map(|c| on_wall[(c + axis) % 3])));
///     normals.push(Vector3::ith((3 - axis) % 3, 1.0));
/// }
/// let corner = Surface::new(&points, &normals, &SurfaceParams::from_voxel_size(1.0))?;
/// let start = Isometry3::new(Vector3::new(0.4, -0.3, 0.5), Vector3::new(0.02, 0.01, -0.02));
/// let found = refine_pair(&corner, &corner, &start, &IcpParams::precise())?;
/// assert!(found.converged && found.undetermined.is_empty());
/// assert!(found.i_from_j.translation.vector.norm() < 1e-2);
/// assert!(found.i_from_j.rotation.angle() < 1e-3);
/// # Ok::<(), gmpcr_refine::Error>(())
/// ```
pub fn refine_pair(
    scan_i: &Surface,
    scan_j: &Surface,
    i_from_j: &Isometry3<f64>,
    params: &IcpParams,
) -> Result<PairRefinement, Error> {
    params.validate()?;
    check::transformations([i_from_j])?;
    let voxel = scan_i.voxel_size().max(scan_j.voxel_size());
    let at = |pose: &Isometry3<f64>, settings: &EquationParams| {
        equations(scan_i, scan_j, pose, settings)
    };
    let descent = descend(i_from_j, voxel, params, at);
    let equations = at(&descent.pose, &params.schedule().last());
    let tangent = Tangent {
        center: equations.center.coords,
        scale: LEVER * voxel,
    };
    Ok(PairRefinement {
        i_from_j: descent.pose,
        undetermined: descent.undetermined,
        smallest_eigenvalue: smallest_eigenvalue(&equations.hessian, &tangent),
        steps: descent.steps,
        converged: descent.converged,
        variance: equations.rms.max(MIN_SIGMA * voxel).powi(2),
        equations,
    })
}

/// Where steps led.
pub(crate) struct Descent {
    pub pose: Isometry3<f64>,
    pub undetermined: Vec<Vector6<f64>>,
    pub steps: usize,
    pub converged: bool,
}

/// Steps from a pose as the schedule says, with the equations that `at` sets up at a pose.
pub(crate) fn descend(
    start: &Isometry3<f64>,
    voxel: f64,
    params: &IcpParams,
    mut at: impl FnMut(&Isometry3<f64>, &EquationParams) -> PairEquations,
) -> Descent {
    let schedule = params.schedule();
    let mut descent = Descent {
        pose: *start,
        undetermined: (0..6).map(|k| Vector6::ith(k, 1.0)).collect(),
        steps: 0,
        converged: false,
    };
    let mut k = 0;
    while k < schedule.len() {
        let settings = schedule.at(k);
        let equations = at(&descent.pose, &settings);
        descent.converged = false;
        if equations.correspondences < params.min_correspondences {
            break;
        }
        let max_length = MAX_STEP * settings.radius * voxel;
        let step = Step::new(&equations, params.min_stability, max_length);
        descent.pose *= step.transformation;
        descent.pose.rotation.renormalize();
        descent.undetermined = step.undetermined;
        descent.steps += 1;
        descent.converged = step.length < params.tolerance * voxel;
        k = match schedule.after_convergence(k) {
            Some(next) if descent.converged => next,
            _ => k + 1,
        };
    }
    descent
}
