//! Points in the Stanford polygon format.

mod ascii;
mod binary;
mod header;
mod names;

use std::path::Path;

use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{DefaultElement, ElementDef, Encoding, Header, PropertyType};

use self::ascii::read_ascii;
use self::binary::read_binary;
use self::names::{AXES, NORMAL};
use crate::bytes::Source;
use crate::{Error, PointFile};

/// Reads the vertices of a PLY file.
///
/// All three encodings are read: ascii, binary little and big endian. The element `vertex` must
/// have the scalar properties `x`, `y` and `z`, of any number type; its other properties, whatever
/// their names, and all other elements are skipped. Coordinates are in the unit and the frame of the
/// file. Vertices
/// with a coordinate that is not finite are left out and counted, see [`PointFile`].
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`] if it is empty, foreign or cut
/// off before its last vertex, or has no vertices with `x`, `y`, `z`. The file is checked before
/// memory is reserved, so a false count in the header is an error too.
///
/// # Example
/// ```
/// use gmpcr_io::read_ply;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("scan.ply");
/// let header = "ply\nformat ascii 1.0\ncomment two points\nelement vertex 2\n\
///               property double x\nproperty double y\nproperty double z\nend_header\n";
/// std::fs::write(&path, format!("{header}1 2 3\n4 5 6.25\n"))?;
/// assert_eq!(read_ply(&path)?.points, [[1.0, 2.0, 3.0].into(), [4.0, 5.0, 6.25].into()]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_ply(path: impl AsRef<Path>) -> Result<PointFile, Error> {
    let mut source = Source::open(path.as_ref(), "PLY", b"ply")?;
    let plain_header = header::plain(&source.header(header::is_last_line)?);
    let mut reader = Reader::new(plain_header.as_bytes());
    let header = Parser::<DefaultElement>::new().read_header(&mut reader);
    let header = header.map_err(|error| Error::parser(source.path, None, "header", error))?;
    let first_line = reader.line();
    check_unambiguous(source.path, &header, first_line - 1)?;
    let elements = up_to_vertices(source.path, &header)?;
    let has_normals = elements.last().is_some_and(|vertex| has_normals(vertex));
    let scan = match header.encoding {
        Encoding::Ascii => read_ascii(source, &elements, first_line),
        Encoding::BinaryBigEndian | Encoding::BinaryLittleEndian => {
            read_binary(source, &elements, &header)
        }
    }?;
    Ok(PointFile {
        has_normals,
        ..scan
    })
}

/// Of two declarations of one name, the parser keeps the last, and misreads the payload; but
/// then the header has more lines than it declares things.
fn check_unambiguous(path: &Path, header: &Header, num_lines: usize) -> Result<(), Error> {
    let elements = header.elements.values();
    let declared: usize = elements.map(|element| 1 + element.properties.len()).sum();
    let others = 3; // ply, format, end_header
    if num_lines != others + header.comments.len() + header.obj_infos.len() + declared {
        return Err(Error::malformed(path, "the header declares the same twice"));
    }
    Ok(())
}

/// The elements of the file up to the vertices, which come last; what follows is not looked at.
fn up_to_vertices<'a>(path: &Path, header: &'a Header) -> Result<Vec<&'a ElementDef>, Error> {
    let place = header.elements.get_index_of("vertex");
    let place = place.ok_or_else(|| Error::malformed(path, "no element \"vertex\""))?;
    let elements: Vec<&ElementDef> = header.elements.values().take(place + 1).collect();
    for name in AXES {
        if !has_scalar(elements[place], name) {
            return Err(Error::malformed(
                path,
                format!("element \"vertex\" has no scalar property {name:?}"),
            ));
        }
    }
    Ok(elements)
}

fn has_normals(vertex: &ElementDef) -> bool {
    NORMAL.iter().all(|name| has_scalar(vertex, name))
}

