use gmpcr_geometry::InvalidParameter;
use nalgebra::{Isometry3, Matrix6, Point3, Vector3, Vector6};

use crate::rigid::{Rigid, cross, dot, minus};
use crate::surface::{Patch, Surface};
use crate::verify::check_radius;
use crate::{Error, check};

/// The smallest robust scale, in voxels: noise-free surfaces have residuals of rounding only.
const MIN_SCALE: f64 = 1e-3;
/// Standard deviations beyond which residuals count little, where the scale follows the residuals.
const SCALE_IN_SIGMAS: f64 = 3.0;
/// Standard deviation of a normal distribution by the median of its absolute values.
const SIGMA_BY_MEDIAN: f64 = 1.4826;

/// Which points correspond, and how outliers among them are weighted down. Lengths are in voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct EquationParams {
    /// Distance below which a query and its nearest point correspond, in voxels; in (0, 3]. Default 1.5.
    pub radius: f64,
    /// Cosine of the angle of their normals above which they correspond, in [0, 1). Default 0.5 (60°).
    pub min_normal_cosine: f64,
    /// Scale `s` of the robust weights `1 / (1 + r²/s²)²`, in voxels; positive. `None` lets it follow the
    /// residuals: three of their standard deviations by the median, at least 0.001. Default 0.75, half of the
    /// radius.
    pub robust_scale: Option<f64>,
}

impl Default for EquationParams {
    fn default() -> Self {
        Self {
            radius: 1.5,
            min_normal_cosine: 0.5,
            robust_scale: Some(0.75),
        }
    }
}

impl EquationParams {
    /// Checks that every parameter is in its range.
    ///
    /// # Errors
    /// [`InvalidParameter`] names the first that is not.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        let &Self {
            radius,
            min_normal_cosine,
            robust_scale,
        } = self;
        check_radius("radius", radius)?;
        check_agreement("min_normal_cosine", min_normal_cosine)?;
        match robust_scale {
            Some(scale) => InvalidParameter::check_positive("robust_scale", scale),
            None => Ok(()),
        }
    }
}

/// Normals that disagree have no mean.
pub(crate) fn check_agreement(name: &str, cosine: f64) -> Result<(), InvalidParameter> {
    let is_acute = (0.0..1.0).contains(&cosine);
    InvalidParameter::check(is_acute, name, cosine, "in [0, 1)")
}

/// What two surfaces ask of their relative pose: the normal equations of symmetric point-to-plane ICP.
///
/// The tangent is at the right, translation before rotation vector: `T(ξ) = i_from_j · exp(ξ)`. With the
/// cost `C = ½ Σ w_m r_m²` over all correspondences,
///
/// ```text
/// hessian  = Σ w_m J_m J_mᵀ,     gradient = ∂C/∂ξ = Σ w_m r_m J_m,     J_m = ∂r_m/∂ξ
/// ```
///
/// for given weights and normals, and a Gauss–Newton step solves `hessian · ξ = −gradient`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PairEquations {
    /// Gauss–Newton Hessian of the cost: translations in 1, rotations in squared lengths per radian².
    pub hessian: Matrix6<f64>,
    /// Gradient of the cost.
    pub gradient: Vector6<f64>,
    /// Corresponding points of both directions.
    pub correspondences: usize,
    /// Sum of their robust weights `w`, each in (0, 1].
    pub weight: f64,
    /// `√(Σ w r² / Σ w)`, in the unit of the points; 0 without correspondences.
    pub rms: f64,
    /// Median of `|r|`, in the unit of the points; 0 without correspondences.
    pub median: f64,
    /// Weighted mean of the correspondences, in the frame of scan j; without them the origin.
    pub center: Point3<f64>,
    /// Weighted root mean square of their distances from the center; 0 without correspondences.
    pub spread: f64,
}

/// A correspondence.
struct Row {
    jacobian: [f64; 6],
    residual: f64,
    /// In the frame of scan j.
    position: [f64; 3],
}

