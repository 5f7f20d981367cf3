//! What holds the scans of a frame together, and how firmly.

use gmpcr::Registration;
use gmpcr::posegraph::Components;

/// Positions of the edges of the spanning forest of largest final weight, weakest first: where the
/// result would fall apart first.
pub fn weakest_links(registration: &Registration) -> Vec<usize> {
    let evidence = &registration.evidence;
    let mut edges: Vec<usize> = (0..evidence.len()).collect();
    edges.sort_by(|&a, &b| {
        evidence[b]
            .final_weight
            .total_cmp(&evidence[a].final_weight)
    });
    let mut set = DisjointSets::new(registration.world_from_scan.len());
    edges.retain(|&k| evidence[k].final_weight > 0.0 && set.join(evidence[k].i, evidence[k].j));
    edges.reverse();
    edges
}

/// Positions of the edges that alone join what they join, if only edges that kept a tenth of their
/// weight count.
pub fn bridges(registration: &Registration) -> Vec<usize> {
    let trusted = trusted_edges(registration);
    let num_scans = registration.world_from_scan.len();
    let ends = |k: usize| (registration.evidence[k].i, registration.evidence[k].j);
    let all = Components::new(num_scans, trusted.iter().map(|&k| ends(k)));
    let is_bridge = |&edge: &usize| {
        let others = trusted.iter().filter(|&&k| k != edge).map(|&k| ends(k));
        Components::new(num_scans, others).members().len() > all.members().len()
    };
    // Only edges of a spanning forest can be bridges.
    let mut forest = weakest_links(registration);
    forest.retain(|edge| trusted.contains(edge) && is_bridge(edge));
    forest
}

/// The parts into which a component falls if only edges that kept a tenth of their weight count.
pub fn trusted_parts(registration: &Registration, component: &[usize]) -> Vec<Vec<usize>> {
    let evidence = &registration.evidence;
    let trusted = trusted_edges(registration).into_iter();
    let ends = trusted.map(|k| (evidence[k].i, evidence[k].j));
    let parts = Components::new(registration.world_from_scan.len(), ends);
    let inside = |part: &&Vec<usize>| component.binary_search(&part[0]).is_ok();
    parts.members().iter().filter(inside).cloned().collect()
}

fn trusted_edges(registration: &Registration) -> Vec<usize> {
    let evidence = registration.evidence.iter().enumerate();
    let trusted = evidence.filter(|(_, e)| e.final_weight >= 0.1 * e.initial_weight);
    trusted
        .filter(|(_, e)| e.final_weight > 0.0)
        .map(|(k, _)| k)
        .collect()
}

struct DisjointSets(Vec<usize>);

impl DisjointSets {
    fn new(len: usize) -> Self {
        Self((0..len).collect())
    }

    fn root(&mut self, mut node: usize) -> usize {
        while self.0[node] != node {
            self.0[node] = self.0[self.0[node]];
            node = self.0[node];
        }
        node
    }

    /// Joins two sets; `false` if they were one.
    fn join(&mut self, a: usize, b: usize) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a] = b;
        a != b
    }
}
