use crate::BitGraph;
use crate::graph::{count, insert, lowest, ones, remove};

/// What an enumeration of maximal cliques did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Enumeration {
    /// Maximal cliques visited.
    pub cliques: usize,
    /// Nodes added to a growing clique: the work done.
    pub steps: usize,
    /// Whether the work budget ran out, so that cliques may be missing.
    pub budget_exhausted: bool,
}

/// Visits the maximal cliques with at least `min_size` nodes.
///
/// Bron and Kerbosch (1973) with the pivot of Tomita, Tanaka and Takahashi (2006), over a
/// degeneracy order of the nodes (Eppstein, Löffler and Strash 2010). A clique comes as a list of
/// nodes in no particular order; the order of the visits is a function of the graph alone. No
/// clique is stored, and neither the call stack nor the memory grows with the number of cliques:
/// `O(n² / 8)` bytes. At worst there are `3^(n/3)` cliques; after `budget` steps the enumeration
/// stops and says so.
///
/// ```
/// use gmpcr_cliques::{BitGraph, for_each_maximal_clique};
///
/// let square_with_diagonal = BitGraph::from_edges(4, |i, j| (i, j) != (1, 3));
/// let mut cliques = Vec::new();
/// let done = for_each_maximal_clique(&square_with_diagonal, 3, 1000, |clique| {
///     let mut clique = clique.to_vec();
///     clique.sort_unstable();
///     cliques.push(clique);
/// });
/// cliques.sort();
/// assert_eq!(cliques, [[0, 1, 2], [0, 2, 3]]);
/// assert_eq!((done.cliques, done.budget_exhausted), (2, false));
/// ```
pub fn for_each_maximal_clique(
    graph: &BitGraph,
    min_size: usize,
    budget: usize,
    mut visit: impl FnMut(&[usize]),
) -> Enumeration {
    let mut search = Search::new(graph, min_size, budget);
    let mut earlier = vec![0; graph.words_per_row()];
    for node in graph.degeneracy_order() {
        search.grow_from(node, &earlier, &mut visit);
        insert(&mut earlier, node);
    }
    search.done
}

struct Search<'a> {
    graph: &'a BitGraph,
    min_size: usize,
    budget: usize,
    clique: Vec<usize>,
    /// One level per node of the growing clique; kept for reuse when the search backs up.
    levels: Vec<Level>,
    done: Enumeration,
}

/// The choices that remain once some nodes form the clique.
struct Level {
    /// Nodes that are adjacent to the whole clique and not tried yet (`P`).
    open: Vec<u64>,
    /// Nodes that are adjacent to the whole clique and already tried (`X`).
    tried: Vec<u64>,
    /// The open nodes to branch on: a maximal clique holds the pivot or one of these.
    branches: Vec<u64>,
}

impl<'a> Search<'a> {
    fn new(graph: &'a BitGraph, min_size: usize, budget: usize) -> Self {
        Self {
            graph,
            min_size,
            budget,
            clique: Vec::new(),
            levels: Vec::new(),
            done: Enumeration::default(),
        }
    }

    /// Visits the maximal cliques that hold `root` and no `earlier` node.
    fn grow_from(&mut self, root: usize, earlier: &[u64], visit: &mut impl FnMut(&[usize])) {
        let neighbors = self.graph.neighbors(root);
        let level = self.level_at(0);
        for (k, &word) in neighbors.iter().enumerate() {
            level.open[k] = word & !earlier[k];
            level.tried[k] = word & earlier[k];
        }
        self.clique.clear();
        if !self.enter(root, 0, visit) {
            return;
        }
        let mut depth = 0;
        loop {
            let Some(node) = lowest(&self.levels[depth].branches) else {
                self.clique.pop();
                if depth == 0 {
                    return;
                }
                depth -= 1;
                continue;
            };
            self.descend(node, depth);
            if self.enter(node, depth + 1, visit) {
                depth += 1;
            }
        }
    }

    /// Sets up the choices that remain after `node`, and marks it as tried.
    fn descend(&mut self, node: usize, depth: usize) {
        self.level_at(depth + 1);
        let neighbors = self.graph.neighbors(node);
        let (above, below) = self.levels.split_at_mut(depth + 1);
        let (level, next) = (&mut above[depth], &mut below[0]);
        for (k, &word) in neighbors.iter().enumerate() {
            next.open[k] = level.open[k] & word;
            next.tried[k] = level.tried[k] & word;
        }
        remove(&mut level.branches, node);
        remove(&mut level.open, node);
        insert(&mut level.tried, node);
    }

    /// Adds `node` to the clique, whose choices stand at `depth`. Returns whether to go on from
    /// there; otherwise the node is taken back.
    fn enter(&mut self, node: usize, depth: usize, visit: &mut impl FnMut(&[usize])) -> bool {
        if self.done.steps >= self.budget {
            self.done.budget_exhausted = true;
            self.levels
                .iter_mut()
                .for_each(|level| level.branches.fill(0));
            return false;
        }
        self.done.steps += 1;
        self.clique.push(node);
        let level = &mut self.levels[depth];
        let num_open = count(&level.open);
        let large_enough = self.clique.len() + num_open >= self.min_size;
        if large_enough && num_open > 0 {
            level.choose_branches(self.graph);
            return true;
        }
        if large_enough && count(&level.tried) == 0 {
            self.done.cliques += 1;
            visit(&self.clique);
        }
        self.clique.pop();
        false
    }

