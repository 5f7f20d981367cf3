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
/// otherwise ignored, although poses of different components do not share a world. Rows without an
/// index are numbered from 0 in the order of the file. Blank lines and lines that start with `#` are
/// passed over. Each 3×3 part is replaced by the nearest rotation, since files often hold few digits.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`], with the line, for a row that
/// has not 12, 13 or 14 finite numbers, for rows of different width in one file, or for a matrix
/// that is off any rotation by more than 0.01 in an entry.
pub fn read_poses_3x4(path: impl AsRef<Path>) -> Result<Vec<(usize, Isometry3<f64>)>, Error> {
    let path = path.as_ref();
    poses_3x4(path, &read_text(path)?)
}

fn poses_3x4(path: &Path, text: &str) -> Result<Vec<(usize, Isometry3<f64>)>, Error> {
    matrix_rows(path, text, |line| {
        let entries = line.numbers(ROW)?;
        rigid::from_matrix_rows(entries).map_err(|reason| line.error(reason))
    })
}

/// Reads `(scan, world_from_scan)` from a file of poses in either format, which the width of its
/// first row tells.
///
/// Rows of 8 numbers are those of [`read_poses_tum`]. Their time stamps are the indices of the scans
/// if all are whole numbers from 0 to 99 999 and each is greater than the one before; otherwise, as
/// for times in seconds since 1970, the rows are numbered from 0 in the order of the file. Rows of 12
/// (KITTI), 13 or 14 numbers are those of [`read_poses_3x4`]. A file without rows has no poses.
///
/// # Errors
/// Those of [`read_poses_tum`] and [`read_poses_3x4`].
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
    let path = path.as_ref();
    let text = read_text(path)?;
    let width = lines(path, &text).next().map(|line| line.words_left());
    if width != Some(8) {
        return poses_3x4(path, &text);
    }
    let timed = tum_rows(path, &text)?;
    let are_indices = timed.iter().all(|&(time, _)| is_index(time))
        && timed.is_sorted_by(|(time, _), (next, _)| time < next);
    let rows = timed.into_iter().enumerate();
    let poses = rows.map(|(row, (time, world_from_scan))| {
        let scan = if are_indices { time as usize } else { row };
        (scan, world_from_scan)
    });
    Ok(poses.collect())
}

/// Whether the time may be an index: nobody has as many scans as seconds have passed since 1970.
fn is_index(time: f64) -> bool {
    time.fract() == 0.0 && (0.0..100_000.0).contains(&time)
}

/// A pose, or `None` where it is unknown.
pub(crate) type KnownPose = Option<Isometry3<f64>>;

/// As [`read_poses_3x4`], but a row without a finite entry is a scan without a pose.
pub(crate) fn read_known_poses_3x4(path: &Path) -> Result<Vec<(usize, KnownPose)>, Error> {
    matrix_rows(path, &read_text(path)?, |line| {
        let entries = line.any_numbers(ROW)?;
        motion_if_known(entries).map_err(|reason| line.error(reason))
    })
}

const ROW: &str = "the 3x4 matrix";

fn matrix_rows<T>(
    path: &Path,
    text: &str,
    pose: impl Fn(&mut Line) -> Result<T, Error>,
) -> Result<Vec<(usize, T)>, Error> {
    let width = lines(path, text).next().map_or(0, |line| line.words_left());
    let rows = lines(path, text).enumerate();
    rows.map(|(row, mut line)| Ok((scan_of_row(&mut line, row, width)?, pose(&mut line)?)))
        .collect()
}

/// The scan of a row, whose words are those of the pose from then on.
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

