use gmpcr_cliques::PoseEstimate;
use gmpcr_geometry::is_usable;
use gmpcr_posegraph::PoseEdge;

use crate::known_pairs::EstimatedPair;

/// A pair that the selection chose.
pub(crate) struct SelectedPair {
    pub i: usize,
    pub j: usize,
    /// Normalized confidence `s_ij`.
    pub confidence: f64,
    pub pair: EstimatedPair,
}

impl SelectedPair {
    /// The edge of the pose graph, with weight `w⁰ = s_ij · IR`; `None` if no transformation explains a
    /// correspondence, or it leads beyond all coordinates.
    pub fn edge(&self) -> Option<PoseEdge> {
        let PoseEstimate { pose, .. } = &self.pair.estimate;
        let pose = pose.as_ref().filter(|pose| pose.inlier_ratio > 0.0)?;
        let i_from_j = pose.target_from_source;
        is_usable(&i_from_j.translation.vector).then_some(PoseEdge {
            i: self.i,
            j: self.j,
            i_from_j,
            weight: self.confidence * pose.inlier_ratio,
        })
    }
}
