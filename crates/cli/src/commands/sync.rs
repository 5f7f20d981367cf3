//! `gmpcr sync`: poses from the relative poses of a g2o file.

use std::collections::{BTreeSet, HashMap};
use std::fmt::Write;

use gmpcr::nalgebra::Isometry3;
use gmpcr::posegraph::{PoseEdge, PoseGraph};
use gmpcr::sync::{ComponentReport, SyncParams, Synchronization, synchronize};
use gmpcr_eval::pose_error;
use gmpcr_io::{G2o, G2oEdge, G2oVertex, read_g2o, write_g2o};
use serde_json::{Value, json};

use crate::arguments::SyncArguments;
use crate::outcome::{Answer, Failure};
use crate::progress::Progress;
use crate::table::{counted, significant, table};

/// Largest residual of eigenvectors that count as found.
const SOLVED: f64 = 1e-10;
/// Largest residual of positions that count as solved: far below the noise of any measurement.
const POSITIONED: f64 = 1e-6;

pub fn run(
    arguments: &SyncArguments,
    is_verbose: bool,
    progress: &Progress,
) -> Result<Answer, Failure> {
    let named = |reason: String| Failure::of(&arguments.graph, reason);
    let mut file = read_g2o(&arguments.graph)?;
    let posed: BTreeSet<usize> = file.vertices.iter().map(|vertex| vertex.id).collect();
    complete_vertices(&mut file, &posed);
    let graph = pose_graph(&file).map_err(named)?;
    let params = SyncParams {
        iterations: arguments.iterations as usize,
        method: arguments.method,
        ..SyncParams::default()
    };
    let before: Vec<_> = file
        .vertices
        .iter()
        .map(|vertex| vertex.world_from_vertex)
        .collect();
    let all_are_posed = posed.len() == before.len();
    let before = all_are_posed.then(|| Residuals::of(&graph, &before));
    let (result, time) = progress.stage("synchronisation", 1, || {
        progress.item(|| synchronize(&graph, &params))
    })?;
    progress.finish();
    let after = Residuals::of(&graph, &result.world_from_scan);
    move_vertices(&mut file.vertices, &posed, &result);
    if let Some(out) = &arguments.out {
        write_g2o(out, &file)?;
    }
    let num_components = result.components.members().len();
    let unused = graph
        .edges()
        .iter()
        .filter(|edge| edge.weight == 0.0)
        .count();
    let largest =
        |of: fn(&ComponentReport) -> f64| result.reports.iter().map(of).fold(0.0, f64::max);
    let eigen_residual = largest(|report| report.eigen_residual);
    let position_residual = largest(|report| report.position_residual);
    let mut text = format!(
        "{} poses, {} edges, {}: {} in {:.3} s\n",
        graph.num_scans(),
        graph.edges().len(),
        counted(num_components, "component"),
        arguments.method.name(),
        time.as_secs_f64()
    );
    if unused > 0 {
        let _ = writeln!(
            text,
            "{} without information on the rotation not used",
            counted(unused, "edge")
        );
    }
    if eigen_residual > SOLVED {
        let _ = writeln!(
            text,
            "rotations were not solved to the end (eigenvector residual {eigen_residual:.1e}): consensus, l1-irls and \
             hara have no eigenproblem"
        );
    }
    if position_residual > POSITIONED {
        let _ = writeln!(
            text,
            "positions were not solved to the end (residual {position_residual:.1e}): distant poses may be off \
             against each other"
        );
    }
    let _ = write!(text, "\n{}", residual_table(before.as_ref(), &after));
    if is_verbose {
        let _ = write!(
            text,
            "\neigenvector residual {eigen_residual:.1e}, residual of positions {position_residual:.1e}\n"
        );
    }
    if let Some(out) = &arguments.out {
        let _ = write!(text, "\n{} written\n", out.display());
    }
    Ok(Answer {
        text,
        json: Some(json!({
            "method": arguments.method.name(),
            "poses": graph.num_scans(),
            "edges": graph.edges().len(),
            "unused_edges": unused,
            "components": num_components,
            "seconds": time.as_secs_f64(),
            "eigen_residual": eigen_residual,
            "position_residual": position_residual,
            "before": before.as_ref().map(Residuals::to_json),
            "after": after.to_json(),
        })),
        is_complete: num_components == 1,
    })
}

