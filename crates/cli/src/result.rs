//! `result.json`: everything that a registration has found, for programs.

use std::path::{Path, PathBuf};

use gmpcr::Registration;
use gmpcr::geometry::{isometry, nearest_rotation};
use gmpcr::nalgebra::{Isometry3, Matrix3, Vector3};
use gmpcr::posegraph::PairConfidences;
use serde::{Deserialize, Serialize};

use crate::attention::Notice;
use crate::config::Config;
use crate::described::DescribedScans;
use crate::georeference::FileFrames;
use crate::outcome::Failure;

const FORMAT: u32 = 1;

/// The content of the file. Motions are the 12 numbers of `[R | t]`, row by row.
#[derive(Serialize, Deserialize)]
pub struct ResultFile {
    /// Form of this file: 1.
    pub format: u32,
    /// Version of the program that wrote it.
    pub version: String,
    /// All parameters by name; lengths in working voxels.
    pub parameters: serde_json::Value,
    /// The working voxel in the unit of the scans.
    pub voxel: f64,
    pub voxel_is_estimated: bool,
    /// Lengths that follow from the voxel, in the unit of the scans.
    pub lengths: Lengths,
    pub features: String,
    pub scans: Vec<ScanResult>,
    /// The scans of each frame; that of the largest is the one of the other files.
    pub components: Vec<Vec<usize>>,
    pub edges: Vec<EdgeResult>,
    /// Selected pairs without a motion.
    pub unresolved: Vec<UnresolvedResult>,
    /// Normalised confidences of all pairs: (0, 1), (0, 2), …, (1, 2), …; zero for those that retrieval
    /// left out.
    pub confidences: Vec<f64>,
    /// The same before they were divided by their norm.
    pub raw_confidences: Vec<f64>,
    /// How the synchronisation of each component went.
    pub synchronization: Vec<SynchronizationResult>,
    pub notices: Vec<Notice>,
    /// Wall time of each stage.
    pub stages: Vec<StageResult>,
}

#[derive(Serialize, Deserialize)]
pub struct Lengths {
    pub normal_radius: f64,
    pub descriptor_radius: f64,
    pub tolerance: f64,
    pub inlier_threshold: f64,
}

#[derive(Serialize, Deserialize)]
pub struct SynchronizationResult {
    pub iterations: usize,
    /// Largest residual of the eigenvectors.
    pub eigen_residual: f64,
    /// Below about 1e-6 reweighting has split the component in all but name.
    pub weakest_block: f64,
    /// Residual of the least squares that positions come from.
    pub position_residual: f64,
}

