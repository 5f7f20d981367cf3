use std::cmp::Ordering;
use std::ops::Range;

/// An edge whose removal disconnects its component.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Bridge {
    /// Its position among the edges.
    pub edge: usize,
    /// The nodes of the smaller of the two sides that it connects, ascending; of sides of equal size,
    /// that of the edge's second node.
    pub smaller_side: Vec<usize>,
}

/// The bridges of the graph with nodes `0..num_nodes` and undirected `edges`, by position.
///
/// Of parallel edges none is a bridge, nor is a loop. One depth-first search finds them all: the edge
/// from a node to its parent in the search is a bridge unless an edge leads from the node or its
/// descendants to an earlier node (Tarjan 1974). `O(N + M)` for `N` nodes and `M` edges, and
/// `O(S log S)` for the `S` nodes of all smaller sides together: up to `N² / 4` in a chain, few where
/// the graph has few bridges.
///
/// # Panics
/// If an edge names a node outside `0..num_nodes`.
///
/// ```
/// use gmpcr_posegraph::bridges;
///
/// // Two triangles, and an edge between them.
/// let edges = [(0, 1), (1, 2), (2, 0), (2, 3), (3, 4), (4, 5), (5, 3)];
/// let found = bridges(6, edges);
/// assert_eq!(found.len(), 1);
/// assert_eq!((found[0].edge, &found[0].smaller_side[..]), (3, &[3, 4, 5][..]));
/// ```
pub fn bridges(num_nodes: usize, edges: impl IntoIterator<Item = (usize, usize)>) -> Vec<Bridge> {
    let edges: Vec<_> = edges.into_iter().collect();
    let mut search = Search::new(num_nodes, &edges);
    (0..num_nodes).for_each(|root| search.visit_component(root));
    search.bridges.sort_unstable_by_key(|bridge| bridge.edge);
    search.bridges
}

/// A depth-first search. Nodes have ranks in the order of their visits, so that the descendants of a
/// node have the ranks that follow its own.
struct Search<'a> {
    edges: &'a [(usize, usize)],
    /// Neighbors of each node, and the position of the edge to each.
    neighbors: Vec<Vec<(usize, usize)>>,
    /// The rank of each visited node.
    rank: Vec<Option<usize>>,
    /// The visited nodes by rank.
    visited: Vec<usize>,
    bridges: Vec<Bridge>,
}

/// A node on the way from the root to where the search is.
struct Step {
    node: usize,
    /// The edge from the parent; `None` at the root.
    edge: Option<usize>,
    rank: usize,
    /// The lowest rank that an edge leads to from the node or its descendants.
    lowest_reached: usize,
    /// How many neighbors of the node have been looked at.
    num_followed: usize,
}

impl<'a> Search<'a> {
    fn new(num_nodes: usize, edges: &'a [(usize, usize)]) -> Self {
        let mut neighbors = vec![Vec::new(); num_nodes];
        for (position, &(i, j)) in edges.iter().enumerate() {
            neighbors[i].push((j, position));
            neighbors[j].push((i, position));
        }
        Self {
            edges,
            neighbors,
            rank: vec![None; num_nodes],
            visited: Vec::with_capacity(num_nodes),
            bridges: Vec::new(),
        }
    }

    /// Visits the nodes that can be reached from a node, unless they were visited before.
    fn visit_component(&mut self, root: usize) {
        if self.rank[root].is_some() {
            return;
        }
        let first_rank = self.visited.len();
        let mut descents = Vec::new();
        let mut path = vec![self.visit(root, None)];
        while let Some(step) = path.last_mut() {
            let Some(&(neighbor, edge)) = self.neighbors[step.node].get(step.num_followed) else {
                let Step {
                    edge,
                    rank,
                    lowest_reached,
                    ..
                } = *step;
                path.pop();
                if let Some(parent) = path.last_mut() {
                    parent.lowest_reached = parent.lowest_reached.min(lowest_reached);
                }
                if let Some(edge) = edge
                    && lowest_reached == rank
                {
                    descents.push((edge, rank..self.visited.len()));
                }
                continue;
            };
            step.num_followed += 1;
            match self.rank[neighbor] {
                _ if step.edge == Some(edge) => {}
                Some(rank) => step.lowest_reached = step.lowest_reached.min(rank),
                None => {
                    let next = self.visit(neighbor, Some(edge));
                    path.push(next);
                }
            }
        }
        let component = first_rank..self.visited.len();
        let bridges = descents
            .into_iter()
            .map(|(edge, below)| self.bridge(edge, below, component.clone()));
        let bridges: Vec<_> = bridges.collect();
        self.bridges.extend(bridges);
    }

