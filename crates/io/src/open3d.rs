//! Pose graphs in the JSON format of Open3D.

use std::io::Write;
use std::path::Path;

use nalgebra::{Isometry3, Matrix6};
use serde_json::{Value, json};

use crate::atomic::write_atomically;
use crate::text::read_text;
use crate::{Error, rigid};

/// A pose graph of Open3D: poses, and relative poses between them.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Open3dPoseGraph {
    /// `world_from_scan` of each scan.
    #[cfg_attr(feature = "serde", serde(with = "gmpcr_geometry::matrix_rows::list"))]
    pub nodes: Vec<Isometry3<f64>>,
    /// The measured relative poses.
    pub edges: Vec<Open3dEdge>,
}

/// A measured relative pose of two scans.
///
/// Without noise it satisfies `target_from_source = world_from_target^-1 * world_from_source`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Open3dEdge {
    /// The scan whose coordinates are mapped, a place in [`Open3dPoseGraph::nodes`].
    pub source: usize,
    /// The scan into whose frame they are mapped, a place in [`Open3dPoseGraph::nodes`].
    pub target: usize,
    /// The transformation from the frame of the source to that of the target.
    #[cfg_attr(feature = "serde", serde(with = "gmpcr_geometry::matrix_rows"))]
    pub target_from_source: Isometry3<f64>,
    /// The information matrix in the order rotation, translation, as Open3D computes and reads it.
    /// (g2o has translation first: swap the two halves of rows and columns.)
    pub information: Matrix6<f64>,
    /// Whether Open3D may remove the edge as an outlier. Its edges of odometry are certain, loop closures
    /// are uncertain.
    pub uncertain: bool,
    /// The weight that Open3D's optimization gave an uncertain edge, from 0 to 1. It is 1 before that.
    pub confidence: f64,
}

/// Writes a pose graph for `open3d.io.read_pose_graph`.
///
/// The file is JSON of class `PoseGraph`, version 1.0. Matrices are written column by column, with all
/// digits of their numbers.
///
/// # Errors
/// [`Error::Unwritable`], which names the node or the edge, if a number is not finite or an edge names
/// a scan that is not a node. [`Error::Io`] if the file cannot be written. In both cases it is as it was
/// before.
///
/// # Example
/// ```
/// use gmpcr_io::{Open3dEdge, Open3dPoseGraph, read_open3d_pose_graph, write_open3d_pose_graph};
/// use nalgebra::{Isometry3, Matrix6};
///
/// let graph = Open3dPoseGraph {
///     nodes: vec![Isometry3::identity(), Isometry3::translation(0.5, 0.0, 0.0)],
///     edges: vec![Open3dEdge {
///         source: 1,
///         target: 0,
///         target_from_source: Isometry3::translation(0.5, 0.0, 0.0),
///         information: 900.0 * Matrix6::identity(),
///         uncertain: true,
///         confidence: 1.0,
///     }],
/// };
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("posegraph.json");
/// write_open3d_pose_graph(&path, &graph)?;
/// assert_eq!(read_open3d_pose_graph(&path)?, graph);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_open3d_pose_graph(
    path: impl AsRef<Path>,
    graph: &Open3dPoseGraph,
) -> Result<(), Error> {
    let path = path.as_ref();
    let graph = graph_value(graph).map_err(|reason| Error::Unwritable {
        path: path.to_owned(),
        reason,
    })?;
    write_atomically(path, |file| {
        serde_json::to_writer_pretty(&mut *file, &graph)?;
        writeln!(file)
    })
}

const GRAPH: &str = "PoseGraph";
const NODE: &str = "PoseGraphNode";
const EDGE: &str = "PoseGraphEdge";

fn graph_value(graph: &Open3dPoseGraph) -> Result<Value, String> {
    let nodes = (0..).zip(&graph.nodes).map(|(k, world_from_scan)| {
        let pose = matrix_value(world_from_scan);
        let pose = pose.ok_or_else(|| format!("node {k} is not finite"))?;
        Ok(json!({ "class_name": NODE, "version_major": 1, "version_minor": 0, "pose": pose }))
    });
    let edges = (0..).zip(&graph.edges).map(|(k, edge)| {
        check_ends(edge, graph.nodes.len()).map_err(|reason| format!("edge {k}: {reason}"))?;
        edge_value(edge).ok_or_else(|| format!("edge {k} is not finite"))
    });
    Ok(json!({
        "class_name": GRAPH,
        "version_major": 1,
        "version_minor": 0,
        "nodes": nodes.collect::<Result<Vec<_>, String>>()?,
        "edges": edges.collect::<Result<Vec<_>, String>>()?,
    }))
}

