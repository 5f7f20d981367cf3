use gmpcr_geometry::{InvalidParameter, PointPairs};
use nalgebra::{DMatrix, DVector, Isometry3};

use crate::ranking::{RankedCliques, rank_cliques};
use crate::{BitGraph, CliqueParams, RankedClique, inlier_ratio, kabsch};

/// The refined compatibility structure of a correspondence set, as plain matrices.
#[derive(Clone, Copy, Debug)]
pub struct Compatibility<'a> {
    /// First-order affinities `Ã`, symmetric, in [0, 1].
    pub fcg: &'a DMatrix<f64>,
    /// Second-order affinities `B̃`, symmetric and nonnegative.
    pub scg: &'a DMatrix<f64>,
    /// Nonnegative dominant eigenvector `ṽ` of `B̃`: the weights of the correspondences.
    pub response: &'a DVector<f64>,
}

/// The rigid transformation between two scans and its support.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct RelativePose {
    /// The transformation from the source's (scan j's) frame into the target's (scan i's).
    #[cfg_attr(feature = "serde", serde(with = "gmpcr_geometry::matrix_rows"))]
    pub target_from_source: Isometry3<f64>,
    /// Fraction of the correspondences that the transformation explains.
    pub inlier_ratio: f64,
    /// The clique that generated it.
    pub clique: RankedClique,
}

/// The outcome of [`estimate_pose`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PoseEstimate {
    /// The best hypothesis; `None` where no clique of three determines a transformation.
    pub pose: Option<RelativePose>,
    /// Maximal cliques with at least three nodes that were seen.
    pub cliques_seen: usize,
    /// Whether the work budget ran out before all cliques were seen.
    pub budget_exhausted: bool,
}

/// Estimates the transformation between two scans from their correspondences and compatibility.
///
/// Nodes of the clique graph are the correspondences; an edge joins two of positive second-order
/// affinity whose first-order affinity exceeds `params.min_affinity`. Each of the top `K_c` maximal
/// cliques gives a transformation by [`kabsch`], weighted by the spectral response; degenerate cliques are
/// skipped. The transformation of highest [`inlier_ratio`] over *all* correspondences wins, on ties that of
/// the higher mean affinity.
///
/// # Errors
/// [`InvalidParameter`] if a parameter is out of range.
///
/// # Panics
/// If the sizes of `pairs` and `compatibility` differ.
///
/// ```
/// use gmpcr_cliques::{CliqueParams, Compatibility, estimate_pose};
/// use gmpcr_geometry::PointPairs;
/// use nalgebra::{DMatrix, DVector, Point3, Vector3};
///
/// let source = vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 2.0, 0.0)];
/// let target = source.iter().map(|p| p + Vector3::new(0.0, 0.0, 4.0)).collect();
/// let pairs = PointPairs::new(target, source)?;
/// let complete = DMatrix::from_fn(3, 3, |m, n| if m == n { 0.0 } else { 1.0 });
/// let response = DVector::repeat(3, 0.577);
/// let compatibility = Compatibility { fcg: &complete, scg: &complete, response: &response };
/// let estimate = estimate_pose(&pairs, compatibility, &CliqueParams::default())?;
/// let pose = estimate.pose.ok_or("no clique")?;
/// assert_eq!((estimate.cliques_seen, pose.inlier_ratio), (1, 1.0));
/// assert!((pose.target_from_source.translation.z - 4.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn estimate_pose(
    pairs: &PointPairs,
    compatibility: Compatibility,
    params: &CliqueParams,
) -> Result<PoseEstimate, InvalidParameter> {
    params.validate()?;
    let Compatibility { fcg, scg, response } = compatibility;
    assert_eq!(
        fcg.shape(),
        (pairs.len(), pairs.len()),
        "one affinity per two correspondences"
    );
    let graph = BitGraph::from_edges(pairs.len(), |m, n| {
        scg[(m, n)] > 0.0 && fcg[(m, n)] > params.min_affinity
    });
    let RankedCliques { best, enumeration } = rank_cliques(&graph, scg, params);
    Ok(PoseEstimate {
        pose: best_hypothesis(pairs, response, best, params.inlier_threshold),
        cliques_seen: enumeration.cliques,
        budget_exhausted: enumeration.budget_exhausted,
    })
}