#[derive(Serialize, Deserialize)]
pub struct ScanResult {
    pub name: String,
    pub file: PathBuf,
    pub component: usize,
    /// From the scan's coordinates to those of the first scan of its component.
    pub world_from_scan: [f64; 12],
    /// Where coordinates were counted from meanwhile; zero, but for georeferenced scans.
    pub origin: [f64; 3],
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
            file: cloud.file.clone(),
            component: registration.components.label(k),
            world_from_scan: rows(&frames.world_from_scan[k]),
            origin: cloud.origin.into(),
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
        let (features, params) = (
            config.features(input.voxel.size),
            config.params(input.voxel.size),
        );
        let reports = registration.synchronization.iter();
        let confidences = &registration.confidences;
        let raw_confidences = confidences.pairs().iter().map(|pair| pair.raw_confidence);
        let raw_confidences: Vec<f64> = raw_confidences.collect();
        Self {
            format: FORMAT,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            parameters: config.to_json(),
            voxel: input.voxel.size,
            voxel_is_estimated: input.voxel.is_estimated,
            lengths: Lengths {
                normal_radius: features.normals.radius,
                descriptor_radius: features.fpfh.radius,
                tolerance: params.compatibility.tolerance,
                inlier_threshold: params.cliques.inlier_threshold,
            },
            features: input.features.to_owned(),
            scans: scans.collect(),
            components: registration.components.members().to_vec(),
            edges: edges(registration, frames),
            unresolved: unresolved.collect(),
            confidences: of_all_pairs(confidences, confidences.normalized()),
            raw_confidences: of_all_pairs(confidences, &raw_confidences),
            synchronization: reports
                .map(|report| SynchronizationResult {
                    iterations: report.iterations.len(),
                    eigen_residual: report.eigen_residual,
                    weakest_block: report.weakest_block,
                    position_residual: report.position_residual,
                })
                .collect(),
            notices,
            stages: stages(input, registration),
        }
    }

    pub fn read(path: &Path) -> Result<Self, Failure> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| format!("cannot read {}: {error}", path.display()))?;
        let result: Self = serde_json::from_str(&text).map_err(|error| {
            let reason = format!("no result.json of this version of gmpcr register: {error}");
            Failure::of(path, reason)
        })?;
        match result.problem() {
            Some(reason) => Err(Failure::of(path, reason)),
            None => Ok(result),
        }
    }

    /// What a file that was changed by hand contradicts itself in.
    fn problem(&self) -> Option<String> {
        if self.format != FORMAT {
            return Some(format!(
                "the form of the file is {}, known is {FORMAT}",
                self.format
            ));
        }
        let mut labels = vec![None; self.scans.len()];
        for (label, scans) in self.components.iter().enumerate() {
            for &scan in scans {
                match labels.get_mut(scan) {
                    Some(place) => *place = Some(label),
                    None => {
                        return Some(format!(
                            "component {label} names a scan {scan}, which is not there"
                        ));
                    }
                }
            }
        }
        let labels_agree = self
            .scans
            .iter()
            .zip(&labels)
            .all(|(scan, label)| *label == Some(scan.component));
        if !labels_agree {
            return Some("the components do not fit the scans".into());
        }
        let bent = self
            .scans
            .iter()
            .position(|scan| !is_rigid(&scan.world_from_scan))?;
        Some(format!("the pose of scan {bent} is no rigid motion"))
    }

    /// The label of the largest component, the first of equal ones.
    pub fn largest_component(&self) -> usize {
        let components = self.components.iter().enumerate().rev();
        components
            .max_by_key(|(_, scans)| scans.len())
            .map_or(0, |(label, _)| label)
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

/// Whether the numbers are a rotation, up to rounding, and a translation.
fn is_rigid(rows: &[f64; 12]) -> bool {
    let rotation = Matrix3::from_fn(|row, column| rows[4 * row + column]);
    let bend = (rotation.transpose() * rotation - Matrix3::identity())
        .abs()
        .max();
    rows.iter().all(|number| number.is_finite()) && bend < 1e-6 && rotation.determinant() > 0.0
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
/// Values of scored pairs among all pairs (0, 1), (0, 2), …, (1, 2), …
fn of_all_pairs(scored: &PairConfidences, values: &[f64]) -> Vec<f64> {
    let n = scored.num_scans();
    let mut all = vec![0.0; n * (n - 1) / 2];
    for (pair, &value) in scored.pairs().iter().zip(values) {
        let before_row = pair.i * (2 * n - pair.i - 1) / 2;
        all[before_row + pair.j - pair.i - 1] = value;
    }
    all
}

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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail")]

    use gmpcr::posegraph::ScoredPair;

    use super::*;

    #[test]
    fn scored_pairs_stand_where_they_belong_among_all() {
        let scored = [(0, 2, 1.0), (1, 3, 2.0), (2, 3, 4.0)];
        let scored = scored.map(|(i, j, raw_confidence)| ScoredPair {
            i,
            j,
            raw_confidence,
        });
        let scored = PairConfidences::new(4, scored.to_vec()).unwrap();
        let all = of_all_pairs(&scored, &[1.0, 2.0, 4.0]);
        assert_eq!(all, [0.0, 1.0, 0.0, 0.0, 2.0, 4.0]);
    }
}
