//! Estimated poses of all scans, and which of them share a frame.

use nalgebra::Isometry3;

use crate::error::{Error, check_length};

/// The outcome of a multiview registration: a pose per scan, and a label per scan that says
/// which scans are connected.
///
/// Scans with different labels, or without a pose, have no relative pose.
///
/// ```
/// use gmpcr_eval::WorldPoses;
/// use nalgebra::Isometry3;
///
/// let pose = |x| Some(Isometry3::translation(x, 0.0, 0.0));
/// let poses = WorldPoses::new(vec![pose(0.0), pose(2.0), pose(5.0), None], vec![0, 0, 1, 0])?;
/// assert_eq!(poses.i_from_j(0, 1), pose(2.0));
/// assert_eq!(poses.i_from_j(0, 2), None);
/// assert_eq!(poses.i_from_j(0, 3), None);
/// # Ok::<(), gmpcr_eval::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "Unchecked")
)]
pub struct WorldPoses {
    world_from_scan: Vec<Option<Isometry3<f64>>>,
    component: Vec<usize>,
}

/// The fields before their lengths are compared.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
struct Unchecked {
    world_from_scan: Vec<Option<Isometry3<f64>>>,
    component: Vec<usize>,
}

#[cfg(feature = "serde")]
impl TryFrom<Unchecked> for WorldPoses {
    type Error = Error;

    fn try_from(file: Unchecked) -> Result<Self, Error> {
        Self::new(file.world_from_scan, file.component)
    }
}

impl WorldPoses {
    /// Poses with a component label per scan.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if the lists differ in length.
    pub fn new(
        world_from_scan: Vec<Option<Isometry3<f64>>>,
        component: Vec<usize>,
    ) -> Result<Self, Error> {
        check_length("component labels", world_from_scan.len(), component.len())?;
        Ok(Self {
            world_from_scan,
            component,
        })
    }

    /// Poses that all share one frame.
    #[must_use]
    pub fn of_one_frame(world_from_scan: &[Isometry3<f64>]) -> Self {
        Self {
            world_from_scan: world_from_scan.iter().copied().map(Some).collect(),
            component: vec![0; world_from_scan.len()],
        }
    }

    /// Number of scans, with or without a pose.
    #[must_use]
    pub fn num_scans(&self) -> usize {
        self.world_from_scan.len()
    }

    /// `world_from_i⁻¹ · world_from_j`: maps scan j's coordinates into scan i's frame.
    /// `None` where the two share no frame, lack a pose, or do not exist.
    #[must_use]
    pub fn i_from_j(&self, i: usize, j: usize) -> Option<Isometry3<f64>> {
        if self.component.get(i)? != self.component.get(j)? {
            return None;
        }
        let (world_from_i, world_from_j) = (self.world_from_scan[i]?, self.world_from_scan[j]?);
        Some(world_from_i.inv_mul(&world_from_j))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_different_length_are_refused() {
        let error = WorldPoses::new(vec![None; 3], vec![0; 2]).unwrap_err();
        let expected = Error::LengthMismatch {
            what: "component labels",
            expected: 3,
            found: 2,
        };
        assert_eq!(error, expected);
        assert_eq!(
            error.to_string(),
            "3 component labels are needed, but there are 2"
        );
    }

    #[test]
    fn scans_that_do_not_exist_have_no_relative_pose() {
        let poses = WorldPoses::of_one_frame(&[Isometry3::identity()]);
        assert_eq!(poses.i_from_j(0, 1), None);
    }
}