fn edge_value(edge: &Open3dEdge) -> Option<Value> {
    Some(json!({
        "class_name": EDGE,
        "version_major": 1,
        "version_minor": 0,
        "source_node_id": edge.source,
        "target_node_id": edge.target,
        "transformation": matrix_value(&edge.target_from_source)?,
        "information": finite(edge.information.as_slice())?,
        "uncertain": edge.uncertain,
        "confidence": finite(&[edge.confidence])?[0],
    }))
}

fn matrix_value(transformation: &Isometry3<f64>) -> Option<Vec<f64>> {
    finite(transformation.to_homogeneous().as_slice())
}

/// JSON has no numbers that are not finite.
fn finite(numbers: &[f64]) -> Option<Vec<f64>> {
    let all = numbers.iter().all(|number| number.is_finite());
    all.then(|| numbers.to_vec())
}

fn check_ends(edge: &Open3dEdge, num_nodes: usize) -> Result<(), String> {
    match [edge.source, edge.target]
        .iter()
        .find(|&&end| end >= num_nodes)
    {
        None => Ok(()),
        Some(end) => Err(format!(
            "it names node {end}, but there are {num_nodes} nodes"
        )),
    }
}

/// Reads a pose graph that Open3D or [`write_open3d_pose_graph`] has written.
///
/// The 3×3 part of each matrix is replaced by the nearest rotation. Where an edge has no
/// `confidence`, as in files of old versions, it is 1.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`] if it is not JSON of class
/// `PoseGraph`, if an entry is missing or of another kind, if a matrix is off any rigid transformation by more
/// than 0.01 in an entry, or if an edge names a node that is not in the file; the message says which.
pub fn read_open3d_pose_graph(path: impl AsRef<Path>) -> Result<Open3dPoseGraph, Error> {
    let path = path.as_ref();
    let text = read_text(path)?;
    let value: Value = serde_json::from_str(&text)
        .map_err(|error| Error::parser(path, Some(error.line()), "not JSON", error))?;
    graph(&value).map_err(|reason| Error::malformed(path, reason))
}

fn graph(value: &Value) -> Result<Open3dPoseGraph, String> {
    check_class(value, GRAPH)?;
    let mut graph = Open3dPoseGraph::default();
    for (k, value) in list(value, "nodes")?.iter().enumerate() {
        let node = node(value).map_err(|reason| format!("node {k}: {reason}"))?;
        graph.nodes.push(node);
    }
    for (k, value) in list(value, "edges")?.iter().enumerate() {
        let edge =
            edge(value, graph.nodes.len()).map_err(|reason| format!("edge {k}: {reason}"))?;
        graph.edges.push(edge);
    }
    Ok(graph)
}

fn node(value: &Value) -> Result<Isometry3<f64>, String> {
    check_class(value, NODE)?;
    transformation(value, "pose")
}

fn edge(value: &Value, num_nodes: usize) -> Result<Open3dEdge, String> {
    check_class(value, EDGE)?;
    let uncertain = value["uncertain"].as_bool();
    let confidence = match &value["confidence"] {
        Value::Null => Some(1.0),
        confidence => confidence.as_f64(),
    };
    let edge = Open3dEdge {
        source: index(value, "source_node_id")?,
        target: index(value, "target_node_id")?,
        target_from_source: transformation(value, "transformation")?,
        information: Matrix6::from_column_slice(&numbers::<36>(value, "information")?),
        uncertain: uncertain.ok_or("\"uncertain\" is neither true nor false")?,
        confidence: confidence.ok_or("\"confidence\" is not a number")?,
    };
    check_ends(&edge, num_nodes)?;
    Ok(edge)
}

fn check_class(value: &Value, class: &str) -> Result<(), String> {
    match value["class_name"].as_str() {
        Some(name) if name == class => Ok(()),
        Some(name) => Err(format!("it is of class {name:?}, not {class:?}")),
        None => Err(format!("it is not of class {class:?}")),
    }
}

fn list<'a>(value: &'a Value, key: &str) -> Result<&'a [Value], String> {
    let list = value[key]
        .as_array()
        .ok_or_else(|| format!("{key:?} is not a list"))?;
    Ok(list)
}

fn index(value: &Value, key: &str) -> Result<usize, String> {
    let index = value[key].as_u64().and_then(|index| index.try_into().ok());
    index.ok_or_else(|| format!("{key:?} is not a whole number from 0 on"))
}

fn numbers<const N: usize>(value: &Value, key: &str) -> Result<[f64; N], String> {
    let numbers: Option<Vec<f64>> = list(value, key)?.iter().map(Value::as_f64).collect();
    numbers
        .and_then(|numbers| numbers.try_into().ok())
        .ok_or_else(|| format!("{key:?} is not a list of {N} numbers"))
}

