//! Points as text, a row each.

use std::path::Path;

use crate::bytes::Source;
use crate::rows::{self, Rows};
use crate::{Error, PointFile};

/// Reads points from text: XYZ, ASC, PTS, CSV and the like.
///
/// Each row is a point, its first three columns are `x`, `y`, `z`. Further columns are passed over
/// and need not be numbers. Columns are separated by semicolons, else by commas, else by white space:
/// the first row decides. Blank lines and lines that start with `#` or `//` are passed over.
///
/// * A first row without any number names the columns; those called `x`, `y` and `z`, in upper or
///   lower case, are taken then if all three exist.
/// * A first row of one whole number, as PTS has it, is the count of the rows that follow.
///
/// Coordinates are in the unit and the frame of the file. Points with a coordinate that is not
/// finite, in any spelling that programs print, are left out and counted, see [`PointFile`].
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`], with the line, if a row has fewer
/// columns or a coordinate is no number, or if there are fewer or more rows than counted.
/// [`Error::Malformed`] also if the file is empty, or has neither a point nor a count nor columns
/// called `x`, `y`, `z`. Text that ends between two rows without a count goes unnoticed.
///
/// # Example
/// ```
/// use gmpcr_io::read_xyz;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("scan.csv");
/// std::fs::write(&path, "time;X;Y;Z\n17:00;1;2;3.5\n17:01;nan;nan;nan\n")?;
/// let scan = read_xyz(&path)?;
/// assert_eq!(scan.points, [[1.0, 2.0, 3.5].into()]);
/// assert_eq!(scan.invalid, 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_xyz(path: impl AsRef<Path>) -> Result<PointFile, Error> {
    let path = path.as_ref();
    let mut source = Source::open(path, "text", b"")?;
    let length = source.bytes_left()?;
    let mut rows = Rows::new(source, 1);

    let mut table = Table::default();
    let mut scan = PointFile::default();
    let mut num_rows = 0;
    while let Some(row) = rows.next_if_any()? {
        let row = row.trim_start_matches('\u{feff}').trim();
        if row.is_empty() || row.starts_with('#') || row.starts_with("//") {
            continue;
        }
        if table.separator.is_none() && table.starts_with(row) {
            continue;
        }
        let point = table
            .coordinates(row)
            .map_err(|reason| rows.error(reason))?;
        scan.push(point);
        num_rows += 1;
    }
    table.check(path, num_rows, length)?;
    Ok(scan)
}

/// What the first rows tell about the others.
#[derive(Default)]
struct Table {
    separator: Option<Separator>,
    /// Places of `x`, `y`, `z` in a row, if columns have these names.
    named: Option<[usize; 3]>,
    count: Option<u64>,
}

#[derive(Clone, Copy)]
enum Separator {
    Letter(char),
    Space,
}

impl Separator {
    fn of(row: &str) -> Self {
        let letters = [';', ','];
        let letter = letters.into_iter().find(|&letter| row.contains(letter));
        letter.map_or(Self::Space, Self::Letter)
    }

    fn columns(self, row: &str) -> Vec<&str> {
        match self {
            Self::Letter(letter) => row.split(letter).map(str::trim).collect(),
            Self::Space => row.split_whitespace().collect(),
        }
    }
}

impl Table {
    /// Whether the row is no point but a count or names; otherwise it is the first point.
    fn starts_with(&mut self, row: &str) -> bool {
        if self.count.is_none()
            && let Ok(count) = row.parse()
        {
            self.count = Some(count);
            return true;
        }
        let separator = Separator::of(row);
        self.separator = Some(separator);
        let columns = separator.columns(row);
        let is_number = |word: &&str| rows::coordinate("", word, false).is_ok();
        if columns.iter().any(is_number) {
            return false;
        }
        let place = |name: &str| {
            let mut columns = columns.iter().map(|column| column.trim_matches('"'));
            columns.position(|column| column.eq_ignore_ascii_case(name))
        };
        if let (Some(x), Some(y), Some(z)) = (place("x"), place("y"), place("z")) {
            self.named = Some([x, y, z]);
        }
        true
    }

