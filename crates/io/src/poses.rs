//! Absolute poses as text, a row each.

use std::io::Write;
use std::path::Path;

use nalgebra::Isometry3;

use crate::atomic::write_atomically;
use crate::pose_matrix::{KnownPose, pose_if_known};
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
/// Blank lines and lines that start with `#` are skipped; quaternions are brought to unit
/// length.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`], with the line, for a row that
/// has not eight finite numbers or whose quaternion's length is off 1 by more than 0.01.
pub fn read_poses_tum(path: impl AsRef<Path>) -> Result<Vec<(f64, Isometry3<f64>)>, Error> {
    let path = path.as_ref();
    tum_rows(path, &read_text(path)?)
}

fn tum_rows(path: &Path, text: &str) -> Result<Vec<(f64, Isometry3<f64>)>, Error> {
    lines(path, text).map(tum_row).collect()
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
/// use gmpcr_io::{read_poses, write_poses_3x4};
/// use nalgebra::Isometry3;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("poses.txt");
/// write_poses_3x4(&path, &[(7, Isometry3::translation(0.5, 1.0, 2.0))])?;
///
/// let text = std::fs::read_to_string(&path)?;
/// assert_eq!(text, "7 1.0 0.0 0.0 0.5 0.0 1.0 0.0 1.0 0.0 0.0 1.0 2.0\n");
/// assert_eq!(read_poses(&path)?, [(7, Isometry3::translation(0.5, 1.0, 2.0))]);
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

/// Reads `(scan, world_from_scan)` from a file of poses. The width of the first row determines the
/// format.
///
/// | numbers in a row | format | scan |
/// |---|---|---|
/// | 8 | TUM, as of [`read_poses_tum`] | the time stamp, or the place of the row: see below |
/// | 12 | `[R \| t]` row by row, as of the KITTI odometry benchmark | the place of the row |
/// | 13 | the same after an index, as of [`write_poses_3x4`] | the index |
/// | 14 | the same after an index and the connected component of the scan | the index |
///
/// Time stamps are the indices of the scans if all are whole numbers from 0 to 99 999 and each is
/// greater than the one before. Otherwise, as for times in seconds since 1970, and for rows without an
/// index, the rows are numbered from 0 in the order of the file. A component must be a whole number. It is
/// otherwise ignored, although poses of different components are not in one world.
///
/// Blank lines and lines that start with `#` are skipped. Each 3×3 part is replaced by the nearest
/// rotation, since files often hold few digits. A file without rows has no poses.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`], with the line, for a row that has
/// not as many finite numbers as the first, or for a pose that is off any rotation by more than 0.01
/// in an entry or in the length of the quaternion.
///
/// # Example
/// ```
/// use gmpcr_io::{read_poses, write_poses_tum};
/// use nalgebra::Isometry3;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("poses.txt");
/// let pose = Isometry3::translation(0.5, 1.0, 2.0);
/// write_poses_tum(&path, &[(3.0, pose), (7.0, pose)])?;
/// assert_eq!(read_poses(&path)?, [(3, pose), (7, pose)]);
/// write_poses_tum(&path, &[(3.0, pose), (7.5, pose)])?;
/// assert_eq!(read_poses(&path)?, [(0, pose), (1, pose)]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_poses(path: impl AsRef<Path>) -> Result<Vec<(usize, Isometry3<f64>)>, Error> {
    read_rows(path.as_ref(), |line| {
        let entries = line.numbers(ROW)?;
        rigid::from_matrix_rows(entries).map_err(|reason| line.error(reason))
    })
}

/// As [`read_poses`], but a matrix without a finite entry is that of a scan of unknown pose.
pub(crate) fn read_known_poses(path: &Path) -> Result<Vec<(usize, KnownPose)>, Error> {
    read_rows(path, |line| {
        let entries = line.any_numbers(ROW)?;
        pose_if_known(entries).map_err(|reason| line.error(reason))
    })
}

const ROW: &str = "the 3x4 matrix";

/// The rows of either format; `matrix` reads the pose of a row of matrix entries.
fn read_rows<Pose: From<Isometry3<f64>>>(
    path: &Path,
    matrix: impl Fn(&mut Line) -> Result<Pose, Error>,
) -> Result<Vec<(usize, Pose)>, Error> {
    let text = read_text(path)?;
    let width = lines(path, &text)
        .next()
        .map_or(0, |line| line.words_left());
    if width == 8 {
        return Ok(numbered(tum_rows(path, &text)?));
    }
    let rows = lines(path, &text).enumerate();
    rows.map(|(row, mut line)| Ok((scan_of_row(&mut line, row, width)?, matrix(&mut line)?)))
        .collect()
}

/// Poses by their time stamps where these are indices, otherwise by their place.
fn numbered<Pose: From<Isometry3<f64>>>(timed: Vec<(f64, Isometry3<f64>)>) -> Vec<(usize, Pose)> {
    let are_indices = timed.iter().all(|&(time, _)| is_index(time))
        && timed.is_sorted_by(|(time, _), (next, _)| time < next);
    let rows = timed.into_iter().enumerate();
    let poses = rows.map(|(row, (time, world_from_scan))| {
        let scan = if are_indices { time as usize } else { row };
        (scan, world_from_scan.into())
    });
    poses.collect()
}

