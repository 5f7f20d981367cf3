//! How well the chosen pairs connect the scans, over many scenes.

use gmpcr_posegraph::Connectivity;

use crate::pooling::mean;

/// The worst and the average of the scenes' connectivities: a row of the paper's connectivity
/// table (section "Pose Graph Connectivity Analysis"). Ratios lie between 0 and 1.
///
/// ```
/// use gmpcr_eval::ConnectivitySummary;
/// use gmpcr_posegraph::Connectivity;
///
/// let scenes = [
///     Connectivity::new(3, &[(0, 1), (1, 2)], 0),
///     Connectivity::new(4, &[(0, 1), (1, 2), (0, 2)], 3),
/// ];
/// let summary = ConnectivitySummary::of(&scenes);
/// assert!(summary.is_some_and(|row| (row.num_connected, row.num_scenes) == (1, 2)));
/// assert!(summary.is_some_and(|row| row.min_reachability == 0.25 && row.mean_num_edges == 2.5));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct ConnectivitySummary {
    /// Number of scenes with all scans in one component, `Conn.`
    pub num_connected: usize,
    /// Number of scenes.
    pub num_scenes: usize,
    /// Largest number of components of a scene, `C_max`.
    pub max_components: usize,
    /// Smallest fraction of a scene's scans in its largest component, `LCC_min`.
    pub min_largest_component_ratio: f64,
    /// Smallest fraction of a scene's scans that its reference scan reaches, `R_min`.
    pub min_reachability: f64,
    /// Mean number of edges, `M̄`, each scene weighing the same.
    pub mean_num_edges: f64,
}

impl ConnectivitySummary {
    /// Summary of the scenes' connectivities; `None` where there are no scenes. `O(scenes)`.
    #[must_use]
    pub fn of(scenes: &[Connectivity]) -> Option<Self> {
        let least =
            |ratio: fn(&Connectivity) -> f64| scenes.iter().map(ratio).min_by(f64::total_cmp);
        Some(Self {
            num_connected: scenes.iter().filter(|scene| scene.is_connected).count(),
            num_scenes: scenes.len(),
            max_components: scenes.iter().map(|scene| scene.num_components).max()?,
            min_largest_component_ratio: least(|scene| scene.largest_component_ratio)?,
            min_reachability: least(|scene| scene.reachability)?,
            mean_num_edges: mean(scenes.iter().map(|scene| scene.num_edges as f64))?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_figure_comes_from_its_own_worst_scene() {
        let scenes = [
            // Five components, but the reference is in the largest one.
            Connectivity::new(8, &[(0, 1), (1, 2), (2, 3)], 0),
            // Two components, the reference in the smaller one.
            Connectivity::new(
                10,
                &[
                    (0, 1),
                    (2, 3),
                    (3, 4),
                    (4, 5),
                    (5, 6),
                    (6, 7),
                    (7, 8),
                    (8, 9),
                ],
                0,
            ),
            Connectivity::new(2, &[(0, 1)], 1),
        ];
        let expected = ConnectivitySummary {
            num_connected: 1,
            num_scenes: 3,
            max_components: 5,
            min_largest_component_ratio: 0.5,
            min_reachability: 0.2,
            mean_num_edges: 4.0,
        };
        assert_eq!(ConnectivitySummary::of(&scenes), Some(expected));
    }

    #[test]
    fn one_scene_is_its_own_summary_and_no_scenes_have_none() {
        let scene = Connectivity::new(5, &[(0, 1), (3, 4)], 2);
        let summary = ConnectivitySummary::of(&[scene]).unwrap();
        assert_eq!((summary.num_connected, summary.num_scenes), (0, 1));
        assert_eq!(summary.max_components, scene.num_components);
        assert_eq!(
            summary.min_largest_component_ratio,
            scene.largest_component_ratio
        );
        assert_eq!(summary.min_reachability, scene.reachability);
        assert_eq!(summary.mean_num_edges, 2.0);
        assert_eq!(ConnectivitySummary::of(&[]), None);
    }
}
