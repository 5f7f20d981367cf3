//! The pose graph of a g2o file, for synchronization, and its solution in the frame of the file.

use std::collections::BTreeMap;

use gmpcr_posegraph::{Components, PoseEdge, PoseGraph, PoseGraphError};
use nalgebra::Isometry3;

use crate::{G2o, G2oEdge, G2oVertex};

/// The pose graph of a g2o file: nodes are numbered from 0 in ascending order of their ids.
///
/// A vertex that only edges name is a node, too. Edge `k` of the graph is edge `k` of the file. Its
/// weight says how certain its rotation is, relative to the other edges:
///
/// ```text
/// w_k = trace(Ω_k[3..6, 3..6]) / max_l trace(Ω_l[3..6, 3..6])
/// ```
///
/// with the information matrix `Ω_k` in the order translation, rotation.
///
/// # Example
/// ```
/// use gmpcr_io::{G2o, G2oEdge, G2oPoseGraph, G2oVertex};
/// use gmpcr_posegraph::Components;
/// use nalgebra::{Isometry3, Matrix6};
///
/// let x = |x| Isometry3::translation(x, 0.0, 0.0);
/// let edge = |i, j, certainty| G2oEdge {
///     i,
///     j,
///     i_from_j: x(1.0),
///     information: certainty * Matrix6::identity(),
/// };
/// let file = G2o {
///     vertices: vec![G2oVertex { id: 7, world_from_vertex: x(10.0) }],
///     edges: vec![edge(3, 7, 2.0), edge(7, 9, 1.0)],
/// };
/// let read = G2oPoseGraph::new(&file)?;
/// assert_eq!(read.ids, [3, 7, 9]);
/// assert_eq!(read.initial_poses, [None, Some(x(10.0)), None]);
/// let edges = read.graph.edges();
/// assert_eq!((edges[1].i, edges[1].j, edges[1].weight), (1, 2, 0.5));
///
/// // A solution in any frame returns to that of the file.
/// let components = Components::new(3, [(0, 1), (1, 2)]);
/// let solved = read.solved(&[x(0.0), x(1.0), x(2.0)], &components);
/// assert_eq!(solved.vertices[0], G2oVertex { id: 3, world_from_vertex: x(9.0) });
/// assert_eq!(solved.vertices[1], file.vertices[0]);
/// assert_eq!(solved.edges, file.edges);
/// # Ok::<(), gmpcr_io::G2oGraphError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct G2oPoseGraph {
    /// The graph of the edges. It has a node for each of the `ids`.
    pub graph: PoseGraph,
    /// The id of each node, ascending.
    pub ids: Vec<usize>,
    /// `world_from_vertex` of each node in the world of the file; `None` where only edges name it.
    pub initial_poses: Vec<Option<Isometry3<f64>>>,
    /// The edges as the file has them, with ids and information matrices.
    pub edges: Vec<G2oEdge>,
}

/// Why a g2o file does not form a pose graph.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum G2oGraphError {
    /// An edge joins a vertex with itself.
    #[error("an edge joins vertex {id} with itself")]
    Loop {
        /// Id of the vertex.
        id: usize,
    },
    /// The rotation block of an information matrix has a trace that is negative or not finite.
    #[error(
        "the edge of vertices {i} and {j} has rotation information of trace {trace:e}: it must be \
         finite and not negative"
    )]
    InvalidInformation {
        /// Id of the first vertex.
        i: usize,
        /// Id of the second vertex.
        j: usize,
        /// The trace.
        trace: f64,
    },
    /// There is no edge, or none has information on its rotation.
    #[error("no EDGE_SE3:QUAT record with information on its rotation")]
    NoInformation,
    /// A relative pose is not one that a pose graph takes. The error names nodes, not ids.
    #[error(transparent)]
    PoseGraph(#[from] PoseGraphError),
}

