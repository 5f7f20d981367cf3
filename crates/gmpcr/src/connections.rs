//! What connects the scans of a frame, and how firmly.

use gmpcr_posegraph::{Bridge, Components, bridges, maximum_spanning_forest};

use crate::{Edge, Registration};

impl Registration {
    /// Positions of the edges of the spanning forest of largest final weight, weakest first: where the
    /// graph would be disconnected first.
    pub fn weakest_edges(&self) -> Vec<usize> {
        let edges = self
            .edges
            .iter()
            .map(|edge| (edge.i, edge.j, edge.synchronization.final_weight));
        maximum_spanning_forest(self.ids.len(), edges)
    }

    /// The [trusted](Edge::is_trusted) edges that alone connect two parts of a component, weakest first, each
    /// with the smaller part: no other edge confirms where those scans are. `O(N + E)`.
    pub fn bridges(&self) -> Vec<Bridge> {
        let trusted = self.trusted_edges();
        let mut bridges = bridges(self.ids.len(), trusted.iter().map(|&k| self.ends(k)));
        for bridge in &mut bridges {
            bridge.edge = trusted[bridge.edge];
        }
        // A bridge belongs to every spanning forest.
        let mut rank = vec![usize::MAX; self.edges.len()];
        for (position, edge) in self.weakest_edges().into_iter().enumerate() {
            rank[edge] = position;
        }
        bridges.sort_by_key(|bridge| rank[bridge.edge]);
        bridges
    }

    /// The parts into which the scans fall if only [trusted](Edge::is_trusted) edges connect them.
    pub fn trusted_parts(&self) -> Components {
        let trusted = self.trusted_edges().into_iter();
        Components::new(self.ids.len(), trusted.map(|k| self.ends(k)))
    }

    fn trusted_edges(&self) -> Vec<usize> {
        let mut positions: Vec<usize> = (0..self.edges.len()).collect();
        positions.retain(|&k| self.edges[k].is_trusted());
        positions
    }

    /// The scans of an edge.
    pub(crate) fn ends(&self, edge: usize) -> (usize, usize) {
        let Edge { i, j, .. } = self.edges[edge];
        (i, j)
    }
}
