//! How time and memory grow with the number of scans and poses, on synthetic data: `docs/growth.csv`, and
//! drawn, `docs/growth-registration.svg` and `docs/growth-synchronization.svg`.
//!
//! ```text
//! cargo bench --bench growth                                  # all of it
//! cargo bench --bench growth -- synchronization --up-to 2000  # a part, up to a size
//! cargo bench --bench growth -- --draw                        # the figures again, of what is in the table
//! ```
//!
//! Sizes that are not measured again keep their rows. Every measurement has a process of its own with
//! one thread, which is given the data, so that its peak is that of the measured call.

#![allow(clippy::unwrap_used, missing_docs)]

#[path = "../data/mod.rs"]
mod data;
mod draw;
mod measure;
mod table;

use gmpcr_sim::{PoseGraphSimParams, Topology, simulate_pose_graph};

use measure::{REGISTRATION, SYNCHRONIZATION};
use table::Table;

const NUM_SCANS: [usize; 5] = [30, 60, 100, 200, 400];
const NUM_POSES: [usize; 8] = [60, 500, 1_000, 2_000, 5_000, 10_000, 20_000, 50_000];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [flag, part, what] = arguments.as_slice()
        && flag == measure::FLAG
    {
        return measure::answer(part, what);
    }
    let has = |argument: &str| arguments.iter().any(|other| other == argument);
    let is_wanted = |part| has(part) || !(has(REGISTRATION) || has(SYNCHRONIZATION));
    let limit = arguments.iter().skip_while(|a| *a != "--up-to").nth(1);
    let limit: usize = limit.map_or(usize::MAX, |number| number.parse().unwrap());
    let mut table = Table::read();
    if is_wanted(REGISTRATION) && !has("--draw") {
        for num_scans in NUM_SCANS.into_iter().filter(|size| *size <= limit) {
            register(num_scans, &mut table);
        }
    }
    if is_wanted(SYNCHRONIZATION) && !has("--draw") {
        for num_poses in NUM_POSES.into_iter().filter(|size| *size <= limit) {
            let random = ["consensus joined at random"];
            synchronize(num_poses, Topology::Random, &random, &mut table);
            let geometric = ["consensus", "adaptive"];
            synchronize(num_poses, Topology::Geometric, &geometric, &mut table);
        }
    }
    draw::registration(&table).unwrap();
    draw::synchronization(&table).unwrap();
}

/// The scans of the benchmark `sizes`.
fn register(num_scans: usize, table: &mut Table) {
    let scans = data::scans(num_scans);
    for what in ["retrieval", "exhaustive"] {
        let cells = measure::ask(REGISTRATION, what, measure::scan_numbers(&scans));
        table.insert(REGISTRATION, what, num_scans, cells);
    }
}

/// The pose graphs of the benchmark `sizes`, or such that are joined at random.
fn synchronize(num_scans: usize, topology: Topology, methods: &[&str], table: &mut Table) {
    let simulated = simulate_pose_graph(&PoseGraphSimParams {
        num_scans,
        degree: 8.0,
        outlier_ratio: 0.2,
        topology,
        ..PoseGraphSimParams::default()
    });
    let simulated = simulated.unwrap();
    for what in methods {
        let cells = measure::ask(SYNCHRONIZATION, what, measure::graph_numbers(&simulated));
        table.insert(SYNCHRONIZATION, what, num_scans, cells);
    }
}
