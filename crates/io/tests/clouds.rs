//! Laws of the formats of point clouds. The same cloud comes back from each. No file that is cut off,
//! changed or false about its size makes a reader panic or reserve more memory than the file can fill.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use gmpcr_io::*;
use nalgebra::{Isometry3, Point3};

/// Coordinates as in a projection of the Earth, in whole millimeters.
fn utm_cloud(num_points: usize) -> Vec<Point3<f64>> {
    let millimeters = |n: usize| n as f64 / 1000.0;
    let point = |k: usize| {
        Point3::new(
            millimeters(672_345_123 + 7919 * k),
            millimeters(5_194_876_547 - 6007 * k),
            millimeters(561_009 + 31 * (k * k % 977)),
        )
    };
    (0..num_points).map(point).collect()
}

fn bytes_of(write: impl FnOnce(&Path)) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("file");
    write(&path);
    fs::read(path).unwrap()
}

fn text(cloud: &[Point3<f64>], heading: &str, separator: &str) -> Vec<u8> {
    let row = |p: &Point3<f64>| format!("{1:?}{0}{2:?}{0}{3:?}\n", separator, p.x, p.y, p.z);
    let rows: String = cloud.iter().map(row).collect();
    (heading.to_owned() + &rows).into_bytes()
}

fn npy(cloud: &[Point3<f64>]) -> Vec<u8> {
    let numbers = cloud.iter().flat_map(|p| [p.x, p.y, p.z, 7.0]);
    let numbers: Vec<u8> = numbers.flat_map(f64::to_le_bytes).collect();
    array(&format!("{}, 4", cloud.len()), &numbers)
}

/// A `.npy` file of doubles in C order.
fn array(shape: &str, entries: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({shape}), }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(entries);
    bytes
}

/// The cloud in every format that this build reads, and how far its coordinates may be off.
fn samples(cloud: &[Point3<f64>]) -> Vec<(&'static str, Vec<u8>, f64)> {
    let merged = bytes_of(|path| {
        let cloud = ColoredCloud {
            points: cloud,
            world_from_points: Isometry3::identity(),
            color: [1, 2, 3],
        };
        write_merged_ply(path, Coordinates::Double, [cloud]).unwrap();
    });
    let pcd_header = format!(
        "VERSION .7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {0}\nHEIGHT 1\nPOINTS {0}\nDATA ascii\n",
        cloud.len()
    );
    #[allow(unused_mut, reason = "without features there are no more")]
    let mut samples = vec![
        ("a.ply", merged, 0.0),
        ("a.pcd", text(cloud, &pcd_header, " "), 0.0),
        ("a.xyz", text(cloud, "# heading\n", "\t"), 0.0),
        ("a.csv", text(cloud, "x,y,z\n", ","), 0.0),
        (
            "a.pts",
            text(cloud, &format!("{}\n", cloud.len()), " "),
            0.0,
        ),
        ("a.txt", text(cloud, "", ";"), 0.0),
        ("a.npy", npy(cloud), 0.0),
    ];
    #[cfg(feature = "npz")]
    samples.push(("a.npz", archive::npz(&[("points", npy(cloud))], true), 0.0));
    #[cfg(feature = "las")]
    samples.push(("a.las", laser::las(cloud, 1, false), 1e-9));
    #[cfg(feature = "laz")]
    {
        samples.push(("a.laz", laser::las(cloud, 1, true), 1e-9));
        samples.push(("layers.laz", laser::las(cloud, 8, true), 1e-9));
    }
    #[cfg(feature = "e57")]
    samples.push(("a.e57", scanner::e57(&[(None, cloud.to_vec())]), 0.0));
    samples
}

fn place(name: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    (folder, path)
}

fn read(name: &str, content: &[u8]) -> Result<PointFile, Error> {
    let (_folder, path) = place(name);
    fs::write(&path, content).unwrap();
    let start = Instant::now();
    let scan = read_points(path);
    // Hundreds of times what the largest of these files takes.
    assert!(
        start.elapsed() < Duration::from_secs(20),
        "{name} takes too long"
    );
    scan
}

