//! What is written for Open3D is what Open3D reads.
//!
//! Where the environment variable `GMPCR_PYTHON` names a Python, that must be able to import `open3d`,
//! or these tests fail. Where it is not set, `python3` is tried, and without `open3d` they pass and
//! check nothing.
#![allow(clippy::unwrap_used)]

use std::env;
use std::path::Path;
use std::process::{Command, Output};

use gmpcr_io::*;
use nalgebra::{Isometry3, Matrix6, Point3, Vector3};

fn python(script: &str, file: &Path) -> Option<Output> {
    let python = env::var_os("GMPCR_PYTHON").unwrap_or_else(|| "python3".into());
    let mut command = Command::new(python);
    command.arg("-c").arg(script).arg(file).output().ok()
}

/// The numbers that the script prints; `None` where there is no Open3D.
fn numbers(script: &str, file: &Path) -> Option<Vec<f64>> {
    let can_import = python("import open3d", file).is_some_and(|output| output.status.success());
    if !can_import {
        let named = env::var_os("GMPCR_PYTHON");
        assert!(named.is_none(), "{named:?} cannot import open3d");
        return None;
    }
    let output = python(script, file).unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let words = String::from_utf8(output.stdout).unwrap();
    Some(
        words
            .split_whitespace()
            .map(|word| word.parse().unwrap())
            .collect(),
    )
}

fn some_pose(k: f64) -> Isometry3<f64> {
    Isometry3::new(
        Vector3::new(1.0 / 3.0, -2.0, k),
        Vector3::new(0.3 * k, -0.5, 0.9),
    )
}

/// The rows of a matrix as NumPy prints them.
fn rows(pose: &Isometry3<f64>) -> Vec<f64> {
    pose.to_homogeneous().transpose().as_slice().to_vec()
}

#[test]
fn open3d_reads_the_same_pose_graph() {
    let nodes = vec![some_pose(0.1), some_pose(1.0), some_pose(-0.7)];
    let edge = |source: usize, target: usize, uncertain| Open3dEdge {
        source,
        target,
        target_from_source: nodes[target].inverse() * nodes[source],
        information: Matrix6::from_fn(|row, column| (10 * row + column) as f64 / 7.0),
        uncertain,
        confidence: 0.25,
    };
    let graph = Open3dPoseGraph {
        edges: vec![edge(0, 1, false), edge(0, 2, true)],
        nodes: nodes.clone(),
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("graph.json");
    write_open3d_pose_graph(&path, &graph).unwrap();

    // The distance tells that an edge of Open3D means what ours means.
    let script = "
import sys, numpy as np, open3d as o3d
graph = o3d.io.read_pose_graph(sys.argv[1])
show = lambda numbers: print(*[repr(float(x)) for x in np.ravel(numbers)])
for node in graph.nodes:
    show(node.pose)
for edge in graph.edges:
    show([edge.source_node_id, edge.target_node_id, edge.uncertain, edge.confidence])
    show(edge.transformation)
    show(edge.information)
    source, target = graph.nodes[edge.source_node_id].pose, graph.nodes[edge.target_node_id].pose
    show(np.abs(np.linalg.inv(target) @ source - edge.transformation).max() < 1e-12)
o3d.io.write_pose_graph(sys.argv[1], graph)
";
    let Some(found) = numbers(script, &path) else {
        return;
    };
    let mut expected: Vec<f64> = nodes.iter().flat_map(rows).collect();
    for edge in &graph.edges {
        let uncertain = f64::from(u8::from(edge.uncertain));
        expected.extend([
            edge.source as f64,
            edge.target as f64,
            uncertain,
            edge.confidence,
        ]);
        expected.extend(rows(&edge.target_from_source));
        expected.extend(edge.information.transpose().as_slice());
        expected.push(1.0);
    }
    assert_eq!(found, expected);

    let back = read_open3d_pose_graph(&path).unwrap();
    assert_eq!((back.nodes.len(), back.edges.len()), (3, 2));
    for (a, b) in back.edges.iter().zip(&graph.edges) {
        assert!(
            (a.target_from_source.to_homogeneous() - b.target_from_source.to_homogeneous()).amax()
                < 1e-12
        );
        assert_eq!((a.information, a.uncertain), (b.information, b.uncertain));
    }
}

#[test]
fn open3d_has_rotation_first_in_the_information_matrix() {
    let folder = tempfile::tempdir().unwrap();
    // Points on the x axis do not tell a rotation about it: its information is zero.
    let script = "
import numpy as np, open3d as o3d
cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector([[k, 0.0, 0.0] for k in range(10)]))
information = o3d.pipelines.registration.get_information_matrix_from_point_clouds(cloud, cloud, 0.1, np.eye(4))
print(*[float(x) for x in np.diag(information)])
";
    let Some(found) = numbers(script, folder.path()) else {
        return;
    };
    assert_eq!(found, [0.0, 285.0, 285.0, 10.0, 10.0, 10.0]);
}

#[test]
fn open3d_reads_the_same_merged_cloud() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("merged.ply");
    let cloud = |x: f64| vec![Point3::new(x, -2.5, 0.125), Point3::new(x, 4.0, 8.0)];
    let script = "
import sys, numpy as np, open3d as o3d
cloud = o3d.io.read_point_cloud(sys.argv[1])
for point, color in zip(np.asarray(cloud.points), np.asarray(cloud.colors)):
    print(*[repr(float(x)) for x in point], *[round(255 * x) for x in color])
";
    for (coordinates, x) in [
        (Coordinates::Single, 0.5),
        (Coordinates::Double, 5_194_876.547),
    ] {
        let clouds = [(x, [1, 2, 3]), (-x, [70, 80, 90])].map(|(x, color)| ColoredCloud {
            points: cloud(x),
            world_from_points: Isometry3::identity(),
            color,
        });
        write_merged_ply(&path, coordinates, clouds).unwrap();
        let Some(found) = numbers(script, &path) else {
            return;
        };
        let mut expected = Vec::new();
        for (x, color) in [(x, [1.0, 2.0, 3.0]), (-x, [70.0, 80.0, 90.0])] {
            for point in cloud(x) {
                expected.extend(point.iter().copied().chain(color));
            }
        }
        assert_eq!(found, expected);
    }
}