    fn level_at(&mut self, depth: usize) -> &mut Level {
        while self.levels.len() <= depth {
            let empty = || vec![0; self.graph.words_per_row()];
            self.levels.push(Level {
                open: empty(),
                tried: empty(),
                branches: empty(),
            });
        }
        &mut self.levels[depth]
    }
}

impl Level {
    /// Branches on the open nodes that the pivot is not adjacent to; the pivot is the open or tried
    /// node with the most open neighbors (ties: lower index, open first).
    fn choose_branches(&mut self, graph: &BitGraph) {
        let mut most = None;
        for node in ones(&self.open).chain(ones(&self.tried)) {
            let neighbors = graph.neighbors(node).iter().zip(&self.open);
            let covered: u32 = neighbors.map(|(a, b)| (a & b).count_ones()).sum();
            if most.is_none_or(|(best, _)| covered > best) {
                most = Some((covered, node));
            }
        }
        self.branches.copy_from_slice(&self.open);
        if let Some((_, pivot)) = most {
            for (branch, neighbor) in self.branches.iter_mut().zip(graph.neighbors(pivot)) {
                *branch &= !neighbor;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;

    fn cliques(graph: &BitGraph, min_size: usize) -> (BTreeSet<Vec<usize>>, Enumeration) {
        let mut cliques = BTreeSet::new();
        let done = for_each_maximal_clique(graph, min_size, usize::MAX, |clique| {
            let mut clique = clique.to_vec();
            clique.sort_unstable();
            assert!(cliques.insert(clique), "a clique came twice");
        });
        (cliques, done)
    }

    /// All subsets of nodes that are cliques and cannot be extended.
    fn plain_cliques(graph: &BitGraph, min_size: usize) -> BTreeSet<Vec<usize>> {
        let n = graph.len();
        let is_clique = |set: u32| {
            let members: Vec<usize> = (0..n).filter(|k| set >> k & 1 == 1).collect();
            let joined = |&i: &usize| members.iter().all(|&j| i == j || graph.has_edge(i, j));
            members.iter().all(joined)
        };
        (1..1u32 << n)
            .filter(|&set| is_clique(set))
            .filter(|&set| (0..n).all(|k| set >> k & 1 == 1 || !is_clique(set | 1 << k)))
            .map(|set| (0..n).filter(|k| set >> k & 1 == 1).collect::<Vec<_>>())
            .filter(|clique| clique.len() >= min_size)
            .collect()
    }

    fn graph() -> impl Strategy<Value = BitGraph> {
        (0..12usize, prop::collection::vec(any::<bool>(), 144))
            .prop_map(|(n, edges)| BitGraph::from_edges(n, |i, j| edges[i * 12 + j]))
    }

    proptest! {
        #[test]
        fn finds_exactly_the_maximal_cliques(graph in graph(), min_size in 1..5usize) {
            let (found, done) = cliques(&graph, min_size);
            prop_assert_eq!(&found, &plain_cliques(&graph, min_size));
            prop_assert_eq!((done.cliques, done.budget_exhausted), (found.len(), false));
        }

        #[test]
        fn a_smaller_budget_visits_a_prefix(graph in graph(), budget in 0..40usize) {
            let (mut all, mut some) = (Vec::new(), Vec::new());
            let full = for_each_maximal_clique(&graph, 1, usize::MAX, |c| all.push(c.to_vec()));
            let done = for_each_maximal_clique(&graph, 1, budget, |c| some.push(c.to_vec()));
            prop_assert!(all.starts_with(&some));
            prop_assert!(done.steps <= budget);
            prop_assert_eq!(done.budget_exhausted, full.steps > budget);
        }
    }

    /// Groups of three nodes, joined to all nodes of the other groups: `3^(n/3)` maximal cliques.
    fn moon_moser(groups: usize) -> BitGraph {
        BitGraph::from_edges(3 * groups, |i, j| i / 3 != j / 3)
    }

    #[test]
    fn a_moon_moser_graph_has_all_its_cliques() {
        let (found, _) = cliques(&moon_moser(5), 3);
        assert_eq!(found.len(), 3usize.pow(5));
        assert!(found.iter().all(|clique| clique.len() == 5));
    }

    #[test]
    fn the_budget_stops_an_explosion() {
        let done = for_each_maximal_clique(&moon_moser(40), 3, 10_000, |_| ());
        assert!(done.budget_exhausted && done.steps == 10_000 && done.cliques > 0);
    }

    #[test]
    fn graphs_wider_than_a_word_work() {
        let two_cliques = BitGraph::from_edges(150, |i, j| (i < 70) == (j < 70));
        let (found, _) = cliques(&two_cliques, 3);
        assert_eq!(found, [(0..70).collect(), (70..150).collect()].into());
    }
}
