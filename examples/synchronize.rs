//! Synchronises relative poses, some of which are wrong, with the crates for pose graphs alone.
//!
//! ```text
//! cargo run --release --example synchronize -- --scans 1000 --outliers 0.4 --method consensus
//! ```
//!
//! Simulates the relative poses, so that the result can be compared with the truth. Pose graphs of
//! g2o files are synchronised by the program: `gmpcr sync GRAPH.g2o`.

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use gmpcr_eval::{Gauge, PoseError, absolute_errors};
use gmpcr_examples::report;
use gmpcr_posegraph::{PoseEdge, PoseGraph};
use gmpcr_sim::{PoseGraphSimParams, SimulatedEdge, simulate_pose_graph};
use gmpcr_sync::{Method, SyncParams, synchronize};

#[derive(Parser)]
#[command(about = "Synchronises simulated relative poses")]
struct Arguments {
    /// Number of scans.
    #[arg(long, default_value_t = 100)]
    scans: usize,
    /// Share of the relative poses that are wrong.
    #[arg(long, default_value_t = 0.2)]
    outliers: f64,
    /// adaptive (the paper), no-recovery, sghr, memoryless, eigse3, l1, l1-irls, rotavg-lhalf,
    /// hara or consensus.
    #[arg(long, default_value = "adaptive")]
    method: Method,
    /// Reweighting iterations; 0 trusts all edges alike.
    #[arg(long, default_value_t = 10)]
    iterations: usize,
    /// Seed of the simulation.
    #[arg(long, default_value_t = 7)]
    seed: u64,
}

fn main() -> ExitCode {
    report(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let simulated = simulate_pose_graph(&PoseGraphSimParams {
        seed: arguments.seed,
        num_scans: arguments.scans,
        outlier_ratio: arguments.outliers,
        ..PoseGraphSimParams::default()
    })?;
    let edge = |edge: &SimulatedEdge| PoseEdge {
        i: edge.i,
        j: edge.j,
        i_from_j: edge.i_from_j,
        weight: edge.weight,
    };
    let edges = simulated.edges.iter().map(edge).collect();
    let graph = PoseGraph::new(arguments.scans, edges)?;
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

    let truth = &simulated.world_from_scan;
    let errors = absolute_errors(&result.world_from_scan, truth, Gauge::LeastAbsolute)?;
    let mean =
        |error: fn(&PoseError) -> f64| errors.iter().map(error).sum::<f64>() / errors.len() as f64;
    println!(
        "mean rotation error     {:.2}°",
        mean(PoseError::rotation_degrees)
    );
    println!(
        "mean translation error  {:.3}",
        mean(|error| error.translation)
    );
    let reports = result.edges.iter().zip(&simulated.edges);
    let distrusted =
        reports.filter(|(report, _)| report.final_weight < 0.1 * report.initial_weight);
    let wrong = distrusted.clone().filter(|(_, edge)| !edge.is_inlier);
    println!(
        "edges that lost nine tenths of their weight: {}, of which {} are wrong",
        distrusted.count(),
        wrong.count()
    );
    Ok(())
}
