use std::time::Duration;

use gmpcr_posegraph::{Components, Connectivity, PairConfidences, PoseGraph};
use gmpcr_sync::ComponentReport;
use nalgebra::Isometry3;

use crate::Stage;

/// Poses of all scans and the evidence for them.
#[derive(Clone, Debug)]
pub struct Registration {
    /// `T_i`, from each scan's frame into the frame of the lowest scan of its component, which has
    /// the identity. Poses of different components do not compare.
    pub world_from_scan: Vec<Isometry3<f64>>,
    /// Which scans share a frame.
    pub components: Components,
    /// The relative poses that were synchronised.
    pub graph: PoseGraph,
    /// What speaks for and against each edge of `graph`, in its order.
    pub evidence: Vec<EdgeEvidence>,
    /// Pairs that were selected, but whose cliques determine no motion that a match supports.
    pub unresolved: Vec<UnresolvedPair>,
    /// Confidences of the scored pairs: all, or those that were retrieved where there are
    /// [`retrieval.min_scans`](gmpcr_retrieval::RetrievalParams::min_scans) scans or more.
    pub confidences: PairConfidences,
    /// Connectivity of `graph`, the reference being scan 0.
    pub connectivity: Connectivity,
    /// Course of the synchronisation of each component.
    pub synchronization: Vec<ComponentReport>,
    /// Wall time of each stage.
    pub times: StageTimes,
}

impl Registration {
    /// Motion `T_ij = T_i⁻¹ T_j` from scan j's frame into scan i's; `None` if they share no frame.
    ///
    /// # Panics
    /// If a scan does not exist.
    pub fn i_from_j(&self, i: usize, j: usize) -> Option<Isometry3<f64>> {
        let share_frame = self.components.label(i) == self.components.label(j);
        share_frame.then(|| self.world_from_scan[i].inv_mul(&self.world_from_scan[j]))
    }

    /// The same registration with the world of one component in the frame of `reference`, whose pose
    /// becomes the identity; other components stay as they are.
    ///
    /// # Panics
    /// If the scan does not exist.
    pub fn in_frame_of(mut self, reference: usize) -> Self {
        let reference_from_world = self.world_from_scan[reference].inverse();
        for &scan in &self.components.members()[self.components.label(reference)] {
            self.world_from_scan[scan] = reference_from_world * self.world_from_scan[scan];
        }
        self.world_from_scan[reference] = Isometry3::identity();
        self
    }

    /// Whether a scan shares a frame with another one.
    ///
    /// # Panics
    /// If the scan does not exist.
    pub fn is_registered(&self, scan: usize) -> bool {
        self.components.members()[self.components.label(scan)].len() > 1
    }
}

/// What speaks for and against an edge of the pose graph.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeEvidence {
    /// The scan into whose frame the motion maps.
    pub i: usize,
    /// The scan from whose frame the motion maps; `i < j`.
    pub j: usize,
    /// Correspondences of the pair before spectral filtering; at most `N_o`.
    pub num_correspondences: usize,
    /// Normalised confidence `s_ij`.
    pub confidence: f64,
    /// Share of the retained correspondences that the motion explains.
    pub inlier_ratio: f64,
    /// Nodes of the clique that generated the motion.
    pub clique_size: usize,
    /// Its mean second-order affinity.
    pub mean_affinity: f64,
    /// Maximal cliques that were seen.
    pub cliques_seen: usize,
    /// Whether the work budget ended the enumeration early.
    pub budget_exhausted: bool,
    /// Weight `w⁰ = s_ij · IR` before the synchronisation.
    pub initial_weight: f64,
    /// Weight in the final solution.
    pub final_weight: f64,
    /// Angle (radians) between the measured and the final relative rotation; `None` where the edge,
    /// being without weight, joins two components.
    pub rotation_residual: Option<f64>,
    /// Distance between the measured and the final relative translation, in the unit of the points.
    pub translation_residual: Option<f64>,
}

/// A selected pair without a motion: no maximal clique of three correspondences determines one that
/// at least one correspondence supports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnresolvedPair {
    /// The lower scan index.
    pub i: usize,
    /// The higher scan index.
    pub j: usize,
    /// Normalised confidence `s_ij`.
    pub confidence: f64,
    /// Maximal cliques that were seen, all of them degenerate or without support.
    pub cliques_seen: usize,
    /// Whether the work budget ended the enumeration early.
    pub budget_exhausted: bool,
}

/// Wall time of each stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageTimes {
    /// Farthest-point sampling of all scans.
    pub sampling: Duration,
    /// Retrieval, matching and scoring of pairs.
    pub scoring: Duration,
    /// Choice of the edges.
    pub selection: Duration,
    /// Relative poses of the selected pairs.
    pub pose_estimation: Duration,
    /// Synchronisation.
    pub synchronization: Duration,
}

impl StageTimes {
    /// Sum of all stages.
    pub fn total(&self) -> Duration {
        self.stages().iter().map(|(_, time)| *time).sum()
    }

    /// The time of a stage.
    pub fn of(&self, stage: Stage) -> Duration {
        match stage {
            Stage::Sampling => self.sampling,
            Stage::Scoring => self.scoring,
            Stage::Selection => self.selection,
            Stage::PoseEstimation => self.pose_estimation,
            Stage::Synchronization => self.synchronization,
        }
    }

    /// The time of each stage, in order.
    pub fn stages(&self) -> [(Stage, Duration); 5] {
        Stage::ALL.map(|stage| (stage, self.of(stage)))
    }
}
