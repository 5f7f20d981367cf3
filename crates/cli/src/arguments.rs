//! What can be said on the command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;
use gmpcr::Preset;
use gmpcr::sync::Method;

/// Registers overlapping point clouds: one globally consistent pose per scan, also at low overlap.
#[derive(Parser)]
#[command(
    name = "gmpcr",
    version,
    max_term_width = 100,
    after_help = "Exit codes: 0 all scans share one frame; 2 some do not, the result is written all the \
                  same;\n1 error; 130 interrupted. RAYON_NUM_THREADS limits the threads.\n\n\
                  Example: gmpcr register scans/ -o out/"
)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
    #[command(flatten)]
    pub verbosity: Verbosity,
}

#[derive(Args, Clone, Copy)]
pub struct Verbosity {
    /// Print errors only.
    #[arg(short, long, global = true, conflicts_with_all = ["verbose", "json"])]
    pub quiet: bool,
    /// Print more: every scan, every edge.
    #[arg(short, long, global = true, conflicts_with = "json")]
    pub verbose: bool,
    /// Print the result as JSON, for scripts.
    #[arg(long, global = true)]
    pub json: bool,
}

#[derive(Subcommand)]
pub enum Command {
    /// Register scans and write poses, pose graph, merged cloud and report.
    Register(RegisterArguments),
    /// Find the transformation between two scans, and its support.
    Pair(PairArguments),
    /// Synchronize the relative poses of a g2o file.
    Sync(SyncArguments),
    /// Print points, extent, resolution and overlap of scans.
    Info(InfoArguments),
    /// Compare a result with the ground truth.
    Eval(EvalArguments),
    /// Print all parameters, with comments, for --config.
    Params(ParamsArguments),
    /// Print the completions of a shell.
    #[command(
        after_help = "Example: gmpcr completions bash > ~/.local/share/bash-completion/completions/gmpcr"
    )]
    Completions {
        /// The shell.
        shell: Shell,
    },
}

#[derive(Args)]
#[command(after_help = "Example: gmpcr register scans/ -o out/ --preset threedlomatch")]
pub struct RegisterArguments {
    /// A folder of scans, or files: PLY, PCD, XYZ/CSV, NPY/NPZ, LAS/LAZ, E57.
    #[arg(required_unless_present = "descriptors", value_name = "FOLDER|FILE")]
    pub inputs: Vec<PathBuf>,
    /// Where to write the results.
    #[arg(short, long, default_value = "out", value_name = "DIR")]
    pub out: PathBuf,
    /// Folder of <name>.kpts.npy (n×3) and <name>.desc.npy (n×d) of the scans, instead of FPFH.
    #[arg(long, value_name = "DIR")]
    pub descriptors: Option<PathBuf>,
    #[command(flatten)]
    pub tuning: Tuning,
    /// Keep one point per voxel of each scan in merged.ply; without SIZE, of the voxel size of the features.
    #[arg(long, value_name = "SIZE", num_args = 0..=1, require_equals = true, value_parser = positive)]
    pub downsample: Option<Option<f64>>,
}

#[derive(Args)]
#[command(after_help = "Example: gmpcr pair hall.ply stairs.ply --json")]
pub struct PairArguments {
    /// The scan into whose frame the transformation maps.
    #[arg(value_name = "A")]
    pub target: PathBuf,
    /// The scan from whose frame the transformation maps.
    #[arg(value_name = "B")]
    pub source: PathBuf,
    #[command(flatten)]
    pub tuning: Tuning,
}

#[derive(Args)]
#[command(after_help = "Example: gmpcr sync sphere.g2o -o solved.g2o --method consensus")]
pub struct SyncArguments {
    /// Pose graph with EDGE_SE3:QUAT records.
    #[arg(value_name = "GRAPH.g2o")]
    pub graph: PathBuf,
    /// Where to write the graph with the resulting poses.
    #[arg(short, long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// adaptive (the paper's), no-recovery, sghr, memoryless, eigse3, l1, l1-irls, rotavg-lhalf,
    /// hara or consensus.
    #[arg(long, default_value = "adaptive")]
    pub method: Method,
    /// Reweighting iterations, up to 100000; 0 trusts all edges alike.
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u32).range(..=100_000))]
    pub iterations: u32,
}

#[derive(Args)]
#[command(after_help = "Example: gmpcr info scans/")]
pub struct InfoArguments {
    /// A folder of scans, or files.
    #[arg(required = true, value_name = "FOLDER|FILE")]
    pub inputs: Vec<PathBuf>,
    #[command(flatten)]
    pub tuning: Tuning,
}

#[derive(Args)]
#[command(after_help = "Example: gmpcr eval out/result.json scene/gt.log")]
pub struct EvalArguments {
    /// result.json of a registration.
    pub result: PathBuf,
    /// The ground truth: pairs of the 3DMatch benchmark (gt.log, with gt.info beside it for the recall);
    /// absolute poses as TUM, KITTI or rows of 3×4 matrices; or the folder of a benchmark's scene.
    #[arg(value_name = "GROUND_TRUTH")]
    pub ground_truth: PathBuf,
    /// Largest rotation error of a registered pair, in degrees.
    #[arg(long, value_name = "DEGREES", default_value_t = 15.0, value_parser = positive)]
    pub max_rotation: f64,
    /// Largest translation error of a registered pair, in the unit of the scans. The default is meant for
    /// rooms in meters.
    #[arg(long, value_name = "LENGTH", default_value_t = 0.3, value_parser = positive)]
    pub max_translation: f64,
}

#[derive(Args)]
#[command(after_help = "Example: gmpcr params --preset eth > params.toml")]
pub struct ParamsArguments {
    #[command(flatten)]
    pub tuning: Tuning,
}

/// Parameters: a preset, then the file, then single ones.
#[derive(Args)]
pub struct Tuning {
    /// Parameters of the paper for one of its datasets: threedmatch (indoor fragments), threedlomatch (of
    /// little overlap), scannet (RGB-D sequences) or eth (outdoor laser scans).
    #[arg(long, default_value = "threedmatch")]
    pub preset: Preset,
    /// Voxel size in the unit of the scans, instead of the estimated one. All lengths follow it.
    #[arg(long, value_name = "SIZE", value_parser = positive, allow_hyphen_values = true)]
    pub voxel: Option<f64>,
    /// File of parameters, as of `gmpcr params`.
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// A single parameter, such as posegraph.neighbors=8; see `gmpcr params`. May be repeated.
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("a positive number is needed".into()),
    }
}
