//! A pose graph from elsewhere: solve it, find the outlier edges, solve it again without them.
//!
//! ```text
//! cargo run --release --example 03_pose_graph                    # simulated, 20 % outlier edges
//! cargo run --release --example 03_pose_graph -- GRAPH.g2o
//! ```

use std::env;
use std::error::Error;

use gmpcr_io::{G2oPoseGraph, read_g2o};
use gmpcr_posegraph::{PoseEdge, PoseGraph, bridges};
use gmpcr_sim::{PoseGraphSimParams, simulate_pose_graph};
use gmpcr_sync::{Method, SyncParams, synchronize};

fn main() -> Result<(), Box<dyn Error>> {
    let graph = match env::args().nth(1) {
        Some(file) => G2oPoseGraph::new(&read_g2o(file)?)?.graph,
        None => simulated()?,
    };
    println!("{} poses, {} edges", graph.num_scans(), graph.edges().len());

    // Of ten methods, this one bears the most outliers where edges form triangles.
    let params = SyncParams {
        method: Method::Consensus,
        ..SyncParams::default()
    };
    let solved = synchronize(&graph, &params)?;
    println!("components        {}", solved.components.members().len());

    // An edge that lost nine tenths of its weight contradicts the others.
    let reports = graph.edges().iter().zip(&solved.edges);
    let kept = reports.filter(|(_, report)| report.final_weight > 0.1 * report.initial_weight);
    let kept: Vec<PoseEdge> = kept.map(|(edge, _)| *edge).collect();
    println!("outlier edges     {}", graph.edges().len() - kept.len());

    // No other edge confirms a bridge.
    let ends = kept.iter().map(|edge| (edge.i, edge.j));
    let bridges = bridges(graph.num_scans(), ends);
    println!("bridges           {}", bridges.len());

    let graph = PoseGraph::new(graph.num_scans(), kept)?;
    let again = synchronize(&graph, &SyncParams::default())?;
    for (scan, world_from_scan) in again.world_from_scan.iter().enumerate().take(3) {
        let [x, y, z] = world_from_scan.translation.vector.into();
        let degrees = world_from_scan.rotation.angle().to_degrees();
        println!("pose {scan}            {x:7.3} {y:7.3} {z:7.3}, rotated by {degrees:.1}°");
    }
    Ok(())
}

fn simulated() -> Result<PoseGraph, Box<dyn Error>> {
    let simulated = simulate_pose_graph(&PoseGraphSimParams {
        outlier_ratio: 0.2,
        ..PoseGraphSimParams::default()
    })?;
    let edges = simulated.edges.iter().map(|edge| PoseEdge {
        i: edge.i,
        j: edge.j,
        i_from_j: edge.i_from_j,
        weight: edge.weight,
    });
    let num_scans = simulated.world_from_scan.len();
    Ok(PoseGraph::new(num_scans, edges.collect())?)
}
