//! One number for many scenes.

use crate::outcome::Recall;

/// Mean of the scenes' recalls, each scene weighing the same, as 3DMatch tables report it.
/// Scenes where no pair counts are left out; `None` where that leaves none.
///
/// ```
/// use gmpcr_eval::{Recall, mean_recall, pooled_recall};
///
/// let scene = |registered, total| Recall { registered, total, pairs: vec![], unjudgeable: vec![] };
/// let scenes = [scene(1, 1), scene(1, 3), scene(0, 0)];
/// assert!(mean_recall(&scenes).is_some_and(|mean| (mean - 2.0 / 3.0).abs() < 1e-12));
/// assert_eq!(pooled_recall(&scenes), Some(0.5));
/// ```
#[must_use]
pub fn mean_recall(scenes: &[Recall]) -> Option<f64> {
    let shares: Vec<f64> = scenes.iter().filter_map(Recall::share).collect();
    (!shares.is_empty()).then(|| shares.iter().sum::<f64>() / shares.len() as f64)
}

/// Registered pairs of all scenes over counted pairs of all scenes, each pair weighing the same.
/// `None` where no pair counts.
#[must_use]
pub fn pooled_recall(scenes: &[Recall]) -> Option<f64> {
    let registered: usize = scenes.iter().map(|scene| scene.registered).sum();
    let total: usize = scenes.iter().map(|scene| scene.total).sum();
    (total > 0).then(|| registered as f64 / total as f64)
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
    }
}
