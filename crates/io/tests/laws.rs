//! Laws that hold for all formats: what is written is read back, and no content makes a reader panic.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};

use gmpcr_io::*;
use nalgebra::{Isometry3, Matrix6, Quaternion, Translation3, UnitQuaternion};
use proptest::prelude::*;

/// Every reader, with a result that tells success only.
type Reader = fn(&Path) -> Result<(), Error>;

const READERS: [(&str, Reader); 11] = [
    ("scan.ply", |path| read_ply(path).map(drop)),
    ("scan.pcd", |path| read_pcd(path).map(drop)),
    ("scan.xyz", |path| read_xyz(path).map(drop)),
    ("matrix.npy", |path| read_npy_matrix(path).map(drop)),
    ("tum.txt", |path| read_poses_tum(path).map(drop)),
    ("3x4.txt", |path| read_poses(path).map(drop)),
    ("world.txt", |path| read_world_poses(path, 2).map(drop)),
    ("graph.g2o", |path| read_g2o(path).map(drop)),
    ("graph.json", |path| read_open3d_pose_graph(path).map(drop)),
    ("gt.log", |path| read_gt_log(path).map(drop)),
    ("gt.info", |path| read_gt_info(path).map(drop)),
];

fn folder() -> (tempfile::TempDir, impl Fn(&str) -> PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().to_owned();
    (folder, move |name| root.join(name))
}

fn pose() -> impl Strategy<Value = Isometry3<f64>> {
    let translation = prop::array::uniform3(-1e6..1e6f64);
    let quaternion = prop::array::uniform4(-1.0..1.0f64);
    (translation, quaternion)
        .prop_filter("a direction", |(_, q)| q.iter().any(|c| c.abs() > 0.1))
        .prop_map(|([x, y, z], [a, b, c, d])| {
            let rotation = UnitQuaternion::new_normalize(Quaternion::new(a, b, c, d));
            Isometry3::from_parts(Translation3::new(x, y, z), rotation)
        })
}

/// Symmetric positive definite, all entries of different size.
fn information() -> impl Strategy<Value = Matrix6<f64>> {
    prop::collection::vec(-10.0..10.0f64, 36).prop_map(|entries| {
        let root = Matrix6::from_iterator(entries);
        let square = root * root.transpose() + Matrix6::identity();
        (square + square.transpose()) / 2.0
    })
}

