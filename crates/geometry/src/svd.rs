use nalgebra::{Matrix3, Rotation3, Vector3};

/// Singular value decomposition `M = U diag(σ) Vᵀ` of a 3×3 matrix with proper rotations.
///
/// `U` and `V` have determinant +1; σ₁ ≥ σ₂ ≥ |σ₃|, and σ₃ carries the sign of `det M`. The
/// rotation nearest to `M` is then `U Vᵀ` with no case for reflections.
///
/// One-sided Jacobi (Hestenes 1958): it works on the columns of `M` itself, never on `MᵀM`, so
/// that nearly collinear points keep all their digits. Entries that are not finite give a result
/// that is not finite; nothing panics.
///
/// ```
/// use gmpcr_geometry::SignedSvd3;
/// use nalgebra::{Matrix3, Vector3};
///
/// let mirror = Matrix3::from_diagonal(&Vector3::new(3.0, 2.0, -1.0));
/// let svd = SignedSvd3::new(&mirror);
/// assert_eq!(svd.singular_values, Vector3::new(3.0, 2.0, -1.0));
/// assert!((svd.nearest_rotation().matrix() - Matrix3::identity()).norm() < 1e-15);
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct SignedSvd3 {
    /// Left singular vectors, as the columns of a rotation.
    pub u: Matrix3<f64>,
    /// Singular values in descending order, the last one with the sign of the determinant.
    pub singular_values: Vector3<f64>,
    /// Right singular vectors, as the columns of a rotation.
    pub v: Matrix3<f64>,
}

/// Column pairs of one Jacobi sweep.
const PAIRS: [(usize, usize); 3] = [(0, 1), (0, 2), (1, 2)];
/// Convergence is quadratic: five sweeps are typical, and thirty are never reached.
const MAX_SWEEPS: usize = 30;
/// Columns shorter than 1e-16 of the matrix are rounding noise: they have no direction to rotate.
const NOISE_SQUARED: f64 = 1e-32;

impl SignedSvd3 {
    /// Decomposes `matrix`.
    pub fn new(matrix: &Matrix3<f64>) -> Self {
        let scale = matrix.amax();
        if scale == 0.0 || !scale.is_finite() {
            return Self {
                u: Matrix3::identity(),
                singular_values: Vector3::repeat(scale),
                v: Matrix3::identity(),
            };
        }
        let (columns, v) = orthogonal_columns(matrix / scale);
        let svd = sorted_and_proper(&columns, &v);
        Self {
            singular_values: svd.singular_values * scale,
            ..svd
        }
    }

    /// The rotation nearest to the decomposed matrix, `U Vᵀ`.
    pub fn nearest_rotation(&self) -> Rotation3<f64> {
        Rotation3::from_matrix_unchecked(self.u * self.v.transpose())
    }

    /// Number of singular values above `relative_tolerance · σ₁`.
    pub fn rank(&self, relative_tolerance: f64) -> usize {
        let threshold = relative_tolerance * self.singular_values[0];
        let above = |sigma: &&f64| sigma.abs() > threshold;
        self.singular_values.iter().filter(above).count()
    }
}

/// Rotates pairs of columns until all are orthogonal: returns `(M V, V)`.
fn orthogonal_columns(mut a: Matrix3<f64>) -> (Matrix3<f64>, Matrix3<f64>) {
    let mut v = Matrix3::identity();
    let noise = NOISE_SQUARED * a.norm_squared();
    for _ in 0..MAX_SWEEPS {
        let mut rotated = false;
        for (p, q) in PAIRS {
            if let Some((c, s)) = jacobi_rotation(&a, p, q, noise) {
                rotate_columns(&mut a, p, q, c, s);
                rotate_columns(&mut v, p, q, c, s);
                rotated = true;
            }
        }
        if !rotated {
            break;
        }
    }
    (a, v)
}

/// Cosine and sine of the rotation that makes columns `p` and `q` orthogonal, if they are not yet.
fn jacobi_rotation(a: &Matrix3<f64>, p: usize, q: usize, noise: f64) -> Option<(f64, f64)> {
    let (alpha, beta) = (a.column(p).norm_squared(), a.column(q).norm_squared());
    let gamma = a.column(p).dot(&a.column(q));
    if alpha.min(beta) <= noise || gamma.abs() <= f64::EPSILON * (alpha * beta).sqrt() {
        return None;
    }
    let zeta = (beta - alpha) / (2.0 * gamma);
    let t = 1f64.copysign(zeta) / (zeta.abs() + zeta.hypot(1.0));
    let c = 1.0 / t.hypot(1.0);
    Some((c, c * t))
}

fn rotate_columns(m: &mut Matrix3<f64>, p: usize, q: usize, c: f64, s: f64) {
    for row in 0..3 {
        let (x, y) = (m[(row, p)], m[(row, q)]);
        m[(row, p)] = c * x - s * y;
        m[(row, q)] = s * x + c * y;
    }
}

