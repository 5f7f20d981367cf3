/// A partition of nodes into sets that are joined two at a time (union–find; Tarjan 1975).
///
/// An operation takes the inverse Ackermann function of the number of nodes, on average.
pub(crate) struct DisjointSets {
    /// A lower node of the same set; the lowest has itself.
    parent: Vec<usize>,
}

impl DisjointSets {
    /// Every node alone.
    pub fn new(num_nodes: usize) -> Self {
        Self {
            parent: (0..num_nodes).collect(),
        }
    }

    /// The lowest node of the set of `node`. Halves the path to it on the way.
    pub fn lowest(&mut self, mut node: usize) -> usize {
        while self.parent[node] != node {
            self.parent[node] = self.parent[self.parent[node]];
            node = self.parent[node];
        }
        node
    }

    /// Joins the sets of two nodes. Returns whether they were two.
    pub fn join(&mut self, i: usize, j: usize) -> bool {
        let (i, j) = (self.lowest(i), self.lowest(j));
        self.parent[i.max(j)] = i.min(j);
        i != j
    }
}