/// Adds the vertices that only edges name, and sorts all by their ids.
fn complete_vertices(file: &mut G2o, posed: &BTreeSet<usize>) {
    let named: BTreeSet<usize> = file
        .edges
        .iter()
        .flat_map(|edge| [edge.i, edge.j])
        .collect();
    let missing = named.difference(posed).map(|&id| G2oVertex {
        id,
        world_from_vertex: Isometry3::identity(),
    });
    file.vertices.extend(missing);
    file.vertices.sort_by_key(|vertex| vertex.id);
}

/// The graph of the file's edges; nodes are the vertices in their order. An edge weighs as much as it
/// knows of its rotation: the trace of that block of its information, relative to the largest.
fn pose_graph(file: &G2o) -> Result<PoseGraph, String> {
    let vertices = file.vertices.iter().enumerate();
    let node: HashMap<usize, usize> = vertices.map(|(node, vertex)| (vertex.id, node)).collect();
    let certainty = |edge: &G2oEdge| edge.information.fixed_view::<3, 3>(3, 3).trace();
    for edge in &file.edges {
        let G2oEdge { i, j, .. } = edge;
        if i == j {
            return Err(format!("an edge joins vertex {i} with itself"));
        }
        let certainty = certainty(edge);
        if !(0.0..f64::INFINITY).contains(&certainty) {
            return Err(format!(
                "the edge of vertices {i} and {j} has rotation information of trace {certainty:e}: it must be \
                 finite and not negative"
            ));
        }
    }
    let largest = file.edges.iter().map(certainty).fold(0.0, f64::max);
    if largest == 0.0 {
        return Err("no EDGE_SE3:QUAT record with information on its rotation".into());
    }
    let edges = file.edges.iter().map(|edge| PoseEdge {
        i: node[&edge.i],
        j: node[&edge.j],
        i_from_j: edge.i_from_j,
        weight: certainty(edge) / largest,
    });
    PoseGraph::new(file.vertices.len(), edges.collect()).map_err(|error| error.to_string())
}

/// Puts the new poses into the frame of the file: the first vertex of a component of which the file has a
/// pose keeps it.
fn move_vertices(vertices: &mut [G2oVertex], posed: &BTreeSet<usize>, result: &Synchronization) {
    for nodes in result.components.members() {
        let reference = nodes
            .iter()
            .find(|&&node| posed.contains(&vertices[node].id));
        let file_from_world = reference.map_or_else(Isometry3::identity, |&node| {
            vertices[node].world_from_vertex * result.world_from_scan[node].inverse()
        });
        for &node in nodes {
            vertices[node].world_from_vertex = file_from_world * result.world_from_scan[node];
        }
    }
}

/// How far measured relative poses are off those of the vertices, in ascending order.
struct Residuals {
    /// Degrees.
    rotation: Vec<f64>,
    /// In the unit of the file.
    translation: Vec<f64>,
}

impl Residuals {
    fn of(graph: &PoseGraph, world_from_scan: &[Isometry3<f64>]) -> Self {
        let (mut rotation, mut translation) = (Vec::new(), Vec::new());
        for edge in graph.edges() {
            let i_from_j = world_from_scan[edge.i].inv_mul(&world_from_scan[edge.j]);
            let error = pose_error(&edge.i_from_j, &i_from_j);
            rotation.push(error.rotation_degrees());
            translation.push(error.translation);
        }
        rotation.sort_by(f64::total_cmp);
        translation.sort_by(f64::total_cmp);
        Self {
            rotation,
            translation,
        }
    }

    fn to_json(&self) -> Value {
        let quantiles = |values| {
            let [median, high, largest] = quantiles(values);
            json!({ "median": median, "percentile_95": high, "largest": largest })
        };
        json!({
            "rotation_degrees": quantiles(&self.rotation),
            "translation": quantiles(&self.translation),
        })
    }
}

/// Median, 95th percentile and maximum of ascending values.
fn quantiles(values: &[f64]) -> [f64; 3] {
    let at = |share: f64| (share * values.len() as f64) as usize;
    [0.5, 0.95, 1.0].map(|share| values[at(share).min(values.len() - 1)])
}

fn residual_table(before: Option<&Residuals>, after: &Residuals) -> String {
    let row = |name: &str, residuals: &Residuals| {
        let degrees = quantiles(&residuals.rotation).map(|value| format!("{value:.3}°"));
        let lengths = quantiles(&residuals.translation).map(significant);
        let cells = [name.to_owned()].into_iter().chain(degrees).chain(lengths);
        cells.collect::<Vec<_>>()
    };
    let before = before.map(|residuals| row("before", residuals));
    let header = [
        "residuals",
        "rotation: median",
        "95 %",
        "largest",
        "translation: median",
        "95 %",
        "largest",
    ];
    table(&header, before.into_iter().chain([row("after", after)]))
}
