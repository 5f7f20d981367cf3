use gmpcr_geometry::{PointPairs, SignedSvd3, isometry};
use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

/// Point pairs that leave the rotation free: fewer than three distinct points, or all on a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the point pairs leave the rotation free: their covariance has rank {rank}, not 2 or 3")]
pub struct Degenerate {
    /// Rank of the cross-covariance: 0 for a single point, 1 for a line.
    pub rank: usize,
}

/// The rigid transformation that best maps the source points onto the target points.
///
/// Minimizes `Σ_m w_m ‖target_m − target_from_source · source_m‖²` over SE(3) (Kabsch 1976;
/// Umeyama, TPAMI 1991): never a reflection, exact for planar and nearly collinear sets. `weights`
/// holds one nonnegative weight per pair; `None`, or weights that are all zero, weigh all alike.
/// Lengths keep the unit of the input. `O(M)`.
///
/// # Errors
/// [`Degenerate`] if the pairs do not determine the rotation.
///
/// # Panics
/// If `weights` and `pairs` differ in length.
///
/// ```
/// use gmpcr_cliques::kabsch;
/// use gmpcr_geometry::PointPairs;
/// use nalgebra::{Isometry3, Point3, Vector3};
///
/// let transformation = Isometry3::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.0, 0.0, 1.5));
/// let source = vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 2.0, 0.0)];
/// let target = source.iter().map(|p| transformation * p).collect();
/// let found = kabsch(&PointPairs::new(target, source)?, None)?;
/// assert!((found.to_matrix() - transformation.to_matrix()).norm() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn kabsch(pairs: &PointPairs, weights: Option<&[f64]>) -> Result<Isometry3<f64>, Degenerate> {
    let weights = usable_weights(pairs.len(), weights);
    let target = Centered::new(pairs.target(), &weights);
    let source = Centered::new(pairs.source(), &weights);
    let mut covariance = Matrix3::zeros();
    for ((weight, x), y) in weights.iter().zip(&target.offsets).zip(&source.offsets) {
        covariance += x * y.transpose() * *weight;
    }
    let svd = SignedSvd3::new(&covariance);
    let rank = svd.rank(8.0 * f64::EPSILON * (1.0 + target.distance + source.distance));
    if rank < 2 {
        return Err(Degenerate { rank });
    }
    let rotation = svd.nearest_rotation();
    let translation = target.centroid - rotation * source.centroid;
    Ok(isometry(&rotation, &translation))
}

fn usable_weights(len: usize, weights: Option<&[f64]>) -> Vec<f64> {
    let weights = weights.map_or_else(|| vec![1.0; len], <[f64]>::to_vec);
    assert_eq!(weights.len(), len, "one weight per point pair");
    let largest = weights.iter().copied().fold(0.0, f64::max);
    if largest == 0.0 {
        return vec![1.0 / len as f64; len];
    }
    let sum: f64 = weights.iter().map(|w| w / largest).sum();
    weights.iter().map(|w| w / largest / sum).collect()
}

/// Points relative to their weighted mean, and to their size: no square of them can overflow or
/// vanish.
struct Centered {
    centroid: Vector3<f64>,
    /// Offsets from the centroid in units of the largest coordinate among them.
    offsets: Vec<Vector3<f64>>,
    /// Distance of the centroid from the origin in extents of the set: what the offsets lose in
    /// digits, and so how far a line of points may look like a plane.
    distance: f64,
}

