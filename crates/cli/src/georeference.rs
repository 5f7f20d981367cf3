//! Results back in the coordinates of the files.

use gmpcr::Registration;
use gmpcr::nalgebra::Isometry3;

use crate::scans::Cloud;

/// Poses and edges between scans in the coordinates of their files.
///
/// Registration sees each scan less its origin. With `T_k` the shift by the origin of scan k and `r`
/// the scan in whose frame the world is, a pose `W_k` becomes `T_r W_k T_k⁻¹`, a relative pose `E_ij`
/// becomes `T_i E_ij T_j⁻¹`.
pub struct FileFrames {
    pub world_from_scan: Vec<Isometry3<f64>>,
    /// One per edge of the pose graph.
    pub i_from_j: Vec<Isometry3<f64>>,
}

impl FileFrames {
    pub fn of(registration: &Registration, clouds: &[Cloud]) -> Self {
        let poses = registration.world_from_scan.iter().enumerate();
        let world_from_scan = poses.map(|(scan, pose)| {
            let label = registration.components.label(scan);
            let reference = registration.components.members()[label][0];
            between_files(&clouds[reference], pose, &clouds[scan])
        });
        let edges = registration.graph.edges().iter();
        Self {
            world_from_scan: world_from_scan.collect(),
            i_from_j: edges
                .map(|edge| between_files(&clouds[edge.i], &edge.i_from_j, &clouds[edge.j]))
                .collect(),
        }
    }
}

/// A motion from the points of `b` to those of `a`, in the coordinates of their files: `T_a M T_b⁻¹`.
/// Unshifted ones keep their bits.
pub fn between_files(a: &Cloud, motion: &Isometry3<f64>, b: &Cloud) -> Isometry3<f64> {
    a.file_from_points() * motion * b.file_from_points().inverse()
}
