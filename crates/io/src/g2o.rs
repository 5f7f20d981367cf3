//! Pose graphs in the text format of the g2o optimizer.

use std::collections::BTreeSet;
use std::io::{self, Write};
use std::path::Path;

use nalgebra::{Isometry3, Matrix6};

use crate::atomic::write_atomically;
use crate::text::{Line, lines, read_text};
use crate::{Error, rigid};

const VERTEX: &str = "VERTEX_SE3:QUAT";
const EDGE: &str = "EDGE_SE3:QUAT";

/// A pose graph: vertices with poses in the world, edges with measured relative poses.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct G2o {
    /// The vertices, in the order of the file.
    pub vertices: Vec<G2oVertex>,
    /// The edges, in the order of the file.
    pub edges: Vec<G2oEdge>,
}

/// A vertex and its pose.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct G2oVertex {
    /// What the edges call it. Ids need not be consecutive.
    pub id: usize,
    /// The pose, which maps the vertex' coordinates into the world.
    #[cfg_attr(feature = "serde", serde(with = "gmpcr_geometry::matrix_rows"))]
    pub world_from_vertex: Isometry3<f64>,
}

/// A measured relative pose and how certain it is.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct G2oEdge {
    /// Id of the vertex `i`, which the line names first.
    pub i: usize,
    /// Id of the vertex `j`.
    pub j: usize,
    /// The measured `world_from_i^-1 * world_from_j`: it maps the coordinates of `j` into the
    /// frame of `i`.
    #[cfg_attr(feature = "serde", serde(with = "gmpcr_geometry::matrix_rows"))]
    pub i_from_j: Isometry3<f64>,
    /// Inverse covariance of the measurement, in the order translation, rotation.
    ///
    /// g2o takes it on the error `(t, v)` of `measured^-1 * estimated`, with `v` the vector part
    /// of the unit quaternion, hence half the rotation vector. Only the upper triangle is written.
    pub information: Matrix6<f64>,
}

/// Reads a three-dimensional pose graph.
///
/// Two kinds of lines count:
/// ```text
/// VERTEX_SE3:QUAT id  x y z qx qy qz qw
/// EDGE_SE3:QUAT   i j x y z qx qy qz qw  I11 I12 .. I16 I22 .. I66
/// ```
/// A vertex has its pose, from its own frame into the world. An edge has its relative pose, from the
/// frame of `j` into that of `i`. Quaternions have the scalar last. The 21 numbers at the end of an edge
/// are the upper triangle of the information matrix, row by row, in the order translation, rotation.
///
/// Quaternions are brought to unit length. Comments (from `#` to the end of the line) and
/// records of other things, `FIX` and parameters among them, are skipped. Vertices and edges of
/// any other kind, landmarks among them, are refused: without them the graph would be another one.
///
/// Edges may name vertices that the file does not list.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`], with the line, for an unexpected count
/// of numbers, numbers that are not finite, a quaternion whose length is off 1 by more than 0.01, an
/// id given twice, a line that is not a g2o record, or a vertex or an edge of another kind.
/// [`Error::Malformed`] also if the file has neither a vertex nor an edge.
///
/// # Example
/// ```
/// use gmpcr_io::read_g2o;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("graph.g2o");
/// std::fs::write(
///     &path,
///     "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n\
///      VERTEX_SE3:QUAT 5 1 0 0 0 0 0 1\n\
///      EDGE_SE3:QUAT 0 5 1 0 0 0 0 0 1  9 0 0 0 0 0  9 0 0 0 0  9 0 0 0  4 0 0  4 0  4\n",
/// )?;
/// let graph = read_g2o(&path)?;
/// assert_eq!(graph.vertices[1].id, 5);
/// let edge = &graph.edges[0];
/// assert_eq!((edge.i, edge.j), (0, 5));
/// assert_eq!(edge.i_from_j, graph.vertices[0].world_from_vertex.inverse() * graph.vertices[1].world_from_vertex);
/// assert_eq!((edge.information[(0, 0)], edge.information[(5, 5)]), (9.0, 4.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_g2o(path: impl AsRef<Path>) -> Result<G2o, Error> {
    let path = path.as_ref();
    let text = read_text(path)?;
    let mut graph = G2o::default();
    let mut ids = BTreeSet::new();
    for mut line in lines(path, &text) {
        match line.word("the kind of record")? {
            VERTEX => graph.vertices.push(vertex(line, &mut ids)?),
            EDGE => graph.edges.push(edge(line)?),
            other => check_skippable(&line, other)?,
        }
    }
    if graph.vertices.is_empty() && graph.edges.is_empty() {
        let reason = format!("no record {VERTEX} or {EDGE}");
        return Err(Error::malformed(path, reason));
    }
    Ok(graph)
}

