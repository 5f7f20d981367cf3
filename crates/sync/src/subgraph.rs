use gmpcr_posegraph::{Components, PoseEdge, PoseGraph};
use nalgebra::{Matrix3, Rotation3, Vector3};

/// A relative pose between nodes of a [`Subgraph`], in matrix form.
#[derive(Clone, Debug)]
pub(crate) struct Measurement {
    pub i: usize,
    pub j: usize,
    pub rotation: Rotation3<f64>,
    pub translation: Vector3<f64>,
}

impl Measurement {
    fn new(edge: &PoseEdge, i: usize, j: usize) -> Self {
        Self {
            i,
            j,
            rotation: edge.i_from_j.rotation.to_rotation_matrix(),
            translation: edge.i_from_j.translation.vector,
        }
    }

    pub fn matrix(&self) -> &Matrix3<f64> {
        self.rotation.matrix()
    }
}

/// A connected part of a pose graph, its nodes renumbered from zero.
#[derive(Clone, Debug)]
pub(crate) struct Subgraph {
    pub num_nodes: usize,
    pub measurements: Vec<Measurement>,
}

impl Subgraph {
    /// The whole graph as one part.
    pub fn whole(graph: &PoseGraph) -> Self {
        let edges = graph.edges().iter();
        Self {
            num_nodes: graph.num_scans(),
            measurements: edges
                .map(|edge| Measurement::new(edge, edge.i, edge.j))
                .collect(),
        }
    }

    /// The parts of `graph` in the order of its `components`, and which edges each holds. Edges
    /// between components, which carry no weight, belong to none.
    pub fn of_components(graph: &PoseGraph, components: &Components) -> Vec<(Self, Vec<usize>)> {
        let mut local = vec![0; graph.num_scans()];
        let members = components.members();
        for scans in members {
            for (node, &scan) in scans.iter().enumerate() {
                local[scan] = node;
            }
        }
        let part = |scans: &Vec<usize>| Self {
            num_nodes: scans.len(),
            measurements: Vec::new(),
        };
        let mut parts: Vec<_> = members
            .iter()
            .map(|scans| (part(scans), Vec::new()))
            .collect();
        for (position, edge) in graph.edges().iter().enumerate() {
            let label = components.label(edge.i);
            if label == components.label(edge.j) {
                let (part, positions) = &mut parts[label];
                part.measurements
                    .push(Measurement::new(edge, local[edge.i], local[edge.j]));
                positions.push(position);
            }
        }
        parts
    }

    /// Angles (radians) between measured and estimated relative rotations,
    /// `d_R(R_iᵀ R_j, R̂_ij)`, one per measurement.
    pub fn rotation_residuals(&self, world_from_node: &[Rotation3<f64>]) -> Vec<f64> {
        let residual = |m: &Measurement| {
            let i_from_j = world_from_node[m.i].inverse() * world_from_node[m.j];
            gmpcr_geometry::angular_distance(&i_from_j, &m.rotation)
        };
        self.measurements.iter().map(residual).collect()
    }

    /// Rotations along a spanning tree of maximal weight, node 0 being the identity. Exact where
    /// the measurements are; a start for iterations elsewhere. Nodes out of reach get the identity.
    pub fn spanning_tree_rotations(&self, weights: &[f64]) -> Vec<Rotation3<f64>> {
        let mut order: Vec<usize> = (0..self.measurements.len()).collect();
        order.sort_by(|&a, &b| weights[b].total_cmp(&weights[a]).then(a.cmp(&b)));
        let mut tree = vec![Vec::new(); self.num_nodes];
        let mut label: Vec<usize> = (0..self.num_nodes).collect();
        for position in order {
            let Measurement { i, j, .. } = self.measurements[position];
            let [root_i, root_j] = [i, j].map(|node| representative(&mut label, node));
            if root_i != root_j {
                label[root_i.max(root_j)] = root_i.min(root_j);
                tree[i].push(position);
                tree[j].push(position);
            }
        }
        self.rotations_along(&tree)
    }

    fn rotations_along(&self, tree: &[Vec<usize>]) -> Vec<Rotation3<f64>> {
        let mut rotations = vec![None; self.num_nodes];
        let mut stack = Vec::new();
        if self.num_nodes > 0 {
            rotations[0] = Some(Rotation3::identity());
            stack.push(0);
        }
        while let Some(node) = stack.pop() {
            let world_from_node = rotations[node].unwrap_or_default();
            for &position in &tree[node] {
                let m = &self.measurements[position];
                let (other, rotation) = if m.i == node {
                    (m.j, world_from_node * m.rotation)
                } else {
                    (m.i, world_from_node * m.rotation.inverse())
                };
                if rotations[other].is_none() {
                    rotations[other] = Some(rotation);
                    stack.push(other);
                }
            }
        }
        rotations
            .into_iter()
            .map(Option::unwrap_or_default)
            .collect()
    }
}

fn representative(label: &mut [usize], mut node: usize) -> usize {
    while label[node] != node {
        label[node] = label[label[node]];
        node = label[node];
    }
    node
}
