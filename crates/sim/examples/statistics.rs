//! What simulated scans look like in numbers: points, overlaps, connectivity.
//!
//! `cargo run --release -p gmpcr-sim --example statistics [seed] [scans] [rooms]`

use std::time::Instant;

use gmpcr_sim::{
    Error, RoomParams, Scene, SimParams, SimulatedScans, overlap_components, overlap_matrix,
    simulate, thin,
};

fn main() -> Result<(), Error> {
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
    let solids = Scene::furnished_room(params.seed, &params.room)?
        .primitives()
        .len();
    println!("seed {}: {num_rooms} rooms, {solids} solids", params.seed);

    let start = Instant::now();
    let scans = simulate(&params)?;
    println!("{} scans in {:.2?}", scans.clouds.len(), start.elapsed());
    report_points(&scans);
    report_overlaps(&scans);
    Ok(())
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

/// Counts pairs by the overlap of clouds thinned to 2.5 cm, within 3.75 cm.
fn report_overlaps(scans: &SimulatedScans) {
    let clouds = scans
        .clouds
        .iter()
        .map(|cloud| thin(cloud, 0.025))
        .collect();
    let thinned = SimulatedScans {
        clouds,
        world_from_scan: scans.world_from_scan.clone(),
    };
    let start = Instant::now();
    let overlap = overlap_matrix(&thinned, 0.0375);
    println!("all overlaps in {:.2?}", start.elapsed());

    let size = scans.clouds.len();
    let pairs: Vec<f64> = (0..size)
        .flat_map(|i| (i + 1..size).map(move |j| (i, j)))
        .map(|p| overlap[p])
        .collect();
    let share = |low: f64, high: f64| {
        let count = pairs.iter().filter(|&&x| low <= x && x < high).count();
        format!(
            "{count} ({:.0} %)",
            100.0 * count as f64 / pairs.len().max(1) as f64
        )
    };
    println!("pairs: {}", pairs.len());
    for (low, high) in [
        (0.7, 1.1),
        (0.5, 0.7),
        (0.3, 0.5),
        (0.1, 0.3),
        (0.001, 0.1),
        (0.0, 0.001),
    ] {
        println!("  overlap {low:.3} .. {high:.3}: {}", share(low, high));
    }
    let consecutive: Vec<String> = (1..size)
        .map(|k| format!("{:.0}", 100.0 * overlap[(k - 1, k)]))
        .collect();
    println!("consecutive, in percent: {}", consecutive.join(" "));
    for limit in [0.3, 0.1] {
        let labels = overlap_components(&overlap, limit);
        let count = labels.iter().max().map_or(0, |last| last + 1);
        println!("components at overlap {limit}: {count}");
    }
}
