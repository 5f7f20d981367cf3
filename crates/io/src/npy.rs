//! Matrices in NumPy's array format, the usual one for learned features.

use std::io::Read;
use std::path::Path;

use npyz::{DType, Deserialize, NpyFile, NpyHeader, Order, TypeChar};

use crate::bytes::Source;
use crate::{Error, PointFile};

/// A matrix of numbers, row by row.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct NpyMatrix {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
    /// The entries: that of row `r` and column `c` is `values[r * columns + c]`.
    pub values: Vec<f64>,
}

/// Reads a two-dimensional `.npy` array of `float32` or `float64`.
///
/// The array may be in C or in Fortran order and of either byte order; the result is row by row in
/// any case. Numbers that are not finite are kept.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`] if it is empty, foreign or cut
/// off, or holds another number of dimensions or another type, or rows without columns; the message
/// says which. The file is checked before memory is reserved, so a false shape in the header is an
/// error too.
///
/// # Example
/// ```
/// use gmpcr_io::read_npy_matrix;
/// use npyz::WriterBuilder;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("matrix.npy");
/// let mut file = npyz::WriteOptions::new()
///     .default_dtype()
///     .shape(&[2, 3])
///     .writer(std::fs::File::create(&path)?)
///     .begin_nd()?;
/// file.extend([1.0f32, 2.0, 3.0, 4.0, 5.0, 6.0])?;
/// file.finish()?;
///
/// let matrix = read_npy_matrix(&path)?;
/// assert_eq!((matrix.rows, matrix.columns), (2, 3));
/// assert_eq!(matrix.values[matrix.columns..], [4.0, 5.0, 6.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_npy_matrix(path: impl AsRef<Path>) -> Result<NpyMatrix, Error> {
    let mut source = Source::open(path.as_ref(), "NPY", MAGIC)?;
    let header = Header::of_file(&mut source)?;
    header.matrix(&mut source.reader)
}

/// What an array starts with.
const MAGIC: &[u8] = b"\x93NUMPY";

/// The points of a `.npy` file: the first three columns of its matrix.
pub(crate) fn read_points(path: &Path) -> Result<PointFile, Error> {
    let mut source = Source::open(path, "NPY", MAGIC)?;
    let header = Header::of_file(&mut source)?;
    header.points(&mut source.reader)
}

/// The header of a matrix, whose entries follow it.
pub(crate) struct Header<'a> {
    path: &'a Path,
    header: NpyHeader,
    rows: usize,
    columns: usize,
    is_double: bool,
}

impl<'a> Header<'a> {
    pub(crate) fn new(path: &'a Path, header: NpyHeader) -> Result<Self, Error> {
        let (rows, columns) = matrix_shape(path, &header)?;
        let is_double = is_double(path, &header.dtype())?;
        Ok(Self {
            path,
            header,
            rows,
            columns,
            is_double,
        })
    }

    /// The header of a file that is long enough for the entries.
    fn of_file(source: &mut Source<'a>) -> Result<Self, Error> {
        let header = read_header(source.path, &mut source.reader)?;
        let header = Self::new(source.path, header)?;
        source.expect_left(header.num_bytes(), &header.description())?;
        Ok(header)
    }

    /// Bytes of the entries; `None` stands for more than a number can say.
    pub(crate) fn num_bytes(&self) -> Option<u64> {
        let size = if self.is_double { 8 } else { 4 };
        self.header.len().checked_mul(size)
    }

    pub(crate) fn description(&self) -> String {
        format!("a matrix of shape {:?}", self.header.shape())
    }

    /// The entries, which `reader` is known to have.
    fn matrix(self, reader: &mut impl Read) -> Result<NpyMatrix, Error> {
        let (rows, columns, order) = (self.rows, self.columns, self.header.order());
        let mut values = Vec::with_capacity(rows * columns);
        self.for_each(reader, |value| values.push(value))?;
        Ok(NpyMatrix {
            rows,
            columns,
            values: match order {
                Order::C => values,
                Order::Fortran => by_rows(&values, rows, columns),
            },
        })
    }

