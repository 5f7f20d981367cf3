use crate::subgraph::Subgraph;

/// Calls `visit` with the measurements of each triangle: those between nodes `a` and `b`, `b` and `c`,
/// `a` and `c`, where `a < b < c`, whichever way each is directed. Parallel measurements make
/// triangles of their own; weights do not matter. In ascending order of `(a, b, c)`.
///
/// Costs `O(Σ deg² log deg)` over the nodes.
pub(crate) fn for_each_triangle(graph: &Subgraph, mut visit: impl FnMut([usize; 3])) {
    let above = neighbors_above(graph);
    for neighbors in &above {
        for &(b, ab) in neighbors {
            for &(c, bc) in &above[b] {
                let start = neighbors.partition_point(|&(node, _)| node < c);
                let closing = neighbors[start..].iter();
                for &(_, ac) in closing.take_while(|&&(node, _)| node == c) {
                    visit([ab, bc, ac]);
                }
            }
        }
    }
}

/// For each node the neighbors of higher number, ascending, and the measurement to each.
fn neighbors_above(graph: &Subgraph) -> Vec<Vec<(usize, usize)>> {
    let mut above = vec![Vec::new(); graph.num_nodes];
    for (position, m) in graph.measurements.iter().enumerate() {
        above[m.i.min(m.j)].push((m.i.max(m.j), position));
    }
    above
        .iter_mut()
        .for_each(|neighbors| neighbors.sort_unstable());
    above
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};

    use super::*;
    use crate::subgraph::Measurement;

    fn graph(num_nodes: usize, ends: &[(usize, usize)]) -> Subgraph {
        let measurement = |&(i, j): &(usize, usize)| Measurement {
            i,
            j,
            rotation: Rotation3::identity(),
            translation: Vector3::zeros(),
        };
        Subgraph {
            num_nodes,
            measurements: ends.iter().map(measurement).collect(),
        }
    }

    /// All triples of measurements that close, by their nodes.
    fn brute_force(ends: &[(usize, usize)]) -> Vec<[usize; 3]> {
        let sorted: Vec<_> = ends.iter().map(|&(i, j)| (i.min(j), i.max(j))).collect();
        let mut found = Vec::new();
        for (ab, &(a, b)) in sorted.iter().enumerate() {
            for (bc, &(b_again, c)) in sorted.iter().enumerate() {
                for (ac, &closing) in sorted.iter().enumerate() {
                    if b == b_again && closing == (a, c) {
                        found.push([ab, bc, ac]);
                    }
                }
            }
        }
        found
    }

    #[test]
    fn finds_the_triangles_of_all_triples() {
        for num_nodes in [2usize, 3, 5, 9, 14] {
            let pairs = (0..4 * num_nodes)
                .map(|k| (k * k % num_nodes, (k * 5 + k / num_nodes + 1) % num_nodes));
            let ends: Vec<_> = pairs.filter(|(i, j)| i != j).collect();
            let mut found = Vec::new();
            for_each_triangle(&graph(num_nodes, &ends), |triangle| found.push(triangle));
            found.sort_unstable();
            let mut expected = brute_force(&ends);
            expected.sort_unstable();
            assert_eq!(found, expected);
            assert_eq!(found.is_empty(), num_nodes < 3);
        }
    }

    #[test]
    fn parallel_measurements_count_individually() {
        let mut count = 0;
        let ends = [(2, 0), (0, 1), (1, 0), (1, 2), (0, 2)];
        for_each_triangle(&graph(3, &ends), |_| count += 1);
        assert_eq!(count, 4);
    }
}