/// Equal up to the rounding of the way through a matrix and back.
fn assert_same(a: &Isometry3<f64>, b: &Isometry3<f64>) {
    assert_eq!(a.translation, b.translation);
    assert!(a.rotation.angle_to(&b.rotation) < 4e-15, "{a} {b}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn poses_come_back_from_both_formats(poses in prop::collection::vec((0usize..1000, pose()), 0..5)) {
        let (_guard, path) = folder();
        write_poses_3x4(path("3x4"), &poses).unwrap();
        let timed: Vec<_> = poses.iter().map(|&(k, pose)| (0.1 * k as f64, pose)).collect();
        write_poses_tum(path("tum"), &timed).unwrap();

        let back = read_poses(path("3x4")).unwrap();
        let timed_back = read_poses_tum(path("tum")).unwrap();
        prop_assert_eq!(timed_back, timed);
        prop_assert_eq!(back.len(), poses.len());
        for k in 0..poses.len() {
            prop_assert_eq!(back[k].0, poses[k].0);
            assert_same(&back[k].1, &poses[k].1);
        }
    }

    #[test]
    fn a_pose_graph_comes_back(
        poses in prop::collection::vec(pose(), 1..4),
        edges in prop::collection::vec((0usize..9, 0usize..9, pose(), information()), 0..4),
    ) {
        let vertex = |(k, &world_from_vertex)| G2oVertex { id: 3 * k, world_from_vertex };
        let edge = |&(i, j, i_from_j, information)| G2oEdge { i, j, i_from_j, information };
        let graph = G2o {
            vertices: poses.iter().enumerate().map(vertex).collect(),
            edges: edges.iter().map(edge).collect(),
        };
        let (_guard, path) = folder();
        write_g2o(path("g2o"), &graph).unwrap();
        let back = read_g2o(path("g2o")).unwrap();

        prop_assert_eq!(back.vertices, graph.vertices);
        prop_assert_eq!(back.edges, graph.edges);
    }

    #[test]
    fn a_pose_graph_of_open3d_comes_back(
        nodes in prop::collection::vec(pose(), 3),
        edges in prop::collection::vec((0usize..3, 0usize..3, pose(), information(), any::<bool>(), 0.0..1.0f64), 0..4),
    ) {
        let edge = |&(source, target, target_from_source, information, uncertain, confidence)| {
            Open3dEdge { source, target, target_from_source, information, uncertain, confidence }
        };
        let graph = Open3dPoseGraph { nodes, edges: edges.iter().map(edge).collect() };
        let (_guard, path) = folder();
        write_open3d_pose_graph(path("json"), &graph).unwrap();
        let back = read_open3d_pose_graph(path("json")).unwrap();

        prop_assert_eq!((back.nodes.len(), back.edges.len()), (3, graph.edges.len()));
        for (a, b) in back.nodes.iter().zip(&graph.nodes) {
            assert_same(a, b);
        }
        for (a, b) in back.edges.into_iter().zip(graph.edges) {
            assert_same(&a.target_from_source, &b.target_from_source);
            let target_from_source = a.target_from_source;
            prop_assert_eq!(a, Open3dEdge { target_from_source, ..b });
        }
    }

    #[test]
    fn benchmark_pairs_come_back(pairs in prop::collection::vec((0usize..60, 0usize..60, pose()), 0..5)) {
        let entry = |&(i, j, i_from_j)| LogEntry { i, j, num_scans: 60, i_from_j };
        let entries: Vec<_> = pairs.iter().map(entry).collect();
        let (_guard, path) = folder();
        write_gt_log(path("log"), &entries).unwrap();
        let back = read_gt_log(path("log")).unwrap();

        prop_assert_eq!(back.len(), entries.len());
        for (a, b) in back.iter().zip(&entries) {
            prop_assert_eq!((a.i, a.j, a.num_scans), (b.i, b.j, 60));
            assert_same(&a.i_from_j, &b.i_from_j);
        }
    }

    #[test]
    fn merged_clouds_come_back_in_order(
        clouds in prop::collection::vec(prop::collection::vec(prop::array::uniform3(any::<f32>()), 0..20), 0..4),
    ) {
        let point = |&[x, y, z]: &[f32; 3]| [x, y, z].map(f64::from).into();
        let (_guard, path) = folder();
        let colored = clouds.iter().map(|cloud| ColoredCloud {
            points: cloud.iter().map(point).collect::<Vec<_>>(),
            world_from_points: Isometry3::identity(),
            color: [1, 2, 3],
        });
        write_merged_ply(path("double.ply"), Coordinates::Double, colored.clone()).unwrap();
        write_merged_ply(path("merged.ply"), Coordinates::Single, colored).unwrap();
        let back = read_points(path("merged.ply")).unwrap();
        prop_assert_eq!(&read_points(path("double.ply")).unwrap(), &back);

        let all: Vec<_> = clouds.iter().flatten().collect();
        let finite = all.iter().filter(|point| point.iter().all(|c| c.is_finite()));
        let expected: Vec<_> = finite.map(|p| point(p)).collect();
        prop_assert_eq!(back.invalid, all.len() - expected.len());
        prop_assert_eq!(back.points, expected);
    }

    #[test]
    fn noise_after_any_start_makes_no_reader_panic(
        noise in prop::collection::vec(any::<u8>(), 0..200),
        which in 0..READERS.len(),
        cut in 0.0..1.0f64,
    ) {
        let (_guard, path) = folder();
        for (name, content) in samples() {
            let kept = (content.len() as f64 * cut) as usize;
            let content = [&content[..kept], &noise].concat();
            let (_, read) = READERS[which];
            fs::write(path(name), content).unwrap();
            let _ = read(&path(name));
        }
    }

    #[test]
    fn a_changed_byte_makes_no_reader_panic(place in 0.0..1.0f64, byte: u8) {
        let (_guard, path) = folder();
        for (name, mut content) in samples() {
            let place = (content.len() as f64 * place) as usize;
            content[place] = byte;
            fs::write(path(name), content).unwrap();
            let _ = reader_of(name)(&path(name));
        }
    }
}