fn vertex(mut line: Line, ids: &mut BTreeSet<usize>) -> Result<G2oVertex, Error> {
    let id = line.index("the id of the vertex")?;
    if !ids.insert(id) {
        return Err(line.error(format!("vertex {id} is given a second time")));
    }
    let world_from_vertex = pose(&mut line)?;
    line.end_or_comment()?;
    Ok(G2oVertex {
        id,
        world_from_vertex,
    })
}

fn edge(mut line: Line) -> Result<G2oEdge, Error> {
    let i = line.index("the first vertex of the edge")?;
    let j = line.index("the second vertex of the edge")?;
    let i_from_j = pose(&mut line)?;
    let information = symmetric(line.numbers("the information matrix")?);
    line.end_or_comment()?;
    Ok(G2oEdge {
        i,
        j,
        i_from_j,
        information,
    })
}

fn pose(line: &mut Line) -> Result<Isometry3<f64>, Error> {
    let row = line.numbers("the pose")?;
    rigid::from_quaternion_row(row).map_err(|reason| line.error(reason))
}

fn symmetric(upper_triangle: [f64; 21]) -> Matrix6<f64> {
    let mut matrix = Matrix6::zeros();
    for ((row, column), entry) in upper_entries().zip(upper_triangle) {
        matrix[(row, column)] = entry;
        matrix[(column, row)] = entry;
    }
    matrix
}

/// Places of the upper triangle, row by row.
fn upper_entries() -> impl Iterator<Item = (usize, usize)> {
    (0..6).flat_map(|row| (row..6).map(move |column| (row, column)))
}

/// Refuses lines that are not records. Refuses vertices and edges of another kind, too: without them the
/// graph would be another one.
fn check_skippable(line: &Line, record: &str) -> Result<(), Error> {
    let part_of_a_name = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || "_:".contains(c);
    if record.starts_with("VERTEX") || record.starts_with("EDGE") {
        let kind = kind_of_graph(record);
        return Err(line.error(format!(
            "{record} belongs to {kind}; only {VERTEX} and {EDGE} are supported"
        )));
    }
    if !record.chars().all(part_of_a_name) {
        return Err(line.error(format!("{record:?} is not a g2o record")));
    }
    Ok(())
}

fn kind_of_graph(record: &str) -> &'static str {
    let planar = record.contains("SE2") || matches!(record, "VERTEX_XY" | "VERTEX2" | "EDGE2");
    if planar {
        "a two-dimensional graph"
    } else {
        "another kind of graph"
    }
}

/// Writes a pose graph in the format that [`read_g2o`] describes. Numbers carry all their digits.
///
/// A graph without vertices and edges gives an empty file, which [`read_g2o`] refuses.
///
/// # Errors
/// [`Error::Io`] if the file cannot be written; then it is as it was before.
///
/// # Example
/// ```
/// use gmpcr_io::{G2o, G2oEdge, G2oVertex, read_g2o, write_g2o};
/// use nalgebra::{Isometry3, Matrix6};
///
/// let vertex = |id, x| G2oVertex { id, world_from_vertex: Isometry3::translation(x, 0.0, 0.0) };
/// let graph = G2o {
///     vertices: vec![vertex(0, 0.0), vertex(1, 2.0)],
///     edges: vec![G2oEdge {
///         i: 0,
///         j: 1,
///         i_from_j: Isometry3::translation(2.0, 0.0, 0.0),
///         information: Matrix6::identity() * 100.0,
///     }],
/// };
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("graph.g2o");
/// write_g2o(&path, &graph)?;
/// assert_eq!(read_g2o(&path)?, graph);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_g2o(path: impl AsRef<Path>, graph: &G2o) -> Result<(), Error> {
    write_atomically(path.as_ref(), |file| {
        for vertex in &graph.vertices {
            write_vertex(file, vertex)?;
        }
        for edge in &graph.edges {
            write_edge(file, edge)?;
        }
        Ok(())
    })
}

fn write_vertex(file: &mut impl Write, vertex: &G2oVertex) -> io::Result<()> {
    write!(file, "{VERTEX} {} ", vertex.id)?;
    rigid::write_quaternion_row(file, &vertex.world_from_vertex)?;
    writeln!(file)
}

