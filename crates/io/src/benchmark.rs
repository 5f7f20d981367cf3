//! The files of the 3DMatch and 3DLoMatch benchmarks: pairs of scans with their relative poses.

use std::io::Write;
use std::path::Path;

use nalgebra::{Isometry3, Matrix6, SMatrix};

use crate::atomic::write_atomically;
use crate::text::{Line, lines, read_text};
use crate::{Error, rigid};

/// The relative pose of a pair of scans, an entry of `gt.log`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LogEntry {
    /// The scan into whose frame the relative pose maps.
    pub i: usize,
    /// The scan whose coordinates the relative pose maps.
    pub j: usize,
    /// How many scans the scene has.
    pub num_scans: usize,
    /// The relative pose, which maps coordinates of scan `j` into the frame of scan `i`.
    #[cfg_attr(feature = "serde", serde(with = "gmpcr_geometry::matrix_rows"))]
    pub i_from_j: Isometry3<f64>,
}

/// How much the overlap of a pair constrains its relative pose, an entry of `gt.info`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct InfoEntry {
    /// The first scan of the pair.
    pub i: usize,
    /// The second scan of the pair.
    pub j: usize,
    /// How many scans the scene has.
    pub num_scans: usize,
    /// The 6×6 matrix as the file has it, in the order translation, rotation.
    ///
    /// The top left entry is the number of corresponding points; the benchmark divides the quadratic
    /// form of a pose error by it to obtain a mean squared distance. The official files hold a matrix
    /// of zeros for some pairs.
    pub information: Matrix6<f64>,
}

/// Reads relative poses of pairs, `gt.log`.
///
/// An entry has five lines: `i j n` with the number `n` of scans in the scene, then the four rows of
/// the 4×4 matrix that maps coordinates of scan `j` into the frame of scan `i`. The files hold about
/// nine digits, so the 3×3 part is replaced by the nearest rotation.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`], with the line, for an unexpected count
/// of rows or numbers, numbers that are not finite, or a matrix that is off any rigid transformation by
/// more than 0.01 in an entry.
///
/// # Example
/// ```
/// use gmpcr_io::read_gt_log;
/// use nalgebra::Point3;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("gt.log");
/// std::fs::write(&path, "0 3 60\n0 -1 0 5\n1 0 0 6\n0 0 1 7\n0 0 0 1\n")?;
/// let pairs = read_gt_log(&path)?;
/// assert_eq!((pairs[0].i, pairs[0].j, pairs[0].num_scans), (0, 3, 60));
/// let in_j = Point3::new(1.0, 0.0, 0.0);
/// assert!((pairs[0].i_from_j * in_j - Point3::new(5.0, 7.0, 7.0)).norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_gt_log(path: impl AsRef<Path>) -> Result<Vec<LogEntry>, Error> {
    let path = path.as_ref();
    let text = read_text(path)?;
    let mut lines = lines(path, &text);
    let mut entries = Vec::new();
    while let Some(mut header) = lines.next() {
        let [i, j, num_scans] = pair_header(&mut header)?;
        let matrix = square::<4>(&header, &mut lines)?;
        let i_from_j = transformation(&matrix).map_err(|reason| header.error(reason))?;
        entries.push(LogEntry {
            i,
            j,
            num_scans,
            i_from_j,
        });
    }
    Ok(entries)
}

/// Reads the information matrices of pairs, `gt.info`.
///
/// An entry has seven lines: `i j n` as in `gt.log`, then the six rows of the matrix.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`], with the line, for an unexpected count
/// of rows or numbers, or numbers that are not finite.
///
/// # Example
/// ```
/// use gmpcr_io::read_gt_info;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("gt.info");
/// std::fs::write(&path, format!("0\t 1\t 60\n{}", "1 2 3 4 5 6\n".repeat(6)))?;
/// let pairs = read_gt_info(&path)?;
/// assert_eq!((pairs[0].i, pairs[0].j), (0, 1));
/// assert_eq!(pairs[0].information[(0, 5)], 6.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_gt_info(path: impl AsRef<Path>) -> Result<Vec<InfoEntry>, Error> {
    let path = path.as_ref();
    let text = read_text(path)?;
    let mut lines = lines(path, &text);
    let mut entries = Vec::new();
    while let Some(mut header) = lines.next() {
        let [i, j, num_scans] = pair_header(&mut header)?;
        let information = square::<6>(&header, &mut lines)?;
        entries.push(InfoEntry {
            i,
            j,
            num_scans,
            information,
        });
    }
    Ok(entries)
}

fn pair_header(line: &mut Line) -> Result<[usize; 3], Error> {
    let i = line.index("the first scan of the pair")?;
    let j = line.index("the second scan of the pair")?;
    let num_scans = line.index("the number of scans")?;
    line.end()?;
    Ok([i, j, num_scans])
}