    /// The first three columns. Memory grows with what is read.
    pub(crate) fn points(self, reader: &mut impl Read) -> Result<PointFile, Error> {
        let (rows, columns, order) = (self.rows, self.columns, self.header.order());
        if columns < 3 {
            let reason = format!("points are n x 3 or wider, but the array is {rows} x {columns}");
            return Err(Error::malformed(self.path, reason));
        }
        let mut scan = PointFile::default();
        match order {
            Order::C => {
                let mut point = [0.0; 3];
                let mut column = 0;
                self.for_each(reader, |value| {
                    if let Some(coordinate) = point.get_mut(column) {
                        *coordinate = value;
                    }
                    column += 1;
                    if column == columns {
                        scan.push(point);
                        column = 0;
                    }
                })?;
            }
            Order::Fortran => {
                let mut values = Vec::new();
                self.for_each(reader, |value| {
                    if values.len() < 3 * rows {
                        values.push(value);
                    }
                })?;
                for row in 0..rows {
                    scan.push([0, 1, 2].map(|column| values[column * rows + row]));
                }
            }
        }
        Ok(scan)
    }

    /// Passes all entries to `take`, in the order of the file.
    fn for_each(self, reader: &mut impl Read, take: impl FnMut(f64)) -> Result<(), Error> {
        match self.is_double {
            true => self.for_each_of::<f64>(reader, take),
            false => self.for_each_of::<f32>(reader, take),
        }
    }

    fn for_each_of<T: Deserialize + Into<f64>>(
        self,
        reader: &mut impl Read,
        mut take: impl FnMut(f64),
    ) -> Result<(), Error> {
        let fault = |error| Error::parser(self.path, None, "entries", error);
        let file = NpyFile::with_header(self.header, reader);
        let entries = file.data::<T>();
        for entry in entries.map_err(|error| fault(std::io::Error::other(error)))? {
            take(entry.map_err(fault)?.into());
        }
        Ok(())
    }
}

/// Reads the header.
///
/// Refuses headers that would overwhelm the header parser. It multiplies the shape without a check for
/// overflow, descends into nested brackets, and reserves whatever length it is given.
///
/// A header of a plain matrix is short and flat, and the decimal digits of its shape are few: up to
/// 18 of them, besides the digit of the type, multiply to less than 2^64.
pub(crate) fn read_header(path: &Path, reader: &mut impl Read) -> Result<NpyHeader, Error> {
    // As NumPy does by default.
    const LONGEST: u64 = 10_000;
    let fault = |error| Error::parser(path, None, "header", error);
    let refuse = |reason: &str| Err(Error::malformed(path, format!("header: {reason}")));

    let mut header = vec![0; 8];
    reader.read_exact(&mut header).map_err(fault)?;
    if !header.starts_with(MAGIC) {
        return refuse("not that of an NPY file");
    }
    // Two bytes in version 1 of the format, four in later ones.
    let mut length = [0; 4];
    let num_bytes = if header[6] == 1 { 2 } else { 4 };
    reader.read_exact(&mut length[..num_bytes]).map_err(fault)?;
    header.extend(&length[..num_bytes]);
    let length = u32::from_le_bytes(length).into();
    if length > LONGEST {
        return refuse(&format!("a length of {length} bytes is too much"));
    }
    let text = header.len();
    reader
        .take(length)
        .read_to_end(&mut header)
        .map_err(fault)?;

    let text = &header[text..];
    let count = |wanted: fn(&u8) -> bool| text.iter().filter(|&byte| wanted(byte)).count();
    if count(|byte| b"({[".contains(byte)) > 2 {
        return refuse("only arrays of a plain number type are supported");
    }
    let hexadecimal = text.windows(2).any(|pair| pair.eq_ignore_ascii_case(b"0x"));
    if hexadecimal || count(u8::is_ascii_digit) > 19 {
        return refuse("the shape is out of range");
    }
    NpyHeader::from_reader(&*header).map_err(fault)
}