/// A damaged file is a cloud no larger than a file of its size can hold, or an error by name.
fn check_damaged(name: &str, content: &[u8]) {
    match read(name, content) {
        Ok(scan) => assert!(scan.points.len() + scan.invalid <= 1000 * content.len()),
        Err(error) => assert!(error.to_string().contains(name), "{error}"),
    }
}

fn complaint(name: &str, content: &[u8]) -> String {
    let said = read(name, content).unwrap_err().to_string();
    assert!(said.contains(name) && said.len() < 500, "{said}");
    said
}

fn assert_near(found: &[Point3<f64>], expected: &[Point3<f64>], tolerance: f64, name: &str) {
    assert_eq!(found.len(), expected.len(), "{name}");
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).amax() <= tolerance, "{name}: {a} {b}");
    }
}

#[test]
fn the_same_cloud_comes_back_from_every_format() {
    for num_points in [0, 1, 2, 1000] {
        let cloud = utm_cloud(num_points);
        for (name, content, tolerance) in samples(&cloud) {
            // Text without points, count or names of columns is any text.
            if num_points == 0 && ["a.txt", "a.xyz"].contains(&name) {
                continue;
            }
            let scan = read(name, &content).unwrap();
            assert_near(&scan.points, &cloud, tolerance, name);
            assert_eq!(scan.invalid, 0, "{name}");
        }
    }
}

#[test]
fn a_file_cut_off_anywhere_is_refused_by_name_where_the_format_tells() {
    for (name, content, _) in samples(&utm_cloud(20)) {
        let is_list = ["a.xyz", "a.csv", "a.txt"].contains(&name);
        // Text may end within its last number.
        let last = if ["a.pts", "a.pcd"].contains(&name) {
            20
        } else {
            0
        };
        let step = (content.len() / 400).max(1);
        for length in (0..content.len()).step_by(step) {
            match read(name, &content[..length]) {
                Ok(_) => assert!(is_list || length + last > content.len(), "{name} {length}"),
                Err(error) => assert!(error.to_string().contains(name), "{error}"),
            }
        }
    }
}

#[test]
fn changed_bytes_make_no_reader_panic_or_linger() {
    for (name, content, _) in samples(&utm_cloud(20)) {
        let step = (content.len() / 200).max(1);
        for place in (0..content.len())
            .step_by(step)
            .chain(0..content.len().min(120))
        {
            for byte in [0, 1, 0x7f, 0xff] {
                let mut content = content.clone();
                content[place] = byte;
                check_damaged(name, &content);
            }
        }
    }
}

#[test]
fn foreign_content_is_refused_by_name() {
    let jpeg = b"\xff\xd8\xff\xe0\x00\x10JFIF\x00\x01\x01\x00\x00\x01".to_vec();
    let prose = b"This is no data file.\nIt has two lines.\n".to_vec();
    let noise = vec![0xC3; 100_000];
    for content in [jpeg, prose, noise, vec![0; 4096]] {
        for (name, ..) in samples(&utm_cloud(1)) {
            complaint(name, &content);
        }
    }
}

#[test]
fn empty_and_missing_files_are_refused_by_name() {
    for (name, ..) in samples(&utm_cloud(1)) {
        assert!(complaint(name, b"").contains("the file is empty"));
        let (_folder, path) = place(name);
        let error = read_points(&path).unwrap_err();
        assert!(matches!(error, Error::Io { .. }), "{error}");
        fs::create_dir(&path).unwrap();
        let error = read_points(&path).unwrap_err();
        assert!(error.to_string().contains(name), "{error}");
    }
}

#[test]
fn an_array_needs_three_columns() {
    assert!(
        complaint("a.npy", &array("2, 2", &[0; 32]))
            .contains("n x 3 or wider, but the array is 2 x 2")
    );
}