fn write_edge(file: &mut impl Write, edge: &G2oEdge) -> io::Result<()> {
    write!(file, "{EDGE} {} {} ", edge.i, edge.j)?;
    rigid::write_quaternion_row(file, &edge.i_from_j)?;
    for place in upper_entries() {
        write!(file, " {:?}", edge.information[place])?;
    }
    writeln!(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn read(text: &str) -> Result<G2o, Error> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("graph.g2o");
        fs::write(&path, text).unwrap();
        read_g2o(path)
    }

    fn complaint(text: &str) -> String {
        read(text).unwrap_err().to_string()
    }

    #[test]
    fn the_triangle_is_taken_row_by_row_translation_first() {
        let numbers: Vec<String> = (1..=21).map(|k| k.to_string()).collect();
        let graph = read(&format!(
            "EDGE_SE3:QUAT 3 9 0 0 0 0 0 0 1 {}",
            numbers.join(" ")
        ));
        let information = graph.unwrap().edges[0].information;
        assert_eq!(information[(0, 5)], 6.0);
        assert_eq!(information[(1, 1)], 7.0);
        assert_eq!(information[(2, 3)], 13.0);
        assert_eq!(information[(3, 3)], 16.0);
        assert_eq!(information[(5, 4)], 20.0);
        assert_eq!(information, information.transpose());
    }

    #[test]
    fn other_records_and_comments_are_passed_over() {
        let text = "# comment\nFIX 0\nPARAMS_SE3OFFSET 0 0 0 0 0 0 0 1\n\
                    FIX 0 # why\nVERTEX_SE3:QUAT 0 1 2 3 0 0 0 1 # origin\n";
        let graph = read(text).unwrap();
        assert_eq!((graph.vertices.len(), graph.edges.len()), (1, 0));
    }

    #[test]
    fn planar_graphs_are_refused_by_name() {
        let said = complaint("# a\nVERTEX_SE2 0 1 2 3\n");
        assert!(said.contains("graph.g2o:2: VERTEX_SE2"), "{said}");
        assert!(said.contains("only VERTEX_SE3:QUAT"), "{said}");
        assert!(complaint("EDGE_SE2_XY 0 1 2 3\n").contains("two-dimensional"));
    }

    #[test]
    fn records_of_other_graphs_are_refused_by_name() {
        for record in [
            "VERTEX3",
            "EDGE3",
            "VERTEX2",
            "EDGE2",
            "VERTEX_SE3:EULER",
            "EDGE_SE3:EULER",
            "VERTEX_SIM3:QUAT",
            "EDGE_SIM3:QUAT",
            "VERTEX_TRACKXYZ",
            "EDGE_SE3_TRACKXYZ",
            "EDGE_SE3:quat",
        ] {
            let good = "VERTEX_SE3:QUAT 0 1 2 3 0 0 0 1";
            let said = complaint(&format!("{good}\n{record} 0 1 2 3 0 0 0\n"));
            assert!(
                said.contains(&format!("graph.g2o:2: {record} belongs to ")),
                "{said}"
            );
        }
    }

    #[test]
    fn files_without_a_supported_record_are_refused() {
        for text in ["", "# comment\n\n", "HELLO WORLD", "FIX 0\n"] {
            let said = complaint(text);
            assert!(said.contains("graph.g2o: no record VERTEX_SE3"), "{said}");
        }
    }

    #[test]
    fn each_fault_names_its_line() {
        let good = "VERTEX_SE3:QUAT 0 1 2 3 0 0 0 1";
        for (bad, reason) in [
            (good, "vertex 0 is given a second time"),
            (
                "VERTEX_SE3:QUAT 1 1 2 3 0 0 0 0",
                "length 0 is not a rotation",
            ),
            ("VERTEX_SE3:QUAT 1 1 2 inf 0 0 0 1", "not a finite number"),
            ("VERTEX_SE3:QUAT 1 1 2 3 0 0 0", "number 7 of 7 of the pose"),
            ("VERTEX_SE3:QUAT 1 1 2 3 0 0 0 1 5", "\"5\" follows"),
            ("VERTEX_SE3:QUAT -1 1 2 3 0 0 0 1", "not a whole number"),
            (
                "EDGE_SE3:QUAT 0 1 1 2 3 0 0 0 1 5",
                "number 2 of 21 of the information",
            ),
            ("These are words", "not a g2o record"),
        ] {
            let said = complaint(&format!("{good}\n{bad}\n"));
            assert!(
                said.contains("graph.g2o:2: ") && said.contains(reason),
                "{said}"
            );
        }
    }
}
