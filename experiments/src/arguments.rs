//! What the program is asked for.

use std::path::PathBuf;

use clap::Parser;

use crate::experiment::Experiment;

/// Runs the paper's experiments on scenes with known poses.
#[derive(Debug, Parser)]
#[command(version, about)]
pub struct Arguments {
    /// A scene, or a folder of scenes, in the layout of 3DMatch, SGHR/YOHO, ScanNet or ETH. Without
    /// it only the synchronization of simulated pose graphs runs.
    pub folder: Option<PathBuf>,
    /// Folder that has, for each scene, a subfolder of its name with keypoints and descriptors as
    /// .npy. They are used besides FPFH.
    #[arg(long, value_name = "DIR", requires = "folder")]
    pub descriptors: Option<PathBuf>,
    /// Run these experiments only.
    #[arg(long, value_enum, value_delimiter = ',')]
    pub only: Vec<Experiment>,
    /// Run on these scenes only.
    #[arg(long, value_delimiter = ',', value_name = "NAME", requires = "folder")]
    pub scenes: Vec<String>,
    /// Where to write tables, records and figures. What is there from the same settings is kept.
    #[arg(long, default_value = "out/experiments", value_name = "DIR")]
    pub out: PathBuf,
    /// Do everything again, whatever is there.
    #[arg(long)]
    pub fresh: bool,
    /// Runs of each experiment that depends on the sampling start: the first from the paper's sampling start, the
    /// others from seeded random ones.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub runs: u32,
    /// Seed of sampling starts, subsets of scans and simulated pose graphs.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Voxel size for FPFH in meters; tolerances are two voxels.
    #[arg(long, default_value_t = 0.05, value_parser = positive, allow_hyphen_values = true)]
    pub voxel: f64,
    /// Pose graphs (g2o) to synchronize besides the simulated ones; their vertices are the ground truth.
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub graphs: Vec<PathBuf>,
}

impl Arguments {
    /// The experiments that were asked for, in the order of the paper.
    pub fn experiments(&self) -> Vec<Experiment> {
        let is_wanted = |experiment: &Experiment| {
            let is_possible = self.folder.is_some() || !experiment.needs_scenes();
            is_possible && (self.only.is_empty() || self.only.contains(experiment))
        };
        Experiment::ALL.into_iter().filter(is_wanted).collect()
    }

    /// Checks what the parser cannot.
    pub fn check(&self) -> Result<(), String> {
        if !self.graphs.is_empty() && !self.experiments().contains(&Experiment::Sync) {
            return Err("--graphs needs the experiment sync".to_owned());
        }
        match self.descriptors.as_ref().filter(|folder| !folder.is_dir()) {
            Some(folder) => Err(format!("{} is no folder", folder.display())),
            None => Ok(()),
        }
    }

    /// What the records depend on, in words: records of other settings are not reused.
    pub fn settings(&self) -> String {
        format!(
            "gmpcr-experiments {}, {} runs, seed {}, voxel {}",
            env!("CARGO_PKG_VERSION"),
            self.runs,
            self.seed,
            self.voxel
        )
    }
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("must be a positive number".to_owned()),
    }
}
