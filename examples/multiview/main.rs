//! Registers many scans at once.
//!
//! ```text
//! cargo run --release --example multiview                         # simulated scans
//! cargo run --release --example multiview -- FOLDER               # PLY or PCD scans of a folder
//! cargo run --release --example multiview -- FOLDER --descriptors DIR   # learned descriptors
//! ```
//!
//! Prints the stage times, the edges and, where the truth is known, recalls and errors; writes the
//! merged cloud and the poses. All results, and other formats, are those of the program `gmpcr`.

mod evaluation;
mod input;
mod output;

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use gmpcr::sync::Method;
use gmpcr::{Params, Preset, Registration, register};
use gmpcr_examples::{positive, report};

use evaluation::print_evaluation;
use input::Input;
use output::write_results;

#[derive(Parser)]
#[command(about = "Registers many scans at once; simulates them where no folder is given")]
struct Arguments {
    /// Folder of .ply or .pcd scans, each in its own frame with the sensor at the origin.
    folder: Option<PathBuf>,
    /// Folder of <name>.kpts.npy (n×3) and <name>.desc.npy (n×d), one pair per scan in the order
    /// of the scans, instead of FPFH.
    #[arg(long, requires = "folder", value_name = "DIR")]
    descriptors: Option<PathBuf>,
    /// Voxel size in the unit of the scans. Radii of normals and FPFH are 2 and 5 voxels, and the
    /// tolerances of compatibility and inliers 2.
    #[arg(long, default_value_t = 0.05, value_parser = positive, allow_hyphen_values = true)]
    voxel: f64,
    /// Parameters of the paper for one of its datasets: threedmatch, threedlomatch, scannet or eth.
    #[arg(long, default_value = "threedmatch")]
    preset: Preset,
    /// Keypoints per scan, instead of the preset's.
    #[arg(long)]
    samples: Option<usize>,
    /// Share of the correspondences that the spectral filter retains, instead of the preset's.
    #[arg(long)]
    retained: Option<f64>,
    /// Neighbours that each scan proposes as edges, instead of the preset's.
    #[arg(long)]
    neighbors: Option<usize>,
    /// How edges are synchronised, instead of the preset's adaptive history: no-recovery, sghr,
    /// memoryless, eigse3, l1, l1-irls, rotavg-lhalf, hara or consensus.
    #[arg(long)]
    method: Option<Method>,
    /// Where to write merged.ply and poses.txt.
    #[arg(long, default_value = "out", value_name = "DIR")]
    out: PathBuf,
    /// Number of simulated scans.
    #[arg(long, default_value_t = 24, conflicts_with = "folder")]
    scans: usize,
    /// Number of simulated rooms, joined by doorways.
    #[arg(long, default_value_t = 1, conflicts_with = "folder")]
    rooms: usize,
    /// Seed of the simulation.
    #[arg(long, default_value_t = 7, conflicts_with = "folder")]
    seed: u64,
}

impl Arguments {
    fn params(&self) -> Params {
        let mut params = self.preset.params().with_tolerance(2.0 * self.voxel);
        if let Some(samples) = self.samples {
            params.correspondence.num_samples = samples;
        }
        if let Some(retained) = self.retained {
            params.compatibility.retained_fraction = retained;
        }
        if let Some(neighbors) = self.neighbors {
            params.posegraph.neighbors = neighbors;
        }
        if let Some(method) = self.method {
            params.sync.method = method;
        }
        params
    }
}

fn main() -> ExitCode {
    report(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let params = arguments.params();
    params.validate()?;
    let input = match &arguments.folder {
        Some(folder) => Input::read(folder, arguments.descriptors.as_deref(), arguments.voxel)?,
        None => Input::simulate(
            arguments.scans,
            arguments.rooms,
            arguments.seed,
            arguments.voxel,
        )?,
    };
    let start = Instant::now();
    let registration = register(&input.scans, &params)?;
    println!("registered in {:.3} s", start.elapsed().as_secs_f64());
    print_summary(&registration);
    let num_written = write_results(&arguments.out, &input.clouds, &registration)?;
    print_evaluation(&input.truth, &registration)?;
    println!(
        "\nwrote merged.ply and poses.txt with the {num_written} scans of the largest component to {}",
        arguments.out.display()
    );
    Ok(())
}

fn print_summary(registration: &Registration) {
    println!("\nstage                   time");
    for (stage, time) in registration.times.stages() {
        println!("{stage:<18} {:>7.1} ms", time.as_secs_f64() * 1e3);
    }
    let num_scans = registration.world_from_scan.len();
    let largest = registration.components.largest().len();
    println!("\nscans              {num_scans:>7}");
    println!(
        "pairs scored       {:>7}",
        registration.confidences.pairs().len()
    );
    println!("edges              {:>7}", registration.evidence.len());
    println!("without a motion   {:>7}", registration.unresolved.len());
    let half_lost = |e: &&gmpcr::EdgeEvidence| e.final_weight < 0.5 * e.initial_weight;
    println!(
        "mostly distrusted  {:>7}",
        registration.evidence.iter().filter(half_lost).count()
    );
    println!(
        "components         {:>7}",
        registration.components.members().len()
    );
    println!("largest component  {:>7} scans", largest);
}
