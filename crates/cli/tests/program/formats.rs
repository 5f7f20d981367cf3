//! The same scans in every format are the same scans.

use std::fs;
use std::path::Path;

#[cfg(feature = "e57")]
use e57::{E57Writer, Quaternion, Record, RecordValue, Transform, Translation};
use gmpcr::nalgebra::Point3;
use npyz::WriterBuilder;

use crate::common::{Workplace, assert_close, poses, room};

type Writer = fn(&Path, &[Point3<f64>]);

/// Registers the simulated scans, written as files of a kind.
fn registers_files_of(extension: &str, write: Writer) {
    let place = Workplace::new();
    let folder = place.create("scans");
    for (k, cloud) in room().clouds.iter().enumerate() {
        write(&folder.join(format!("scan_{k}.{extension}")), cloud);
    }
    let result = place.register(0, "scans", "out", &[]);
    for (scan, cloud) in result["scans"]
        .as_array()
        .unwrap()
        .iter()
        .zip(&room().clouds)
    {
        assert_eq!(scan["points"], cloud.len());
    }
    assert_close(&poses(&result), &room().world_from_scan);
}

fn rows(points: &[Point3<f64>], separator: &str) -> String {
    let row = |p: &Point3<f64>| format!("{}{separator}{}{separator}{}\n", p.x, p.y, p.z);
    points.iter().map(row).collect()
}

fn npy(points: &[Point3<f64>]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let options = npyz::WriteOptions::new().default_dtype();
    let shape = [points.len() as u64, 3];
    let mut writer = options.shape(&shape).writer(&mut bytes).begin_nd().unwrap();
    writer
        .extend(points.iter().flat_map(|point| [point.x, point.y, point.z]))
        .unwrap();
    writer.finish().unwrap();
    bytes
}

#[cfg(feature = "las")]
pub fn write_las(path: &Path, points: &[Point3<f64>]) {
    let mut builder = las::Builder::from((1, 4));
    for (axis, transform) in [
        &mut builder.transforms.x,
        &mut builder.transforms.y,
        &mut builder.transforms.z,
    ]
    .into_iter()
    .enumerate()
    {
        transform.scale = 0.0001;
        transform.offset = points[0][axis].round();
    }
    let mut writer = las::Writer::from_path(path, builder.into_header().unwrap()).unwrap();
    for p in points {
        let point = las::Point {
            x: p.x,
            y: p.y,
            z: p.z,
            ..Default::default()
        };
        writer.write_point(point).unwrap();
    }
    writer.close().unwrap();
}

#[test]
fn text() {
    registers_files_of("xyz", |path, points| {
        fs::write(path, rows(points, " ")).unwrap()
    });
    registers_files_of("csv", |path, points| {
        fs::write(path, format!("x,y,z\n{}", rows(points, ","))).unwrap();
    });
}

#[test]
fn point_cloud_library() {
    registers_files_of("pcd", |path, points| {
        let n = points.len();
        let header = format!(
            "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {n}\nHEIGHT 1\n\
             VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {n}\nDATA ascii\n"
        );
        fs::write(path, header + &rows(points, " ")).unwrap();
    });
}

#[test]
fn numpy() {
    registers_files_of("npy", |path, points| fs::write(path, npy(points)).unwrap());
}

#[cfg(feature = "npz")]
#[test]
fn compressed_numpy() {
    registers_files_of("npz", |path, points| {
        let mut archive = zip::ZipWriter::new(fs::File::create(path).unwrap());
        archive
            .start_file("points.npy", zip::write::SimpleFileOptions::default())
            .unwrap();
        std::io::Write::write_all(&mut archive, &npy(points)).unwrap();
        archive.finish().unwrap();
    });
}

#[cfg(feature = "las")]
#[test]
fn surveys() {
    registers_files_of("las", write_las);
}

#[cfg(feature = "laz")]
#[test]
fn compressed_surveys() {
    registers_files_of("laz", write_las);
}

