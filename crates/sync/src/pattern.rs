use crate::cholesky::SparseCholesky;
use crate::subgraph::Subgraph;

/// The lower triangle of a symmetric matrix with a block for each node but the first and for each pair of
/// them that a measurement joins: node 0 is fixed. Stored column by column with ascending rows, of the
/// diagonal blocks the lower half.
pub(crate) struct GroundedPattern {
    /// Unknowns of a node.
    size: usize,
    /// For each node but the first, its higher neighbors, ascending.
    above: Vec<Vec<usize>>,
    /// Where the scalar columns start.
    column_starts: Vec<usize>,
    rows: Vec<usize>,
}

impl GroundedPattern {
    pub fn new(graph: &Subgraph, size: usize) -> Self {
        let above = higher_neighbors(graph);
        let (mut column_starts, mut rows) = (vec![0], Vec::new());
        let block = |node: usize| size * (node - 1)..size * node;
        for (index, nodes) in above.iter().enumerate() {
            for row in block(index + 1) {
                rows.extend(row..size * (index + 1));
                rows.extend(nodes.iter().flat_map(|&node| block(node)));
                column_starts.push(rows.len());
            }
        }
        Self {
            size,
            above,
            column_starts,
            rows,
        }
    }

    pub fn num_values(&self) -> usize {
        self.rows.len()
    }

    /// Where the entries of a block's `k`-th column start, for nodes `row ≥ column > 0` that are equal or
    /// joined. Of a diagonal block that is the diagonal entry.
    pub fn start(&self, row: usize, column: usize, k: usize) -> usize {
        let start = self.column_starts[self.size * (column - 1) + k];
        if row == column {
            return start;
        }
        let place = self.above[column - 1].partition_point(|&other| other < row);
        start + self.size * (place + 1) - k
    }

    /// A decomposition that knows the pattern and no values. `None` where the factor would fill up.
    pub fn cholesky(&self) -> Option<SparseCholesky> {
        let size = self.size * self.above.len();
        SparseCholesky::new(size, self.column_starts.clone(), self.rows.clone())
    }
}

fn higher_neighbors(graph: &Subgraph) -> Vec<Vec<usize>> {
    let mut above = vec![Vec::new(); graph.num_nodes - 1];
    for m in &graph.measurements {
        let (low, high) = (m.i.min(m.j), m.i.max(m.j));
        if low > 0 {
            above[low - 1].push(high);
        }
    }
    for nodes in &mut above {
        nodes.sort_unstable();
        nodes.dedup();
    }
    above
}
