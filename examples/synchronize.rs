//! Synchronises the relative poses of a g2o file, with the synchronisation crate alone.
//!
//! ```text
//! cargo run --release --example synchronize -- GRAPH.g2o [--out RESULT.g2o]
//! ```
//!
//! Every edge starts with the weight 1; initial vertex poses are not used.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use gmpcr_examples::report;
use gmpcr_io::{G2o, G2oEdge, G2oVertex, read_g2o, write_g2o};
use gmpcr_posegraph::{PoseEdge, PoseGraph};
use gmpcr_sync::{EdgeReport, Method, SyncParams, synchronize};
use nalgebra::Isometry3;

#[derive(Parser)]
#[command(about = "Synchronises the relative poses of a g2o file")]
struct Arguments {
    /// Pose graph with EDGE_SE3:QUAT records.
    graph: PathBuf,
    /// Where to write the graph with the resulting poses.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// adaptive (the paper), no-recovery, sghr, memoryless, eigse3, l1, l1-irls, rotavg-lhalf,
    /// hara or consensus.
    #[arg(long, default_value = "adaptive")]
    method: Method,
    /// Reweighting iterations; 0 trusts all edges alike.
    #[arg(long, default_value_t = 10)]
    iterations: usize,
}

fn main() -> ExitCode {
    report(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let mut file = read_g2o(&arguments.graph)?;
    complete_vertices(&mut file);
    let graph = pose_graph(&file)?;
    if graph.edges().is_empty() {
        return Err(format!("{}: no edges to synchronise", arguments.graph.display()).into());
    }
    let params = SyncParams {
        iterations: arguments.iterations,
        method: arguments.method,
        ..SyncParams::default()
    };

    let start = Instant::now();
    let result = synchronize(&graph, &params);
    println!(
        "{} poses, {} edges: {:.3} s",
        graph.num_scans(),
        graph.edges().len(),
        start.elapsed().as_secs_f64()
    );
    println!(
        "components          {:>8}",
        result.components.members().len()
    );
    let residuals = result.reports.iter().map(|report| report.eigen_residual);
    println!(
        "eigenvector residual {:>9.1e}",
        residuals.fold(0.0, f64::max)
    );
    let degrees = |edge: &EdgeReport| edge.rotation_residual.map(f64::to_degrees);
    print_quantiles(
        "rotation residual, degrees",
        result.edges.iter().filter_map(degrees).collect(),
    );
    let lengths = result
        .edges
        .iter()
        .filter_map(|edge| edge.translation_residual);
    print_quantiles("translation residual", lengths.collect());

    if let Some(out) = &arguments.out {
        for (vertex, pose) in file.vertices.iter_mut().zip(&result.world_from_scan) {
            vertex.world_from_vertex = *pose;
        }
        write_g2o(out, &file)?;
    }
    Ok(())
}

/// Adds the vertices that only edges name, and sorts all by their ids.
fn complete_vertices(file: &mut G2o) {
    let known: HashSet<usize> = file.vertices.iter().map(|vertex| vertex.id).collect();
    let named: BTreeSet<usize> = file
        .edges
        .iter()
        .flat_map(|edge| [edge.i, edge.j])
        .collect();
    let missing = named.into_iter().filter(|id| !known.contains(id));
    file.vertices.extend(missing.map(|id| G2oVertex {
        id,
        world_from_vertex: Isometry3::identity(),
    }));
    file.vertices.sort_by_key(|vertex| vertex.id);
}

/// The graph of the file's edges; nodes are the vertices in their order.
fn pose_graph(file: &G2o) -> Result<PoseGraph, Box<dyn Error>> {
    let vertices = file.vertices.iter().enumerate();
    let node: HashMap<usize, usize> = vertices.map(|(node, vertex)| (vertex.id, node)).collect();
    let edge = |edge: &G2oEdge| PoseEdge {
        i: node[&edge.i],
        j: node[&edge.j],
        i_from_j: edge.i_from_j,
        weight: 1.0,
    };
    let edges = file.edges.iter().map(edge).collect();
    Ok(PoseGraph::new(file.vertices.len(), edges)?)
}

fn print_quantiles(name: &str, mut values: Vec<f64>) {
    values.sort_by(f64::total_cmp);
    let quantile = |share: f64| values.get((share * values.len() as f64) as usize).copied();
    let [low, middle, high] = [0.05, 0.5, 0.95].map(|share| quantile(share).unwrap_or(0.0));
    println!("{name}: 5 % {low:.4}, median {middle:.4}, 95 % {high:.4}");
}