impl Centered {
    fn new(points: &[Point3<f64>], weights: &[f64]) -> Self {
        let weighted = points.iter().zip(weights);
        let centroid: Vector3<f64> = weighted.map(|(p, w)| p.coords * *w).sum();
        let mut offsets: Vec<_> = points.iter().map(|p| p.coords - centroid).collect();
        let size = offsets.iter().map(|x| x.amax()).fold(0.0, f64::max);
        if size > 0.0 {
            offsets.iter_mut().for_each(|x| *x /= size);
        }
        let squares = offsets.iter().zip(weights);
        let extent = squares
            .map(|(x, w)| w * x.norm_squared())
            .sum::<f64>()
            .sqrt();
        let distance = (centroid / size).norm() / extent;
        Self {
            centroid,
            offsets,
            distance: if distance.is_finite() { distance } else { 0.0 },
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;
    use proptest::prelude::*;

    use super::*;

    fn transformation() -> impl Strategy<Value = Isometry3<f64>> {
        let vector = || prop::array::uniform3(-3.0..3.0f64).prop_map(Vector3::from);
        (vector(), vector()).prop_map(|(t, r)| Isometry3::new(t, r))
    }

    fn points(range: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Point3<f64>>> {
        let point = prop::array::uniform3(-2.0..2.0f64).prop_map(Point3::from);
        prop::collection::vec(point, range)
    }

    fn moved(source: Vec<Point3<f64>>, transformation: &Isometry3<f64>) -> PointPairs {
        let target = source.iter().map(|p| transformation * p).collect();
        PointPairs::new(target, source).unwrap()
    }

    fn cost(pairs: &PointPairs, weights: &[f64], transformation: &Isometry3<f64>) -> f64 {
        let squares = pairs.residuals(transformation).zip(weights);
        squares.map(|(r, w)| w * r * r).sum()
    }

    fn difference(a: &Isometry3<f64>, b: &Isometry3<f64>) -> f64 {
        (a.to_matrix() - b.to_matrix()).norm()
    }

    proptest! {
        #[test]
        fn recovers_the_transformation_of_noise_free_points(source in points(4..12), transformation in transformation()) {
            let found = kabsch(&moved(source, &transformation), None).unwrap();
            prop_assert!(difference(&found, &transformation) < 1e-11);
        }

        #[test]
        fn recovers_the_transformation_of_planar_points(source in points(6..12), transformation in transformation()) {
            let flat = source.iter().map(|p| Point3::new(p.x, p.y, 0.0)).collect();
            let found = kabsch(&moved(flat, &transformation), None).unwrap();
            prop_assert!(difference(&found, &transformation) < 1e-11);
        }

        #[test]
        fn swapping_target_and_source_inverts_the_transformation(target in points(8..9), source in points(8..9)) {
            let pairs = PointPairs::new(target, source).unwrap();
            let forward = kabsch(&pairs, None).unwrap();
            let backward = kabsch(&pairs.swapped(), None).unwrap();
            // Random sets are far from rigid: the optimum may be flat, its value is not.
            let ones = [1.0; 8];
            prop_assert!((cost(&pairs, &ones, &forward) - cost(&pairs, &ones, &backward.inverse())).abs() < 1e-9);
        }

        #[test]
        fn no_transformation_nearby_costs_less(
            target in points(6..7), source in points(6..7),
            weights in prop::array::uniform6(0.01..1.0f64), step in transformation(),
        ) {
            let pairs = PointPairs::new(target, source).unwrap();
            let best = kabsch(&pairs, Some(&weights)).unwrap();
            for size in [1.0, 1e-2] {
                let small = Isometry3::new(step.translation.vector * size, step.rotation.scaled_axis() * size);
                prop_assert!(cost(&pairs, &weights, &best) <= cost(&pairs, &weights, &(best * small)) + 1e-12);
            }
        }

        #[test]
        fn weights_act_as_repetitions(target in points(5..6), source in points(5..6)) {
            let pairs = PointPairs::new(target, source).unwrap();
            let weighted = kabsch(&pairs, Some(&[1.0, 2.0, 0.0, 3.0, 1.0])).unwrap();
            let repeated = kabsch(&pairs.select(&[0, 1, 1, 3, 3, 3, 4]), None).unwrap();
            let ones = [1.0, 2.0, 0.0, 3.0, 1.0];
            prop_assert!((cost(&pairs, &ones, &weighted) - cost(&pairs, &ones, &repeated)).abs() < 1e-9);
        }
    }

    #[test]
    fn nearly_collinear_points_keep_their_digits() {
        let transformation =
            Isometry3::new(Vector3::new(0.3, 0.1, -2.0), Vector3::new(1.0, 2.0, -0.5));
        let source = (0..20)
            .map(|k| {
                Point3::new(
                    k as f64 * 0.1,
                    1e-4 * (k as f64).sin(),
                    1e-4 * (k as f64).cos(),
                )
            })
            .collect();
        let found = kabsch(&moved(source, &transformation), None).unwrap();
        assert!(difference(&found, &transformation) < 1e-10);
    }

    #[test]
    fn extreme_scales_of_points_and_weights_keep_the_digits() {
        let transformation = Isometry3::rotation(Vector3::new(0.4, -1.0, 0.3));
        for scale in [1e-160, 1e-100, 1e-9, 1e9, 1e99] {
            let source = (0..7).map(|k| k as f64);
            let source = source.map(|k| Point3::new(k.sin(), k.cos(), (2.0 * k).sin()) * scale);
            let pairs = moved(source.collect(), &transformation);
            for weight in [1e-300, 1.0, 1e308] {
                let found = kabsch(&pairs, Some(&[weight; 7])).unwrap();
                assert!(
                    found.rotation.angle_to(&transformation.rotation) < 1e-13,
                    "{scale}, {weight}"
                );
                assert!(
                    found.translation.vector.norm() < 1e-13 * scale,
                    "{scale}, {weight}"
                );
            }
        }
    }

    #[test]
    fn a_mirrored_set_still_gives_a_rotation() {
        let source = vec![
            Point3::origin(),
            Point3::new(1.0, 0.0, 0.0),
            Point3::new(0.0, 2.0, 0.0),
            Point3::new(0.0, 0.0, 3.0),
        ];
        let target = source.iter().map(|p| Point3::new(-p.x, p.y, p.z)).collect();
        let found = kabsch(&PointPairs::new(target, source).unwrap(), None).unwrap();
        let rotation: Rotation3<f64> = found.rotation.to_rotation_matrix();
        assert!((rotation.matrix().determinant() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn degenerate_sets_are_rejected_wherever_they_lie() {
        let transformation =
            Isometry3::new(Vector3::new(5.0, 6.0, 7.0), Vector3::new(1.0, 2.0, -0.5));
        for offset in [0.0, 10.0, 1e4, 1e7] {
            let place = |x: f64| Point3::new(offset + x / 3.0, offset - x / 7.0, offset + x / 11.0);
            for n in 0..4 {
                let line: Vec<_> = (0..n).map(|k| place(k as f64)).collect();
                assert!(
                    kabsch(&moved(line, &transformation), None).is_err(),
                    "{n} points on a line"
                );
            }
            let equal = vec![place(0.0); 9];
            assert!(
                kabsch(&moved(equal, &transformation), None).is_err(),
                "nine equal points"
            );
            let two = [place(0.0), place(1.0)].repeat(5);
            assert!(
                kabsch(&moved(two, &transformation), None).is_err(),
                "two distinct points"
            );
        }
    }

    #[test]
    fn weights_that_are_all_zero_weigh_all_alike() {
        let transformation = Isometry3::new(Vector3::x(), Vector3::z());
        let source = vec![
            Point3::origin(),
            Point3::new(1.0, 0.0, 0.0),
            Point3::new(0.0, 2.0, 1.0),
        ];
        let pairs = moved(source, &transformation);
        let found = kabsch(&pairs, Some(&[0.0; 3])).unwrap();
        assert!(difference(&found, &transformation) < 1e-14);
    }
}
