//! Absolute poses as text.

use std::io::Write;
use std::path::Path;

use nalgebra::Isometry3;

use crate::atomic::write_atomically;
use crate::text::{Line, lines, read_text};
use crate::{Error, rigid};

/// Writes poses in the format of the TUM RGB-D benchmark, which trajectory tools read.
///
/// One line per pose, `timestamp tx ty tz qx qy qz qw`: `(timestamp, world_from_scan)` with the
/// translation in the unit of the scans and the rotation as a unit quaternion, scalar last. Scans
/// without time stamps take their index as time. Numbers carry all their digits.
///
/// # Errors
/// [`Error::Io`] if the file cannot be written; then it is as it was before.
///
/// # Example
/// ```
/// use gmpcr_io::{read_poses_tum, write_poses_tum};
/// use nalgebra::Isometry3;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("trajectory.txt");
/// write_poses_tum(&path, &[(0.0, Isometry3::identity()), (1.5, Isometry3::translation(0.1, 0.0, 2.0))])?;
///
/// let second = std::fs::read_to_string(&path)?.lines().nth(1).unwrap().to_owned();
/// assert_eq!(second, "1.5 0.1 0.0 2.0 0.0 0.0 0.0 1.0");
/// assert_eq!(read_poses_tum(&path)?[1], (1.5, Isometry3::translation(0.1, 0.0, 2.0)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_poses_tum(
    path: impl AsRef<Path>,
    poses: &[(f64, Isometry3<f64>)],
) -> Result<(), Error> {
    write_atomically(path.as_ref(), |file| {
        for (timestamp, world_from_scan) in poses {
            write!(file, "{timestamp:?} ")?;
            rigid::write_quaternion_row(file, world_from_scan)?;
            writeln!(file)?;
        }
        Ok(())
    })
}

/// Reads `(timestamp, world_from_scan)` from a file of [`write_poses_tum`]'s format.
///
/// Blank lines and lines that start with `#` are passed over; quaternions are brought to unit
/// length.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`], with the line, for a row that
/// has not eight finite numbers or whose quaternion's length is off 1 by more than 0.01.
pub fn read_poses_tum(path: impl AsRef<Path>) -> Result<Vec<(f64, Isometry3<f64>)>, Error> {
    let path = path.as_ref();
    let text = read_text(path)?;
    lines(path, &text).map(tum_row).collect()
}

fn tum_row(mut line: Line) -> Result<(f64, Isometry3<f64>), Error> {
    let timestamp = line.number("the timestamp")?;
    let row = line.numbers("the pose")?;
    line.end()?;
    let pose = rigid::from_quaternion_row(row).map_err(|reason| line.error(reason))?;
    Ok((timestamp, pose))
}

/// Writes poses as rows of their matrices.
///
/// One line per pose: the index of the scan, then the 12 entries of the upper 3×4 part `[R | t]` of
/// `world_from_scan`, row by row. Numbers carry all their digits.
///
/// # Errors
/// [`Error::Io`] if the file cannot be written; then it is as it was before.
///
/// # Example
/// ```
/// use gmpcr_io::{read_poses_3x4, write_poses_3x4};
/// use nalgebra::Isometry3;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("poses.txt");
/// write_poses_3x4(&path, &[(7, Isometry3::translation(0.5, 1.0, 2.0))])?;
///
/// let text = std::fs::read_to_string(&path)?;
/// assert_eq!(text, "7 1.0 0.0 0.0 0.5 0.0 1.0 0.0 1.0 0.0 0.0 1.0 2.0\n");
/// assert_eq!(read_poses_3x4(&path)?, [(7, Isometry3::translation(0.5, 1.0, 2.0))]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_poses_3x4(
    path: impl AsRef<Path>,
    poses: &[(usize, Isometry3<f64>)],
) -> Result<(), Error> {
    write_atomically(path.as_ref(), |file| {
        for (scan, world_from_scan) in poses {
            write!(file, "{scan}")?;
            for entry in rigid::matrix_rows(world_from_scan).as_flattened() {
                write!(file, " {entry:?}")?;
            }
            writeln!(file)?;
        }
        Ok(())
    })
}