#[cfg(feature = "npz")]
mod archive {
    use super::*;
    use std::io::{Cursor, Write};
    use zip::write::SimpleFileOptions;
    use zip::{CompressionMethod, ZipWriter};

    pub(crate) fn npz(arrays: &[(&str, Vec<u8>)], compressed: bool) -> Vec<u8> {
        let method = match compressed {
            true => CompressionMethod::Deflated,
            false => CompressionMethod::Stored,
        };
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        for (name, bytes) in arrays {
            let options = SimpleFileOptions::default().compression_method(method);
            archive.start_file(format!("{name}.npy"), options).unwrap();
            archive.write_all(bytes).unwrap();
        }
        archive.finish().unwrap().into_inner()
    }

    fn vector() -> Vec<u8> {
        array("2,", &[0; 16])
    }

    #[test]
    fn the_array_of_points_is_that_of_the_usual_name_or_the_only_matrix() {
        let (cloud, other) = (utm_cloud(3), utm_cloud(5));
        for arrays in [
            vec![("color", npy(&other)), ("xyz", npy(&cloud))],
            vec![("pc", npy(&other)), ("points", npy(&cloud))],
            vec![("stamp", vector()), ("arr_0", npy(&cloud))],
            vec![("a", b"no array".to_vec()), ("pcd", npy(&cloud))],
        ] {
            for compressed in [false, true] {
                let scan = read("a.npz", &npz(&arrays, compressed)).unwrap();
                assert_eq!(scan.points, cloud);
            }
        }
    }

    #[test]
    fn an_archive_that_is_false_about_its_size_is_refused_at_once() {
        let zeros = vec![0; 1 << 24];
        let honest = npz(
            &[("points", array("699050, 3", &zeros[..699_050 * 24]))],
            true,
        );
        assert_eq!(read("a.npz", &honest).unwrap().points.len(), 699_050);

        // A small array, then a bomb.
        let long = npz(&[("points", array("2, 3", &zeros))], true);
        assert!(long.len() < 1 << 15);
        let said = complaint("a.npz", &long);
        assert!(said.contains("longer than its shape"), "{said}");

        for shape in ["99999999, 3", "3, 99999999999999", "99999999999999999, 9"] {
            let short = npz(&[("points", array(shape, &zeros))], true);
            let said = complaint("a.npz", &short);
            assert!(
                said.contains("cannot unpack to a matrix of shape"),
                "{said}"
            );
        }
        let short = npz(&[("points", array("3, 3", &[0; 71]))], true);
        assert!(complaint("a.npz", &short).contains("entries"));
    }

    #[test]
    fn an_array_that_its_checksum_belies_is_refused() {
        let mut content = npz(&[("points", array("1, 3", &[b'@'; 24]))], false);
        let place = content
            .windows(24)
            .position(|bytes| bytes == [b'@'; 24])
            .unwrap();
        content[place] = b'A';
        let said = complaint("a.npz", &content);
        assert!(said.contains("checksum"), "{said}");
    }

    #[test]
    fn an_unclear_archive_lists_its_arrays() {
        let cloud = npy(&utm_cloud(3));
        let said = complaint("a.npz", &npz(&[("a", cloud.clone()), ("b", cloud)], false));
        assert!(
            said.contains("the arrays are: a [3, 4], b [3, 4]"),
            "{said}"
        );
        let said = complaint("a.npz", &npz(&[("t", vector())], false));
        assert!(said.contains("the arrays are: t [2]"), "{said}");
        complaint("a.npz", &npz(&[("points", vector())], false));
        complaint("a.npz", &npz(&[("points", b"no array".to_vec())], false));
        complaint("a.npz", &npz(&[], false));
    }
}

#[cfg(feature = "las")]
mod laser {
    use super::*;
    use las::point::Format;
    use las::{Builder, Color, Point, Transform, Vector, Writer};