impl G2oPoseGraph {
    /// The pose graph of a file, in `O(n log n)` of its vertices and edges. Of vertices of the same
    /// id, which [`read_g2o`](crate::read_g2o) refuses, the last counts.
    ///
    /// # Errors
    /// [`G2oGraphError`] if an edge joins a vertex with itself, if the information on its rotation is
    /// negative or not finite, if no edge has such information, or if a relative pose is invalid.
    pub fn new(file: &G2o) -> Result<Self, G2oGraphError> {
        let named = file.edges.iter().flat_map(|edge| [edge.i, edge.j]);
        let mut nodes: BTreeMap<usize, Option<Isometry3<f64>>> =
            named.map(|id| (id, None)).collect();
        let posed = file.vertices.iter();
        nodes.extend(posed.map(|vertex| (vertex.id, Some(vertex.world_from_vertex))));
        let (ids, initial_poses): (Vec<usize>, Vec<_>) = nodes.into_iter().unzip();
        Ok(Self {
            graph: PoseGraph::new(ids.len(), weighted_edges(&file.edges, &ids)?)?,
            ids,
            initial_poses,
            edges: file.edges.clone(),
        })
    }

    /// The file with solved poses: those of `world_from_node`, moved into the frame of the file.
    ///
    /// Poses of a component are known up to a common transformation. It is chosen such that one node keeps
    /// the pose that the file gives it: the first node of the component that has one. If there is none,
    /// the poses of the component stay as they are. `components` are those of the synchronization, which
    /// may leave edges out.
    ///
    /// # Panics
    /// If there is not one pose per node, or if `components` have another number of nodes.
    pub fn solved(&self, world_from_node: &[Isometry3<f64>], components: &Components) -> G2o {
        let num_nodes = self.ids.len();
        assert_eq!(
            world_from_node.len(),
            num_nodes,
            "a pose per node is needed"
        );
        let num_members: usize = components.members().iter().map(Vec::len).sum();
        assert_eq!(num_members, num_nodes, "a component per node is needed");
        let mut file_from_node = world_from_node.to_vec();
        for nodes in components.members() {
            let in_file = |&node: &usize| Some((node, self.initial_poses[node]?));
            let Some((reference, file_from_reference)) = nodes.iter().find_map(in_file) else {
                continue;
            };
            let file_from_world = file_from_reference * world_from_node[reference].inverse();
            for &node in nodes {
                file_from_node[node] = file_from_world * world_from_node[node];
            }
        }
        let vertices = self.ids.iter().zip(file_from_node);
        G2o {
            vertices: vertices
                .map(|(&id, world_from_vertex)| G2oVertex {
                    id,
                    world_from_vertex,
                })
                .collect(),
            edges: self.edges.clone(),
        }
    }
}

/// The edges between nodes. The ascending `ids` hold every id that an edge names.
fn weighted_edges(edges: &[G2oEdge], ids: &[usize]) -> Result<Vec<PoseEdge>, G2oGraphError> {
    let traces = edges.iter().map(certainty);
    let traces = traces.collect::<Result<Vec<f64>, _>>()?;
    let largest = traces.iter().copied().fold(0.0, f64::max);
    if largest == 0.0 {
        return Err(G2oGraphError::NoInformation);
    }
    let node = |id: usize| ids.partition_point(|&other| other < id);
    let edges = edges.iter().zip(traces).map(|(edge, trace)| PoseEdge {
        i: node(edge.i),
        j: node(edge.j),
        i_from_j: edge.i_from_j,
        weight: trace / largest,
    });
    Ok(edges.collect())
}

