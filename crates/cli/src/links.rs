//! What holds the scans of a frame together, and how firmly.

use gmpcr::posegraph::Components;
use gmpcr::{EdgeEvidence, Registration};

/// The edges of a registration by their final weights.
pub struct Links<'a> {
    num_scans: usize,
    edges: &'a [EdgeEvidence],
    /// Positions of the edges that kept a tenth of their weight, ascending.
    trusted: Vec<usize>,
}

/// A trusted edge that alone joins two parts.
#[derive(Debug, PartialEq)]
pub struct Bridge {
    /// Its position.
    pub edge: usize,
    /// The smaller part.
    pub part: Vec<usize>,
}

impl<'a> Links<'a> {
    pub fn of(registration: &'a Registration) -> Self {
        Self::new(registration.world_from_scan.len(), &registration.evidence)
    }

    fn new(num_scans: usize, edges: &'a [EdgeEvidence]) -> Self {
        let is_trusted = |edge: &EdgeEvidence| {
            edge.final_weight > 0.0 && edge.final_weight >= 0.1 * edge.initial_weight
        };
        let trusted = (0..edges.len()).filter(|&k| is_trusted(&edges[k]));
        Self {
            num_scans,
            edges,
            trusted: trusted.collect(),
        }
    }

    /// Positions of the edges of the spanning forest of largest final weight, weakest first: where the
    /// result would fall apart first.
    pub fn weakest(&self) -> Vec<usize> {
        let weight = |k: usize| self.edges[k].final_weight;
        let mut positions: Vec<usize> = (0..self.edges.len()).collect();
        positions.retain(|&k| weight(k) > 0.0);
        positions.sort_by(|&a, &b| weight(b).total_cmp(&weight(a)));
        let mut labels: Vec<usize> = (0..self.num_scans).collect();
        positions.retain(|&k| {
            let (a, b) = (labels[self.edges[k].i], labels[self.edges[k].j]);
            if a == b {
                return false;
            }
            for label in labels.iter_mut().filter(|label| **label == b) {
                *label = a;
            }
            true
        });
        positions.reverse();
        positions
    }

    /// The bridges among the trusted edges, in the order of [`Self::weakest`].
    pub fn bridges(&self) -> Vec<Bridge> {
        // Only edges of a spanning forest can be bridges.
        let mut candidates = self.weakest();
        candidates.retain(|edge| self.trusted.binary_search(edge).is_ok());
        let bridge = |edge: usize| {
            let parts = self.parts_without(Some(edge));
            let EdgeEvidence { i, j, .. } = self.edges[edge];
            let [a, b] = [i, j].map(|scan| &parts.members()[parts.label(scan)]);
            let smaller = if a.len() < b.len() { a } else { b };
            (parts.label(i) != parts.label(j)).then(|| Bridge {
                edge,
                part: smaller.clone(),
            })
        };
        candidates.into_iter().filter_map(bridge).collect()
    }

    /// The parts into which the scans fall without distrusted edges.
    pub fn trusted_parts(&self) -> Components {
        self.parts_without(None)
    }

    /// The parts that trusted edges join, except for one.
    fn parts_without(&self, edge: Option<usize>) -> Components {
        let others = self.trusted.iter().filter(|&&k| Some(k) != edge);
        let ends = others.map(|&k| (self.edges[k].i, self.edges[k].j));
        Components::new(self.num_scans, ends)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edge(i: usize, j: usize, initial_weight: f64, final_weight: f64) -> EdgeEvidence {
        EdgeEvidence {
            i,
            j,
            num_correspondences: 100,
            confidence: 1.0,
            inlier_ratio: initial_weight,
            clique_size: 10,
            mean_affinity: 1.0,
            cliques_seen: 3,
            budget_exhausted: false,
            initial_weight,
            final_weight,
            rotation_residual: Some(0.0),
            translation_residual: Some(0.0),
        }
    }

    /// Triangles 0 1 2 and 3 4 5, joined by the edge 2 3; scan 6 by a distrusted edge.
    fn edges() -> Vec<EdgeEvidence> {
        vec![
            edge(0, 1, 0.9, 0.9),
            edge(0, 2, 0.8, 0.7),
            edge(1, 2, 0.8, 0.6),
            edge(2, 3, 0.3, 0.2),
            edge(3, 4, 0.9, 0.9),
            edge(3, 5, 0.9, 0.5),
            edge(4, 5, 0.9, 0.8),
            edge(5, 6, 0.9, 0.01),
        ]
    }

    #[test]
    fn the_weakest_links_are_those_of_the_heaviest_tree() {
        let edges = edges();
        assert_eq!(Links::new(7, &edges).weakest(), [7, 3, 1, 6, 4, 0]);
    }

    #[test]
    fn an_edge_between_triangles_is_a_bridge_and_their_own_are_none() {
        let edges = edges();
        let bridges = Links::new(7, &edges).bridges();
        let part = vec![3, 4, 5];
        assert_eq!(bridges, [Bridge { edge: 3, part }]);
    }

    #[test]
    fn distrusted_edges_join_nothing() {
        let edges = edges();
        let parts = Links::new(7, &edges).trusted_parts();
        assert_eq!(parts.members(), [vec![0, 1, 2, 3, 4, 5], vec![6]]);
    }

    #[test]
    fn no_edges_have_no_links() {
        let links = Links::new(3, &[]);
        assert!(links.weakest().is_empty() && links.bridges().is_empty());
        assert_eq!(links.trusted_parts().members(), [vec![0], vec![1], vec![2]]);
    }
}