/// Whether the time may be an index: nobody has as many scans as seconds have passed since 1970.
fn is_index(time: f64) -> bool {
    time.fract() == 0.0 && (0.0..100_000.0).contains(&time)
}

/// The scan of a row. After it the words of the pose are left.
fn scan_of_row(line: &mut Line, row: usize, width: usize) -> Result<usize, Error> {
    let words = line.words_left();
    match words {
        _ if words != width => {
            let reason = format!("{words} numbers, but the first row has {width}");
            Err(line.error(reason))
        }
        12 => Ok(row),
        13 => line.index("the index of the scan"),
        14 => {
            let scan = line.index("the index of the scan")?;
            line.index("the component of the scan")?;
            Ok(scan)
        }
        _ => {
            let reason = format!(
                "{words} numbers: a pose has 12, or 13 with its index, or 14 with its component too"
            );
            Err(line.error(reason))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    const IDENTITY: &str = "1 0 0 0 0 1 0 0 0 0 1 0";

    fn read_content(text: &str) -> Result<Vec<(usize, Isometry3<f64>)>, Error> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("poses.txt");
        fs::write(&path, text).unwrap();
        read_poses(path)
    }

    #[test]
    fn rows_without_an_index_are_numbered_from_zero() {
        let poses = read_content(&format!("# comment\n{IDENTITY}\n\n{IDENTITY}\n")).unwrap();
        assert_eq!(
            poses,
            [(0, Isometry3::identity()), (1, Isometry3::identity())]
        );
    }

    #[test]
    fn the_component_after_the_index_is_ignored() {
        let poses = read_content(&format!("4 0 {IDENTITY}\n9 1 {IDENTITY}\n")).unwrap();
        assert_eq!(
            poses,
            [(4, Isometry3::identity()), (9, Isometry3::identity())]
        );
        assert!(read_content(&format!("4 0.5 {IDENTITY}\n")).is_err());
    }

    #[test]
    fn an_unknown_pose_has_no_finite_entry_in_any_spelling() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("poses.txt");
        for word in ["-inf", "nan", "1.#INF", "-nan(ind)"] {
            let row = format!("{word} ").repeat(12);
            fs::write(&path, format!("0 {IDENTITY}\n1 {row}\n")).unwrap();
            let poses = read_known_poses(&path).unwrap();
            assert_eq!(poses, [(0, Some(Isometry3::identity())), (1, None)]);
            assert!(read_poses(&path).is_err());
        }
        fs::write(&path, IDENTITY.replacen('0', "nan", 1)).unwrap();
        let error = read_known_poses(&path).unwrap_err().to_string();
        assert!(error.contains("poses.txt:1: only 11 of 12"), "{error}");
    }

    #[test]
    fn rows_of_different_width_are_refused_with_their_line() {
        let error = read_content(&format!("{IDENTITY}\n3 {IDENTITY}\n")).unwrap_err();
        assert!(
            error
                .to_string()
                .ends_with("poses.txt:2: 13 numbers, but the first row has 12")
        );
        assert!(read_content("1 2 3\n").is_err());
        assert!(read_content(&format!("-1 {IDENTITY}\n")).is_err());
    }

    #[test]
    fn a_matrix_that_is_no_rotation_is_refused() {
        let error = read_content("2 0 0 0 0 1 0 0 0 0 1 0\n").unwrap_err();
        assert!(error.to_string().contains("not a rotation within 0.01"));
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
        assert!(read_poses(&path).unwrap().is_empty());
    }

    #[test]
    fn the_width_of_the_first_row_tells_the_format() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("poses.txt");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            read_poses(&path)
                .map(|poses| poses.into_iter().map(|(scan, _)| scan).collect::<Vec<_>>())
        };
        let (quaternion, matrix) = ("1 2 3 0 0 0 1\n", "1 0 0 0 0 1 0 0 0 0 1 0\n");
        assert_eq!(
            read(&format!("# t\n4 {quaternion}9 {quaternion}")).unwrap(),
            [4, 9]
        );
        // The second at which a benchmark was recorded is not an index, nor are equal or falling numbers.
        for time in ["-1", "0.5", "1e300", "1305031102", "100000", "4", "3"] {
            let text = format!("4 {quaternion}{time} {quaternion}");
            assert_eq!(read(&text).unwrap(), [0, 1], "{time}");
        }
        assert_eq!(read(&matrix.repeat(2)).unwrap(), [0, 1]);
        assert_eq!(read(&format!("7 {matrix}")).unwrap(), [7]);
        assert_eq!(read(&format!("7 0 {matrix}")).unwrap(), [7]);
        assert!(read("").unwrap().is_empty());
        assert!(
            read("0 1 60\n")
                .unwrap_err()
                .to_string()
                .contains("3 numbers")
        );
        assert!(read(&format!("4 {quaternion}{matrix}")).is_err());
    }
}
