//! Open3D as an independent reader, where the Python that `GMPCR_PYTHON` names has it.

use std::process::Command;

use crate::common::{Run, Workplace, poses, room};

const SCRIPT: &str = "
import json, sys
import numpy, open3d
graph = open3d.io.read_pose_graph(sys.argv[1] + '/posegraph.json')
cloud = open3d.io.read_point_cloud(sys.argv[1] + '/merged.ply')
residuals = []
for edge in graph.edges:
    source, target = (graph.nodes[k].pose for k in (edge.source_node_id, edge.target_node_id))
    residuals.append(numpy.linalg.norm(edge.transformation - numpy.linalg.inv(target) @ source))
before = [node.pose[:3].ravel().tolist() for node in graph.nodes]
open3d.pipelines.registration.global_optimization(
    graph,
    open3d.pipelines.registration.GlobalOptimizationLevenbergMarquardt(),
    open3d.pipelines.registration.GlobalOptimizationConvergenceCriteria(),
    open3d.pipelines.registration.GlobalOptimizationOption(
        max_correspondence_distance=0.15, edge_prune_threshold=0.25, reference_node=0))
moved = [numpy.linalg.norm(node.pose[:3, 3] - numpy.array(pose).reshape(3, 4)[:, 3])
         for node, pose in zip(graph.nodes, before)]
print(json.dumps({
    'moved': moved,
    'poses': before,
    'residuals': residuals,
    'points': len(cloud.points),
    'colors': len(numpy.unique(numpy.asarray(cloud.colors), axis=0)),
}))
";

#[test]
fn open3d_reads_the_pose_graph_and_the_merged_cloud() {
    let python = std::env::var("GMPCR_PYTHON").unwrap_or("python3".into());
    let has_open3d = Command::new(&python).args(["-c", "import open3d"]).output();
    if !has_open3d.is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: {python} has no open3d, see GMPCR_PYTHON");
        return;
    }
    let place = Workplace::with_scans();
    let result = place.register(0, "scans", "out", &[]);
    let output = Command::new(python)
        .args(["-c", SCRIPT, &place.text("out")])
        .output()
        .unwrap();
    let read = Run::from(output);
    assert_eq!(read.code, Some(0), "{}", read.stderr);
    // Open3D says things before.
    let last = read.stdout.lines().last().unwrap();
    let read: serde_json::Value = serde_json::from_str(last).unwrap();
    for (read, pose) in read["poses"].as_array().unwrap().iter().zip(poses(&result)) {
        let read = crate::common::pose(read);
        assert!((read.to_matrix() - pose.to_matrix()).norm() < 1e-9);
    }
    let residuals = read["residuals"].as_array().unwrap();
    assert!(
        residuals
            .iter()
            .all(|residual| residual.as_f64().unwrap() < 0.5),
        "{residuals:?}"
    );
    // Its own optimizer goes on from there, and not far.
    let moved = read["moved"].as_array().unwrap();
    assert!(
        moved.iter().all(|length| length.as_f64().unwrap() < 0.5),
        "{moved:?}"
    );
    let num_points: usize = room().clouds.iter().map(Vec::len).sum();
    assert_eq!(read["points"], num_points);
    assert_eq!(read["colors"], 6);
}
