use gmpcr_geometry::angular_distance;
use gmpcr_posegraph::{PoseEdge, PoseGraph};
use nalgebra::Isometry3;

/// How far the relative pose of an edge is from that of the poses of its scans.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct EdgeResidual {
    /// Angle between the two relative rotations, `d_R(R_iᵀ R_j, R̂_ij)`, in radians.
    pub rotation: f64,
    /// Distance between the two relative translations, in the unit of the input.
    pub translation: f64,
}

/// Residuals of the edges of a graph under given poses, one per edge.
///
/// They have a meaning where the poses of both scans of the edge are in one frame.
///
/// # Panics
/// If there is not one pose per scan.
///
/// ```
/// use gmpcr_posegraph::{PoseEdge, PoseGraph};
/// use gmpcr_sync::edge_residuals;
/// use nalgebra::{Isometry3, Vector3};
///
/// let step = Isometry3::new(Vector3::x(), Vector3::z() * 0.2);
/// let graph = PoseGraph::new(2, vec![PoseEdge { i: 0, j: 1, i_from_j: step, weight: 1.0 }])?;
/// let residuals = edge_residuals(&graph, &[Isometry3::identity(); 2]);
/// assert!((residuals[0].rotation - 0.2).abs() < 1e-12);
/// assert_eq!(residuals[0].translation, 1.0);
/// # Ok::<(), gmpcr_posegraph::PoseGraphError>(())
/// ```
pub fn edge_residuals(graph: &PoseGraph, world_from_scan: &[Isometry3<f64>]) -> Vec<EdgeResidual> {
    assert_eq!(
        world_from_scan.len(),
        graph.num_scans(),
        "one pose per scan"
    );
    let residual = |edge: &PoseEdge| {
        let estimated = world_from_scan[edge.i].inv_mul(&world_from_scan[edge.j]);
        let [a, b] = [&edge.i_from_j, &estimated].map(|pose| pose.rotation.to_rotation_matrix());
        let offset = edge.i_from_j.translation.vector - estimated.translation.vector;
        EdgeResidual {
            rotation: angular_distance(&a, &b),
            translation: offset.norm(),
        }
    };
    graph.edges().iter().map(residual).collect()
}
