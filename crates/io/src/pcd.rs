//! Points in the format of the Point Cloud Library.

use std::io::Read;
use std::path::Path;

use nalgebra::Point3;
use pcd_rs::{DataKind, DynReader, Field, FieldDef, PcdMeta, ValueKind};

use crate::bytes::Source;
use crate::rows::{self, Rows};
use crate::{Error, PointFile};

/// Reads the points of a PCD file.
///
/// All three encodings of the versions 0.5 to 0.7 are read: ascii, binary and binary_compressed.
/// There must be the fields `x`, `y` and `z`, each one float or double. Other fields are skipped, and in
/// ascii need not be numbers. Coordinates are in the unit and the frame of the file. The viewpoint is
/// not applied; its translation is [`PointFile::viewpoint`].
/// Points with a coordinate that is not finite are left out and counted, see [`PointFile`].
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`] if it is empty, foreign or cut
/// off before its last point, or has no such fields. The file is checked before memory is reserved,
/// so a false count in the header is an error too.
///
/// # Example
/// ```
/// use gmpcr_io::read_pcd;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("scan.pcd");
/// let header = "VERSION .7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\n\
///               WIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n";
/// std::fs::write(&path, format!("{header}0.5 1 2\nnan nan nan\n"))?;
/// let scan = read_pcd(&path)?;
/// assert_eq!(scan.points, [[0.5, 1.0, 2.0].into()]);
/// assert_eq!(scan.invalid, 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_pcd(path: impl AsRef<Path>) -> Result<PointFile, Error> {
    let path = path.as_ref();
    let mut source = Source::open(path, "PCD", b"")?;
    let text = plain_header(&source.header(is_last_line)?);
    let header = PcdMeta::from_reader(text.as_bytes());
    let header = header.map_err(|error| Error::parser(path, None, "no PCD header", error))?;
    let axes = coordinate_fields(path, &header)?;
    check_size(&mut source, &header)?;
    let scan = match header.data {
        DataKind::Ascii => read_ascii(source, &header, text.lines().count() + 1),
        DataKind::Binary | DataKind::BinaryCompressed => read_binary(source, &text, axes),
    }?;
    Ok(PointFile {
        has_normals: has_normals(&header),
        viewpoint: viewpoint(&header, &text),
        ..scan
    })
}

fn has_normals(header: &PcdMeta) -> bool {
    let names = ["normal_x", "normal_y", "normal_z"];
    let mut fields = names.iter().map(|name| {
        let mut fields = header.field_defs.iter();
        fields.any(|field| field.name == *name)
    });
    fields.all(|found| found)
}

/// The place of the sensor, if the header has a line for it. Otherwise the parser invents one.
fn viewpoint(header: &PcdMeta, text: &str) -> Option<Point3<f64>> {
    let is_viewpoint = |line: &str| line.split_ascii_whitespace().next() == Some("VIEWPOINT");
    let told = text.lines().any(is_viewpoint);
    let viewpoint = &header.viewpoint;
    let place = Point3::new(viewpoint.tx, viewpoint.ty, viewpoint.tz);
    (told && place.iter().all(|coordinate| coordinate.is_finite())).then_some(place)
}

/// Whether the line ends the header.
fn is_last_line(line: &str) -> bool {
    let first = line.split_ascii_whitespace().next();
    first.is_some_and(|word| word.eq_ignore_ascii_case("DATA"))
}

/// The header with the kind of data in lower case, as the parser needs it.
fn plain_header(header: &str) -> String {
    let plain = |line: &str| match is_last_line(line) {
        true => line.to_ascii_lowercase() + "\n",
        false => line.to_owned() + "\n",
    };
    header.lines().map(plain).collect()
}

fn read_binary(source: Source, header: &str, axes: [usize; 3]) -> Result<PointFile, Error> {
    let path = source.path;
    let records = DynReader::from_reader(header.as_bytes().chain(source.reader));
    let records = records.map_err(|error| Error::parser(path, None, "points", error))?;
    let num_points = records.meta().num_points;
    let mut scan = PointFile::default();
    for (row, record) in (1..).zip(records) {
        let context = || format!("point {row} of {num_points}");
        let record = record.map_err(|error| Error::parser(path, None, &context(), error))?;
        scan.push(axes.map(|axis| coordinate(&record.0[axis])));
    }
    Ok(scan)
}

/// The points of text that starts at line `first_line`; only coordinates need be numbers.
fn read_ascii(source: Source, header: &PcdMeta, first_line: usize) -> Result<PointFile, Error> {
    let num_points = header.num_points;
    let mut rows = Rows::new(source, first_line);
    let mut scan = PointFile::default();
    for row in 1..=num_points {
        let content = rows.next(|| format!("{num_points} points"))?;
        let point = row_coordinates(content, header)
            .map_err(|reason| rows.error(format!("point {row} of {num_points}: {reason}")))?;
        scan.push(point);
    }
    Ok(scan)
}

