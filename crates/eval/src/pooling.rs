//! One number for many scenes.

use crate::outcome::Recall;
use crate::retrieval::Retrieval;

/// Mean of the scenes' recalls, each scene weighing the same, as 3DMatch tables report it.
/// Scenes where no pair counts are left out; `None` where that leaves none.
///
/// ```
/// use gmpcr_eval::{Recall, mean_recall, pairwise_recall, pooled_recall};
/// # use gmpcr_eval::{GroundTruthPair, Protocol};
/// # use nalgebra::{Isometry3, Matrix6};
/// # let scene = |registered: usize, total: usize| {
/// #     let pair = |j| GroundTruthPair {
/// #         i: 0, j, i_from_j: Isometry3::identity(), information: Matrix6::identity(),
/// #     };
/// #     let pairs: Vec<_> = (1..=total).map(pair).collect();
/// #     let estimate = |_, j| (j <= registered).then(Isometry3::identity);
/// #     pairwise_recall(&pairs, total + 1, Protocol::ThreeDLoMatch, estimate)
/// # };
///
/// // Registered pairs and all pairs of each scene.
/// let scenes: [Recall; 3] = [scene(1, 1)?, scene(1, 3)?, scene(0, 0)?];
/// assert!(mean_recall(&scenes).is_some_and(|mean| (mean - 2.0 / 3.0).abs() < 1e-12));
/// assert_eq!(pooled_recall(&scenes), Some(0.5));
/// # Ok::<(), gmpcr_eval::Error>(())
/// ```
#[must_use]
pub fn mean_recall(scenes: &[Recall]) -> Option<f64> {
    mean(scenes.iter().filter_map(Recall::ratio))
}

/// Registered pairs of all scenes over counted pairs of all scenes, each pair weighing the same.
/// `None` where no pair counts.
#[must_use]
pub fn pooled_recall(scenes: &[Recall]) -> Option<f64> {
    let registered: usize = scenes.iter().map(|scene| scene.registered).sum();
    let total: usize = scenes.iter().map(|scene| scene.total).sum();
    (total > 0).then(|| registered as f64 / total as f64)
}

/// Mean R@K and mean Regret of the scenes, each scene weighing the same whatever its number of
/// scans, as in the paper's table (section "Pose Graph Construction Quality"). `None` where there
/// are no scenes; those that [`retrieval`](crate::retrieval) has nothing to say of are left out
/// by the caller.
///
/// ```
/// use gmpcr_eval::{mean_retrieval, retrieval};
///
/// // Of three scans, the two that overlap choose each other in the first scene, but not in the second.
/// let overlap = |i: usize, j: usize| if (i, j) == (0, 1) { 0.5 } else { 0.25 };
/// let scenes = [[0.9, 0.1], [0.1, 0.9]].map(|[near, far]| {
///     let confidence = move |i: usize, j: usize| if (i, j) == (0, 1) { near } else { far };
///     retrieval(3, 1, confidence, overlap)
/// });
/// let scenes: Vec<_> = scenes.into_iter().flatten().collect();
/// let mean = mean_retrieval(&scenes);
/// assert!(mean.is_some_and(|mean| mean.recall < 1.0 && mean.regret > 0.0));
/// ```
#[must_use]
pub fn mean_retrieval(scenes: &[Retrieval]) -> Option<Retrieval> {
    Some(Retrieval {
        recall: mean(scenes.iter().map(|scene| scene.recall))?,
        regret: mean(scenes.iter().map(|scene| scene.regret))?,
    })
}

/// Arithmetic mean; `None` of no values.
pub(crate) fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (count, sum) = values.fold((0_usize, 0.0), |(count, sum), value| {
        (count + 1, sum + value)
    });
    (count > 0).then(|| sum / count as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_scenes_have_no_recall() {
        assert_eq!(mean_recall(&[]), None);
        assert_eq!(pooled_recall(&[]), None);
        let empty = Recall::of(Vec::new());
        assert_eq!(mean_recall(std::slice::from_ref(&empty)), None);
        assert_eq!(pooled_recall(&[empty]), None);
        assert_eq!(mean_retrieval(&[]), None);
    }
}
