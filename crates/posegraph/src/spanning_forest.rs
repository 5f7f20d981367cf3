use crate::disjoint_sets::DisjointSets;

/// Positions of the edges of a spanning forest of maximal weight, lightest first (Kruskal 1956).
///
/// The forest connects what the edges of positive weight connect; other edges are left out. Along it
/// the lightest edge between two nodes is as heavy as on any path between them. So its first edges are
/// the weakest connections of the graph.
///
/// `edges` holds `(i, j, weight)`. Of edges of equal weight the forest prefers the earlier ones, and
/// names them last. `O(M log M)` for `M` edges.
///
/// # Panics
/// If an edge of positive weight names a node outside `0..num_nodes`.
///
/// ```
/// use gmpcr_posegraph::maximum_spanning_forest;
///
/// let edges = [(0, 1, 0.9), (1, 2, 0.2), (2, 0, 0.3), (3, 2, 0.0)];
/// assert_eq!(maximum_spanning_forest(4, edges), [2, 0]);
/// ```
pub fn maximum_spanning_forest(
    num_nodes: usize,
    edges: impl IntoIterator<Item = (usize, usize, f64)>,
) -> Vec<usize> {
    let mut edges: Vec<_> = edges.into_iter().enumerate().collect();
    edges.retain(|(_, (_, _, weight))| *weight > 0.0);
    edges.sort_by(|(_, (.., a)), (_, (.., b))| b.total_cmp(a));
    let mut sets = DisjointSets::new(num_nodes);
    edges.retain(|&(_, (i, j, _))| sets.join(i, j));
    edges.iter().rev().map(|&(position, _)| position).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::components::Components;

    proptest! {
        #[test]
        fn every_threshold_leaves_the_components_of_the_graph(
            n in 1..12usize,
            edges in prop::collection::vec((0..12usize, 0..12usize, 0..5u8), 0..30),
        ) {
            let edges: Vec<_> = edges
                .into_iter()
                .map(|(i, j, weight)| (i % n, j % n, f64::from(weight)))
                .collect();
            let forest = maximum_spanning_forest(n, edges.iter().copied());
            let weights: Vec<f64> = forest.iter().map(|&k| edges[k].2).collect();
            prop_assert!(weights.is_sorted());
            for threshold in 0..5 {
                let kept = |&(_, _, weight): &(usize, usize, f64)| weight > f64::from(threshold);
                let components = |edges: Vec<(usize, usize, f64)>| {
                    let kept = edges.into_iter().filter(kept);
                    Components::new(n, kept.map(|(i, j, _)| (i, j)))
                };
                let in_forest = components(forest.iter().map(|&k| edges[k]).collect());
                prop_assert_eq!(&in_forest, &components(edges.clone()));
                let num_kept = weights.iter().filter(|&&w| w > f64::from(threshold)).count();
                prop_assert_eq!(num_kept, n - in_forest.members().len());
            }
        }
    }

    #[test]
    fn equal_edges_come_in_reverse_order() {
        let edges = [(0, 1, 1.0), (1, 2, 1.0), (0, 2, 1.0), (2, 3, 1.0)];
        assert_eq!(maximum_spanning_forest(4, edges), [3, 1, 0]);
    }

    #[test]
    fn loops_and_edges_without_weight_are_left_out() {
        let edges = [(0, 0, 5.0), (0, 1, 0.0), (0, 1, f64::NAN), (0, 1, -1.0)];
        assert!(maximum_spanning_forest(2, edges).is_empty());
        assert!(maximum_spanning_forest(0, []).is_empty());
    }
}
