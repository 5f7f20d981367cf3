/// An undirected graph without loops, one bit per ordered pair of nodes.
///
/// ```
/// use gmpcr_cliques::BitGraph;
///
/// let triangle_and_tail = BitGraph::from_edges(4, |i, j| i + j != 3 || i == 0);
/// assert!(triangle_and_tail.has_edge(0, 3) && !triangle_and_tail.has_edge(1, 2));
/// assert_eq!(triangle_and_tail.num_edges(), 5);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BitGraph {
    size: usize,
    words_per_row: usize,
    rows: Vec<u64>,
}

impl BitGraph {
    /// Graph of `size` nodes with an edge `i < j` wherever `is_edge(i, j)`.
    pub fn from_edges(size: usize, is_edge: impl Fn(usize, usize) -> bool) -> Self {
        let words_per_row = size.div_ceil(64);
        let mut rows = vec![0; size * words_per_row];
        for (j, i) in (0..size).flat_map(|j| (0..j).map(move |i| (j, i))) {
            if is_edge(i, j) {
                rows[i * words_per_row + j / 64] |= 1 << (j % 64);
                rows[j * words_per_row + i / 64] |= 1 << (i % 64);
            }
        }
        Self {
            size,
            words_per_row,
            rows,
        }
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.size
    }

    /// Whether there is no node.
    pub fn is_empty(&self) -> bool {
        self.size == 0
    }

    /// Number of edges.
    pub fn num_edges(&self) -> usize {
        count(&self.rows) / 2
    }

    /// Whether nodes `i` and `j` are joined.
    ///
    /// # Panics
    /// If a node is [`len`](Self::len) or more.
    pub fn has_edge(&self, i: usize, j: usize) -> bool {
        assert!(
            i < self.size && j < self.size,
            "edge ({i}, {j}) outside 0..{}",
            self.size
        );
        contains(self.neighbors(i), j)
    }

    /// The neighbors of node `i` as a bit set.
    pub(crate) fn neighbors(&self, i: usize) -> &[u64] {
        &self.rows[i * self.words_per_row..(i + 1) * self.words_per_row]
    }

    pub(crate) fn words_per_row(&self) -> usize {
        self.words_per_row
    }

    /// Nodes in degeneracy order (Matula and Beck 1983): each has the fewest neighbors among the
    /// nodes from it on (ties: lower index).
    pub(crate) fn degeneracy_order(&self) -> Vec<usize> {
        let mut degree: Vec<usize> = (0..self.size).map(|i| count(self.neighbors(i))).collect();
        let mut remaining: Vec<usize> = (0..self.size).collect();
        let mut order = Vec::with_capacity(self.size);
        while let Some(node) = remaining.iter().copied().min_by_key(|&i| (degree[i], i)) {
            remaining.retain(|&i| i != node);
            order.push(node);
            for neighbor in ones(self.neighbors(node)) {
                degree[neighbor] -= 1;
            }
        }
        order
    }
}

pub(crate) fn count(bits: &[u64]) -> usize {
    bits.iter().map(|word| word.count_ones() as usize).sum()
}

pub(crate) fn contains(bits: &[u64], node: usize) -> bool {
    bits[node / 64] >> (node % 64) & 1 == 1
}

pub(crate) fn insert(bits: &mut [u64], node: usize) {
    bits[node / 64] |= 1 << (node % 64);
}

pub(crate) fn remove(bits: &mut [u64], node: usize) {
    bits[node / 64] &= !(1 << (node % 64));
}

/// The lowest node of a set.
pub(crate) fn lowest(bits: &[u64]) -> Option<usize> {
    let word = bits.iter().position(|&word| word != 0)?;
    Some(word * 64 + bits[word].trailing_zeros() as usize)
}

/// The nodes of a set, ascending.
pub(crate) fn ones(bits: &[u64]) -> impl Iterator<Item = usize> + '_ {
    bits.iter().enumerate().flat_map(|(k, &word)| {
        std::iter::successors(Some(word), |&rest| Some(rest & rest.wrapping_sub(1)))
            .take_while(|&rest| rest != 0)
            .map(move |rest| k * 64 + rest.trailing_zeros() as usize)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_of_bits_hold_nodes_across_words() {
        let nodes = [0, 1, 63, 64, 129];
        let mut bits = vec![0; 3];
        nodes.iter().for_each(|&node| insert(&mut bits, node));
        assert_eq!(ones(&bits).collect::<Vec<_>>(), nodes);
        assert_eq!((count(&bits), lowest(&bits)), (5, Some(0)));
        remove(&mut bits, 0);
        assert!(!contains(&bits, 0) && contains(&bits, 129));
        assert_eq!(lowest(&[0, 0]), None);
    }

    #[test]
    fn a_star_is_ordered_from_its_leaves() {
        let star = BitGraph::from_edges(5, |i, _| i == 0);
        assert_eq!(star.degeneracy_order(), [1, 2, 3, 0, 4]);
    }

    #[test]
    fn a_graph_without_nodes_is_empty() {
        let graph = BitGraph::from_edges(0, |_, _| true);
        assert!(graph.is_empty() && graph.degeneracy_order().is_empty());
    }
}
