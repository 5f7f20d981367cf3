//! Tables of the overlaps of pairs.

use std::path::Path;

use crate::Error;
use crate::text::{Line, lines, read_text};

/// How much two scans overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PairOverlap {
    /// The first scan of the pair.
    pub i: usize,
    /// The second scan of the pair.
    pub j: usize,
    /// Fraction of the points of one scan that have a counterpart in the other, from 0 to 1. A mean
    /// over both directions if the file has one.
    pub overlap: f64,
}

/// Reads the overlaps of pairs: rows `i,j,overlap`, as of the benchmark's `gt_overlap.log`, or
/// `i,j,mean,min`, of which the mean is taken.
///
/// A first line `i,j,...` is a heading. Blank lines and lines that start with `#` are skipped.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`], with the line, for a row that has
/// not three or four numbers or not as many as the first, or whose overlap is not within 0 and 1.
///
/// # Example
/// ```
/// use gmpcr_io::read_overlaps;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("overlap.csv");
/// std::fs::write(&path, "i,j,mean,min\n0,1,0.75,0.5\n0,2,0.25,0.0\n")?;
/// let overlaps = read_overlaps(&path)?;
/// assert_eq!(overlaps.len(), 2);
/// assert_eq!((overlaps[0].i, overlaps[0].j, overlaps[0].overlap), (0, 1, 0.75));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_overlaps(path: impl AsRef<Path>) -> Result<Vec<PairOverlap>, Error> {
    let path = path.as_ref();
    let text = read_text(path)?.replace(',', " ");
    let mut rows = lines(path, &text).peekable();
    let width = rows.peek().map_or(0, Line::words_left);
    rows.next_if(is_heading);
    rows.map(|row| overlap_row(row, width)).collect()
}

fn is_heading(line: &Line) -> bool {
    line.first() == Some("i")
}

fn overlap_row(mut line: Line, width: usize) -> Result<PairOverlap, Error> {
    let words = line.words_left();
    if words != width || !(3..=4).contains(&words) {
        let reason =
            format!("{words} columns: a row is i,j,overlap or i,j,mean,min throughout the file");
        return Err(line.error(reason));
    }
    let i = line.index("the first scan of the pair")?;
    let j = line.index("the second scan of the pair")?;
    let overlap = fraction(&mut line, "the overlap")?;
    if words == 4 {
        fraction(&mut line, "the lesser overlap")?;
    }
    Ok(PairOverlap { i, j, overlap })
}

fn fraction(line: &mut Line, what: &str) -> Result<f64, Error> {
    let fraction = line.number(what)?;
    if !(0.0..=1.0).contains(&fraction) {
        return Err(line.error(format!("{what} is {fraction}, not within 0 and 1")));
    }
    Ok(fraction)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn read(text: &str) -> Result<Vec<PairOverlap>, Error> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("overlap.csv");
        fs::write(&path, text).unwrap();
        read_overlaps(path)
    }

    #[test]
    fn both_kinds_of_table_are_read_with_and_without_heading() {
        let expected = [
            PairOverlap {
                i: 0,
                j: 1,
                overlap: 0.5,
            },
            PairOverlap {
                i: 0,
                j: 12,
                overlap: 0.0,
            },
        ];
        for text in [
            "0,1,0.5\n0,12,0\n",
            "i,j,overlap\n0,1,0.5\n0,12,0\n",
            "i,j,mean,min\r\n0,1,0.5,0.25\r\n0,12,0.0,0.0\r\n",
            "0, 1, 0.5, 0.25\n\n0, 12, 0, 0",
        ] {
            assert_eq!(read(text).unwrap(), expected, "{text}");
        }
        assert!(read("").unwrap().is_empty());
        assert!(read("i,j,mean,min\n").unwrap().is_empty());
    }

    #[test]
    fn broken_rows_are_named() {
        for (text, place) in [
            ("0,1\n", "overlap.csv:1: 2 columns"),
            ("i,j,mean,min\n0,1,0.5\n", "overlap.csv:2: 3 columns"),
            ("i,j,mean,min\n0,1,,0.5\n", "overlap.csv:2: 3 columns"),
            ("0,1,0.5\n0,1,0.5,0.5\n", "overlap.csv:2: 4 columns"),
            ("0,1,1.5\n", "not within 0 and 1"),
            ("0,1,0.5,-1\n", "not within 0 and 1"),
            ("0,1,nan\n", "not a finite number"),
            ("-1,1,0.5\n", "overlap.csv:1: the first scan"),
            ("99999999999999999999,1,0.5\n", "not a whole number"),
            ("0,1,0.5\ni,j,mean\n", "overlap.csv:2: "),
        ] {
            let said = read(text).unwrap_err().to_string();
            assert!(said.contains(place), "{said}");
        }
    }
}
