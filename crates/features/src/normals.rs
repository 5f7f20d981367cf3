//! The direction in which a neighborhood extends least.

use crate::neighbors::{Neighbor, Reach, Search};
use crate::{Error, NormalParams, check};
use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

/// A neighborhood whose second largest eigenvalue is below this part of the largest is a line.
///
/// It is then a million times longer than wide, and the rounding of the covariance (1e-16 of the
/// largest eigenvalue) would rotate the normal by 1e-4 and more.
const LINE: f64 = 1e-12;

/// QR steps after which the eigenvectors are given up; two or three are usual.
const MAX_QR_STEPS: usize = 100;

/// Unit normal of the surface around each point, on the side of the viewpoint.
///
/// With `N` the point and its neighbors within reach and `m` their mean, the normal is the
/// eigenvector of the smallest eigenvalue of the covariance `1/|N| sum_N (p - m) (p - m)^T`: the
/// normal of the plane that fits `N` best in the least-squares sense (Hoppe et al., SIGGRAPH
/// 1992). Its sign makes `normal . (viewpoint - point) >= 0`. This is Open3D's `EstimateNormals`
/// with a hybrid search, followed by `OrientNormalsTowardsCameraLocation`.
///
/// Where no plane is determined, that is with fewer than three points in `N` or all of them on one
/// line or in one place, the normal is the direction from the point to the viewpoint, or (0, 0, 1)
/// if the point lies there itself. (Open3D returns ±(0, 0, 1) or whatever rounding leaves.) Where
/// the two smallest eigenvalues are equal, as on a tube, the normal is one of their
/// eigenvectors; where the viewpoint lies in the tangent plane, the sign is open. Results are
/// always finite unit vectors, and equal input gives equal bits.
///
/// Takes O(n log n) for the tree and a search per point. Points that coincide in large numbers
/// make the searches quadratic in that number; [`voxel_grid`](crate::voxel_grid) removes them.
///
/// # Errors
/// [`Error::Parameter`] for values outside the ranges that [`NormalParams`] states, [`Error::Coordinate`]
/// for coordinates outside ±1e100. An empty cloud has no normals.
///
/// ```
/// use gmpcr_features::{NormalParams, estimate_normals};
/// use nalgebra::{Point3, Vector3};
///
/// // A floor, seen from above.
/// let floor: Vec<_> = (0..100).map(|k| Point3::new((k % 10) as f64, (k / 10) as f64, 0.0)).collect();
/// let params = NormalParams {
///     radius: 2.0,
///     viewpoint: Point3::new(5.0, 5.0, 3.0),
///     ..NormalParams::default()
/// };
/// let normals = estimate_normals(&floor, &params)?;
/// assert!(normals.iter().all(|normal| (normal - Vector3::z()).norm() < 1e-12));
/// # Ok::<(), gmpcr_features::Error>(())
/// ```
pub fn estimate_normals(
    points: &[Point3<f64>],
    params: &NormalParams,
) -> Result<Vec<Vector3<f64>>, Error> {
    params.validate()?;
    check::points(points)?;
    if points.is_empty() {
        return Ok(Vec::new());
    }
    let search = Search::new(points)?;
    let mut neighbors = Vec::new();
    let normal = |center| {
        search.around(center, params.reach(), &mut neighbors);
        normal_at(points, center, &neighbors, &params.viewpoint)
    };
    Ok((0..points.len()).map(normal).collect())
}

impl NormalParams {
    pub(crate) fn reach(&self) -> Reach {
        Reach {
            radius: self.radius,
            max_neighbors: self.max_neighbors,
        }
    }
}

/// Normal of one point, given all neighbors to be fitted.
pub(crate) fn normal_at(
    points: &[Point3<f64>],
    center: usize,
    neighbors: &[Neighbor],
    viewpoint: &Point3<f64>,
) -> Vector3<f64> {
    let view = viewpoint - points[center];
    match flattest_direction(&covariance(points, center, neighbors)) {
        Some(normal) if normal.dot(&view) < 0.0 => -normal,
        Some(normal) => normal,
        None => view.try_normalize(check::SMALLEST).unwrap_or(Vector3::z()),
    }
}

/// Covariance of a point and its neighbors, about the point itself so that distance from the
/// origin costs no digits.
fn covariance(points: &[Point3<f64>], center: usize, neighbors: &[Neighbor]) -> Matrix3<f64> {
    let mut first = Vector3::zeros();
    let mut second = Matrix3::zeros();
    for neighbor in neighbors {
        let offset = points[neighbor.at()] - points[center];
        first += offset;
        second += offset * offset.transpose();
    }
    let count = (neighbors.len() + 1) as f64;
    let mean = first / count;
    second / count - mean * mean.transpose()
}

