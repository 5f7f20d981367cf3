//! Registers two scans, with three of the crates and nothing else: correspondences, compatibility,
//! cliques.
//!
//! ```text
//! cargo run --release --example pairwise                 # two simulated scans
//! cargo run --release --example pairwise -- A.ply B.ply  # two files, 5 cm voxels
//! ```

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use gmpcr_cliques::{CliqueParams, Compatibility, estimate_pose};
use gmpcr_compatibility::{CompatibilityParams, SpectralFilter};
use gmpcr_correspondence::{CorrespondenceParams, Descriptors, Keypoints, Scan, correspondences};
use gmpcr_examples::{positive, report};
use gmpcr_features::{FeatureParams, describe};
use gmpcr_io::read_points;
use gmpcr_sim::{SimParams, simulate};
use nalgebra::Point3;

#[derive(Parser)]
#[command(about = "Registers two scans; simulates them where no files are given")]
struct Arguments {
    /// Two .ply or .pcd files.
    #[arg(num_args = 2)]
    files: Vec<PathBuf>,
    /// Voxel size in the unit of the scans.
    #[arg(long, default_value_t = 0.05, value_parser = positive, allow_hyphen_values = true)]
    voxel: f64,
}

fn main() -> ExitCode {
    report(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let clouds = read_or_simulate(&arguments.files)?;
    let tolerance = 2.0 * arguments.voxel;
    let sampling = CorrespondenceParams::default();

    // Describe and thin each scan.
    let mut keypoints = Vec::new();
    for cloud in &clouds {
        let scan = describe_cloud(cloud, arguments.voxel)?;
        keypoints.push(Keypoints::sample(&scan, sampling.num_samples));
    }

    // Match, and keep the correspondences that agree with each other.
    let pairs = correspondences(&keypoints[0], &keypoints[1], sampling.max_correspondences)?;
    let params = CompatibilityParams {
        tolerance,
        ..CompatibilityParams::default()
    };
    let filter = SpectralFilter::new(&pairs, &params);
    println!(
        "correspondences  {:>4}, retained {}",
        pairs.len(),
        filter.retained.len()
    );
    println!("raw confidence   {:>7.2}", filter.raw_confidence());

    // Turn cliques of them into motions, and choose the best supported one.
    let compatibility = Compatibility {
        fcg: filter.graph.fcg(),
        scg: filter.graph.scg(),
        response: &filter.dominant.vector,
    };
    let params = CliqueParams {
        inlier_threshold: tolerance,
        ..CliqueParams::default()
    };
    let estimate = estimate_pose(&pairs.select(&filter.retained), compatibility, &params);
    let Some(pose) = estimate.pose else {
        println!("no motion: the scans do not overlap, or the descriptors do not match");
        return Ok(());
    };
    println!(
        "maximal cliques  {:>4}, inlier ratio {:.2}",
        estimate.cliques_seen, pose.inlier_ratio
    );
    println!("motion of the second scan into the frame of the first:");
    println!("{:.4}", pose.target_from_source.to_matrix());
    Ok(())
}

fn describe_cloud(cloud: &[Point3<f64>], voxel: f64) -> Result<Scan, Box<dyn Error>> {
    let described = describe(cloud, &FeatureParams::from_voxel_size(voxel))?;
    let rows = described.descriptors.into_flattened();
    let descriptors = Descriptors::new(rows, gmpcr_features::FPFH_DIMENSION)?;
    Ok(Scan::new(described.points, descriptors)?)
}

fn read_or_simulate(files: &[PathBuf]) -> Result<Vec<Vec<Point3<f64>>>, Box<dyn Error>> {
    if files.is_empty() {
        let scans = simulate(&SimParams {
            num_scans: 2,
            ..SimParams::default()
        })?;
        let truth = scans.world_from_scan[0].inv_mul(&scans.world_from_scan[1]);
        println!("true motion of the second scan into the frame of the first:");
        println!("{:.4}", truth.to_matrix());
        return Ok(scans.clouds);
    }
    let mut clouds = Vec::new();
    for file in files {
        clouds.push(read_points(file)?.points);
    }
    Ok(clouds)
}
