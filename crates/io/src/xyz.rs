//! Points as text, a row each.

use std::path::Path;

use crate::bytes::Source;
use crate::rows::{self, Rows};
use crate::{Error, PointFile};

/// Reads points from text: XYZ, ASC, PTS, CSV and the like.
///
/// Each row is a point. Its first three columns are `x`, `y`, `z`. Further columns are skipped and
/// need not be numbers or Unicode. The separator is the first of semicolon, comma and white space
/// with which the first point has three numbers. Numbers may stand in quotes, and mark their
/// exponent by `E` or `D`. Blank lines and lines that start with `#` or `//` are skipped.
///
/// * A first row without any number names the columns. If there are columns called `x`, `y` and `z`, in
///   upper or lower case, they are taken.
/// * The last comment before the first point names the columns, too, if it has as many words as the point
///   has columns, with `x`, `y` and `z` among them: `# t x y z`, `//X,Y,Z`.
/// * A first row of one whole number, as PTS has it, is the count of the rows that follow. Several
///   clouds in one file, each with its count, are not read.
///
/// Coordinates are in the unit and the frame of the file. Points with a coordinate that is not
/// finite, in any spelling that programs print, are left out and counted, see [`PointFile`].
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`], with the line, if a row has fewer
/// columns or a coordinate is not a number, or has a zero byte as UTF-16 has, or if there are fewer or
/// more rows than counted, or another count.
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

    let mut head = Head::default();
    let mut columns = None;
    let mut scan = PointFile::default();
    let mut num_rows = 0;
    while let Some(row) = rows.next_if_any()? {
        let row = row.trim_start_matches('\u{feff}').trim();
        if row.is_empty() {
            continue;
        }
        if let Some(comment) = row.strip_prefix("//").or_else(|| row.strip_prefix('#')) {
            if !comment.trim().is_empty() {
                comment.clone_into(&mut head.comment);
            }
            continue;
        }
        columns = columns.or_else(|| head.columns_from(row));
        let Some(columns) = columns else {
            continue;
        };
        let point = columns.point(row);
        let point = point.map_err(|reason| head.explain(row, reason));
        scan.push(point.map_err(|reason| rows.error(reason))?);
        num_rows += 1;
    }
    head.check(path, num_rows, length)?;
    Ok(scan)
}

#[derive(Clone, Copy)]
enum Separator {
    Letter(char),
    Space,
}

impl Separator {
    const ALL: [Self; 3] = [Self::Letter(';'), Self::Letter(','), Self::Space];

    /// The first that the row has.
    fn of(row: &str) -> Self {
        let letter = [';', ','].into_iter().find(|&letter| row.contains(letter));
        letter.map_or(Self::Space, Self::Letter)
    }

    fn columns(self, row: &str) -> Vec<&str> {
        match self {
            Self::Letter(letter) => row.split(letter).map(bare).collect(),
            Self::Space => row.split_whitespace().map(bare).collect(),
        }
    }
}

/// A word without its quotes.
fn bare(word: &str) -> &str {
    word.trim().trim_matches('"').trim()
}

/// How to find the coordinates in a row.
#[derive(Clone, Copy)]
struct Columns {
    separator: Separator,
    /// Of `x`, `y`, `z`.
    places: [usize; 3],
}

impl Columns {
    fn point(self, row: &str) -> Result<[f64; 3], String> {
        let columns = self.separator.columns(row);
        let mut point = [0.0; 3];
        for ((coordinate, name), place) in point.iter_mut().zip(["x", "y", "z"]).zip(self.places) {
            let column = columns.get(place).ok_or_else(|| {
                let found = columns.len();
                format!("{name:?} is column {}, but the row has {found}", place + 1)
            })?;
            *coordinate = rows::coordinate(name, column, false)?;
        }
        Ok(point)
    }
}

/// What precedes the first point.
#[derive(Default)]
struct Head {
    count: Option<u64>,
    has_names: bool,
    /// Places of `x`, `y`, `z` in a row, if columns have these names.
    named: Option<[usize; 3]>,
    /// The last comment, which may name the columns too.
    comment: String,
}

impl Head {
    /// Takes a row that is a count or names. Any other is the first point, which determines the columns.
    fn columns_from(&mut self, row: &str) -> Option<Columns> {
        if self.count.is_none()
            && !self.has_names
            && let Ok(count) = row.parse()
        {
            self.count = Some(count);
            return None;
        }
        let mut all = Separator::ALL.into_iter();
        let columns = all.find_map(|separator| {
            let columns = self.columns(separator, row);
            columns.point(row).is_ok().then_some(columns)
        });
        if columns.is_some() {
            return columns;
        }
        let separator = Separator::of(row);
        let is_name = |word: &str| rows::coordinate("", word, false).is_err();
        if !self.has_names && separator.columns(row).into_iter().all(is_name) {
            self.has_names = true;
            let mut all = Separator::ALL.into_iter();
            self.named = all.find_map(|separator| places(&separator.columns(row)));
            return None;
        }
        Some(self.columns(separator, row))
    }

    fn columns(&self, separator: Separator, row: &str) -> Columns {
        let in_comment = || {
            // As in "# columns: x y z".
            let list = self.comment.rsplit(':').next()?;
            let names = list.split(|letter: char| letter.is_whitespace() || ",;".contains(letter));
            let names: Vec<&str> = names.map(bare).filter(|name| !name.is_empty()).collect();
            let names_all = names.len() == separator.columns(row).len();
            places(&names).filter(|_| names_all)
        };
        Columns {
            separator,
            places: self.named.or_else(in_comment).unwrap_or([0, 1, 2]),
        }
    }

    /// The reason why a row is not a point.
    fn explain(&self, row: &str, reason: String) -> String {
        match (self.count, row.parse::<u64>()) {
            (Some(_), Ok(count)) => {
                format!("{count} is another count: several clouds in one file are not read")
            }
            _ => reason,
        }
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

/// Places of the columns called `x`, `y` and `z`, if all exist.
fn places(names: &[&str]) -> Option<[usize; 3]> {
    let place = |wanted| {
        names
            .iter()
            .position(|name| name.eq_ignore_ascii_case(wanted))
    };
    Some([place("x")?, place("y")?, place("z")?])
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
            "1 -2.5 3e-3 tree,red\n4 5 672345.123 car\n",
            "x y z kind,color\n1 -2.5 3e-3 tree,red\n4 5 672345.123 car\n",
            "\"1\",\"-2.5\",\"3e-3\"\n\"4\", \"5\", \"672345.123\"\n",
            "1.0D+00 -0.25D+01 3d-3\n4.0D+00 5.0D+00 0.672345123D+06\n",
        ] {
            let scan = read(content).unwrap();
            let expected = POINTS.map(Into::into).to_vec();
            assert_eq!((scan.points, scan.invalid), (expected, 0), "{content}");
        }
    }

    #[test]
    fn a_comment_names_the_columns_if_it_names_all_of_them() {
        let rows = "0.5 1 -2.5 3e-3\n0.6 4 5 672345.123\n";
        let by_comma = rows.replace(' ', ",");
        for content in [
            format!("# t x y z\n{rows}"),
            format!("# t,x,y,z\n{by_comma}"),
            format!("# t x y z\n{by_comma}"),
            format!("#columns: t, x, y, z\n#\n\n{rows}"),
            format!("//T,X,Y,Z\n2\n{rows}# 1 comment x y\n"),
        ] {
            let scan = read(&content).unwrap();
            assert_eq!(scan.points, POINTS.map(Into::into), "{content}");
        }
        for comment in [
            "# t x y z i",
            "# x y z",
            "# t e n h",
            "# columns: x y z",
            "# t x y z\n# by nobody",
        ] {
            let scan = read(format!("{comment}\n{rows}")).unwrap();
            assert_eq!(scan.points[0], [0.5, 1.0, -2.5].into(), "{comment}");
        }
    }

    #[test]
    fn words_beside_the_numbers_may_be_in_any_encoding() {
        for content in [
            &b"x;y;z;H\xf6he\n1;-2.5;3e-3;Z\xfcrich\n4;5;672345.123;\n"[..],
            b"# H\xf6he\n1 -2.5 3e-3 Gen\xe8ve\n4 5 672345.123\n",
        ] {
            assert_eq!(read(content).unwrap().points, POINTS.map(Into::into));
        }
        let said = read(b"1 2 3\n1\xe8 2 3\n").unwrap_err().to_string();
        assert!(said.contains(":2: \"x\" is \"1\u{fffd}\""), "{said}");
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
            (
                "2\n1 2 3\n4 5 6\n1\n7 8 9\n",
                ":4: 1 is another count: several clouds",
            ),
            ("0\n1\n7 8 9\n", ":2: 1 is another count: several clouds"),
            ("18446744073709551615\n1 2 3\n", "but 1 follow in"),
            ("-3\n1 2 3\n", ":1: \"y\" is column 2, but the row has 1"),
        ] {
            let said = read(content).unwrap_err().to_string();
            assert!(said.contains("scan.xyz") && said.contains(reason), "{said}");
        }
        let utf_16: Vec<u8> = "1 2 3\n"
            .encode_utf16()
            .flat_map(u16::to_le_bytes)
            .collect();
        for content in [utf_16, vec![b'7'; 1 << 20], vec![0xff; 3 << 20]] {
            let said = read(content).unwrap_err().to_string();
            assert!(said.contains("scan.xyz:1: not text"), "{said}");
        }
    }
}