/// The normal equations of a relative pose by corresponding points of two surfaces.
///
/// Each query `q` of one scan corresponds to its nearest point `p` of the other, if both are near enough and
/// their normals agree. The residual is the distance from the plane through `p` whose normal is the mean
/// of both,
///
/// ```text
/// r = (q − p) · n,     n = (n_q + n_p) / ‖n_q + n_p‖,     w = 1 / (1 + r²/s²)²
/// ```
///
/// with the queries of both scans, each in the frame of the other (symmetric ICP in the sense of Rusinkiewicz,
/// "A symmetric objective function for ICP", SIGGRAPH 2019; Geman–McClure weights). Each direction uses the
/// radius and the scale in voxels of the surface that is asked.
///
/// [`refine_pair`](crate::refine_pair) and [`refine_jointly`](crate::refine_jointly) iterate them. Time is
/// linear in the queries.
///
/// # Errors
/// [`Error::Parameter`] if a parameter is out of range, [`Error::Coordinate`] if the pose is not of finite
/// numbers.
///
/// ```
/// use gmpcr_refine::{EquationParams, Surface, SurfaceParams, pair_equations};
/// use nalgebra::{Isometry3, Point3, Vector3};
///
/// let sheet: Vec<_> = (0..400).map(|k| Point3::new(f64::from(k % 20), f64::from(k / 20), 9.0)).collect();
/// let surface = Surface::new(&sheet, &vec![-Vector3::z(); 400], &SurfaceParams::from_voxel_size(1.0))?;
/// let too_far = Isometry3::translation(0.0, 0.0, 0.25);
/// let equations = pair_equations(&surface, &surface, &too_far, &EquationParams::default())?;
/// // 800 queries, each a quarter too far; the plane says nothing of the other two translations.
/// assert_eq!((equations.correspondences, equations.median), (800, 0.25));
/// assert!((equations.gradient.z / equations.hessian[(2, 2)] - 0.25).abs() < 1e-9);
/// assert_eq!(equations.hessian[(0, 0)], 0.0);
/// # Ok::<(), gmpcr_refine::Error>(())
/// ```
pub fn pair_equations(
    scan_i: &Surface,
    scan_j: &Surface,
    i_from_j: &Isometry3<f64>,
    params: &EquationParams,
) -> Result<PairEquations, Error> {
    params.validate()?;
    check::transformations([i_from_j])?;
    Ok(equations(scan_i, scan_j, i_from_j, params))
}

/// The same with input that was checked.
pub(crate) fn equations(
    scan_i: &Surface,
    scan_j: &Surface,
    i_from_j: &Isometry3<f64>,
    params: &EquationParams,
) -> PairEquations {
    let rows = correspondences(scan_i, scan_j, i_from_j, params);
    if rows.is_empty() {
        return PairEquations::empty();
    }
    let median = median(rows.iter().map(|row| row.residual.abs()).collect());
    let voxel = scan_i.voxel_size().max(scan_j.voxel_size());
    let following = (SCALE_IN_SIGMAS * SIGMA_BY_MEDIAN * median).max(MIN_SCALE * voxel);
    let scale = params.robust_scale.map_or(following, |scale| scale * voxel);
    PairEquations::of_rows(&rows, scale, median)
}

/// The corresponding points of both directions.
fn correspondences(
    scan_i: &Surface,
    scan_j: &Surface,
    i_from_j: &Isometry3<f64>,
    params: &EquationParams,
) -> Vec<Row> {
    let mut rows = Vec::with_capacity(scan_i.queries.len() + scan_j.queries.len());
    let rigid = Rigid::new(i_from_j);
    for_each_match(scan_i, scan_j, &rigid, params, |query, matched| {
        // With n rotated into frame j, r changes by n · (v + ω × q).
        let normal = rigid.rotate_back(&matched.normal);
        let [x, y, z] = cross(&query.point, &normal);
        rows.push(Row {
            jacobian: [normal[0], normal[1], normal[2], x, y, z],
            residual: matched.residual,
            position: query.point,
        });
    });
    let inverse = Rigid::new(&i_from_j.inverse());
    for_each_match(scan_j, scan_i, &inverse, params, |_, matched| {
        // The query is in frame j already and moves the other way.
        let normal = matched.normal.map(|c| -c);
        let [x, y, z] = cross(&matched.position, &normal);
        rows.push(Row {
            jacobian: [normal[0], normal[1], normal[2], x, y, z],
            residual: matched.residual,
            position: matched.position,
        });
    });
    rows
}