    pub(crate) fn las(cloud: &[Point3<f64>], format: u8, compressed: bool) -> Vec<u8> {
        let mut builder = Builder::from((1, 4));
        builder.point_format = Format::new(format).unwrap();
        builder.point_format.is_compressed = compressed;
        let transform = |offset| Transform {
            scale: 0.001,
            offset,
        };
        builder.transforms = Vector {
            x: transform(672_000.0),
            y: transform(5_194_000.0),
            z: transform(0.0),
        };
        bytes_of(|path| {
            let header = builder.into_header().unwrap();
            let mut writer = Writer::from_path(path.with_extension("las"), header.clone());
            if compressed {
                writer = Writer::from_path(path.with_extension("laz"), header);
            }
            let mut writer = writer.unwrap();
            for p in cloud {
                let point = Point {
                    x: p.x,
                    y: p.y,
                    z: p.z,
                    gps_time: builder_has_time(format).then_some(0.5),
                    color: (format == 8).then(|| Color::new(1, 2, 3)),
                    nir: (format == 8).then_some(9),
                    ..Point::default()
                };
                writer.write_point(point).unwrap();
            }
            writer.close().unwrap();
            let written = path.with_extension(if compressed { "laz" } else { "las" });
            fs::rename(written, path).unwrap();
        })
    }

    fn builder_has_time(format: u8) -> bool {
        Format::new(format).unwrap().has_gps_time
    }

    const OFFSET_TO_POINTS: usize = 96;
    const FORMAT: usize = 104;
    const COUNT: usize = 107;
    const LARGE_COUNT: usize = 247;
    const FIRST_EXTENDED: usize = 235;

    fn with(content: &[u8], place: usize, bytes: &[u8]) -> Vec<u8> {
        let mut content = content.to_vec();
        content[place..place + bytes.len()].copy_from_slice(bytes);
        content
    }

    #[test]
    fn counts_that_the_file_cannot_hold_are_refused_at_once() {
        let good = las(&utm_cloud(20), 1, false);
        let said = complaint("a.las", &with(&good, COUNT, &u32::MAX.to_le_bytes()));
        assert!(
            said.contains("announces 4294967295 points, but only"),
            "{said}"
        );
        let none = with(&good, COUNT, &[0; 4]);
        for huge in [21, u64::MAX, u64::MAX / 28] {
            complaint("a.las", &with(&none, LARGE_COUNT, &huge.to_le_bytes()));
        }
        for start in [1, u64::MAX, good.len() as u64 - 60] {
            let extended = [&start.to_le_bytes()[..], &[1, 0, 0, 0]].concat();
            complaint("a.las", &with(&good, FIRST_EXTENDED, &extended));
        }
        complaint("a.las", &with(&good, OFFSET_TO_POINTS, &[0xff; 4]));
        complaint("a.las", &with(&good, OFFSET_TO_POINTS, &[0; 4]));
    }

    #[test]
    fn a_name_does_not_hide_compression() {
        let content = las(&utm_cloud(20), 1, false);
        let content = with(&content, FORMAT, &[0x81]);
        let said = complaint("a.las", &content);
        assert_eq!(
            said.contains("rebuild with the feature `laz`"),
            cfg!(not(feature = "laz"))
        );
    }

    #[cfg(feature = "laz")]
    #[test]
    fn a_damaged_compressed_file_is_read_or_refused() {
        for format in [1, 8] {
            let good = las(&utm_cloud(120), format, true);
            // The decompressor panics at some of these changes.
            for place in 0..good.len() {
                check_damaged("a.laz", &with(&good, place, &[!good[place]]));
            }
        }
    }

