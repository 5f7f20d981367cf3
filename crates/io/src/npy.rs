//! Matrices in NumPy's array format, the common tongue of learned features.

use std::io::{BufRead, Read, Seek};
use std::path::Path;

use nalgebra::Point3;
use npyz::{DType, NpyFile, NpyHeader, Order, TypeChar};

use crate::bytes::Source;
use crate::{Error, PointFile};

/// A matrix of numbers, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct NpyMatrix {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
    /// The entries: that of row `r` and column `c` is `values[r * columns + c]`.
    pub values: Vec<f64>,
}

/// Descriptors of equal length, one after another.
#[derive(Clone, Debug, PartialEq)]
pub struct Descriptors {
    /// How many numbers a descriptor has; at least one.
    pub dimension: usize,
    /// The numbers: descriptor `k` is `values[k * dimension..(k + 1) * dimension]`.
    pub values: Vec<f32>,
}

/// Reads a two-dimensional `.npy` array of `float32` or `float64`.
///
/// The array may be in C or in Fortran order and of either byte order; the result is row by row in
/// any case. Numbers that are not finite are kept.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`] if it is empty, foreign or cut
/// off, or holds another number of dimensions or another type, or rows without columns; the message
/// tells which. The file is checked before memory is reserved, so a false shape in the header is an
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
    read_matrix(Source::open(path.as_ref(), "NPY", MAGIC)?)
}

/// What an array starts with.
pub(crate) const MAGIC: &[u8] = b"\x93NUMPY";

/// The points of a `.npy` file: the first three columns of its matrix.
pub(crate) fn read_points(path: &Path) -> Result<PointFile, Error> {
    let matrix = read_npy_matrix(path)?;
    points(path, &matrix)
}

pub(crate) fn points(path: &Path, matrix: &NpyMatrix) -> Result<PointFile, Error> {
    let &NpyMatrix { rows, columns, .. } = matrix;
    if columns < 3 {
        let reason = format!("points are n x 3 or wider, but the array is {rows} x {columns}");
        return Err(Error::malformed(path, reason));
    }
    let mut scan = PointFile::default();
    for row in matrix.values.chunks_exact(columns) {
        scan.push([row[0], row[1], row[2]]);
    }
    Ok(scan)
}

/// The header, after which `source` stands then.
pub(crate) fn read_header(source: &mut Source<impl BufRead + Seek>) -> Result<NpyHeader, Error> {
    check_header(source)?;
    let header = NpyHeader::from_reader(&mut source.reader);
    header.map_err(|error| Error::parser(source.path, None, "header", error))
}

pub(crate) fn read_matrix(mut source: Source<impl BufRead + Seek>) -> Result<NpyMatrix, Error> {
    let path = source.path;
    let header = read_header(&mut source)?;
    let (rows, columns) = matrix_shape(path, &header)?;
    let wide = is_double(path, &header.dtype())?;
    let bytes = header.len().checked_mul(if wide { 8 } else { 4 });
    source.expect_left(bytes, &format!("a matrix of shape {:?}", header.shape()))?;

    let order = header.order();
    let file = NpyFile::with_header(header, source.reader);
    let values = if wide {
        file.into_vec::<f64>()
    } else {
        let narrow = file.into_vec::<f32>();
        narrow.map(|values| values.into_iter().map(f64::from).collect())
    };
    let values = values.map_err(|error| Error::parser(path, None, "entries", error))?;
    Ok(NpyMatrix {
        rows,
        columns,
        values: match order {
            Order::C => values,
            Order::Fortran => by_rows(&values, rows, columns),
        },
    })
}

/// Turns away headers that would overwhelm the header parser, which multiplies the shape without
/// looking for overflow, descends into nested brackets, and reserves whatever length it is told.
///
/// A header of a plain matrix is short and flat, and the decimal digits of its shape are few: up to
/// 18 of them, besides the digit of the type, multiply to less than 2^64.
fn check_header(source: &mut Source<impl BufRead + Seek>) -> Result<(), Error> {
    // As NumPy does by default.
    const LONGEST: u64 = 10_000;
    let path = source.path;
    let refuse = |reason: &str| Err(Error::malformed(path, format!("header: {reason}")));

    let length = header_length(source)?;
    if length > LONGEST.min(source.bytes_left()?) {
        return refuse(&format!("a length of {length} bytes is too much"));
    }
    let mut header = Vec::new();
    let read = source.reader.by_ref().take(length).read_to_end(&mut header);
    read.map_err(Error::io("read", path))?;
    source.reader.rewind().map_err(Error::io("read", path))?;

    let count = |wanted: fn(&u8) -> bool| header.iter().filter(|&byte| wanted(byte)).count();
    if count(|byte| b"({[".contains(byte)) > 2 {
        return refuse("only arrays of a plain number type are supported");
    }
    let hexadecimal = header
        .windows(2)
        .any(|pair| pair.eq_ignore_ascii_case(b"0x"));
    if hexadecimal || count(u8::is_ascii_digit) > 19 {
        return refuse("the shape is out of range");
    }
    Ok(())
}