/// The first hypothesis of highest inlier ratio; the cliques come in order of preference.
fn best_hypothesis(
    pairs: &PointPairs,
    response: &DVector<f64>,
    cliques: Vec<RankedClique>,
    inlier_threshold: f64,
) -> Option<RelativePose> {
    let mut best: Option<RelativePose> = None;
    for clique in cliques {
        let weights: Vec<f64> = clique.nodes.iter().map(|&m| response[m]).collect();
        let Ok(transformation) = kabsch(&pairs.select(&clique.nodes), Some(&weights)) else {
            continue;
        };
        let inlier_ratio = inlier_ratio(pairs, &transformation, inlier_threshold);
        if best
            .as_ref()
            .is_none_or(|best| inlier_ratio > best.inlier_ratio)
        {
            best = Some(RelativePose {
                target_from_source: transformation,
                inlier_ratio,
                clique,
            });
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Vector3};

    use super::*;

    /// `sizes[0]` pairs of one transformation and `sizes[1]` of another, each group mutually compatible.
    fn two_transformations(sizes: [usize; 2], affinity: [f64; 2]) -> (PointPairs, DMatrix<f64>) {
        let transformations = [
            Isometry3::new(Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 0.5, 0.0)),
            Isometry3::new(Vector3::new(0.0, 5.0, 0.0), Vector3::new(1.0, 0.0, 0.0)),
        ];
        let group = |k: usize| usize::from(k >= sizes[0]);
        let count = sizes[0] + sizes[1];
        let source: Vec<_> = (0..count)
            .map(|k| Point3::new((k as f64).sin(), (k as f64 * 1.7).cos(), k as f64 * 0.1))
            .collect();
        let target = (0..count)
            .map(|k| transformations[group(k)] * source[k])
            .collect();
        let scg = DMatrix::from_fn(count, count, |m, n| {
            if m != n && group(m) == group(n) {
                affinity[group(m)]
            } else {
                0.0
            }
        });
        (PointPairs::new(target, source).unwrap(), scg)
    }

    fn estimate(pairs: &PointPairs, scg: &DMatrix<f64>, params: &CliqueParams) -> PoseEstimate {
        let response = DVector::repeat(pairs.len(), 1.0);
        let compatibility = Compatibility {
            fcg: scg,
            scg,
            response: &response,
        };
        estimate_pose(pairs, compatibility, params).unwrap()
    }

    #[test]
    fn the_better_supported_transformation_wins_over_the_higher_affinity() {
        let (pairs, scg) = two_transformations([4, 7], [0.9, 0.5]);
        let found = estimate(&pairs, &scg, &CliqueParams::default());
        let pose = found.pose.unwrap();
        assert_eq!(pose.clique.nodes, (4..11).collect::<Vec<_>>());
        assert_eq!(pose.inlier_ratio, 7.0 / 11.0);
        assert_eq!((found.cliques_seen, found.budget_exhausted), (2, false));
    }

    #[test]
    fn equal_support_goes_to_the_higher_affinity() {
        let (pairs, scg) = two_transformations([5, 5], [0.5, 0.9]);
        let pose = estimate(&pairs, &scg, &CliqueParams::default())
            .pose
            .unwrap();
        assert_eq!(pose.clique.nodes, (5..10).collect::<Vec<_>>());
    }

    #[test]
    fn only_the_top_cliques_generate_hypotheses() {
        let (pairs, scg) = two_transformations([4, 7], [0.9, 0.5]);
        let params = CliqueParams {
            max_cliques: 1,
            ..Default::default()
        };
        let pose = estimate(&pairs, &scg, &params).pose.unwrap();
        assert_eq!(pose.clique.nodes, [0, 1, 2, 3]);
    }

    #[test]
    fn swapping_the_scans_inverts_the_transformation() {
        let (pairs, scg) = two_transformations([4, 7], [0.9, 0.5]);
        let forward = estimate(&pairs, &scg, &CliqueParams::default())
            .pose
            .unwrap();
        let backward = estimate(&pairs.swapped(), &scg, &CliqueParams::default())
            .pose
            .unwrap();
        let product = forward.target_from_source * backward.target_from_source;
        assert!((product.to_matrix() - nalgebra::Matrix4::identity()).norm() < 1e-13);
        assert_eq!(forward.clique, backward.clique);
    }

    #[test]
    fn a_threshold_on_first_order_affinities_leaves_out_edges() {
        let (pairs, scg) = two_transformations([4, 7], [0.9, 0.5]);
        let params = CliqueParams {
            min_affinity: 0.6,
            ..Default::default()
        };
        assert_eq!(estimate(&pairs, &scg, &params).cliques_seen, 1);
    }

    #[test]
    fn degenerate_cliques_are_skipped() {
        let line: Vec<_> = (0..5).map(|k| Point3::new(k as f64, 0.0, 0.0)).collect();
        let pairs = PointPairs::new(line.clone(), line).unwrap();
        let complete = DMatrix::from_fn(5, 5, |m, n| if m == n { 0.0 } else { 1.0 });
        let found = estimate(&pairs, &complete, &CliqueParams::default());
        assert_eq!((found.pose, found.cliques_seen), (None, 1));
    }

    #[test]
    fn an_exhausted_budget_is_reported_with_the_best_so_far() {
        let (pairs, scg) = two_transformations([4, 7], [0.9, 0.5]);
        let params = CliqueParams {
            work_budget: 5,
            ..Default::default()
        };
        let found = estimate(&pairs, &scg, &params);
        assert!(found.budget_exhausted && found.cliques_seen == 1 && found.pose.is_some());
    }

    #[test]
    fn no_correspondence_gives_no_pose() {
        let found = estimate(
            &PointPairs::default(),
            &DMatrix::zeros(0, 0),
            &CliqueParams::default(),
        );
        assert_eq!((found.pose, found.cliques_seen), (None, 0));
    }
}