    fn visit(&mut self, node: usize, edge: Option<usize>) -> Step {
        let rank = self.visited.len();
        self.rank[node] = Some(rank);
        self.visited.push(node);
        Step {
            node,
            edge,
            rank,
            lowest_reached: rank,
            num_followed: 0,
        }
    }

    /// The bridge to the nodes of the ranks `below` from the others of their component.
    fn bridge(&self, edge: usize, below: Range<usize>, component: Range<usize>) -> Bridge {
        let (_, second) = self.edges[edge];
        let second_is_below = self.rank[second].is_some_and(|rank| below.contains(&rank));
        let (num_below, num_above) = (below.len(), component.len() - below.len());
        let takes_below = match num_below.cmp(&num_above) {
            Ordering::Less => true,
            Ordering::Equal => second_is_below,
            Ordering::Greater => false,
        };
        let mut smaller_side = if takes_below {
            self.visited[below].to_vec()
        } else {
            let before = &self.visited[component.start..below.start];
            [before, &self.visited[below.end..component.end]].concat()
        };
        smaller_side.sort_unstable();
        Bridge { edge, smaller_side }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::components::Components;

    /// The edges without which there are more components, and the smaller of the two that come apart.
    fn by_definition(num_nodes: usize, edges: &[(usize, usize)]) -> Vec<Bridge> {
        let all = Components::new(num_nodes, edges.iter().copied());
        let bridge = |edge: usize| {
            let others = (0..edges.len()).filter(|&k| k != edge).map(|k| edges[k]);
            let without = Components::new(num_nodes, others);
            let (i, j) = edges[edge];
            let [a, b] = [i, j].map(|node| &without.members()[without.label(node)]);
            let smaller_side = if a.len() < b.len() { a } else { b }.clone();
            let comes_apart = without.members().len() > all.members().len();
            comes_apart.then_some(Bridge { edge, smaller_side })
        };
        (0..edges.len()).filter_map(bridge).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(1000))]

        #[test]
        fn the_search_finds_what_the_definition_says(
            n in 1..14usize, edges in prop::collection::vec((0..14usize, 0..14usize), 0..18)
        ) {
            let edges: Vec<_> = edges.into_iter().map(|(i, j)| (i % n, j % n)).collect();
            prop_assert_eq!(bridges(n, edges.iter().copied()), by_definition(n, &edges));
        }
    }

    #[test]
    fn of_equal_sides_the_one_of_the_second_node_is_given() {
        assert_eq!(bridges(2, [(0, 1)])[0].smaller_side, [1]);
        assert_eq!(bridges(2, [(1, 0)])[0].smaller_side, [0]);
    }

    #[test]
    fn parallel_edges_and_loops_are_no_bridges() {
        assert!(bridges(3, [(0, 1), (1, 0), (2, 2)]).is_empty());
        assert!(bridges(0, []).is_empty());
    }

    #[test]
    fn a_long_chain_needs_no_deep_recursion() {
        // A ring of two hundred thousand nodes with one more node.
        let n = 200_000;
        let edges = (0..n).map(|i| (i, (i + 1) % n)).chain([(n / 2, n)]);
        let found = bridges(n + 1, edges);
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].edge, found[0].smaller_side[0]), (n, n));
    }
}