fn row_coordinates(row: &str, header: &PcdMeta) -> Result<[f64; 3], String> {
    let mut words = row.split_ascii_whitespace();
    let mut coordinates = [0.0; 3];
    for field in &header.field_defs {
        for _ in 0..field.count {
            let missing = || format!("field {:?} is missing", field.name);
            let word = words.next().ok_or_else(missing)?;
            if let Some(axis) = AXES.iter().position(|name| *name == field.name) {
                let single = field.kind == ValueKind::F32;
                coordinates[axis] = rows::coordinate(&field.name, word, single)?;
            }
        }
    }
    match words.next() {
        None => Ok(coordinates),
        Some(word) => Err(format!("{word:?} follows the last field")),
    }
}

const AXES: [&str; 3] = ["x", "y", "z"];

/// Places of `x`, `y`, `z` in a record.
fn coordinate_fields(path: &Path, header: &PcdMeta) -> Result<[usize; 3], Error> {
    // Records leave out the padding.
    let fields = || header.field_defs.iter().filter(|field| !field.is_padding());
    let is_axis = |field: &FieldDef, name| {
        let float = matches!(field.kind, ValueKind::F32 | ValueKind::F64);
        field.name == name && field.count == 1 && float
    };
    let mut axes = [0; 3];
    for (axis, name) in axes.iter_mut().zip(AXES) {
        *axis = fields()
            .position(|field| is_axis(field, name))
            .ok_or_else(|| {
                let reason = format!("no field {name:?} that is one float or double");
                Error::malformed(path, reason)
            })?;
    }
    Ok(axes)
}

fn coordinate(field: &Field) -> f64 {
    match field {
        Field::F32(values) => f64::from(values[0]),
        Field::F64(values) => values[0],
        _ => f64::NAN,
    }
}

/// Checks that the file can hold what its header announces, since the reader relies on it.
fn check_size(source: &mut Source, header: &PcdMeta) -> Result<(), Error> {
    let announced = format!("{} points", header.num_points);
    let needed = |bytes_of: fn(&FieldDef) -> u64| {
        let fields = header.field_defs.iter();
        let mut sizes = fields.map(|field| field.count.checked_mul(bytes_of(field)));
        let record = sizes.try_fold(0u64, |sum, size| sum.checked_add(size?))?;
        record.checked_mul(header.num_points)
    };
    let binary = needed(|field| field.kind.byte_size() as u64);
    match header.data {
        // In text, a number takes a letter at least.
        DataKind::Ascii => source.expect_left(needed(|_| 1), &announced),
        DataKind::Binary => source.expect_left(binary, &announced),
        DataKind::BinaryCompressed => check_compressed_size(source, binary, &announced),
    }
}