    fn coordinates(&self, row: &str) -> Result<[f64; 3], String> {
        let columns = self.separator.unwrap_or(Separator::Space).columns(row);
        let mut coordinates = [0.0; 3];
        let places = self.named.unwrap_or([0, 1, 2]);
        for ((coordinate, name), place) in coordinates.iter_mut().zip(["x", "y", "z"]).zip(places) {
            let column = columns.get(place).ok_or_else(|| {
                let found = columns.len();
                format!("{name:?} is column {}, but the row has {found}", place + 1)
            })?;
            *coordinate = rows::coordinate(name, column, false)?;
        }
        Ok(coordinates)
    }

    fn check(&self, path: &Path, num_rows: u64, length: u64) -> Result<(), Error> {
        let reason = match self.count {
            Some(count) if count != num_rows => format!(
                "the first row announces {count} points, but {num_rows} follow in {length} bytes"
            ),
            None if num_rows == 0 && self.named.is_none() => "no row of three numbers".to_owned(),
            _ => return Ok(()),
        };
        Err(Error::malformed(path, reason))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn read(content: impl AsRef<[u8]>) -> Result<PointFile, Error> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scan.xyz");
        fs::write(&path, content).unwrap();
        read_xyz(path)
    }

    const POINTS: [[f64; 3]; 2] = [[1.0, -2.5, 3e-3], [4.0, 5.0, 672_345.123]];

    #[test]
    fn every_separator_comment_and_heading_gives_the_same_points() {
        for content in [
            "1 -2.5 3e-3\n4 5 672345.123\n",
            "1\t-2.5\t3e-3\r\n4\t5\t672345.123",
            "1,-2.5,3e-3,\n\n4, 5 ,672345.123,a\n",
            "1;-2.5;3e-3;7,5\n4;5;672345.123;a b\n",
            "\u{feff}# heading\n//X Y Z\n 1 -2.5 3e-3 car\n4 5 672345.123 tree,red\n",
            "x y z\n1 -2.5 3e-3\n4 5 672345.123\n",
            "east,north,height\n1,-2.5,3e-3\n4,5,672345.123\n",
            "Label;Z;X;\"y\"\nnan;3e-3;1;-2.5\n;672345.123;4;5\n",
            "2\n1 -2.5 3e-3 12 255 255 255\n4 5 672345.123 12 0 0 0\n",
        ] {
            let scan = read(content).unwrap();
            let expected = POINTS.map(Into::into).to_vec();
            assert_eq!((scan.points, scan.invalid), (expected, 0), "{content}");
        }
    }

    #[test]
    fn points_without_a_position_are_counted() {
        let scan = read("nan nan nan\n1 2 3\n1.#QNAN 0 0\n0 inf 0\n").unwrap();
        assert_eq!((scan.points.len(), scan.invalid), (1, 3));
    }

    #[test]
    fn no_points_are_no_error_where_the_file_says_so() {
        for content in ["0\n", "x,y,z\n", "# scan\nX Y Z intensity\n"] {
            assert_eq!(read(content).unwrap(), PointFile::default(), "{content}");
        }
    }

    #[test]
    fn faults_are_named_with_their_line() {
        for (content, reason) in [
            ("", "the file is empty"),
            ("# nothing\n", "no row of three numbers"),
            ("time value\n", "no row of three numbers"),
            ("1 2 3\n\n4 5\n", ":3: \"z\" is column 3, but the row has 2"),
            ("1 2 3\n# c\n4 b 6\n", ":3: \"y\" is \"b\", not a number"),
            ("1,,3,4\n", ":1: \"y\" is \"\", not a number"),
            ("1,5;2,5;3\n", ":1: \"x\" is \"1,5\", not a number"),
            (
                "a,x,y,z\n1,2,3\n",
                ":2: \"z\" is column 4, but the row has 3",
            ),
            ("3\n1 2 3\n4 5 6\n", "announces 3 points, but 2 follow"),
            ("1\n1 2 3\n4 5 6\n", "announces 1 points, but 2 follow"),
            ("18446744073709551615\n1 2 3\n", "but 1 follow in"),
            ("-3\n1 2 3\n", ":1: \"y\" is column 2, but the row has 1"),
        ] {
            let said = read(content).unwrap_err().to_string();
            assert!(said.contains("scan.xyz") && said.contains(reason), "{said}");
        }
        let said = read([0xff; 100]).unwrap_err().to_string();
        assert!(said.contains("scan.xyz:1: no text"), "{said}");
    }
}
