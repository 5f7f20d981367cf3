use gmpcr_geometry::PointPairs;
use nalgebra::Isometry3;

/// The correspondences that a transformation explains, ascending:
/// `{m : ‖x_m^i − (R x_m^j + t)‖ < τ_in}`.
///
/// `inlier_threshold` is in the unit of the points. [`PointPairs::select`] gives their points.
///
/// ```
/// use gmpcr_cliques::inliers;
/// use gmpcr_geometry::PointPairs;
/// use nalgebra::{Isometry3, Point3};
///
/// let source = vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0)];
/// let target = vec![Point3::new(0.0, 0.0, 2.0), Point3::new(1.0, 5.0, 2.0), Point3::new(0.0, 1.0, 2.05)];
/// let pairs = PointPairs::new(target, source)?;
/// let target_from_source = Isometry3::translation(0.0, 0.0, 2.0);
/// assert_eq!(inliers(&pairs, &target_from_source, 0.1), [0, 2]);
/// # Ok::<(), gmpcr_geometry::PairsError>(())
/// ```
pub fn inliers(
    pairs: &PointPairs,
    target_from_source: &Isometry3<f64>,
    inlier_threshold: f64,
) -> Vec<usize> {
    let residuals = pairs.residuals(target_from_source).enumerate();
    let explained = residuals.filter(|&(_, residual)| residual < inlier_threshold);
    explained.map(|(index, _)| index).collect()
}

/// Fraction of the correspondences that a transformation explains,
/// `IR = |{m : ‖x_m^i − (R x_m^j + t)‖ < τ_in}| / M`; zero of an empty set.
///
/// It counts the [`inliers`].
///
/// ```
/// use gmpcr_cliques::inlier_ratio;
/// use gmpcr_geometry::PointPairs;
/// use nalgebra::{Isometry3, Point3};
///
/// let points = [0.0, 1.0, 2.0, 3.0].map(|x| Point3::new(x, 0.0, 0.0)).to_vec();
/// let mut target = points.clone();
/// target[3].y = 7.0;
/// let pairs = PointPairs::new(target, points)?;
/// assert_eq!(inlier_ratio(&pairs, &Isometry3::identity(), 0.1), 0.75);
/// # Ok::<(), gmpcr_geometry::PairsError>(())
/// ```
pub fn inlier_ratio(
    pairs: &PointPairs,
    target_from_source: &Isometry3<f64>,
    inlier_threshold: f64,
) -> f64 {
    let num_inliers = inliers(pairs, target_from_source, inlier_threshold).len();
    num_inliers as f64 / pairs.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;

    #[test]
    fn a_residual_of_the_threshold_is_no_inlier() {
        let source = vec![Point3::origin(); 3];
        let target = [0.0, 0.5, 1.0].map(|x| Point3::new(x, 0.0, 0.0));
        let pairs = PointPairs::new(target.to_vec(), source).unwrap();
        assert_eq!(inliers(&pairs, &Isometry3::identity(), 0.5), [0]);
        assert_eq!(
            inlier_ratio(&pairs, &Isometry3::identity(), 0.75),
            2.0 / 3.0
        );
    }

    #[test]
    fn no_correspondence_has_no_inlier() {
        let none = PointPairs::default();
        assert!(inliers(&none, &Isometry3::identity(), 1.0).is_empty());
        assert_eq!(inlier_ratio(&none, &Isometry3::identity(), 1.0), 0.0);
    }
}