/// The reader of a sample file.
fn reader_of(name: &str) -> Reader {
    let name = match name.rsplit('.').next().unwrap() {
        "ply" => "scan.ply",
        "pcd" => "scan.pcd",
        "xyz" => "scan.xyz",
        "npy" => "matrix.npy",
        "tum" => "tum.txt",
        "3x4" => "3x4.txt",
        "g2o" => "graph.g2o",
        "json" => "graph.json",
        "log" => "gt.log",
        _ => "gt.info",
    };
    READERS.iter().find(|reader| reader.0 == name).unwrap().1
}

/// A small good file of every format and encoding.
fn samples() -> Vec<(&'static str, Vec<u8>)> {
    let text = |text: &str| text.as_bytes().to_vec();
    let floats = |numbers: &[f32]| {
        numbers
            .iter()
            .flat_map(|n| n.to_le_bytes())
            .collect::<Vec<u8>>()
    };
    let body = floats(&[1.0, 2.0, 3.0, f32::NAN, 5.0, 6.0]);

    let ply = |encoding: &str, body: &[u8]| {
        let header = format!(
            "ply\nformat {encoding} 1.0\nelement vertex 2\nproperty float x\nproperty float y\n\
             property float z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n"
        );
        [header.as_bytes(), body].concat()
    };
    let pcd = |encoding: &str, body: &[u8]| {
        let header = format!(
            "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\n\
             VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA {encoding}\n"
        );
        [header.as_bytes(), body].concat()
    };
    // One literal run of 24 bytes, column by column.
    let columns = floats(&[1.0, f32::NAN, 2.0, 5.0, 3.0, 6.0]);
    let packed = [&[25, 0, 0, 0, 24, 0, 0, 0, 23], &columns[..]].concat();
    let npy_header = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }\n";
    let npy = [b"\x93NUMPY\x01\x00\x3c\x00", npy_header.as_bytes(), &body].concat();
    assert_eq!(npy_header.len(), 0x3c);

    vec![
        ("ascii.ply", ply("ascii", b"1 2 3\nnan 5 6\n")),
        ("little.ply", ply("binary_little_endian", &body)),
        ("big.ply", ply("binary_big_endian", &body)),
        ("ascii.pcd", pcd("ascii", b"1 2 3\nnan 5 6\n")),
        ("binary.pcd", pcd("binary", &body)),
        ("packed.pcd", pcd("binary_compressed", &packed)),
        ("scan.xyz", text("# x y z\n1 2 3 255\nnan 5 6 0\n")),
        ("matrix.npy", npy),
        ("poses.tum", text("0.5 1 2 3 0 0 0 1\n1.5 1 2 3 0 0 1 0\n")),
        ("poses.3x4", text("0 1 0 0 1 0 1 0 2 0 0 1 3\n")),
        (
            "graph.g2o",
            text(
                "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nFIX 0\n\
                 EDGE_SE3:QUAT 0 1 0 0 0 0 0 0 1 9 0 0 0 0 0 9 0 0 0 0 9 0 0 0 9 0 0 9 0 9\n",
            ),
        ),
        ("graph.json", text(&pose_graph_json())),
        (
            "gt.log",
            text("0\t1\t60\n1 0 0 1\n0 1 0 2\n0 0 1 3\n0 0 0 1\n"),
        ),
        (
            "gt.info",
            text(&format!("0 1 60\n{}", "0 0 0 0 0 0\n".repeat(6))),
        ),
    ]
}

/// Two nodes and an edge, as Open3D writes them.
fn pose_graph_json() -> String {
    let identity = "[1.0,0.0,0.0,0.0, 0.0,1.0,0.0,0.0, 0.0,0.0,1.0,0.0, 0.0,0.0,0.0,1.0]";
    let version = "\"version_major\":1,\"version_minor\":0";
    let node = format!("{{\"class_name\":\"PoseGraphNode\",\"pose\":{identity},{version}}}");
    let information = ["0.5"; 36].join(",");
    format!(
        "{{\"class_name\":\"PoseGraph\",\"edges\":[{{\"class_name\":\"PoseGraphEdge\",\
         \"confidence\":1.0,\"information\":[{information}],\"source_node_id\":0,\
         \"target_node_id\":1,\"transformation\":{identity},\"uncertain\":false,{version}}}],\
         \"nodes\":[{node},{node}],{version}}}"
    )
}