fn transformation(value: &Value, key: &str) -> Result<Isometry3<f64>, String> {
    let columns = numbers::<16>(value, key)?;
    let entry = |row: usize, column: usize| columns[4 * column + row];
    let named = |reason: String| format!("{key:?}: {reason}");
    rigid::check_last_row(std::array::from_fn(|column| entry(3, column))).map_err(named)?;
    rigid::from_matrix_rows(std::array::from_fn(|k| entry(k / 4, k % 4))).map_err(named)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use std::fs;

    fn some_graph() -> Open3dPoseGraph {
        let pose = Isometry3::new(Vector3::new(1.0, -2.0, 3.0), Vector3::new(0.3, -0.5, 0.9));
        Open3dPoseGraph {
            nodes: vec![Isometry3::identity(), pose],
            edges: vec![Open3dEdge {
                source: 1,
                target: 0,
                target_from_source: pose,
                information: Matrix6::from_fn(|row, column| (10 * row + column) as f64),
                uncertain: false,
                confidence: 0.5,
            }],
        }
    }

    fn written(graph: &Open3dPoseGraph) -> Value {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("graph.json");
        write_open3d_pose_graph(&path, graph).unwrap();
        serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
    }

    fn complaint(content: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("graph.json");
        fs::write(&path, content).unwrap();
        let said = read_open3d_pose_graph(path).unwrap_err().to_string();
        assert!(said.contains("graph.json"), "{said}");
        said
    }

    #[test]
    fn matrices_are_written_column_by_column() {
        let value = written(&some_graph());
        assert_eq!(value["nodes"][1]["pose"][12], 1.0);
        assert_eq!(value["nodes"][1]["pose"][14], 3.0);
        assert_eq!(value["nodes"][1]["pose"][15], 1.0);
        assert_eq!(value["edges"][0]["information"][1], 10.0);
        assert_eq!(value["edges"][0]["information"][6], 1.0);
    }

    #[test]
    fn an_edge_of_an_old_version_has_full_confidence() {
        let mut value = written(&some_graph());
        value["edges"][0]
            .as_object_mut()
            .unwrap()
            .remove("confidence");
        assert_eq!(graph(&value).unwrap().edges[0].confidence, 1.0);
    }

    #[test]
    fn faults_are_named() {
        let good = written(&some_graph());
        let with = |pointer: &str, value: Value| {
            let mut graph = good.clone();
            *graph.pointer_mut(pointer).unwrap() = value;
            complaint(&graph.to_string())
        };
        for (pointer, value, reason) in [
            (
                "/class_name",
                json!("TriangleMesh"),
                "it is of class \"TriangleMesh\"",
            ),
            ("/nodes", json!(3), "\"nodes\" is not a list"),
            (
                "/nodes/1/pose",
                json!([1.0, 2.0]),
                "node 1: \"pose\" is not a list of 16 numbers",
            ),
            (
                "/nodes/1/pose/0",
                json!("a"),
                "node 1: \"pose\" is not a list of 16 numbers",
            ),
            (
                "/nodes/1/pose/0",
                json!(7.0),
                "node 1: \"pose\": the 3x3 part is not a rotation",
            ),
            (
                "/nodes/1/pose/3",
                json!(1.0),
                "node 1: \"pose\": the last row",
            ),
            (
                "/edges/0/source_node_id",
                json!(2),
                "edge 0: it names node 2, but there are 2",
            ),
            (
                "/edges/0/target_node_id",
                json!(-1),
                "\"target_node_id\" is not a whole number",
            ),
            ("/edges/0/uncertain", json!(1), "\"uncertain\" is neither"),
            (
                "/edges/0/confidence",
                json!("high"),
                "\"confidence\" is not a number",
            ),
        ] {
            let said = with(pointer, value);
            assert!(said.contains(reason), "{said}");
        }
        assert!(complaint("").contains("not JSON"));
        assert!(complaint("[1, 2]").contains("it is not of class \"PoseGraph\""));
        complaint(&"[".repeat(100_000));
    }

    #[test]
    fn what_open3d_could_not_read_is_not_written() {
        let mut far = some_graph();
        far.nodes[1].translation.x = f64::NAN;
        let mut unknown = some_graph();
        unknown.edges[0].source = 2;
        let mut infinite = some_graph();
        infinite.edges[0].information[(5, 5)] = f64::INFINITY;
        for (graph, reason) in [
            (far, "node 1 is not finite"),
            (unknown, "edge 0: it names node 2"),
            (infinite, "edge 0 is not finite"),
        ] {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("graph.json");
            let error = write_open3d_pose_graph(&path, &graph).unwrap_err();
            assert!(matches!(error, Error::Unwritable { .. }), "{error:?}");
            let said = error.to_string();
            assert!(
                said.contains("graph.json") && said.contains(reason),
                "{said}"
            );
            assert!(!path.exists());
        }
    }
}
