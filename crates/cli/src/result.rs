//! `result.json`: everything that a registration has found, for programs.

use std::path::Path;

use gmpcr::Registration;
use gmpcr::geometry::{isometry, nearest_rotation};
use gmpcr::nalgebra::{Isometry3, Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::attention::Notice;
use crate::config::Config;
use crate::described::DescribedScans;
use crate::georeference::FileFrames;
use crate::outcome::Failure;

/// The content of the file. Motions are the 12 numbers of `[R | t]`, row by row.
#[derive(Serialize, Deserialize)]
pub struct ResultFile {
    /// Version of the program that wrote it.
    pub version: String,
    /// All parameters by name; lengths in working voxels.
    pub parameters: serde_json::Value,
    /// The working voxel in the unit of the scans.
    pub voxel: f64,
    pub voxel_is_estimated: bool,
    pub features: String,
    pub scans: Vec<ScanResult>,
    /// The scans of each frame; that of the largest is the one of the other files.
    pub components: Vec<Vec<usize>>,
    pub edges: Vec<EdgeResult>,
    /// Selected pairs without a motion.
    pub unresolved: Vec<UnresolvedResult>,
    /// Normalised confidences of all pairs: (0, 1), (0, 2), …, (1, 2), …
    pub confidences: Vec<f64>,
    pub notices: Vec<Notice>,
    /// Wall time of each stage.
    pub stages: Vec<StageResult>,
}

#[derive(Serialize, Deserialize)]
pub struct ScanResult {
    pub name: String,
    pub component: usize,
    /// From the scan's coordinates to those of the first scan of its component.
    pub world_from_scan: [f64; 12],
    pub points: usize,
    /// Points without a position.
    pub invalid: usize,
    /// Points with a descriptor.
    pub described: usize,
    /// Why it could not be read.
    pub problem: Option<String>,
}

#[derive(Serialize, Deserialize)]
pub struct EdgeResult {
    pub i: usize,
    pub j: usize,
    /// The measured motion, from scan j's coordinates to scan i's.
    pub i_from_j: [f64; 12],
    pub confidence: f64,
    pub inlier_ratio: f64,
    pub correspondences: usize,
    pub clique_size: usize,
    pub mean_affinity: f64,
    pub cliques_seen: usize,
    pub budget_exhausted: bool,
    pub initial_weight: f64,
    pub final_weight: f64,
    /// Between the measured motion and that of the poses, in degrees.
    pub rotation_residual: Option<f64>,
    /// The same, in the unit of the scans.
    pub translation_residual: Option<f64>,
    /// The initial weight, and that after each iteration of reweighting.
    pub weights: Vec<f64>,
}

#[derive(Serialize, Deserialize)]
pub struct UnresolvedResult {
    pub i: usize,
    pub j: usize,
    pub confidence: f64,
    pub cliques_seen: usize,
    pub budget_exhausted: bool,
}

#[derive(Clone, Serialize, Deserialize)]
pub struct StageResult {
    pub name: String,
    pub seconds: f64,
}

impl ResultFile {
    pub fn new(
        input: &DescribedScans,
        config: &Config,
        registration: &Registration,
        frames: &FileFrames,
        notices: Vec<Notice>,
    ) -> Self {
        let scans = input.clouds.iter().zip(&input.scans).enumerate();
        let scans = scans.map(|(k, (cloud, scan))| ScanResult {
            name: cloud.name.clone(),
            component: registration.components.label(k),
            world_from_scan: rows(&frames.world_from_scan[k]),
            points: cloud.points.len(),
            invalid: cloud.invalid,
            described: scan.len(),
            problem: cloud.problem.clone(),
        });
        let unresolved = registration.unresolved.iter().map(|pair| UnresolvedResult {
            i: pair.i,
            j: pair.j,
            confidence: pair.confidence,
            cliques_seen: pair.cliques_seen,
            budget_exhausted: pair.budget_exhausted,
        });
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            parameters: config.to_json(),
            voxel: input.voxel.size,
            voxel_is_estimated: input.voxel.is_estimated,
            features: input.features.to_owned(),
            scans: scans.collect(),
            components: registration.components.members().to_vec(),
            edges: edges(registration, frames),
            unresolved: unresolved.collect(),
            confidences: registration.confidences.normalized().to_vec(),
            notices,
            stages: stages(input, registration),
        }
    }

    pub fn read(path: &Path) -> Result<Self, Failure> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| format!("cannot read {}: {error}", path.display()))?;
        let result: Self = serde_json::from_str(&text).map_err(|error| {
            format!(
                "{} is no result.json of `gmpcr register`: {error}",
                path.display()
            )
        })?;
        let num_scans = result.scans.len();
        let is_sound = result.scans.iter().all(|scan| scan.component < num_scans);
        match is_sound {
            true => Ok(result),
            false => Err(format!("{}: components do not fit the scans", path.display()).into()),
        }
    }

    /// The poses of all scans.
    pub fn world_from_scan(&self) -> Vec<Isometry3<f64>> {
        let poses = self.scans.iter();
        poses.map(|scan| motion(&scan.world_from_scan)).collect()
    }
}

/// The numbers of `[R | t]`, row by row.
pub fn rows(motion: &Isometry3<f64>) -> [f64; 12] {
    let matrix = motion.to_matrix();
    std::array::from_fn(|k| matrix[(k / 4, k % 4)])
}

fn motion(rows: &[f64; 12]) -> Isometry3<f64> {
    let rotation = Matrix3::from_fn(|row, column| rows[4 * row + column]);
    isometry(
        &nearest_rotation(&rotation),
        &Vector3::new(rows[3], rows[7], rows[11]),
    )
}

fn edges(registration: &Registration, frames: &FileFrames) -> Vec<EdgeResult> {
    let weights = weights(registration);
    let evidence = registration
        .evidence
        .iter()
        .zip(&frames.i_from_j)
        .zip(weights);
    let edges = evidence.map(|((edge, i_from_j), weights)| EdgeResult {
        i: edge.i,
        j: edge.j,
        i_from_j: rows(i_from_j),
        confidence: edge.confidence,
        inlier_ratio: edge.inlier_ratio,
        correspondences: edge.num_correspondences,
        clique_size: edge.clique_size,
        mean_affinity: edge.mean_affinity,
        cliques_seen: edge.cliques_seen,
        budget_exhausted: edge.budget_exhausted,
        initial_weight: edge.initial_weight,
        final_weight: edge.final_weight,
        rotation_residual: edge.rotation_residual.map(f64::to_degrees),
        translation_residual: edge.translation_residual,
        weights,
    });
    edges.collect()
}

/// The course of the weight of each edge.
fn weights(registration: &Registration) -> Vec<Vec<f64>> {
    let evidence = registration.evidence.iter();
    let mut weights: Vec<_> = evidence.map(|edge| vec![edge.initial_weight]).collect();
    for report in &registration.synchronization {
        for iteration in &report.iterations {
            for (&edge, &weight) in report.edges.iter().zip(&iteration.update.weights) {
                weights[edge].push(weight);
            }
        }
    }
    weights
}

fn stages(input: &DescribedScans, registration: &Registration) -> Vec<StageResult> {
    let before = input.times.iter().copied();
    let stages = registration.times.stages();
    let stages = stages.iter().map(|&(stage, time)| (stage.name(), time));
    before
        .chain(stages)
        .map(|(name, time)| StageResult {
            name: name.to_owned(),
            seconds: time.as_secs_f64(),
        })
        .collect()
}
