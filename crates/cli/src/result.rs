//! `result.json`: everything that a registration has found, for programs.

use std::path::PathBuf;

use gmpcr::Registration;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::config::Config;
use crate::input::Input;
use crate::warnings::Finding;

/// The form of the file that this version writes. Form 1, which had a layout of its own, is still read by
/// `gmpcr eval`.
pub const FORMAT: u32 = 2;

/// The content of the file.
#[derive(Serialize, Deserialize)]
pub struct ResultFile {
    /// Form of this file.
    pub format: u32,
    /// Version of the program that wrote it.
    pub version: String,
    /// What was asked for: all parameters by path, lengths in voxels, angles in degrees. Those of the registration
    /// have the unit of the scans.
    pub parameters: Value,
    /// In the unit of the scans.
    pub voxel_size: f64,
    /// Whether it follows from the scans, and not from the parameters.
    pub voxel_is_estimated: bool,
    /// What features the points have, in words.
    pub features: String,
    /// What the files have, in the order of the registration.
    pub scans: Vec<ScanResult>,
    /// The library's result, in the coordinates of the files. The frame of the largest component is that of the
    /// other files.
    pub registration: Registration,
    /// The gravest kind first.
    pub warnings: Vec<Finding>,
    /// Wall time of each stage, reading included.
    pub stages: Vec<StageResult>,
}

#[derive(Serialize, Deserialize)]
pub struct ScanResult {
    pub name: String,
    pub file: PathBuf,
    /// What was subtracted from the coordinates for the computation; zero, but for georeferenced scans.
    pub origin: [f64; 3],
    pub points: usize,
    /// Points without a position.
    pub invalid: usize,
    /// Points with normals and descriptors.
    pub with_features: usize,
    /// Why it could not be read.
    pub problem: Option<String>,
}

#[derive(Clone, Serialize, Deserialize)]
pub struct StageResult {
    pub name: String,
    pub seconds: f64,
}

impl ResultFile {
    /// `registration` is in the coordinates of the files.
    pub fn new(
        input: &Input,
        config: &Config,
        registration: Registration,
        warnings: Vec<Finding>,
    ) -> Self {
        Self {
            format: FORMAT,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            parameters: config.to_json(),
            voxel_size: input.set.voxel_size,
            voxel_is_estimated: input.voxel_is_estimated,
            features: input.features.to_owned(),
            scans: scans(input),
            stages: stages(input, &registration),
            registration,
            warnings,
        }
    }
}

fn scans(input: &Input) -> Vec<ScanResult> {
    let set = &input.set;
    let files = input.files.iter().enumerate();
    files
        .map(|(k, file)| ScanResult {
            name: file.name.clone(),
            file: file.file.clone(),
            origin: set.clouds[k].origin.into(),
            points: set.clouds[k].points.len(),
            invalid: file.invalid,
            with_features: set.scans[k].len(),
            problem: file.problem.clone(),
        })
        .collect()
}

fn stages(input: &Input, registration: &Registration) -> Vec<StageResult> {
    let before = input.times.iter().copied();
    let features = input.set.times.stages();
    let stages = features.chain(registration.times.stages());
    let stages = stages.map(|(stage, time)| (stage.name(), time));
    before
        .chain(stages)
        .map(|(name, time)| StageResult {
            name: name.to_owned(),
            seconds: time.as_secs_f64(),
        })
        .collect()
}