fn has_scalar(element: &ElementDef, name: &str) -> bool {
    let property = element.properties.get(name);
    property.is_some_and(|property| matches!(property.data_type, PropertyType::Scalar(_)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn read(content: impl AsRef<[u8]>) -> Result<PointFile, Error> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scan.ply");
        fs::write(&path, content).unwrap();
        read_ply(path)
    }

    fn complaint(content: impl AsRef<[u8]>) -> String {
        read(content).unwrap_err().to_string()
    }

    const XYZ: &str = "property float x\nproperty float y\nproperty float z\n";

    fn ascii(vertices: usize, body: &str) -> String {
        format!("ply\nformat ascii 1.0\nelement vertex {vertices}\n{XYZ}end_header\n{body}")
    }

    #[test]
    fn normals_are_there_if_all_three_are() {
        let normals = "property float nx\nproperty float ny\nproperty float nz\nend_header";
        let content = ascii(1, "1 2 3 0 0 1\n").replace("end_header", normals);
        let scan = read(&content).unwrap();
        assert!(scan.has_normals);
        assert_eq!(scan.points, [[1.0, 2.0, 3.0].into()]);
        let content = content.replace("property float nz", "property float curvature");
        assert!(!read(content).unwrap().has_normals);
        let listed =
            "property list uchar float nx\nproperty float ny\nproperty float nz\nend_header";
        let content = ascii(1, "1 2 3 0 0 1\n").replace("end_header", listed);
        assert!(!read(content).unwrap().has_normals);
    }

    /// A camera, then vertices with color, list and double coordinates, then a face.
    fn rich_header(encoding: &str) -> String {
        format!(
            "ply\nformat {encoding} 1.0\ncomment made by hand\nobj_info none\nelement camera 1\n\
             property list uchar short values\nelement vertex 2\nproperty uchar red\n\
             property list uchar int marks\nproperty double z\nproperty float x\n\
             property short y\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        )
    }

    const RICH: [[f64; 3]; 2] = [[0.5, -2.0, 1e300], [0.25, 3.0, -0.1]];

    fn rich_binary(big_endian: bool) -> Vec<u8> {
        let order = |mut bytes: Vec<u8>| {
            if !big_endian {
                bytes.reverse();
            }
            bytes
        };
        let encoding = if big_endian {
            "binary_big_endian"
        } else {
            "binary_little_endian"
        };
        let mut content = rich_header(encoding).into_bytes();
        content.push(2);
        content.extend(order(7i16.to_be_bytes().to_vec()));
        content.extend(order(8i16.to_be_bytes().to_vec()));
        for (marks, [x, y, z]) in RICH.into_iter().enumerate() {
            content.extend([255, marks as u8]);
            for _ in 0..marks {
                content.extend(order(9i32.to_be_bytes().to_vec()));
            }
            content.extend(order(z.to_be_bytes().to_vec()));
            content.extend(order((x as f32).to_be_bytes().to_vec()));
            content.extend(order((y as i16).to_be_bytes().to_vec()));
        }
        content.extend([0]);
        content
    }

    #[test]
    fn all_encodings_of_a_rich_file_hold_the_same_points() {
        let body = "2 7 8\n255 0 1e300 0.5 -2\n255 1 9 -0.1 0.25 3\n0\n";
        let expected = RICH.map(Into::into);
        assert_eq!(read(rich_header("ascii") + body).unwrap().points, expected);
        assert_eq!(read(rich_binary(false)).unwrap().points, expected);
        assert_eq!(read(rich_binary(true)).unwrap().points, expected);
    }

    const ODD_NAMES: [&str; 7] = [
        "scalar_C2C_absolute_distances[<1]",
        "scalar_Gaussian_curvature_(0.1)",
        "scalar_dip.x",
        "scalar_R/G",
        "scalar_a#",
        "höhe",
        "höhe",
    ];

    /// A header with a property of each odd name around the coordinates, a byte that is no text
    /// and blank lines.
    fn odd_header(encoding: &str, line_end: &str) -> Vec<u8> {
        let odd = ODD_NAMES.map(|name| format!("property float {name}\n"));
        let (before, after) = odd.split_at(3);
        let header = format!(
            "ply\nformat {encoding} 1.0\ncomment by Andr?\n\nobj_info ?\nelement vertex 2\n{}{XYZ}\n{}\
             element face 0\nproperty list uchar int vertex.indices\nend_header\n",
            before.concat(),
            after.concat()
        );
        let latin_1 = |byte| if byte == b'?' { 0xe9 } else { byte };
        let header = header.replace('\n', line_end).into_bytes();
        header.into_iter().map(latin_1).collect()
    }

    #[test]
    fn odd_names_and_lines_in_the_header_are_passed_over() {
        let expected = [[3.0, 4.0, 5.0].into(), [13.0, 14.0, 15.0].into()];
        let numbers = (0..20u8).map(f32::from);
        let big: Vec<u8> = numbers.clone().flat_map(f32::to_be_bytes).collect();
        let little: Vec<u8> = numbers.flat_map(f32::to_le_bytes).collect();
        for line_end in ["\n", "\r\n"] {
            for (encoding, body) in [
                (
                    "ascii",
                    &b"0 nan 2 3 4 5 6 7 8 9\n10 11 12 13 14 15 16 17 18 19"[..],
                ),
                ("binary_big_endian", &big),
                ("binary_little_endian", &little),
            ] {
                let scan = read([&odd_header(encoding, line_end), body].concat()).unwrap();
                assert_eq!(scan.points, expected, "{encoding}");
            }
        }
    }

    #[test]
    fn errors_below_an_odd_header_name_the_line_of_the_file() {
        let content = [&odd_header("ascii", "\n"), &b"0 1 2 3 4 5 6 7 8\n"[..]].concat();
        let said = complaint(content);
        assert!(said.contains(":21: property 10 is missing"), "{said}");
        let said = complaint("ply\n\nformat ascii 1.0\n\nelement vertex\nend_header\n");
        assert!(said.contains("Line 5"), "{said}");
    }

    #[test]
    fn carriage_returns_and_blank_lines_are_white_space() {
        let content = ascii(2, "0 1 2\n\n   \n3 4 5").replace('\n', "\r\n");
        let expected = [[0.0, 1.0, 2.0].into(), [3.0, 4.0, 5.0].into()];
        assert_eq!(read(content).unwrap().points, expected);
    }

    #[test]
    fn text_is_rounded_to_the_declared_type() {
        let scan = read(ascii(1, "0.1 .5 1.\n")).unwrap();
        assert_eq!(scan.points, [[f64::from(0.1f32), 0.5, 1.0].into()]);
        let scan = read(ascii(1, "0.1 0 0\n").replace("float", "double")).unwrap();
        assert_eq!(scan.points[0].x, 0.1);
    }

    #[test]
    fn vertices_without_a_position_are_counted_in_every_spelling() {
        let body = "nan nan nan\n-nan 0 0\n0 NaN 0\n0 0 -nan(ind)\n0 inf 0\n1 2 3\n";
        let scan = read(ascii(6, body)).unwrap();
        assert_eq!((scan.points.len(), scan.invalid), (1, 5));
    }

    #[test]
    fn no_vertices_are_no_error() {
        assert_eq!(read(ascii(0, "")).unwrap(), PointFile::default());
    }

    #[test]
    fn faults_are_named() {
        for (content, reason) in [
            (String::new(), "the file is empty"),
            ("solid cube\n".to_owned(), "not a PLY file"),
            ("ply\nformat ascii 1.0\n".to_owned(), "missing 'end_header'"),
            (
                "ply\nformat ascii 1.0\nend_header\n".to_owned(),
                "no element \"vertex\"",
            ),
            (
                ascii(1, "0 0 0 0\n").replace("end_", "property float x\nend_"),
                "the same twice",
            ),
            (
                ascii(1, "0 0 0\n").replace("end_", "element vertex 2\nend_"),
                "the same twice",
            ),
            (
                ascii(1, "0 0 0\n").replace("float z", "float w"),
                "no scalar property \"z\"",
            ),
            (
                ascii(1, "0 0 0\n").replace("float y", "list uchar float y"),
                "property \"y\"",
            ),
            (
                ascii(2, "0 0 0\n"),
                ":9: the header announces 2 times element \"vertex\"",
            ),
            (ascii(2, "0 0 0\n0 0\n"), ":9: property \"z\" is missing"),
            (ascii(1, "0 a 0\n"), ":8: \"y\" is \"a\", not a number"),
        ] {
            let said = complaint(&content);
            assert!(said.contains("scan.ply") && said.contains(reason), "{said}");
        }
    }

    #[test]
    fn a_header_without_end_is_refused() {
        let comments = "comment more\n".repeat(1_000_000);
        let said = complaint(format!("ply\nformat ascii 1.0\n{comments}"));
        assert!(said.contains("the header takes 4194304 bytes"), "{said}");
    }

    #[test]
    fn counts_that_the_file_cannot_hold_are_refused_at_once() {
        for count in [
            "4294967296",
            "18446744073709551615",
            "99999999999999999999999",
        ] {
            for encoding in ["ascii", "binary_little_endian", "binary_big_endian"] {
                let vertices =
                    ascii(7, "some bytes").replace("vertex 7", &format!("vertex {count}"));
                complaint(vertices.replace("ascii", encoding));
                let empty_element = format!("element nothing {count}\nelement vertex");
                let empty = ascii(0, "").replace("element vertex", &empty_element);
                complaint(empty.replace("ascii", encoding));
            }
        }
        let list = "property list uint double marks\nproperty float x";
        let content = ascii(1, "\u{7f}\u{7f}\u{7f}\u{7f}0123456789abcdef");
        let content = content.replace("ascii", "binary_little_endian");
        complaint(content.replace("property float x", list));
        let text = ascii(1, "18446744073709551615 0 0 0\n");
        complaint(text.replace("property float x", list));
    }
}
