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
print(json.dumps({
    'poses': [node.pose[:3].ravel().tolist() for node in graph.nodes],
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
    let read = read.json();
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
    let num_points: usize = room().clouds.iter().map(Vec::len).sum();
    assert_eq!(read["points"], num_points);
    assert_eq!(read["colors"], 6);
}
