use gmpcr_cliques::PoseEstimate;
use gmpcr_posegraph::PoseEdge;
use gmpcr_sync::EdgeReport;
use nalgebra::Isometry3;

use crate::selected_pair::SelectedPair;

/// An edge of the pose graph: the relative pose of two scans, its support, and what became of it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Edge {
    /// Position of the scan into whose frame the relative pose maps.
    pub i: usize,
    /// Position of the scan from whose frame the relative pose maps; `i < j`.
    pub j: usize,
    /// The measured relative pose `T̂_ij`, from scan j's frame into scan i's.
    #[cfg_attr(feature = "serde", serde(with = "gmpcr_geometry::matrix_rows"))]
    pub i_from_j: Isometry3<f64>,
    /// Normalized confidence `s_ij`.
    pub confidence: f64,
    /// Correspondences of the pair before spectral filtering; at most `N_o` where they come from descriptors.
    pub num_correspondences: usize,
    /// How many of them the spectral filter retained.
    pub num_retained: usize,
    /// Ratio of the retained correspondences that the relative pose explains.
    pub inlier_ratio: f64,
    /// Nodes of the clique that generated the relative pose.
    pub clique_size: usize,
    /// Its mean second-order affinity.
    pub mean_affinity: f64,
    /// Maximal cliques that were seen.
    pub cliques_seen: usize,
    /// Whether the work budget ended the enumeration early.
    pub budget_exhausted: bool,
    /// Weights and residuals. The initial weight is `w⁰ = s_ij · IR`.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub synchronization: EdgeReport,
}

impl Edge {
    pub(crate) fn new(selected: &SelectedPair, synchronization: EdgeReport) -> Option<Self> {
        let PoseEdge { i, j, i_from_j, .. } = selected.edge()?;
        let PoseEstimate {
            pose,
            cliques_seen,
            budget_exhausted,
            ..
        } = &selected.pair.estimate;
        let pose = pose.as_ref()?;
        Some(Self {
            i,
            j,
            i_from_j,
            confidence: selected.confidence,
            num_correspondences: selected.pair.num_correspondences,
            num_retained: selected.pair.num_retained,
            inlier_ratio: pose.inlier_ratio,
            clique_size: pose.clique.nodes.len(),
            mean_affinity: pose.clique.mean_affinity,
            cliques_seen: *cliques_seen,
            budget_exhausted: *budget_exhausted,
            synchronization,
        })
    }

    /// The edge with its initial weight: what was synchronized.
    pub(crate) fn pose_edge(&self) -> PoseEdge {
        PoseEdge {
            i: self.i,
            j: self.j,
            i_from_j: self.i_from_j,
            weight: self.synchronization.initial_weight,
        }
    }

    /// Whether the edge kept a tenth of its weight.
    pub fn is_trusted(&self) -> bool {
        let EdgeReport {
            initial_weight,
            final_weight,
            ..
        } = self.synchronization;
        final_weight > 0.0 && final_weight >= 0.1 * initial_weight
    }
}

/// A selected pair without a relative pose: no maximal clique of three correspondences determines one that
/// at least one correspondence supports.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct UnresolvedPair {
    /// The lower position.
    pub i: usize,
    /// The higher position.
    pub j: usize,
    /// Normalized confidence `s_ij`.
    pub confidence: f64,
    /// Maximal cliques that were seen, all of them degenerate or without support.
    pub cliques_seen: usize,
    /// Whether the work budget ended the enumeration early.
    pub budget_exhausted: bool,
}

impl UnresolvedPair {
    pub(crate) fn new(selected: &SelectedPair) -> Self {
        Self {
            i: selected.i,
            j: selected.j,
            confidence: selected.confidence,
            cliques_seen: selected.pair.estimate.cliques_seen,
            budget_exhausted: selected.pair.estimate.budget_exhausted,
        }
    }
}