#[cfg(feature = "e57")]
#[test]
fn several_scans_in_one_file_have_names_of_their_own() {
    let place = Workplace::new();
    let path = place.path("survey.e57");
    let mut file = E57Writer::from_file(&path, "file").unwrap();
    for (k, cloud) in room().clouds.iter().enumerate() {
        let prototype = vec![
            Record::CARTESIAN_X_F64,
            Record::CARTESIAN_Y_F64,
            Record::CARTESIAN_Z_F64,
        ];
        let mut writer = file
            .add_pointcloud(&format!("scan {k}"), prototype)
            .unwrap();
        writer.set_name(Some(format!("station {k}")));
        // A pose that is of no help: registration sees each scan in its own frame.
        writer.set_transform(Some(Transform {
            rotation: Quaternion {
                w: 1.0,
                x: 0.0,
                y: 0.0,
                z: 0.0,
            },
            translation: Translation {
                x: 10.0 * k as f64,
                y: 0.0,
                z: 0.0,
            },
        }));
        for point in cloud {
            let values = point.iter().map(|&value| RecordValue::Double(value));
            writer.add_point(values.collect()).unwrap();
        }
        writer.finalize().unwrap();
    }
    file.finalize().unwrap();
    let result = place.register(0, "survey.e57", "out", &[]);
    assert_eq!(result["scans"][4]["name"], "survey.e57:station 4");
    assert_close(&poses(&result), &room().world_from_scan);
}

#[cfg(feature = "las")]
#[test]
fn georeferenced_scans_come_back_in_their_own_coordinates() {
    use gmpcr::nalgebra::{Isometry3, Vector3};

    let place = Workplace::new();
    let folder = place.create("scans");
    // The poses of the survey are off by meters and degrees, far from zero.
    let survey_from_scan = |k: usize| {
        let corner = Vector3::new(448_262.0 + 3.0 * k as f64, 5_411_932.0, 120.0);
        Isometry3::new(corner, Vector3::z() * 0.02 * k as f64) * room().world_from_scan[k]
    };
    for (k, cloud) in room().clouds.iter().enumerate() {
        let moved: Vec<_> = cloud
            .iter()
            .map(|point| survey_from_scan(k) * point)
            .collect();
        write_las(&folder.join(format!("scan_{k}.las")), &moved);
    }
    let result = place.register(0, "scans", "out", &[]);
    // Between the coordinates of the files lies what the survey is off.
    let found = poses(&result);
    let world_from_scan: Vec<_> = found
        .iter()
        .enumerate()
        .map(|(k, pose)| survey_from_scan(0).inverse() * pose * survey_from_scan(k))
        .collect();
    assert_close(&world_from_scan, &room().world_from_scan);

    // The merged cloud has no steps of half a meter, as single precision would have it.
    let merged = gmpcr_io::read_ply(place.path("out/merged.ply"))
        .unwrap()
        .points;
    let expected = survey_from_scan(0) * room().clouds[0][7];
    assert!(
        (merged[7] - expected).norm() < 0.001,
        "{} {expected}",
        merged[7]
    );
}

#[test]
fn keypoints_and_descriptors_of_files_are_registered_with_and_without_clouds() {
    let place = Workplace::with_scans();
    let folder = place.create("learned");
    for (k, cloud) in room().clouds.iter().enumerate() {
        let scan = gmpcr::compute_scan(cloud, &Default::default()).unwrap();
        fs::write(folder.join(format!("{k}.kpts.npy")), npy(scan.points())).unwrap();
        let mut bytes = Vec::new();
        let options = npyz::WriteOptions::new().default_dtype();
        let shape = [scan.len() as u64, scan.descriptors().dimension() as u64];
        let mut writer = options.shape(&shape).writer(&mut bytes).begin_nd().unwrap();
        writer
            .extend(scan.descriptors().values().iter().copied())
            .unwrap();
        writer.finish().unwrap();
        fs::write(folder.join(format!("{k}.desc.npy")), bytes).unwrap();
    }
    let folder = folder.to_str().unwrap();
    let result = place.register(0, "scans", "out", &["--descriptors", folder]);
    assert_eq!(result["features"], "descriptors of files");
    assert_close(&poses(&result), &room().world_from_scan);

    let out = place.text("alone");
    crate::common::Run::ending_with(0, &["register", "--descriptors", folder, "-o", &out]);
    assert_close(&poses(&place.result("alone")), &room().world_from_scan);
}