/// Length of the header's text: two bytes in version 1 of the format, four in later ones.
fn header_length(source: &mut Source<impl BufRead + Seek>) -> Result<u64, Error> {
    let mut start = [0; 8];
    let mut length = [0; 4];
    let reader = &mut source.reader;
    let read = reader.read_exact(&mut start).and_then(|()| match start[6] {
        1 => reader.read_exact(&mut length[..2]),
        _ => reader.read_exact(&mut length),
    });
    read.map_err(|error| Error::parser(source.path, None, "header", error))?;
    Ok(u32::from_le_bytes(length).into())
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

/// Reads keypoints from an n×3 `.npy` array of `float32` or `float64`, a point per row.
///
/// All rows are kept, also those that are not finite, since row `k` belongs to row `k` of the
/// descriptors.
///
/// # Errors
/// As for [`read_npy_matrix`], and [`Error::Malformed`] if there are not three columns.
///
/// # Example
/// ```
/// use gmpcr_io::read_keypoints;
/// use npyz::WriterBuilder;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("0.kpts.npy");
/// let mut file = npyz::WriteOptions::new()
///     .default_dtype()
///     .shape(&[2, 3])
///     .writer(std::fs::File::create(&path)?)
///     .begin_nd()?;
/// file.extend([1.0f32, 2.0, 3.0, 4.0, 5.0, 6.0])?;
/// file.finish()?;
///
/// assert_eq!(read_keypoints(&path)?, [[1.0, 2.0, 3.0].into(), [4.0, 5.0, 6.0].into()]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_keypoints(path: impl AsRef<Path>) -> Result<Vec<Point3<f64>>, Error> {
    let path = path.as_ref();
    let matrix = read_npy_matrix(path)?;
    if matrix.columns != 3 {
        let (rows, columns) = (matrix.rows, matrix.columns);
        let reason = format!("keypoints are n x 3, but the array is {rows} x {columns}");
        return Err(Error::malformed(path, reason));
    }
    let points = matrix.values.chunks_exact(3);
    Ok(points.map(Point3::from_slice).collect())
}

/// Reads descriptors from an n×d `.npy` array of `float32` or `float64`, a descriptor per row.
///
/// Wider numbers are rounded to `f32`. All rows are kept, also those that are not finite, since row
/// `k` belongs to row `k` of the keypoints.
///
/// # Errors
/// As for [`read_npy_matrix`], and [`Error::Malformed`] if there are no columns.
///
/// # Example
/// ```
/// use gmpcr_io::read_descriptors;
/// use npyz::WriterBuilder;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("0.desc.npy");
/// let mut file = npyz::WriteOptions::new()
///     .default_dtype()
///     .shape(&[3, 2])
///     .writer(std::fs::File::create(&path)?)
///     .begin_nd()?;
/// file.extend([0.0f32, 1.0, 0.6, 0.8, 1.0, 0.0])?;
/// file.finish()?;
///
/// let descriptors = read_descriptors(&path)?;
/// assert_eq!(descriptors.dimension, 2);
/// assert_eq!(descriptors.values[2..4], [0.6, 0.8]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_descriptors(path: impl AsRef<Path>) -> Result<Descriptors, Error> {
    let path = path.as_ref();
    let matrix = read_npy_matrix(path)?;
    if matrix.columns == 0 {
        return Err(Error::malformed(
            path,
            "descriptors need columns, but the array is 0 x 0",
        ));
    }
    Ok(Descriptors {
        dimension: matrix.columns,
        values: matrix
            .values
            .into_iter()
            .map(|value| value as f32)
            .collect(),
    })
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
        let (_folder, path) = file(&npy(&header("<f4", "False", "0, 3"), &[]));
        assert!(read_keypoints(&path).unwrap().is_empty());
        assert_eq!(read_descriptors(&path).unwrap().dimension, 3);
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
    fn keypoints_and_descriptors_tell_their_shape() {
        let (_folder, path) = file(&npy(&header("<f4", "False", "1, 4"), &[0; 16]));
        let said = read_keypoints(&path).unwrap_err().to_string();
        assert!(
            said.contains("keypoints are n x 3, but the array is 1 x 4"),
            "{said}"
        );
        let (_folder, path) = file(&npy(&header("<f4", "False", "0, 0"), &[]));
        let said = read_descriptors(&path).unwrap_err().to_string();
        assert!(said.contains("the array is 0 x 0"), "{said}");
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
