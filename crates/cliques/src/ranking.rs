use nalgebra::DMatrix;

use crate::{BitGraph, CliqueParams, Enumeration, for_each_maximal_clique};

/// The smallest set that determines a rigid transformation.
const MIN_CLIQUE_SIZE: usize = 3;

/// A maximal clique and what ranks it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct RankedClique {
    /// Its nodes, ascending.
    pub nodes: Vec<usize>,
    /// Mean SCG affinity `q` of its pairs.
    pub mean_affinity: f64,
}

/// The best maximal cliques of a graph.
pub(crate) struct RankedCliques {
    /// At most `K_c` cliques in descending order of mean affinity; equal ones: lexicographically
    /// smaller nodes first.
    pub(crate) best: Vec<RankedClique>,
    /// How many were seen, and whether all were.
    pub(crate) enumeration: Enumeration,
}

/// Enumerates the maximal cliques with at least three nodes and keeps the top `K_c` by mean
/// internal affinity,
///
/// ```text
/// q(M) = Σ_{m≠n ∈ M} b_mn / (|M| (|M| − 1))
/// ```
///
/// The mean, unlike the sum, lets a small consistent set compete with a large loose one, which
/// counts at low overlap. At no time are more than `K_c` cliques held.
///
/// # Panics
/// If `graph` and `scg` differ in size.
pub(crate) fn rank_cliques(
    graph: &BitGraph,
    scg: &DMatrix<f64>,
    params: &CliqueParams,
) -> RankedCliques {
    assert_eq!(
        scg.shape(),
        (graph.len(), graph.len()),
        "one affinity per pair of nodes"
    );
    let mut best: Vec<RankedClique> = Vec::new();
    let enumeration =
        for_each_maximal_clique(graph, MIN_CLIQUE_SIZE, params.work_budget, |clique| {
            let mut nodes = clique.to_vec();
            nodes.sort_unstable();
            let mean_affinity = mean_affinity(&nodes, scg);
            let clique = RankedClique {
                nodes,
                mean_affinity,
            };
            let rank = best.partition_point(|other| is_ahead(other, &clique));
            if rank < params.max_cliques {
                best.insert(rank, clique);
                best.truncate(params.max_cliques);
            }
        });
    RankedCliques { best, enumeration }
}

fn is_ahead(a: &RankedClique, b: &RankedClique) -> bool {
    let by_affinity = b.mean_affinity.total_cmp(&a.mean_affinity);
    by_affinity.then_with(|| a.nodes.cmp(&b.nodes)).is_lt()
}

fn mean_affinity(nodes: &[usize], scg: &DMatrix<f64>) -> f64 {
    let size = scg.nrows();
    let mut sum = 0.0;
    for (k, &m) in nodes.iter().enumerate() {
        let column = &scg.as_slice()[m * size..(m + 1) * size];
        sum += nodes[..k].iter().map(|&n| column[n]).sum::<f64>();
    }
    2.0 * sum / (nodes.len() * (nodes.len() - 1)) as f64
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn affinities() -> impl Strategy<Value = DMatrix<f64>> {
        let entry = prop_oneof![Just(0.0), Just(0.5), 0.0..1.0f64];
        (3..12usize).prop_flat_map(move |n| {
            prop::collection::vec(entry.clone(), n * n).prop_map(move |entries| {
                let mut matrix = DMatrix::from_vec(n, n, entries);
                matrix.fill_diagonal(0.0);
                matrix.fill_upper_triangle_with_lower_triangle();
                matrix
            })
        })
    }

    proptest! {
        #[test]
        fn the_best_are_the_best_of_all(scg in affinities(), max_cliques in 1..6usize) {
            let graph = BitGraph::from_edges(scg.nrows(), |i, j| scg[(i, j)] > 0.0);
            let params = |max_cliques| CliqueParams { max_cliques, ..Default::default() };
            let all = rank_cliques(&graph, &scg, &params(usize::MAX / 2));
            let best = rank_cliques(&graph, &scg, &params(max_cliques));
            prop_assert_eq!(all.best.len(), all.enumeration.cliques);
            prop_assert!(all.best.windows(2).all(|w| w[0].mean_affinity >= w[1].mean_affinity));
            prop_assert_eq!(&best.best[..], &all.best[..max_cliques.min(all.best.len())]);
        }
    }

    #[test]
    fn equal_cliques_are_ordered_by_their_nodes() {
        let two = DMatrix::from_fn(
            6,
            6,
            |i, j| if i != j && i / 3 == j / 3 { 1.0 } else { 0.0 },
        );
        let graph = BitGraph::from_edges(6, |i, j| two[(i, j)] > 0.0);
        let ranked = rank_cliques(&graph, &two, &CliqueParams::default());
        let nodes: Vec<_> = ranked.best.iter().map(|c| c.nodes.clone()).collect();
        assert_eq!(nodes, [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(ranked.best[0].mean_affinity, 1.0);
    }
}
