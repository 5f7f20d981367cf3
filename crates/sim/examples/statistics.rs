//! What simulated scans look like in numbers: points, overlaps, connectivity.
//!
//! `cargo run --release -p gmpcr-sim --example statistics [seed] [scans] [rooms]`

use std::error::Error;
use std::time::Instant;

use gmpcr_eval::overlap_matrix;
use gmpcr_posegraph::Connectivity;
use gmpcr_sim::{RoomParams, SimParams, SimulatedScans, simulate};

fn main() -> Result<(), Box<dyn Error>> {
    let argument = |k: usize| std::env::args().nth(k).and_then(|text| text.parse().ok());
    let default = SimParams::default();
    let num_rooms = argument(3).unwrap_or(default.room.num_rooms);
    let params = SimParams {
        seed: argument(1).map_or(default.seed, |seed| seed as u64),
        num_scans: argument(2).unwrap_or(default.num_scans),
        room: RoomParams {
            num_rooms,
            ..default.room
        },
        ..default
    };
    println!("seed {}: {num_rooms} rooms", params.seed);

    let start = Instant::now();
    let scans = simulate(&params)?;
    println!("{} scans in {:.2?}", scans.clouds.len(), start.elapsed());
    report_points(&scans);
    report_overlaps(&scans, 1.5 * params.voxel)
}

fn report_points(scans: &SimulatedScans) {
    let mut sizes: Vec<usize> = scans.clouds.iter().map(Vec::len).collect();
    sizes.sort_unstable();
    let last = sizes.len() - 1;
    println!(
        "points per scan: {} .. {} .. {}",
        sizes[0],
        sizes[last / 2],
        sizes[last]
    );
}

/// Counts pairs by their overlap within a radius.
fn report_overlaps(scans: &SimulatedScans, radius: f64) -> Result<(), Box<dyn Error>> {
    let start = Instant::now();
    let overlap = overlap_matrix(&scans.clouds, &scans.world_from_scan, radius)?;
    println!("all overlaps in {:.2?}", start.elapsed());

    let size = scans.clouds.len();
    let pairs = || (0..size).flat_map(|i| (i + 1..size).map(move |j| (i, j)));
    let num_pairs = pairs().count();
    let counted = |low: f64, high: f64| {
        let is_within = |pair: &(usize, usize)| low <= overlap[*pair] && overlap[*pair] < high;
        let count = pairs().filter(is_within).count();
        let percent = 100.0 * count as f64 / num_pairs.max(1) as f64;
        format!("{count} ({percent:.0} %)")
    };
    println!("pairs: {}", num_pairs);
    for (low, high) in [
        (0.7, 1.1),
        (0.5, 0.7),
        (0.3, 0.5),
        (0.1, 0.3),
        (0.001, 0.1),
        (0.0, 0.001),
    ] {
        println!("  overlap {low:.3} .. {high:.3}: {}", counted(low, high));
    }
    let consecutive: Vec<String> = (1..size)
        .map(|k| format!("{:.0}", 100.0 * overlap[(k - 1, k)]))
        .collect();
    println!("consecutive, in percent: {}", consecutive.join(" "));
    for limit in [0.3, 0.1] {
        let edges: Vec<_> = pairs().filter(|&pair| overlap[pair] >= limit).collect();
        let count = Connectivity::new(size, &edges, 0).num_components;
        println!("components at overlap {limit}: {count}");
    }
    Ok(())
}