/// The trace of the information on the rotation of an edge.
fn certainty(edge: &G2oEdge) -> Result<f64, G2oGraphError> {
    let &G2oEdge { i, j, .. } = edge;
    if i == j {
        return Err(G2oGraphError::Loop { id: i });
    }
    let trace = edge.information.fixed_view::<3, 3>(3, 3).trace();
    if !(0.0..f64::INFINITY).contains(&trace) {
        return Err(G2oGraphError::InvalidInformation { i, j, trace });
    }
    Ok(trace)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix6, Vector3};

    fn edge(i: usize, j: usize) -> G2oEdge {
        G2oEdge {
            i,
            j,
            i_from_j: Isometry3::translation(1.0, 2.0, 3.0),
            information: Matrix6::identity(),
        }
    }

    fn complaint(edges: Vec<G2oEdge>) -> String {
        let vertices = Vec::new();
        let file = G2o { vertices, edges };
        G2oPoseGraph::new(&file).unwrap_err().to_string()
    }

    #[test]
    fn faults_are_named_by_the_ids_of_the_file() {
        assert_eq!(
            complaint(vec![edge(5, 9), edge(9, 9)]),
            "an edge joins vertex 9 with itself"
        );
        for diagonal in [-1.0, f64::NAN, f64::INFINITY] {
            let mut bad = edge(5, 9);
            bad.information[(4, 4)] = 3.0 * diagonal;
            let said = complaint(vec![edge(0, 1), bad]);
            assert!(
                said.starts_with("the edge of vertices 5 and 9 has rotation information of trace "),
                "{said}"
            );
        }
        let none = "no EDGE_SE3:QUAT record with information on its rotation";
        assert_eq!(complaint(vec![]), none);
        let mut blind = edge(0, 1);
        blind.information.fixed_view_mut::<3, 3>(3, 3).fill(0.0);
        assert_eq!(complaint(vec![blind]), none);
        let mut far = edge(0, 1);
        far.i_from_j.translation.x = 1e200;
        assert!(complaint(vec![far]).starts_with("edge (0, 1) has "));
    }

    #[test]
    fn only_the_rotation_block_counts_as_weight() {
        let mut certain = edge(2, 1);
        certain.information *= 4.0;
        let mut rigid = edge(2, 4);
        rigid.information.fixed_view_mut::<3, 3>(0, 0).fill(1e9);
        let file = G2o {
            vertices: Vec::new(),
            edges: vec![certain, rigid],
        };
        let read = G2oPoseGraph::new(&file).unwrap();
        let edges = read.graph.edges();
        assert_eq!((edges[0].i, edges[0].j, edges[0].weight), (1, 0, 1.0));
        assert_eq!((edges[1].i, edges[1].j, edges[1].weight), (1, 2, 0.25));
        assert_eq!(read.initial_poses, [None; 3]);
    }

    #[test]
    fn each_component_returns_to_the_frame_of_its_first_posed_vertex() {
        let pose = |k: f64| Isometry3::new(Vector3::new(k, -k, 2.0), Vector3::new(0.3, k, 0.1));
        let expected: Vec<_> = (0..6).map(|k| pose(f64::from(k))).collect();
        let vertex = |id: usize| G2oVertex {
            id,
            world_from_vertex: expected[id],
        };
        // Components 0 1 2 and 3 4 have poses in the file, 5 has none.
        let file = G2o {
            vertices: [4, 2, 1].map(vertex).to_vec(),
            edges: vec![edge(0, 1), edge(1, 2), edge(4, 3), edge(2, 5)],
        };
        let components = Components::new(6, [(0, 1), (1, 2), (3, 4)]);
        let gauges = [pose(7.0), pose(-3.0), pose(0.5)];
        let found: Vec<_> = (0..6)
            .map(|k| gauges[components.label(k)] * expected[k])
            .collect();
        let solved = G2oPoseGraph::new(&file)
            .unwrap()
            .solved(&found, &components);
        for (id, vertex) in solved.vertices.iter().enumerate() {
            assert_eq!(vertex.id, id);
            let known = if id == 5 { found[5] } else { expected[id] };
            let difference = vertex.world_from_vertex.inv_mul(&known);
            assert!(difference.translation.vector.norm() < 1e-12, "{id}");
            assert!(difference.rotation.angle() < 1e-12, "{id}");
        }
    }
}