#[test]
fn the_samples_are_good() {
    let (_guard, path) = folder();
    for (name, content) in samples() {
        fs::write(path(name), content).unwrap();
        reader_of(name)(&path(name)).unwrap();
    }
    for name in [
        "ascii.ply",
        "little.ply",
        "ascii.pcd",
        "binary.pcd",
        "packed.pcd",
        "scan.xyz",
        "matrix.npy",
    ] {
        let scan = read_points(path(name)).unwrap();
        assert_eq!(
            (scan.points, scan.invalid),
            (vec![[1.0, 2.0, 3.0].into()], 1),
            "{name}"
        );
    }
}

#[test]
fn a_file_cut_off_anywhere_is_read_or_refused_by_name() {
    let (_guard, path) = folder();
    for (name, content) in samples() {
        for length in 0..content.len() {
            fs::write(path(name), &content[..length]).unwrap();
            if let Err(error) = reader_of(name)(&path(name)) {
                assert!(error.to_string().contains(name), "{error}");
            }
        }
    }
}

#[test]
fn a_binary_file_cut_off_anywhere_is_refused() {
    let (_guard, path) = folder();
    for name in [
        "little.ply",
        "big.ply",
        "binary.pcd",
        "packed.pcd",
        "matrix.npy",
    ] {
        let (_, content) = samples()
            .into_iter()
            .find(|sample| sample.0 == name)
            .unwrap();
        for length in 0..content.len() {
            fs::write(path(name), &content[..length]).unwrap();
            reader_of(name)(&path(name)).unwrap_err();
        }
    }
}

#[test]
fn foreign_content_is_refused_by_name() {
    let (_guard, path) = folder();
    let jpeg = b"\xff\xd8\xff\xe0\x00\x10JFIF\x00\x01\x01\x00\x00\x01".to_vec();
    let zeros = vec![0; 4096];
    let prose = b"This is no data file.\nIt has two lines.\n".to_vec();
    let noise = vec![0xC3; 1_000_000];
    for content in [jpeg, zeros, prose, noise] {
        for (name, read) in READERS {
            fs::write(path(name), &content).unwrap();
            let error = read(&path(name)).unwrap_err();
            let said = error.to_string();
            assert!(said.contains(name) && said.len() < 500, "{said}");
        }
    }
}

#[test]
fn missing_files_and_folders_in_their_place_are_refused_by_name() {
    let (_guard, path) = folder();
    for (name, read) in READERS {
        let missing = read(&path(name)).unwrap_err();
        assert!(matches!(missing, Error::Io { .. }) && missing.to_string().contains(name));
        fs::create_dir(path(name)).unwrap();
        let error = read(&path(name)).unwrap_err();
        assert!(error.to_string().contains(name), "{error}");
    }
}

#[test]
fn an_empty_file_is_no_scan_and_no_matrix() {
    let (_guard, path) = folder();
    for (name, read) in &READERS[..4] {
        fs::write(path(name), "").unwrap();
        let said = read(&path(name)).unwrap_err().to_string();
        assert!(
            said.contains(name) && said.contains("the file is empty"),
            "{said}"
        );
    }
}

#[test]
fn an_empty_file_is_no_pose_graph_but_an_empty_list() {
    let (_guard, path) = folder();
    for (name, read) in &READERS[4..] {
        fs::write(path(name), "").unwrap();
        let is_refused = name.starts_with("graph") || name.starts_with("world");
        assert_eq!(read(&path(name)).is_err(), is_refused, "{name}");
    }
}

#[test]
fn writers_to_a_missing_folder_fail_and_create_nothing() {
    let (guard, path) = folder();
    let target = path("missing").join("file");
    let results = [
        write_poses_tum(&target, &[]),
        write_poses_3x4(&target, &[]),
        write_g2o(&target, &G2o::default()),
        write_gt_log(&target, &[]),
        write_open3d_pose_graph(&target, &Open3dPoseGraph::default()),
        write_merged_ply::<Vec<_>>(&target, Coordinates::Double, []),
    ];
    for result in results {
        let error = result.unwrap_err();
        assert!(
            matches!(
                error,
                Error::Io {
                    action: "write",
                    ..
                }
            ),
            "{error}"
        );
    }
    assert_eq!(fs::read_dir(guard.path()).unwrap().count(), 0);
}
