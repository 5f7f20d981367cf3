//! A pose in a file of its own, as a matrix.

use std::path::Path;

use nalgebra::Isometry3;

use crate::text::{lines, read_text};
use crate::{Error, rigid};

/// A pose, or `None` where it is unknown.
pub(crate) type KnownPose = Option<Isometry3<f64>>;

/// Reads a file of one matrix, such as ScanNet has for each image: `world_from_scan`, or `None` if
/// the pose is unknown.
///
/// The file has the three rows of `[R | t]`, with or without the fourth row `0 0 0 1`. ScanNet writes
/// `-inf` into all entries if its tracking was lost. Hence a matrix without a finite entry stands
/// for an unknown pose. The 3×3 part is replaced by the nearest rotation.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`] if there are not three or four
/// rows of four numbers, if only some of them are finite, or if the matrix is off any rigid transformation
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
    let pose = pose_if_known(entries).map_err(|reason| Error::malformed(path, reason))?;
    if let (Some(_), [last]) = (pose, last) {
        rigid::check_last_row(*last).map_err(|reason| Error::malformed(path, reason))?;
    }
    Ok(pose)
}

/// The pose of `[R | t]`, row by row. `None` if no entry is finite.
pub(crate) fn pose_if_known(entries: [f64; 12]) -> Result<Option<Isometry3<f64>>, String> {
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

    #[test]
    fn an_unknown_pose_has_no_finite_entry_in_any_spelling() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("0.txt");
        for word in ["-inf", "nan", "1.#INF", "-nan(ind)"] {
            fs::write(&path, format!("{word} {word} {word} {word}\n").repeat(3)).unwrap();
            assert_eq!(read_pose_matrix(&path).unwrap(), None);
        }
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
            (&[0, 0, 2, 3], Some("not a rotation")),
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
}