fn matrix_shape(path: &Path, header: &NpyHeader) -> Result<(usize, usize), Error> {
    let shape = header.shape();
    if let &[rows, columns] = shape
        && let (Ok(rows), Ok(columns)) = (rows.try_into(), columns.try_into())
    {
        if columns == 0 && rows > 0 {
            let reason = format!("the array has {rows} rows but no columns");
            return Err(Error::malformed(path, reason));
        }
        return Ok((rows, columns));
    }
    let reason = format!("the array has shape {shape:?}, not that of a matrix");
    Err(Error::malformed(path, reason))
}

/// Whether entries are `float64`, where only this and `float32` are known.
fn is_double(path: &Path, dtype: &DType) -> Result<bool, Error> {
    let float_bytes = match dtype {
        DType::Plain(kind) if kind.type_char() == TypeChar::Float => kind.num_bytes(),
        _ => None,
    };
    match float_bytes {
        Some(4) => Ok(false),
        Some(8) => Ok(true),
        _ => Err(Error::malformed(
            path,
            format!(
                "entries are of type {}, not float32 or float64",
                dtype.descr()
            ),
        )),
    }
}

fn by_rows(by_columns: &[f64], rows: usize, columns: usize) -> Vec<f64> {
    let places = (0..rows).flat_map(|row| (0..columns).map(move |column| column * rows + row));
    places.map(|place| by_columns[place]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn npy(header: &str, entries: &[u8]) -> Vec<u8> {
        let mut content = b"\x93NUMPY\x01\x00".to_vec();
        content.extend((header.len() as u16).to_le_bytes());
        content.extend(header.as_bytes());
        content.extend(entries);
        content
    }

    fn header(descr: &str, fortran: &str, shape: &str) -> String {
        format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': ({shape}), }}   \n")
    }

    fn file(content: &[u8]) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("array.npy");
        fs::write(&path, content).unwrap();
        (folder, path)
    }

    fn read(content: &[u8]) -> Result<NpyMatrix, Error> {
        let (_folder, path) = file(content);
        read_npy_matrix(path)
    }

    fn complaint(content: &[u8]) -> String {
        read(content).unwrap_err().to_string()
    }

    const ROWS: [f64; 6] = [1.0, 2.5, -3.0, 4.0, 5.0, f64::INFINITY];
    const COLUMNS: [f64; 6] = [1.0, 4.0, 2.5, 5.0, -3.0, f64::INFINITY];

    #[test]
    fn every_type_and_order_gives_the_same_rows() {
        for (fortran, stored) in [("False", ROWS), ("True", COLUMNS)] {
            let single = stored.map(|value| value as f32);
            for (descr, entries) in [
                ("<f4", single.map(f32::to_le_bytes).concat()),
                (">f4", single.map(f32::to_be_bytes).concat()),
                ("<f8", stored.map(f64::to_le_bytes).concat()),
                (">f8", stored.map(f64::to_be_bytes).concat()),
            ] {
                let matrix = read(&npy(&header(descr, fortran, "2, 3"), &entries)).unwrap();
                assert_eq!((matrix.rows, matrix.columns), (2, 3));
                assert_eq!(matrix.values, ROWS, "{descr} {fortran}");
            }
        }
    }

    #[test]
    fn points_are_the_first_three_columns_in_every_type_and_order() {
        let by_rows = [
            1.0,
            2.0,
            3.0,
            9.0,
            f64::NAN,
            0.0,
            0.0,
            9.0,
            4.0,
            5.0,
            6.0,
            9.0,
        ];
        let by_columns = [
            1.0,
            f64::NAN,
            4.0,
            2.0,
            0.0,
            5.0,
            3.0,
            0.0,
            6.0,
            9.0,
            9.0,
            9.0,
        ];
        for (fortran, stored) in [("False", by_rows), ("True", by_columns)] {
            let single = stored.map(|value| value as f32);
            for (descr, entries) in [
                ("<f4", single.map(f32::to_le_bytes).concat()),
                (">f8", stored.map(f64::to_be_bytes).concat()),
            ] {
                let (_folder, path) = file(&npy(&header(descr, fortran, "3, 4"), &entries));
                let scan = read_points(&path).unwrap();
                let expected = [[1.0, 2.0, 3.0].into(), [4.0, 5.0, 6.0].into()];
                assert_eq!(scan.points, expected, "{descr} {fortran}");
                assert_eq!(scan.invalid, 1);
            }
        }
    }

    #[test]
    fn later_versions_have_a_longer_length() {
        let text = header("<f8", "False", "2, 3");
        let mut content = b"\x93NUMPY\x02\x00".to_vec();
        content.extend((text.len() as u32).to_le_bytes());
        content.extend(text.as_bytes());
        content.extend(ROWS.map(f64::to_le_bytes).concat());
        assert_eq!(read(&content).unwrap().values, ROWS);
    }

    #[test]
    fn arrays_without_rows_are_no_error() {
        let matrix = read(&npy(&header("<f4", "False", "0, 3"), &[])).unwrap();
        assert_eq!((matrix.rows, matrix.columns, matrix.values), (0, 3, vec![]));
    }

    #[test]
    fn other_shapes_and_types_are_named() {
        for (content, reason) in [
            (
                npy(&header("<f4", "False", "3,"), &[0; 12]),
                "shape [3], not that of a matrix",
            ),
            (
                npy(&header("<f4", "False", "1, 1, 3"), &[0; 12]),
                "shape [1, 1, 3]",
            ),
            (npy(&header("<f4", "False", ""), &[0; 4]), "shape []"),
            (
                npy(&header("<i4", "False", "1, 3"), &[0; 12]),
                "type '<i4', not float32",
            ),
            (
                npy(&header("<f2", "False", "1, 3"), &[0; 6]),
                "type '<f2', not float32",
            ),
            (
                npy(&header("|O", "False", "1, 3"), &[0; 6]),
                "not float32 or float64",
            ),
            (
                npy(&header("<f4", "False", "1, 3"), &[0; 11]),
                "only 11 bytes follow",
            ),
            (npy(&header("<f4", "Maybe", "1, 3"), &[0; 12]), "header: "),
            (
                npy(
                    "{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': (1,)}",
                    &[0; 4],
                ),
                "plain number type",
            ),
            (Vec::new(), "the file is empty"),
            (b"PK\x03\x04".to_vec(), "not a NPY file"),
        ] {
            let said = complaint(&content);
            assert!(
                said.contains("array.npy") && said.contains(reason),
                "{said}"
            );
        }
    }

    #[test]
    fn rows_without_columns_are_refused_at_once() {
        for order in ["False", "True"] {
            for rows in ["5", "999999999999"] {
                let content = npy(&header("<f4", order, &format!("{rows}, 0")), &[]);
                let said = complaint(&content);
                assert!(
                    said.contains(&format!("{rows} rows but no columns")),
                    "{said}"
                );
            }
        }
    }

    #[test]
    fn hostile_headers_are_refused_at_once() {
        for shape in [
            "4294967296, 4294967296",
            "18446744073709551615, 1",
            "0, 18446744073709551615, 2",
            "0xFFFFFFFFFFFFFFFF, 0xFF",
            "0XFFFFFFFFFFFFFFFF, 9",
            "-1, 3",
            "999999999999999999, 3",
            "0b1111111111111111111111111111111, 3",
            "1e30, 3",
            "9_9_9_9_9_9, 3",
        ] {
            complaint(&npy(&header("<f4", "False", shape), &[0; 12]));
        }
        complaint(&npy(&"(".repeat(60_000), &[]));
        complaint(&npy(&"{'a': ".repeat(1_000), &[]));
        let mut long = b"\x93NUMPY\x02\x00".to_vec();
        long.extend(u32::MAX.to_le_bytes());
        complaint(&long);
        long.extend([b'('; 100_000]);
        long[8..12].copy_from_slice(&100_000u32.to_le_bytes());
        complaint(&long);
    }
}