/// Reads a file of one matrix, such as ScanNet has for each frame: `world_from_scan`, or `None` if
/// the pose is unknown.
///
/// The file has the three rows of `[R | t]`, with or without the fourth row `0 0 0 1`. ScanNet writes
/// `-inf` into all entries where its tracking was lost; hence a matrix without a finite entry stands
/// for an unknown pose. The 3×3 part is replaced by the nearest rotation.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`] if there are not three or four
/// rows of four numbers, if only some of them are finite, or if the matrix is off any rigid motion
/// by more than 0.01 in an entry.
///
/// # Example
/// ```
/// use gmpcr_io::read_pose_matrix;
/// use nalgebra::Isometry3;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("0.txt");
/// std::fs::write(&path, "1 0 0 0.5\n0 1 0 0\n0 0 1 2\n0 0 0 1\n")?;
/// assert_eq!(read_pose_matrix(&path)?, Some(Isometry3::translation(0.5, 0.0, 2.0)));
/// std::fs::write(&path, "-inf -inf -inf -inf\n".repeat(4))?;
/// assert_eq!(read_pose_matrix(&path)?, None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_pose_matrix(path: impl AsRef<Path>) -> Result<Option<Isometry3<f64>>, Error> {
    let path = path.as_ref();
    let text = read_text(path)?;
    let mut rows = Vec::new();
    for mut line in lines(path, &text) {
        rows.push(line.any_numbers::<4>("the row")?);
        line.end()?;
    }
    let (&[a, b, c], last) = rows
        .split_first_chunk::<3>()
        .filter(|(_, last)| last.len() <= 1)
        .ok_or_else(|| {
            let reason = format!("{} rows: a pose has 3, or 4 with 0 0 0 1", rows.len());
            Error::malformed(path, reason)
        })?;
    let entries = std::array::from_fn(|k| [a, b, c][k / 4][k % 4]);
    let pose = motion_if_known(entries).map_err(|reason| Error::malformed(path, reason))?;
    if let (Some(_), [last]) = (pose, last) {
        rigid::check_last_row(*last).map_err(|reason| Error::malformed(path, reason))?;
    }
    Ok(pose)
}

/// The motion of `[R | t]`, row by row; none if none of the entries is finite.
fn motion_if_known(entries: [f64; 12]) -> Result<Option<Isometry3<f64>>, String> {
    match entries.iter().filter(|entry| entry.is_finite()).count() {
        12 => rigid::from_matrix_rows(entries).map(Some),
        0 => Ok(None),
        finite => Err(format!(
            "only {finite} of 12 entries of the pose are finite"
        )),
    }
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
    fn an_unknown_pose_has_no_finite_entry_in_any_spelling() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("poses.txt");
        for word in ["-inf", "nan", "1.#INF", "-nan(ind)"] {
            let row = format!("{word} ").repeat(12);
            fs::write(&path, format!("0 {IDENTITY}\n1 {row}\n")).unwrap();
            let poses = read_known_poses_3x4(&path).unwrap();
            assert_eq!(poses, [(0, Some(Isometry3::identity())), (1, None)]);
            assert!(read_poses_3x4(&path).is_err());
            fs::write(&path, format!("{word} {word} {word} {word}\n").repeat(3)).unwrap();
            assert_eq!(read_pose_matrix(&path).unwrap(), None);
        }
        fs::write(&path, IDENTITY.replacen('0', "nan", 1)).unwrap();
        let error = read_known_poses_3x4(&path).unwrap_err().to_string();
        assert!(error.contains("poses.txt:1: only 11 of 12"), "{error}");
    }

    #[test]
    fn a_file_of_one_matrix_has_three_or_four_rows() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("0.txt");
        let rows = ["1 0 0 7", "0 1 0 8", "0 0 1 9", "0 0 0 1", "0 0 0 0"];
        for (chosen, reason) in [
            (&[0, 1, 2][..], None),
            (&[0, 1, 2, 3], None),
            (&[], Some("0 rows")),
            (&[0, 1], Some("2 rows")),
            (&[0, 1, 2, 3, 3], Some("5 rows")),
            (&[0, 1, 2, 4], Some("not 0 0 0 1")),
            (&[0, 0, 2, 3], Some("no rotation")),
        ] {
            let text: Vec<&str> = chosen.iter().map(|&row| rows[row]).collect();
            fs::write(&path, text.join("\n")).unwrap();
            match (read_pose_matrix(&path), reason) {
                (Ok(pose), None) => assert_eq!(pose, Some(Isometry3::translation(7.0, 8.0, 9.0))),
                (Err(error), Some(reason)) => {
                    let said = error.to_string();
                    assert!(said.contains("0.txt: ") && said.contains(reason), "{said}");
                }
                (read, _) => panic!("{chosen:?}: {read:?}"),
            }
        }
        fs::write(&path, "1 0 0\n").unwrap();
        let error = read_pose_matrix(&path).unwrap_err().to_string();
        assert!(error.contains("0.txt:1: the line ends"), "{error}");
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
        // The second at which a benchmark was recorded is no index, nor are equal or falling numbers.
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