/// Reads `(scan, world_from_scan)` from rows of 13 numbers as of [`write_poses_3x4`], of 12,
/// without the index, as of the KITTI odometry benchmark, or of 14, with a second index after the
/// first.
///
/// The second index is the connected component of the scan; it must be a whole number and is
/// otherwise ignored, although poses of different components do not share a world. Rows without an index are numbered from 0 in the order of the file. Blank lines and lines that
/// start with `#` are passed over. Each 3×3 part is replaced by the nearest rotation, since files
/// often hold few digits.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`], with the line, for a row that
/// has not 12, 13 or 14 finite numbers, for rows of different width in one file, or for a matrix
/// that is off any rotation by more than 0.01 in an entry.
pub fn read_poses_3x4(path: impl AsRef<Path>) -> Result<Vec<(usize, Isometry3<f64>)>, Error> {
    let path = path.as_ref();
    let text = read_text(path)?;
    let width = lines(path, &text)
        .next()
        .map_or(0, |line| line.words_left());
    let rows = lines(path, &text).enumerate();
    rows.map(|(row, line)| matrix_row(line, row, width))
        .collect()
}

fn matrix_row(mut line: Line, row: usize, width: usize) -> Result<(usize, Isometry3<f64>), Error> {
    let words = line.words_left();
    let scan = match words {
        _ if words != width => {
            let reason = format!("{words} numbers, but the first row has {width}");
            return Err(line.error(reason));
        }
        12 => row,
        13 => line.index("the index of the scan")?,
        14 => {
            let scan = line.index("the index of the scan")?;
            line.index("the component of the scan")?;
            scan
        }
        _ => {
            let reason = format!(
                "{words} numbers: a pose has 12, or 13 with its index, or 14 with its component too"
            );
            return Err(line.error(reason));
        }
    };
    let entries = line.numbers("the 3x4 matrix")?;
    let pose = rigid::from_matrix_rows(entries).map_err(|reason| line.error(reason))?;
    Ok((scan, pose))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    const IDENTITY: &str = "1 0 0 0 0 1 0 0 0 0 1 0";

    fn read_text_as_3x4(text: &str) -> Result<Vec<(usize, Isometry3<f64>)>, Error> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("poses.txt");
        fs::write(&path, text).unwrap();
        read_poses_3x4(path)
    }

    #[test]
    fn rows_without_an_index_are_numbered_from_zero() {
        let poses = read_text_as_3x4(&format!("# comment\n{IDENTITY}\n\n{IDENTITY}\n")).unwrap();
        assert_eq!(
            poses,
            [(0, Isometry3::identity()), (1, Isometry3::identity())]
        );
    }

    #[test]
    fn the_component_after_the_index_is_ignored() {
        let poses = read_text_as_3x4(&format!("4 0 {IDENTITY}\n9 1 {IDENTITY}\n")).unwrap();
        assert_eq!(
            poses,
            [(4, Isometry3::identity()), (9, Isometry3::identity())]
        );
        assert!(read_text_as_3x4(&format!("4 0.5 {IDENTITY}\n")).is_err());
    }

    #[test]
    fn rows_of_different_width_are_refused_with_their_line() {
        let error = read_text_as_3x4(&format!("{IDENTITY}\n3 {IDENTITY}\n")).unwrap_err();
        assert!(
            error
                .to_string()
                .ends_with("poses.txt:2: 13 numbers, but the first row has 12")
        );
        assert!(read_text_as_3x4("1 2 3\n").is_err());
        assert!(read_text_as_3x4(&format!("-1 {IDENTITY}\n")).is_err());
    }

    #[test]
    fn a_matrix_that_is_no_rotation_is_refused() {
        let error = read_text_as_3x4("2 0 0 0 0 1 0 0 0 0 1 0\n").unwrap_err();
        assert!(error.to_string().contains("no rotation within 0.01"));
    }

    #[test]
    fn tum_rows_with_a_missing_or_an_extra_number_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("poses.txt");
        for row in [
            "0 1 2 3 0 0 0",
            "0 1 2 3 0 0 0 1 9",
            "0 1 2 3 0 0 0 0",
            "0 1 2 3 0 0 0 2",
            "0 1 2 nan 0 0 0 1",
        ] {
            fs::write(&path, row).unwrap();
            let error = read_poses_tum(&path).unwrap_err();
            assert!(error.to_string().contains("poses.txt:1: "), "{error}");
        }
    }

    #[test]
    fn no_poses_are_a_file_too() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("poses.txt");
        write_poses_tum(&path, &[]).unwrap();
        assert!(read_poses_tum(&path).unwrap().is_empty());
        write_poses_3x4(&path, &[]).unwrap();
        assert!(read_poses_3x4(&path).unwrap().is_empty());
    }
}