/// A compressed body is preceded by its size and the size of what it unpacks to.
fn check_compressed_size(
    source: &mut Source,
    binary: Option<u64>,
    announced: &str,
) -> Result<(), Error> {
    source.expect_left(Some(8), announced)?;
    let mut sizes = [0; 8];
    let read = source.reader.read_exact(&mut sizes);
    let back = read.and_then(|()| source.reader.seek_relative(-8));
    back.map_err(Error::io("read", source.path))?;
    let [a, b, c, d, e, f, g, h] = sizes;
    let packed = u64::from(u32::from_le_bytes([a, b, c, d]));
    let unpacked = u64::from(u32::from_le_bytes([e, f, g, h]));

    let needed = Some(8 + packed);
    source.expect_left(needed, &format!("{announced} in {packed} bytes"))?;
    // LZF makes at most 264 bytes of three.
    if binary != Some(unpacked) || unpacked > 88 * packed {
        return Err(Error::malformed(
            source.path,
            format!("{packed} bytes cannot unpack to {announced} of {unpacked} bytes"),
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use pcd_rs::{DynRecord, DynWriter, Schema, ValueKind, WriterInit};
    use std::fs;
    use std::io::Cursor;

    fn read(content: impl AsRef<[u8]>) -> Result<PointFile, Error> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scan.pcd");
        fs::write(&path, content).unwrap();
        read_pcd(path)
    }

    fn complaint(content: impl AsRef<[u8]>) -> String {
        read(content).unwrap_err().to_string()
    }

    fn written(
        data_kind: DataKind,
        schema: &[(&str, ValueKind, u64)],
        records: &[DynRecord],
    ) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let init = WriterInit {
            width: records.len() as u64,
            height: 1,
            viewpoint: Default::default(),
            data_kind,
            schema: Some(Schema::from_iter(schema.iter().copied())),
            version: None,
        };
        let mut writer: DynWriter<_> = init.build_from_writer(&mut bytes).unwrap();
        for record in records {
            writer.push(record).unwrap();
        }
        writer.finish().unwrap();
        bytes.into_inner()
    }

    const KINDS: [DataKind; 3] = [
        DataKind::Ascii,
        DataKind::Binary,
        DataKind::BinaryCompressed,
    ];

    /// Points of which every seventh is missing, among other fields and in an unusual order.
    fn rich(data_kind: DataKind, num_points: usize) -> Vec<u8> {
        let schema = [
            ("normal", ValueKind::F32, 3),
            ("z", ValueKind::F32, 1),
            ("label", ValueKind::U8, 1),
            ("x", ValueKind::F64, 1),
            ("y", ValueKind::F32, 1),
        ];
        let record = |row: usize| {
            let missing = row % 7 == 3;
            let [x, y, z] = rich_point(row);
            DynRecord(vec![
                Field::F32(vec![0.0, 0.0, 1.0]),
                Field::F32(vec![if missing { f32::NAN } else { z as f32 }]),
                Field::U8(vec![row as u8]),
                Field::F64(vec![x]),
                Field::F32(vec![y as f32]),
            ])
        };
        let records: Vec<_> = (0..num_points).map(record).collect();
        written(data_kind, &schema, &records)
    }

    fn rich_point(row: usize) -> [f64; 3] {
        [0.1 * row as f64, -0.5 * row as f64, 8.0]
    }

    #[test]
    fn all_encodings_hold_the_same_points() {
        let rows = (0..100).filter(|row| row % 7 != 3);
        let expected: Vec<_> = rows.map(|row| rich_point(row).into()).collect();
        for kind in KINDS {
            let scan = read(rich(kind, 100)).unwrap();
            assert_eq!(scan.points, expected, "{kind:?}");
            assert_eq!(scan.invalid, 14, "{kind:?}");
        }
    }

    #[test]
    fn no_points_are_no_error() {
        for kind in KINDS {
            let scan = read(rich(kind, 0)).unwrap();
            assert_eq!((scan.points.len(), scan.invalid), (0, 0), "{kind:?}");
        }
    }

    #[test]
    fn the_viewpoint_is_that_of_the_header_if_it_has_one() {
        let with = |line: &str| {
            let header = LABELLED.replace("POINTS 3", &format!("{line}POINTS 3"));
            let scan = read(header + &"1 0 2 3\n".repeat(3)).unwrap();
            scan.viewpoint
        };
        assert_eq!(with(""), None);
        assert_eq!(
            with("VIEWPOINT 1 2 3 1 0 0 0\n"),
            Some([1.0, 2.0, 3.0].into())
        );
        assert_eq!(with("VIEWPOINT nan 2 3 1 0 0 0\n"), None);
    }

    #[test]
    fn normals_are_there_if_all_three_are() {
        let with = |names: &str| {
            let header = format!(
                "VERSION .7\nFIELDS x y z {names}\nSIZE 4 4 4 4 4 4\nTYPE F F F F F F\n\
                 COUNT 1 1 1 1 1 1\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n"
            );
            read(header + "1 2 3 0 0 1\n").unwrap().has_normals
        };
        assert!(with("normal_x normal_y normal_z"));
        assert!(!with("normal_x normal_y curvature"));
    }

    const PADDED: &str = "# .PCD\r\nVERSION 0.7\r\nFIELDS x _ y z\r\nSIZE 4 1 4 4\r\nTYPE F U F F\r\n\
                          COUNT 1 4 1 1\r\nWIDTH 1\r\nHEIGHT 1\r\nPOINTS 1\r\nDATA binary\r\n";

    #[test]
    fn padding_and_carriage_returns_are_passed_over() {
        let mut content = PADDED.as_bytes().to_vec();
        for number in [1.0f32, f32::NAN, 2.0, 3.0] {
            content.extend(number.to_le_bytes());
        }
        assert_eq!(read(content).unwrap().points, [[1.0, 2.0, 3.0].into()]);
        let text = PADDED.replace("binary", "ascii") + "1 9 9 9 9 2 3\r\n";
        assert_eq!(read(text).unwrap().points, [[1.0, 2.0, 3.0].into()]);
    }

    const LABELLED: &str = "VERSION .7\nFIELDS x label y z\nSIZE 4 4 4 8\nTYPE F U F F\n\
                            COUNT 1 1 1 1\nWIDTH 3\nHEIGHT 1\nPOINTS 3\nDATA ascii\n";

    #[test]
    fn only_coordinates_must_be_numbers_in_ascii() {
        let body = "1 nan 2 3\n\n4 -1 5 0.1\n \n7 8.5 9 1.#QNAN\n";
        for spelling in ["DATA ascii", "DATA ASCII", "# some\nData Ascii"] {
            let header = LABELLED.replace("DATA ascii", spelling);
            let scan = read(header + body).unwrap();
            let expected = [[1.0, 2.0, 3.0].into(), [4.0, 5.0, 0.1].into()];
            assert_eq!((scan.points, scan.invalid), (expected.to_vec(), 1));
        }
    }

    #[test]
    fn bytes_that_are_no_text_in_a_comment_are_passed_over() {
        let rows = b"1 0 2 3\n1 0 2 3\n1 0 2 3";
        let content = [b"# Andr\xe9\n", LABELLED.as_bytes(), rows].concat();
        assert_eq!(read(content).unwrap().points.len(), 3);
    }

    #[test]
    fn binary_kinds_of_data_may_be_in_capitals() {
        for (kind, line) in [
            (DataKind::Binary, "DATA binary\n"),
            (DataKind::BinaryCompressed, "DATA binary_compressed\n"),
        ] {
            let good = rich(kind, 20);
            let mut windows = good.windows(line.len());
            let place = windows.position(|window| window == line.as_bytes());
            let mut content = good.clone();
            content[place.unwrap()..][..line.len()].make_ascii_uppercase();
            assert_eq!(read(content).unwrap(), read(good).unwrap());
        }
    }

    #[test]
    fn faulty_rows_are_named_with_their_line() {
        for (row, reason) in [
            ("1 0 2", "field \"z\" is missing"),
            ("1 0 2 3 4", "\"4\" follows the last field"),
            ("1 0 b 3", "\"y\" is \"b\", not a number"),
            ("", "announces 3 points, but the file ends before"),
        ] {
            let said = complaint(format!("{LABELLED}1.25 0 2.25 3.25\n\n{row}"));
            assert!(
                said.contains("scan.pcd:12: ") && said.contains(reason),
                "{said}"
            );
        }
    }

    #[test]
    fn faults_are_named() {
        let text = PADDED.replace("binary", "ascii");
        let two = text.replace("POINTS 1", "POINTS 2");
        for (content, reason) in [
            (String::new(), "the file is empty"),
            ("solid cube\n".to_owned(), "no PCD header"),
            (
                text.replace("x _ y z", "x _ y w"),
                "no field \"z\" that is one float",
            ),
            (
                text.replace("TYPE F U F F", "TYPE F U I F"),
                "no field \"y\" that is one float",
            ),
            (
                two.clone() + "1 9 9 9 9 2 3\n4 9 9 9 9 5\n",
                "point 2 of 2: ",
            ),
            (
                two.clone() + "1 9 9 9 9 2 3\n",
                "announces 2 points, but the file ends before",
            ),
            (
                two + "1 9 9 9\n",
                "announces 2 points, but only 8 bytes follow",
            ),
            (
                PADDED.to_owned() + "123",
                "announces 1 points, but only 3 bytes follow",
            ),
        ] {
            let said = complaint(&content);
            assert!(said.contains("scan.pcd") && said.contains(reason), "{said}");
        }
    }

    #[test]
    fn counts_that_the_file_cannot_hold_are_refused_at_once() {
        for kind in ["ascii", "binary", "binary_compressed"] {
            for huge in ["99999999", "9223372036854775807", "18446744073709551615"] {
                let header = PADDED.replace("binary", kind);
                complaint(header.replace("POINTS 1", &format!("POINTS {huge}")) + "0123456789");
                complaint(header.replace("COUNT 1 4", &format!("COUNT 1 {huge}")) + "0123456789");
                complaint(
                    header.replace("COUNT 1 4 1 1", &format!("COUNT 1 {huge} 1 {huge}")) + "012",
                );
            }
        }
    }

    #[test]
    fn false_sizes_of_a_compressed_body_are_refused() {
        let good = rich(DataKind::BinaryCompressed, 20);
        let marker = b"DATA binary_compressed\n";
        let body = good
            .windows(marker.len())
            .position(|window| window == marker)
            .unwrap()
            + marker.len();
        let no_points = String::from_utf8_lossy(&good[..body]).replace("POINTS 20", "POINTS 0 ");
        complaint([no_points.as_bytes(), &good[body..]].concat());
        complaint([no_points.as_bytes(), &[255; 8]].concat());
        for place in [body, body + 4] {
            for size in [0, 1, 100, u32::MAX] {
                let mut content = good.clone();
                content[place..place + 4].copy_from_slice(&u32::to_le_bytes(size));
                complaint(content);
            }
        }
        let more_points = String::from_utf8_lossy(&good[..body]).replace("POINTS 20", "POINTS 21");
        complaint([more_points.as_bytes(), &good[body..]].concat());
    }
}