    #[cfg(feature = "laz")]
    #[test]
    fn a_compressed_file_that_is_false_about_its_size_is_refused_at_once() {
        for format in [1, 8] {
            let good = las(&utm_cloud(20), format, true);
            let start = u32::from_le_bytes(std::array::from_fn(|k| good[OFFSET_TO_POINTS + k]));
            let start = start as usize;
            let table = u64::from_le_bytes(std::array::from_fn(|k| good[start + k])) as usize;
            let none = with(&good, COUNT, &[0; 4]);
            for huge in [u64::MAX, u64::MAX / 30, 1 << 40] {
                complaint("a.laz", &with(&none, LARGE_COUNT, &huge.to_le_bytes()));
            }
            complaint("a.laz", &with(&good, table + 4, &[0xff; 4]));
            if format == 8 {
                let layers = start + 8 + usize::from(good[105]) + 4;
                for layer in 0..11 {
                    let said = complaint("a.laz", &with(&good, layers + 4 * layer, &[0xff; 4]));
                    assert!(said.contains("announces layers of"), "{said}");
                }
            }
        }
    }
}

#[cfg(feature = "e57")]
mod scanner {
    use super::*;
    use e57::{E57Writer, Quaternion, Record, RecordValue, Transform, Translation};
    use nalgebra::{Isometry3, Vector3};

    type Scan = (Option<Isometry3<f64>>, Vec<Point3<f64>>);

    fn transform(pose: &Isometry3<f64>) -> Transform {
        let (t, q) = (&pose.translation, &pose.rotation);
        Transform {
            rotation: Quaternion {
                w: q.w,
                x: q.i,
                y: q.j,
                z: q.k,
            },
            translation: Translation {
                x: t.x,
                y: t.y,
                z: t.z,
            },
        }
    }

    pub(crate) fn e57(scans: &[Scan]) -> Vec<u8> {
        let prototype = vec![
            Record::CARTESIAN_X_F64,
            Record::CARTESIAN_Y_F64,
            Record::CARTESIAN_Z_F64,
            Record::CARTESIAN_INVALID_STATE,
        ];
        written(prototype, scans, |p| {
            let state = if p.iter().all(|c| c.is_finite()) {
                0
            } else {
                2
            };
            vec![
                RecordValue::Double(if state == 0 { p.x } else { 0.0 }),
                RecordValue::Double(if state == 0 { p.y } else { 0.0 }),
                RecordValue::Double(if state == 0 { p.z } else { 0.0 }),
                RecordValue::Integer(state),
            ]
        })
    }

    fn written(
        prototype: Vec<Record>,
        scans: &[Scan],
        values: impl Fn(&Point3<f64>) -> Vec<RecordValue>,
    ) -> Vec<u8> {
        bytes_of(|path| {
            let mut writer = E57Writer::from_file(path, "file").unwrap();
            for (k, (pose, cloud)) in scans.iter().enumerate() {
                let mut scan = writer
                    .add_pointcloud(&k.to_string(), prototype.clone())
                    .unwrap();
                scan.set_name(Some(format!("scan {k}")));
                scan.set_transform(pose.as_ref().map(transform));
                for point in cloud {
                    scan.add_point(values(point)).unwrap();
                }
                scan.finalize().unwrap();
            }
            writer.finalize().unwrap();
        })
    }

    fn read_scans(content: &[u8]) -> Result<Vec<E57Scan>, Error> {
        let (_folder, path) = place("a.e57");
        fs::write(&path, content).unwrap();
        read_e57(path)
    }

    fn some_pose() -> Isometry3<f64> {
        Isometry3::new(Vector3::new(10.0, -20.0, 3.0), Vector3::new(0.3, -0.5, 0.9))
    }

    fn two_scans() -> [Scan; 2] {
        let near = (0..700).map(|k| Point3::new(0.01 * k as f64, -1.5, (k % 7) as f64));
        let mut near: Vec<_> = near.collect();
        near[5].x = f64::NAN;
        [(Some(some_pose()), near), (None, utm_cloud(3))]
    }

    #[test]
    fn scans_keep_their_frame_and_their_pose() {
        let scans = read_scans(&e57(&two_scans())).unwrap();
        let [(_, near), (_, far)] = two_scans();
        assert_eq!(scans.len(), 2);
        assert_eq!(scans[0].name.as_deref(), Some("scan 0"));
        assert_eq!(scans[0].points.points[5..], near[6..]);
        assert_eq!((scans[0].points.invalid, scans[1].points.invalid), (1, 0));
        assert_eq!(scans[1].points.points, far);
        assert!(
            (scans[0].file_from_scan.to_homogeneous() - some_pose().to_homogeneous()).amax()
                < 1e-14
        );
        assert_eq!(scans[1].file_from_scan, Isometry3::identity());
    }

