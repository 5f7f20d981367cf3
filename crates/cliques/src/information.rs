use gmpcr_geometry::PointPairs;
use nalgebra::{Matrix3, Matrix6, Vector3};

/// Information matrix (inverse covariance) of a relative pose from corresponding points.
///
/// `pairs` are the inliers of the pose, and `sigma` is the standard deviation of a coordinate of their
/// residuals, in the unit of the points; finite and positive. With the tangent at the right,
///
/// ```text
/// T(ξ) = target_from_source · exp(ξ),     ξ = (v, ω): translation, then rotation vector in radians
/// r_m  = target_m − T(ξ) source_m ≈ target_m − target_from_source (source_m + ω × source_m + v)
/// J_m  = ∂r_m/∂ξ = −R [ I | −[source_m]× ]
/// Ω    = Σ_m J_mᵀ J_m / σ²
///      = 1/σ² [ M I          −[Σ source_m]×                                  ]
///             [ [Σ source_m]×  Σ (‖source_m‖² I − source_m source_mᵀ) ]
/// ```
///
/// where `[s]×` is the matrix of the cross product, `[s]× ω = s × ω`. Ω is the Gauss–Newton Hessian of
/// `Σ_m ‖r_m‖² / (2 σ²)`, and its exact Hessian where the residuals vanish. The rotation `R` cancels: the
/// matrix is in the source's frame and depends neither on the pose nor on the target points. It is
/// symmetric and positive semidefinite, and definite if three of the points are not on a line.
///
/// | entries | unit |
/// |---|---|
/// | rows and columns 0–2, translation | 1 / length² |
/// | rows and columns 3–5, rotation | 1 / radian² |
///
/// Other conventions follow from it:
///
/// - **g2o**, `EDGE_SE3:QUAT i j` with the measurement `i_from_j`: the same side and order, but the
///   rotation is the vector part of the unit quaternion, `q ≈ ω / 2`. So multiply the rotation block by
///   4, and the two blocks beside it by 2.
/// - **Open3D**, `get_information_matrix_from_point_clouds`: rotation first, in the frame of the target,
///   and `σ = 1`. So take the matrix of [`swapped`](PointPairs::swapped) pairs and exchange the two
///   halves of its rows and of its columns.
///
/// Points that are counted more than once, such as noise that neighbors have in common, make the matrix
/// too large: its scale is as good as the assumption of independent residuals. `O(M)`.
///
/// ```
/// use gmpcr_cliques::information_matrix;
/// use gmpcr_geometry::PointPairs;
/// use nalgebra::{Point3, Vector6};
///
/// let points = vec![Point3::new(2.0, 0.0, 0.0), Point3::new(-2.0, 0.0, 0.0)];
/// let pairs = PointPairs::new(points.clone(), points)?;
/// let information = information_matrix(&pairs, 0.1);
/// // Two points, each with 1 / 0.1²; no information on the rotation around the line through both.
/// assert!((information.diagonal() - Vector6::new(200., 200., 200., 0., 800., 800.)).norm() < 1e-9);
/// # Ok::<(), gmpcr_geometry::PairsError>(())
/// ```
pub fn information_matrix(pairs: &PointPairs, sigma: f64) -> Matrix6<f64> {
    let (mut sum, mut squares) = (Vector3::zeros(), Matrix3::zeros());
    for point in pairs.source() {
        sum += point.coords;
        squares += point.coords * point.coords.transpose();
    }
    let mut information = Matrix6::identity() * pairs.len() as f64;
    let cross = sum.cross_matrix();
    let moments = Matrix3::identity() * squares.trace() - squares;
    information.fixed_view_mut::<3, 3>(0, 3).copy_from(&-cross);
    information.fixed_view_mut::<3, 3>(3, 0).copy_from(&cross);
    information.fixed_view_mut::<3, 3>(3, 3).copy_from(&moments);
    information / (sigma * sigma)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Matrix3x6, Point3, Translation3, UnitQuaternion, Vector6};
    use proptest::prelude::*;

    use super::*;

    /// The exponential map of SE(3).
    fn exp(xi: &Vector6<f64>) -> Isometry3<f64> {
        let (v, omega) = (
            xi.fixed_rows::<3>(0).into_owned(),
            xi.fixed_rows::<3>(3).into_owned(),
        );
        let (angle, cross) = (omega.norm(), omega.cross_matrix());
        let (first, second) = match angle < 1e-4 {
            true => (
                0.5 - angle * angle / 24.0,
                1.0 / 6.0 - angle * angle / 120.0,
            ),
            false => (
                (1.0 - angle.cos()) / (angle * angle),
                (angle - angle.sin()) / (angle * angle * angle),
            ),
        };
        let left_jacobian = Matrix3::identity() + cross * first + cross * cross * second;
        let rotation = UnitQuaternion::from_scaled_axis(omega);
        Isometry3::from_parts(Translation3::from(left_jacobian * v), rotation)
    }

    /// `T exp(ξ) = exp(Ad ξ) T`.
    fn adjoint(pose: &Isometry3<f64>) -> Matrix6<f64> {
        let rotation = pose.rotation.to_rotation_matrix().into_inner();
        let mut adjoint = Matrix6::zeros();
        adjoint.fixed_view_mut::<3, 3>(0, 0).copy_from(&rotation);
        adjoint.fixed_view_mut::<3, 3>(3, 3).copy_from(&rotation);
        let lever = pose.translation.vector.cross_matrix() * rotation;
        adjoint.fixed_view_mut::<3, 3>(0, 3).copy_from(&lever);
        adjoint
    }

    fn is_close(a: &Matrix6<f64>, b: &Matrix6<f64>, tolerance: f64) -> bool {
        (a - b).norm() <= tolerance * (1.0 + b.norm())
    }

    fn vector(limit: f64) -> impl Strategy<Value = Vector3<f64>> {
        prop::array::uniform3(-limit..limit).prop_map(Vector3::from)
    }

    fn pose() -> impl Strategy<Value = Isometry3<f64>> {
        (vector(3.0), vector(1.5)).prop_map(|(t, r)| Isometry3::new(t, r))
    }

    fn points() -> impl Strategy<Value = Vec<Point3<f64>>> {
        prop::collection::vec(vector(2.0).prop_map(Point3::from), 3..9)
    }

    /// Pairs without residuals.
    fn pairs(source: &[Point3<f64>], pose: &Isometry3<f64>) -> PointPairs {
        let target = source.iter().map(|point| pose * point).collect();
        PointPairs::new(target, source.to_vec()).unwrap()
    }

    /// Second derivatives of `Σ ‖r‖² / (2 σ²)` by central differences.
    fn hessian(pairs: &PointPairs, pose: &Isometry3<f64>, sigma: f64) -> Matrix6<f64> {
        let step = 1e-3;
        let cost = |xi: Vector6<f64>| {
            let residuals: f64 = pairs.residuals(&(pose * exp(&xi))).map(|r| r * r).sum();
            0.5 * residuals / (sigma * sigma)
        };
        let along = |k: usize| Vector6::ith(k, step);
        Matrix6::from_fn(|k, l| {
            let (a, b) = (along(k), along(l));
            let same = cost(a + b) + cost(-a - b);
            let opposite = cost(a - b) + cost(b - a);
            (same - opposite) / (4.0 * step * step)
        })
    }

    proptest! {
        #[test]
        fn it_is_the_hessian_where_the_residuals_vanish(
            source in points(), pose in pose(), sigma in 0.1..3.0f64,
        ) {
            let pairs = pairs(&source, &pose);
            let expected = hessian(&pairs, &pose, sigma);
            prop_assert!(is_close(&information_matrix(&pairs, sigma), &expected, 1e-5));
        }

        #[test]
        fn it_is_the_sum_of_the_jacobians(source in points(), pose in pose(), sigma in 0.1..3.0f64) {
            let mut sum = Matrix6::zeros();
            for point in &source {
                let mut jacobian = Matrix3x6::identity();
                jacobian.fixed_view_mut::<3, 3>(0, 3).copy_from(&-point.coords.cross_matrix());
                let jacobian = -pose.rotation.to_rotation_matrix().into_inner() * jacobian;
                sum += jacobian.transpose() * jacobian / (sigma * sigma);
            }
            let information = information_matrix(&pairs(&source, &pose), sigma);
            prop_assert!(is_close(&information, &sum, 1e-12));
            prop_assert_eq!(information, information.transpose());
        }

        #[test]
        fn another_source_frame_transforms_it_by_the_adjoint(
            source in points(), pose in pose(), other_from_source in pose(),
        ) {
            let here = information_matrix(&pairs(&source, &pose), 0.2);
            let moved: Vec<_> = source.iter().map(|point| other_from_source * point).collect();
            let there = pairs(&moved, &(pose * other_from_source.inverse()));
            let adjoint = adjoint(&other_from_source);
            let expected = adjoint.transpose() * information_matrix(&there, 0.2) * adjoint;
            prop_assert!(is_close(&here, &expected, 1e-10));
        }

        #[test]
        fn swapping_the_scans_transforms_it_by_the_adjoint_of_the_pose(
            source in points(), pose in pose(),
        ) {
            let pairs = pairs(&source, &pose);
            let adjoint = adjoint(&pose);
            let of_inverse = information_matrix(&pairs.swapped(), 0.2);
            let expected = adjoint.transpose() * of_inverse * adjoint;
            prop_assert!(is_close(&information_matrix(&pairs, 0.2), &expected, 1e-10));
        }

        #[test]
        fn g2o_counts_half_the_rotation(source in points(), pose in pose()) {
            // The cost as a function of the translation and the vector part of the quaternion.
            let xi = |q: &Vector6<f64>| {
                let mut xi = *q;
                xi.fixed_rows_mut::<3>(3).scale_mut(2.0);
                xi
            };
            let information = information_matrix(&pairs(&source, &pose), 1.0);
            let scale = Matrix6::from_diagonal(&Vector6::new(1.0, 1.0, 1.0, 2.0, 2.0, 2.0));
            let in_g2o = scale * information * scale;
            let q = Vector6::new(0.3, -0.2, 0.1, 0.02, 0.05, -0.01);
            prop_assert!((q.dot(&(in_g2o * q)) - xi(&q).dot(&(information * xi(&q)))).abs() < 1e-9);
            let ratio = |row, column| in_g2o[(row, column)] - information[(row, column)];
            prop_assert!((ratio(4, 4) - 3.0 * information[(4, 4)]).abs() < 1e-9);
            prop_assert!((ratio(0, 4) - information[(0, 4)]).abs() < 1e-9);
        }

        #[test]
        fn open3d_has_the_rotation_first_in_the_frame_of_the_target(
            source in points(), pose in pose(),
        ) {
            let pairs = pairs(&source, &pose);
            let mut open3d = Matrix6::zeros();
            for p in pairs.target() {
                let rows = [
                    Vector6::new(0.0, p.z, -p.y, 1.0, 0.0, 0.0),
                    Vector6::new(-p.z, 0.0, p.x, 0.0, 1.0, 0.0),
                    Vector6::new(p.y, -p.x, 0.0, 0.0, 0.0, 1.0),
                ];
                open3d += rows.iter().map(|row| row * row.transpose()).sum::<Matrix6<f64>>();
            }
            let ours = information_matrix(&pairs.swapped(), 1.0);
            let exchanged = Matrix6::from_fn(|row, column| ours[((row + 3) % 6, (column + 3) % 6)]);
            prop_assert!(is_close(&exchanged, &open3d, 1e-12));
        }
    }

    #[test]
    fn no_pair_gives_no_information() {
        assert_eq!(
            information_matrix(&PointPairs::default(), 1.0),
            Matrix6::zeros()
        );
    }
}