/// Eigenvector of the smallest eigenvalue; none if the matrix has a rank below two.
fn flattest_direction(covariance: &Matrix3<f64>) -> Option<Vector3<f64>> {
    let scale = covariance.trace();
    if scale < f64::MIN_POSITIVE {
        return None;
    }
    let eigen = SymmetricEigen::try_new(covariance / scale, f64::EPSILON, MAX_QR_STEPS)?;
    let (smallest, largest) = (eigen.eigenvalues.imin(), eigen.eigenvalues.imax());
    let middle = eigen.eigenvalues.sum() - eigen.eigenvalues[smallest] - eigen.eigenvalues[largest];
    if middle <= LINE * eigen.eigenvalues[largest] {
        return None;
    }
    eigen
        .eigenvectors
        .column(smallest)
        .try_normalize(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEAR: NormalParams = NormalParams {
        radius: 2.5,
        max_neighbors: 30,
        viewpoint: Point3::new(3.0, -4.0, 5.0),
    };

    fn grid(place: impl Fn(f64, f64) -> Point3<f64>) -> Vec<Point3<f64>> {
        (0..100)
            .map(|k| place((k % 10) as f64, (k / 10) as f64))
            .collect()
    }

    #[test]
    fn a_tilted_plane_has_its_own_normal_on_the_side_of_the_viewpoint() {
        let normal = Vector3::new(2.0, -3.0, 6.0) / 7.0;
        let (u, v) = (Vector3::new(3.0, 2.0, 0.0), Vector3::new(6.0, 2.0, -1.0));
        let plane = grid(|s, t| Point3::from(0.1 * (s * u + t * v)));
        for (viewpoint, sign) in [(NEAR.viewpoint, 1.0), (-NEAR.viewpoint, -1.0)] {
            let normals = estimate_normals(&plane, &NormalParams { viewpoint, ..NEAR }).unwrap();
            assert!(normals.iter().all(|n| (n - normal * sign).norm() < 1e-12));
        }
    }

    #[test]
    fn a_plane_far_from_the_origin_loses_no_more_than_its_coordinates_did() {
        let plane = grid(|s, t| Point3::new(1e6 + s, 1e6 + t, 1e6));
        let normals = estimate_normals(&plane, &NEAR).unwrap();
        assert!(normals.iter().all(|n| (n + Vector3::z()).norm() < 1e-12));
    }

    #[test]
    fn normals_of_a_sphere_are_radial_and_face_its_center() {
        // Equal areas: steps in height, the golden angle around the axis.
        let point = |k: usize| {
            let (z, angle) = ((k as f64 + 0.5) / 1000.0 - 1.0, k as f64 * 2.399_963);
            let r = (1.0 - z * z).sqrt();
            Point3::new(r * angle.cos(), r * angle.sin(), z)
        };
        let sphere: Vec<_> = (0..2000).map(point).collect();
        let params = NormalParams {
            radius: 0.2,
            max_neighbors: 30,
            viewpoint: Point3::origin(),
        };
        let normals = estimate_normals(&sphere, &params).unwrap();
        for (point, normal) in sphere.iter().zip(&normals) {
            assert!(normal.dot(&point.coords) < -0.999);
        }
    }

    #[test]
    fn fewer_than_three_points_face_the_viewpoint() {
        let pair = [Point3::new(3.0, -4.0, 4.0), Point3::new(3.0, -3.0, 5.0)];
        let normals = estimate_normals(&pair, &NEAR).unwrap();
        assert_eq!(normals, [Vector3::z(), -Vector3::y()]);
    }

    #[test]
    fn points_on_a_line_face_the_viewpoint() {
        let line: Vec<_> = (0..50)
            .map(|k| Point3::new(0.1, 0.2, 0.3) * f64::from(k))
            .collect();
        let normals = estimate_normals(&line, &NEAR).unwrap();
        for (point, normal) in line.iter().zip(&normals) {
            assert!((normal - (NEAR.viewpoint - point).normalize()).norm() < 1e-15);
        }
    }

    #[test]
    fn a_thousand_equal_points_face_the_viewpoint() {
        let normals = estimate_normals(&[Point3::new(3.0, -4.0, 9.0); 1000], &NEAR).unwrap();
        assert_eq!(normals, vec![-Vector3::z(); 1000]);
    }

    #[test]
    fn a_point_alone_at_the_viewpoint_faces_upward() {
        assert_eq!(
            estimate_normals(&[NEAR.viewpoint], &NEAR),
            Ok(vec![Vector3::z()])
        );
    }

    #[test]
    fn a_strip_a_thousandth_as_wide_as_long_still_has_a_normal() {
        let strip = grid(|s, t| Point3::new(s, 1e-3 * t, 0.0));
        let normals = estimate_normals(&strip, &NEAR).unwrap();
        assert!(normals.iter().all(|n| (n - Vector3::z()).norm() < 1e-9));
    }

    #[test]
    fn only_the_nearest_points_are_fitted() {
        // A floor with a wall behind it: with all points the normals would tilt.
        let mut scene = grid(|s, t| Point3::new(s, t, 0.0));
        scene.extend((1..20).map(|k| Point3::new(0.0, 0.0, 1.0 + f64::from(k))));
        let params = NormalParams {
            radius: 100.0,
            max_neighbors: 4,
            ..NEAR
        };
        let normals = estimate_normals(&scene, &params).unwrap();
        assert!((normals[55] - Vector3::z()).norm() < 1e-12);
        let params = NormalParams {
            max_neighbors: 1000,
            ..params
        };
        let normals = estimate_normals(&scene, &params).unwrap();
        assert!((normals[55] - Vector3::z()).norm() > 0.1);
    }
}