/// A query in the frame of the surface that is asked.
struct Match {
    position: [f64; 3],
    normal: [f64; 3],
    residual: f64,
}

#[inline(always)]
fn for_each_match(
    target: &Surface,
    source: &Surface,
    target_from_source: &Rigid,
    params: &EquationParams,
    mut visit: impl FnMut(&Patch, Match),
) {
    let squared_radius = (params.radius * target.voxel_size()).powi(2);
    for query in &source.queries {
        let position = target_from_source.apply(&query.point);
        let Some(index) = target.grid.nearest(&position) else {
            continue;
        };
        let nearest = &target.patches[index];
        let offset = minus(&position, &nearest.point);
        if dot(&offset, &offset) >= squared_radius {
            continue;
        }
        let rotated = target_from_source.rotate(&query.normal);
        if dot(&rotated, &nearest.normal) <= params.min_normal_cosine {
            continue;
        }
        let sum = [0, 1, 2].map(|k| rotated[k] + nearest.normal[k]);
        let inverse_length = 1.0 / dot(&sum, &sum).sqrt();
        let normal = sum.map(|c| c * inverse_length);
        let residual = dot(&offset, &normal);
        visit(
            query,
            Match {
                position,
                normal,
                residual,
            },
        );
    }
}

/// The lower median; the values are not empty.
fn median(mut values: Vec<f64>) -> f64 {
    let middle = (values.len() - 1) / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

impl PairEquations {
    fn empty() -> Self {
        Self {
            hessian: Matrix6::zeros(),
            gradient: Vector6::zeros(),
            correspondences: 0,
            weight: 0.0,
            rms: 0.0,
            median: 0.0,
            center: Point3::origin(),
            spread: 0.0,
        }
    }

    fn of_rows(rows: &[Row], scale: f64, median: f64) -> Self {
        let inverse_square = 1.0 / (scale * scale);
        let first = rows[0].position;
        let (mut hessian, mut gradient) = ([[0.0; 6]; 6], [0.0; 6]);
        let (mut weights, mut squares, mut distances) = (0.0, 0.0, 0.0);
        let mut offsets = [0.0; 3];
        for row in rows {
            let root = 1.0 / (1.0 + row.residual * row.residual * inverse_square);
            let weight = root * root;
            let offset = minus(&row.position, &first);
            weights += weight;
            squares += weight * row.residual * row.residual;
            distances += weight * dot(&offset, &offset);
            for k in 0..3 {
                offsets[k] += weight * offset[k];
            }
            for (k, entries) in hessian.iter_mut().enumerate() {
                let weighted = weight * row.jacobian[k];
                gradient[k] += weighted * row.residual;
                for (entry, other) in entries.iter_mut().zip(&row.jacobian) {
                    *entry += weighted * other;
                }
            }
        }
        let offset = Vector3::from(offsets) / weights;
        Self {
            hessian: symmetric(&hessian),
            gradient: gradient.into(),
            correspondences: rows.len(),
            weight: weights,
            rms: (squares / weights).sqrt(),
            median,
            center: Point3::from(Vector3::from(first) + offset),
            spread: (distances / weights - offset.norm_squared())
                .max(0.0)
                .sqrt(),
        }
    }
}

/// The products `w J_k J_l` and `w J_l J_k` may differ by rounding.
fn symmetric(hessian: &[[f64; 6]; 6]) -> Matrix6<f64> {
    Matrix6::from_fn(|k, l| hessian[k.min(l)][k.max(l)])
}
