use nalgebra::Isometry3;

use crate::surface::Surface;
use crate::{Error, check};

/// A surface and its pose in a frame that it shares with others.
#[derive(Clone, Copy, Debug)]
pub struct PosedSurface<'a> {
    /// The surface, in the frame of its scan.
    pub surface: &'a Surface,
    /// The transformation from the scan's frame into the shared one.
    pub frame_from_scan: Isometry3<f64>,
}

impl<'a> PosedSurface<'a> {
    /// A surface and its pose.
    pub fn new(surface: &'a Surface, frame_from_scan: Isometry3<f64>) -> Self {
        Self {
            surface,
            frame_from_scan,
        }
    }
}

pub(crate) fn check_poses(scans: &[PosedSurface]) -> Result<(), Error> {
    check::transformations(scans.iter().map(|scan| &scan.frame_from_scan))
}

/// The largest voxel size of some surfaces; 0 if there are none.
pub(crate) fn largest_voxel(scans: &[PosedSurface]) -> f64 {
    let sizes = scans.iter().map(|scan| scan.surface.voxel_size());
    sizes.fold(0.0, f64::max)
}

/// Whether the bounding spheres of two surfaces meet. An empty surface meets none.
pub(crate) fn spheres_meet(i: &Surface, j: &Surface, i_from_j: &Isometry3<f64>) -> bool {
    let reach = i.radius() + j.radius() + i.voxel_size() + j.voxel_size();
    let distance = (i.center() - i_from_j * j.center()).norm();
    !i.is_empty() && !j.is_empty() && distance < reach
}
