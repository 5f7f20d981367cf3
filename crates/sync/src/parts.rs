use gmpcr_posegraph::{Components, PoseEdge, PoseGraph};

use crate::subgraph::{Measurement, Subgraph};

/// One component of a pose graph.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub graph: Subgraph,
    /// One per measurement.
    pub initial_weights: Vec<f64>,
}

/// The components of a pose graph, and where its scans and edges are in them.
pub(crate) struct Parts {
    /// In the order of the components.
    pub all: Vec<Part>,
    /// The node of each scan within its component.
    pub node_of_scan: Vec<usize>,
    /// The component of each edge, and its measurement there; `None` for edges between components,
    /// which carry no weight.
    pub place_of_edge: Vec<Option<(usize, usize)>>,
}

impl Parts {
    pub fn new(graph: &PoseGraph, components: &Components) -> Self {
        let mut sizes = vec![0; components.members().len()];
        let node_of_scan: Vec<_> = components
            .labels()
            .iter()
            .map(|&label| {
                sizes[label] += 1;
                sizes[label] - 1
            })
            .collect();
        let part = |num_nodes| Part {
            graph: Subgraph {
                num_nodes,
                measurements: Vec::new(),
            },
            initial_weights: Vec::new(),
        };
        let mut all: Vec<_> = sizes.into_iter().map(part).collect();
        let mut place = |edge: &PoseEdge| {
            let label = components.label(edge.i);
            if label != components.label(edge.j) {
                return None;
            }
            let [i, j] = [edge.i, edge.j].map(|scan| node_of_scan[scan]);
            let Part {
                graph,
                initial_weights,
            } = &mut all[label];
            graph.measurements.push(Measurement::new(edge, i, j));
            initial_weights.push(edge.weight);
            Some((label, initial_weights.len() - 1))
        };
        let place_of_edge = graph.edges().iter().map(&mut place).collect();
        Self {
            all,
            node_of_scan,
            place_of_edge,
        }
    }
}
