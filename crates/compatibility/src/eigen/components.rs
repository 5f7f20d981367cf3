use std::borrow::Cow;

use nalgebra::{DMatrix, DVector};

use super::products::inner_products;

/// A connected component of the graph of the positive entries.
pub(super) struct Component {
    /// Its nodes, ascending.
    pub nodes: Vec<usize>,
    /// Its largest row sum.
    pub bound: f64,
}

impl Component {
    /// Its rows and columns of the matrix, copied by runs of successive nodes unless it is the whole.
    pub fn of<'a>(&self, matrix: &'a DMatrix<f64>) -> Cow<'a, DMatrix<f64>> {
        let (size, all) = (self.nodes.len(), matrix.nrows());
        if size == all {
            return Cow::Borrowed(matrix);
        }
        let runs: Vec<_> = self.nodes.chunk_by(|a, b| a + 1 == *b).collect();
        let mut entries = Vec::with_capacity(size * size);
        for &node in &self.nodes {
            let column = &matrix.as_slice()[node * all..][..all];
            for run in &runs {
                entries.extend_from_slice(&column[run[0]..][..run.len()]);
            }
        }
        Cow::Owned(DMatrix::from_vec(size, size, entries))
    }
}

/// The components with a positive entry in descending order of their bounds; equal ones: lower index.
pub(super) fn connected_components(matrix: &DMatrix<f64>) -> Vec<Component> {
    let size = matrix.nrows();
    let row_sums = inner_products(matrix.as_slice(), &DVector::repeat(size, 1.0));
    let has_ties = |&node: &usize| row_sums[node] > 0.0;
    let mut unseen: Vec<usize> = (0..size).rev().filter(has_ties).collect();
    let mut components = Vec::new();
    while let Some(first) = unseen.pop() {
        let (mut nodes, mut next, mut bound) = (vec![first], 0, 0f64);
        while next < nodes.len() {
            let column = &matrix.as_slice()[nodes[next] * size..(nodes[next] + 1) * size];
            bound = bound.max(row_sums[nodes[next]]);
            unseen.retain(|&node| {
                let is_joined = column[node] > 0.0;
                if is_joined {
                    nodes.push(node);
                }
                !is_joined
            });
            next += 1;
        }
        nodes.sort_unstable();
        components.push(Component { nodes, bound });
    }
    components.sort_by(|a, b| b.bound.total_cmp(&a.bound).then(a.nodes.cmp(&b.nodes)));
    components
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_connected_and_ordered_by_their_bounds() {
        let edges = [(0, 4, 1.0), (1, 2, 3.0), (2, 5, 0.5)];
        let mut matrix = DMatrix::zeros(7, 7);
        for (m, n, weight) in edges {
            matrix[(m, n)] = weight;
            matrix[(n, m)] = weight;
        }
        let components: Vec<_> = connected_components(&matrix)
            .into_iter()
            .map(|p| (p.nodes, p.bound))
            .collect();
        assert_eq!(components, [(vec![1, 2, 5], 3.5), (vec![0, 4], 1.0)]);
    }
}