/// The N×N matrix of the next N lines, which belong to the entry that `header` opens.
fn square<'a, const N: usize>(
    header: &Line,
    lines: &mut impl Iterator<Item = Line<'a>>,
) -> Result<SMatrix<f64, N, N>, Error> {
    let mut matrix = SMatrix::<f64, N, N>::zeros();
    for row in 0..N {
        let mut line = lines
            .next()
            .ok_or_else(|| header.error(format!("the entry ends after {row} of {N} rows")))?;
        let numbers = line.numbers::<N>("the row")?;
        line.end()?;
        matrix.row_mut(row).copy_from_slice(&numbers);
    }
    Ok(matrix)
}

fn transformation(matrix: &SMatrix<f64, 4, 4>) -> Result<Isometry3<f64>, String> {
    rigid::check_last_row(std::array::from_fn(|column| matrix[(3, column)]))?;
    rigid::from_matrix_rows(std::array::from_fn(|k| matrix[(k / 4, k % 4)]))
}

/// Writes relative poses of pairs in the format that [`read_gt_log`] describes, separated by tabs
/// as the benchmark's own tools do. Numbers carry all their digits.
///
/// # Errors
/// [`Error::Io`] if the file cannot be written; then it is as it was before.
///
/// # Example
/// ```
/// use gmpcr_io::{LogEntry, read_gt_log, write_gt_log};
/// use nalgebra::Isometry3;
///
/// let pair = LogEntry { i: 0, j: 2, num_scans: 3, i_from_j: Isometry3::translation(0.5, 0.0, 1.0) };
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("est.log");
/// write_gt_log(&path, std::slice::from_ref(&pair))?;
/// assert_eq!(read_gt_log(&path)?, [pair]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_gt_log(path: impl AsRef<Path>, entries: &[LogEntry]) -> Result<(), Error> {
    write_atomically(path.as_ref(), |file| {
        for entry in entries {
            writeln!(file, "{}\t{}\t{}", entry.i, entry.j, entry.num_scans)?;
            for [a, b, c, d] in rigid::matrix_rows(&entry.i_from_j) {
                writeln!(file, "{a:?}\t{b:?}\t{c:?}\t{d:?}")?;
            }
            writeln!(file, "0.0\t0.0\t0.0\t1.0")?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::path::PathBuf;

    fn file(text: &str) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("gt.txt");
        fs::write(&path, text).unwrap();
        (folder, path)
    }

    #[test]
    fn tabs_trailing_space_and_exponents_are_read() {
        let (_folder, path) = file(
            "3\t 17\t 60\t\n 9.96926560e-01\t  6.68735757e-02\t -4.06664421e-02\t -1.15576939e-01\t\n\
             -6.61289946e-02\t  9.97617877e-01\t  1.94008687e-02\t -3.87705398e-02\t\n \
             4.18675510e-02\t -1.66517807e-02\t  9.98977765e-01\t  1.14874890e-01\t\n \
             0.00000000e+00\t  0.00000000e+00\t  0.00000000e+00\t  1.00000000e+00\t\n",
        );
        let pairs = read_gt_log(path).unwrap();
        assert_eq!((pairs[0].i, pairs[0].j, pairs[0].num_scans), (3, 17, 60));
        let matrix = pairs[0].i_from_j.to_homogeneous();
        assert!((matrix[(0, 1)] - 6.687_357_57e-2).abs() < 1e-6);
        assert_eq!(matrix[(2, 3)], 0.114_874_890);
    }

    #[test]
    fn a_matrix_of_zeros_is_information_but_no_pose() {
        let (_folder, path) = file(&format!("0 1 2\n{}", "0 0 0 0 0 0\n".repeat(6)));
        assert_eq!(read_gt_info(path).unwrap()[0].information, Matrix6::zeros());
        let (_folder, path) = file("0 1 2\n0 0 0 0\n0 0 0 0\n0 0 0 0\n0 0 0 1\n");
        let error = read_gt_log(path).unwrap_err().to_string();
        assert!(
            error.contains("gt.txt:1: the 3x3 part is not a rotation"),
            "{error}"
        );
    }

    #[test]
    fn missing_rows_and_numbers_are_named() {
        let (_folder, path) = file("0 1 2\n1 0 0 0\n0 1 0 0\n");
        let error = read_gt_log(path).unwrap_err().to_string();
        assert!(
            error.contains("gt.txt:1: the entry ends after 2 of 4 rows"),
            "{error}"
        );
        let (_folder, path) = file("0 1 2\n1 0 0\n");
        let error = read_gt_log(path).unwrap_err().to_string();
        assert!(
            error.contains("gt.txt:2: the line ends where number 4 of 4"),
            "{error}"
        );
        let (_folder, path) = file("0 1 2\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 1 1\n");
        let error = read_gt_log(path).unwrap_err().to_string();
        assert!(error.contains("not 0 0 0 1"), "{error}");
    }
}