/// Orders the orthogonal columns by length and completes both bases to rotations: the third
/// vectors are cross products, which puts the sign of the determinant into σ₃.
fn sorted_and_proper(columns: &Matrix3<f64>, v: &Matrix3<f64>) -> SignedSvd3 {
    let mut order = [0, 1, 2];
    order.sort_by(|&p, &q| {
        columns
            .column(q)
            .norm()
            .total_cmp(&columns.column(p).norm())
    });
    let [a1, a2, a3] = order.map(|k| columns.column(k).into_owned());
    let [v1, v2, v3] = order.map(|k| v.column(k).into_owned());

    let u1 = a1.normalize();
    let orthogonal = a2 - u1 * u1.dot(&a2);
    let u2 = if orthogonal.norm_squared() > NOISE_SQUARED {
        orthogonal.normalize()
    } else {
        any_orthogonal(&u1)
    };
    let u3 = u1.cross(&u2);
    let proper_v3 = v1.cross(&v2);
    let sigma3 = u3.dot(&a3) * proper_v3.dot(&v3).signum();
    SignedSvd3 {
        u: Matrix3::from_columns(&[u1, u2, u3]),
        singular_values: Vector3::new(a1.norm(), a2.norm(), sigma3),
        v: Matrix3::from_columns(&[v1, v2, proper_v3]),
    }
}

/// A unit vector orthogonal to the unit vector `u`.
fn any_orthogonal(u: &Vector3<f64>) -> Vector3<f64> {
    let axis = Vector3::ith(u.iamin(), 1.0);
    u.cross(&axis).normalize()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn reconstructed(svd: &SignedSvd3) -> Matrix3<f64> {
        svd.u * Matrix3::from_diagonal(&svd.singular_values) * svd.v.transpose()
    }

    fn assert_is_svd_of(svd: &SignedSvd3, m: &Matrix3<f64>) {
        for basis in [&svd.u, &svd.v] {
            assert!((basis.transpose() * basis - Matrix3::identity()).norm() < 1e-14);
            assert!((basis.determinant() - 1.0).abs() < 1e-14);
        }
        let sigma = svd.singular_values;
        assert!(sigma[0] >= sigma[1] && sigma[1] >= sigma[2].abs() * (1.0 - 1e-14));
        assert!((reconstructed(svd) - m).norm() <= 4e-15 * m.norm());
    }

    #[test]
    fn decomposes_matrices_of_every_rank() {
        let x = Vector3::new(1.0, -2.0, 0.5);
        let y = Vector3::new(0.3, 0.1, 4.0);
        let cases = [
            (Matrix3::zeros(), 0),
            (x * y.transpose(), 1),
            (x * y.transpose() + y * x.transpose(), 2),
            (Matrix3::identity(), 3),
            (-Matrix3::identity(), 3),
        ];
        for (m, rank) in cases {
            let svd = SignedSvd3::new(&m);
            assert_is_svd_of(&svd, &m);
            assert_eq!(svd.rank(1e-12), rank, "{m}");
        }
    }

    #[test]
    fn survives_extreme_scales_and_values_that_are_not_finite() {
        for scale in [1e-300, 1e-160, 1e160, 1e300] {
            let m = Matrix3::new(1.0, 2.0, 3.0, -4.0, 5.0, 6.0, 7.0, -8.0, 9.0) * scale;
            let svd = SignedSvd3::new(&m);
            assert!((reconstructed(&svd) / scale - m / scale).norm() < 1e-13);
        }
        let svd = SignedSvd3::new(&Matrix3::repeat(f64::INFINITY));
        assert!(!svd.singular_values[0].is_finite());
        SignedSvd3::new(&Matrix3::repeat(f64::NAN));
    }

    #[test]
    fn keeps_the_small_direction_of_a_nearly_collinear_set() {
        let rotation = Rotation3::new(Vector3::new(0.4, -1.1, 0.2));
        let stretch = Matrix3::from_diagonal(&Vector3::new(1.0, 1e-8, 1e-8));
        let other = Rotation3::new(Vector3::new(-0.7, 0.3, 2.0));
        let m = rotation.matrix() * other.matrix() * stretch * other.matrix().transpose();
        let error = SignedSvd3::new(&m).nearest_rotation().matrix() - rotation.matrix();
        assert!(error.norm() < 1e-7, "{error}");
    }

    fn matrix() -> impl Strategy<Value = Matrix3<f64>> {
        prop::array::uniform9(-10.0..10.0f64).prop_map(|e| Matrix3::from_column_slice(&e))
    }

    proptest! {
        #[test]
        fn reconstructs_any_matrix(m in matrix()) {
            assert_is_svd_of(&SignedSvd3::new(&m), &m);
        }

        #[test]
        fn no_rotation_is_nearer_than_the_nearest(m in matrix(), axis in prop::array::uniform3(-3.0..3.0f64)) {
            let nearest = SignedSvd3::new(&m).nearest_rotation();
            let other = Rotation3::new(Vector3::from(axis));
            prop_assert!((m - nearest.matrix()).norm() <= (m - other.matrix()).norm() + 1e-12);
        }

        #[test]
        fn the_nearest_rotation_rotates_with_the_matrix(m in matrix(), axis in prop::array::uniform3(-3.0..3.0f64)) {
            let svd = SignedSvd3::new(&m);
            prop_assume!(svd.singular_values[1] + svd.singular_values[2] > 1e-2);
            let rotation = Rotation3::new(Vector3::from(axis));
            let rotated = SignedSvd3::new(&(rotation.matrix() * m)).nearest_rotation();
            prop_assert!((rotated.matrix() - (rotation * svd.nearest_rotation()).matrix()).norm() < 1e-11);
        }
    }
}