    #[test]
    fn a_file_of_several_scans_is_one_cloud_with_poses_applied() {
        let cloud = read("a.e57", &e57(&two_scans())).unwrap();
        let [(_, near), (_, far)] = two_scans();
        let moved = near
            .iter()
            .filter(|p| p.x.is_finite())
            .map(|p| some_pose() * p);
        let expected: Vec<_> = moved.chain(far).collect();
        assert_near(&cloud.points, &expected, 1e-9, "a.e57");
        assert_eq!(cloud.invalid, 1);
    }

    #[test]
    fn spherical_coordinates_are_converted() {
        let cloud = vec![Point3::new(1.0, 2.0, 0.5), Point3::new(-3.0, 0.25, -1.0)];
        let prototype = vec![
            Record::SPHERICAL_AZIMUTH_F64,
            Record::SPHERICAL_ELEVATION_F64,
            Record::SPHERICAL_RANGE_F64,
        ];
        let content = written(prototype, &[(None, cloud.clone())], |p| {
            let range = p.coords.norm();
            vec![
                RecordValue::Double(p.y.atan2(p.x)),
                RecordValue::Double((p.z / range).asin()),
                RecordValue::Double(range),
            ]
        });
        assert_near(
            &read("a.e57", &content).unwrap().points,
            &cloud,
            1e-14,
            "a.e57",
        );
    }

    /// The file with the checksum of each page corrected: four bytes at the end of each kilobyte.
    fn with_checksums(mut content: Vec<u8>) -> Vec<u8> {
        for page in content.chunks_exact_mut(1024) {
            let mut checksum = !0u32;
            for byte in &page[..1020] {
                checksum ^= u32::from(*byte);
                for _ in 0..8 {
                    let carry = 0x82f6_3b78 * (checksum & 1);
                    checksum = checksum >> 1 ^ carry;
                }
            }
            page[1020..].copy_from_slice(&(!checksum).to_be_bytes());
        }
        content
    }

    fn replaced(content: &[u8], old: &str, new: &str) -> Vec<u8> {
        assert_eq!(old.len(), new.len());
        let place = content
            .windows(old.len())
            .position(|window| window == old.as_bytes());
        let mut content = content.to_vec();
        content[place.unwrap()..][..new.len()].copy_from_slice(new.as_bytes());
        with_checksums(content)
    }

    #[test]
    fn counts_that_the_file_cannot_hold_are_refused_at_once() {
        let content = e57(&[(None, utm_cloud(1234))]);
        assert_eq!(with_checksums(content.clone()), content);
        let said = complaint(
            "a.e57",
            &replaced(&content, "recordCount=\"1234\"", "recordCount=\"9999\""),
        );
        assert!(said.contains("scan 1 of 1"), "{said}");
        let mut long = content.clone();
        long[32..40].copy_from_slice(&[0xff; 8]);
        complaint("a.e57", &with_checksums(long));
        let mut damaged = content.clone();
        damaged[1500] ^= 1;
        complaint("a.e57", &damaged);
    }

    #[test]
    fn changed_bytes_with_correct_checksums_make_no_reader_panic_or_linger() {
        let content = e57(&[(Some(some_pose()), utm_cloud(20))]);
        for place in (0..content.len()).step_by(5) {
            for byte in [0, b'9', 0xff] {
                let mut content = content.clone();
                content[place] = byte;
                check_damaged("a.e57", &with_checksums(content));
            }
        }
    }

    #[test]
    fn a_file_without_scans_is_refused() {
        assert!(complaint("a.e57", &e57(&[])).contains("the file has no scan"));
    }
}
