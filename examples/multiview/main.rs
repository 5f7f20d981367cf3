//! Registers many scans at once and, where the ground truth is known, says how well.
//!
//! ```text
//! cargo run --release --example multiview                               # simulated scans
//! cargo run --release --example multiview -- FOLDER                     # scans of a folder
//! cargo run --release --example multiview -- FOLDER --descriptors DIR   # learned descriptors
//! ```
//!
//! Prints a summary with the time of each stage, warnings and recalls, and writes the merged cloud and the
//! poses. All other results are those of the program `gmpcr`.

mod ground_truth;
mod input;

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use gmpcr::io::{ColoredCloud, Coordinates, distinct_color, write_merged_ply, write_poses_3x4};
use gmpcr::{Preset, Registration, ScanSet, register};

use ground_truth::print_recalls;
use input::Input;

#[derive(Parser)]
#[command(about = "Registers many scans at once; simulates them where no folder is given")]
struct Arguments {
    /// Folder of scans, each in its own frame, with or without ground truth.
    folder: Option<PathBuf>,
    /// Folder of <name>.kpts.npy (n×3) and <name>.desc.npy (n×d), one pair per scan in the order
    /// of the scans, instead of FPFH.
    #[arg(long, requires = "folder", value_name = "DIR")]
    descriptors: Option<PathBuf>,
    /// Voxel size in the unit of the scans. All other lengths follow from it.
    #[arg(long, default_value_t = 0.05)]
    voxel: f64,
    /// Parameters of the paper for one of its data sets: threedmatch, threedlomatch, scannet or eth.
    #[arg(long, default_value = "threedmatch")]
    preset: Preset,
    /// Number of simulated scans.
    #[arg(long, default_value_t = 24, conflicts_with = "folder")]
    scans: usize,
    /// Number of simulated rooms, joined by doorways.
    #[arg(long, default_value_t = 1, conflicts_with = "folder")]
    rooms: usize,
    /// Seed of the simulation.
    #[arg(long, default_value_t = 7, conflicts_with = "folder")]
    seed: u64,
    /// Where to write merged.ply and poses.txt.
    #[arg(long, default_value = "out", value_name = "DIR")]
    out: PathBuf,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let Input { set, ground_truth } = match &arguments.folder {
        Some(folder) => Input::read(folder, arguments)?,
        None => Input::simulate(arguments)?,
    };
    let params = arguments.preset.params().with_voxel_size(arguments.voxel);
    let registration = set.in_cloud_frames(register(&set.scans, &params)?);
    print_summary(&set, &registration);
    for (scan, problem) in set.problems.iter().enumerate() {
        if let Some(problem) = problem {
            println!("warning: scan {scan} has no features: {problem}");
        }
    }
    for warning in registration.warnings() {
        println!("warning: {warning}");
    }
    if !ground_truth.is_empty() {
        print_recalls(&ground_truth, &registration)?;
    }
    write(&arguments.out, &set, &registration)
}

fn print_summary(set: &ScanSet, registration: &Registration) {
    for (stage, time) in set.times.stages().chain(registration.times.stages()) {
        println!("{stage:<18} {:>7.1} ms", time.as_secs_f64() * 1e3);
    }
    let components = &registration.components;
    println!("\nscans              {:>7}", set.scans.len());
    println!("edges              {:>7}", registration.edges.len());
    println!("components         {:>7}", components.members().len());
    println!("largest component  {:>7} scans", components.largest().len());
}

/// Writes cloud and poses of the largest component, whose scans share a frame.
fn write(folder: &Path, set: &ScanSet, registration: &Registration) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(folder)?;
    let poses = registration.indexed_poses();
    write_poses_3x4(folder.join("poses.txt"), &poses)?;
    let world_from_local = set.world_from_local(registration);
    let merged = poses.iter().map(|&(scan, _)| ColoredCloud {
        points: &set.clouds[scan].points,
        world_from_points: world_from_local[scan],
        color: distinct_color(scan),
    });
    write_merged_ply(folder.join("merged.ply"), Coordinates::Double, merged)?;
    println!("\nmerged.ply and poses.txt are in {}", folder.display());
    Ok(())
}
