//! Poses of all scans, by scan.

use std::path::Path;

use nalgebra::Isometry3;

use crate::Error;
use crate::poses::read_known_poses;

/// Reads `world_from_scan` of the scans `0..num_scans`: `None` where the file has no pose of a scan, or
/// says that it is unknown.
///
/// The formats are those of [`read_poses`](crate::read_poses); a matrix without a finite entry is that
/// of a scan of unknown pose. This is the form in which [`read_scene`](crate::read_scene) returns the
/// poses of a scene, [`GroundTruth::world_from_scan`](crate::GroundTruth::world_from_scan).
///
/// # Errors
/// Those of [`read_poses`](crate::read_poses), and [`Error::Malformed`] if there is no pose, if a scan
/// has two, or if one is of a scan outside `0..num_scans`.
///
/// # Example
/// ```
/// use gmpcr_io::{read_world_poses, write_poses_3x4};
/// use nalgebra::Isometry3;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("poses.txt");
/// let pose = Isometry3::translation(0.5, 1.0, 2.0);
/// write_poses_3x4(&path, &[(2, pose), (0, Isometry3::identity())])?;
/// assert_eq!(read_world_poses(&path, 3)?, [Some(Isometry3::identity()), None, Some(pose)]);
/// let error = read_world_poses(&path, 2).unwrap_err().to_string();
/// assert!(error.ends_with("poses.txt: a pose of scan 2, but there are 2 scans"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_world_poses(
    path: impl AsRef<Path>,
    num_scans: usize,
) -> Result<Vec<Option<Isometry3<f64>>>, Error> {
    let path = path.as_ref();
    let rows = read_known_poses(path)?;
    if rows.is_empty() {
        return Err(Error::malformed(path, "there is no pose in it"));
    }
    let mut is_given = vec![false; num_scans];
    let mut world_from_scan = vec![None; num_scans];
    for (scan, pose) in rows {
        if scan >= num_scans {
            let reason = format!("a pose of scan {scan}, but there are {num_scans} scans");
            return Err(Error::malformed(path, reason));
        }
        if std::mem::replace(&mut is_given[scan], true) {
            return Err(Error::malformed(path, format!("scan {scan} has two poses")));
        }
        world_from_scan[scan] = pose;
    }
    Ok(world_from_scan)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_of_no_scan_and_second_ones_are_refused_and_unknown_ones_are_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("poses.txt");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            read_world_poses(&path, 2).map_err(|error| error.to_string())
        };
        let (pose, lost) = ("1 0 0 0 0 1 0 0 0 0 1 0\n", "-inf ".repeat(12) + "\n");
        let identity = Some(Isometry3::identity());
        assert_eq!(read(&pose.repeat(2)).unwrap(), [identity; 2]);
        assert_eq!(
            read(&format!("1 {pose}0 {lost}")).unwrap(),
            [None, identity]
        );
        assert_eq!(read("1 0 0 0 0 0 0 1\n").unwrap(), [None, identity]);
        for (text, reason) in [
            (String::new(), "there is no pose in it"),
            (pose.repeat(3), "a pose of scan 2, but there are 2 scans"),
            (format!("1 {pose}1 {pose}"), "scan 1 has two poses"),
            (format!("1 {lost}1 {pose}"), "scan 1 has two poses"),
        ] {
            let said = read(&text).unwrap_err();
            assert!(said.ends_with(reason), "{said}");
        }
    }
}
