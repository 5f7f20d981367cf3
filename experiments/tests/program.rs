//! The program `experiments` from the outside, on a simulated scene in the layout of 3DMatch.

#![allow(clippy::unwrap_used)]

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use gmpcr::cliques::information_matrix;
use gmpcr::geometry::PointPairs;
use gmpcr_eval::{OverlapIndex, overlap_matrix};
use gmpcr_io::{LogEntry, write_gt_log, write_poses_3x4};
use gmpcr_sim::{SimParams, SimulatedScans, simulate};
use nalgebra::{Isometry3, Point3};

const NUM_SCANS: usize = 6;
const OVERLAP_RADIUS: f64 = 0.045;

/// Writes scans, pairs with information matrices, and overlaps of a small scene.
fn write_scene(folder: &Path) -> Vec<Isometry3<f64>> {
    fs::create_dir_all(folder).unwrap();
    let scans = simulate(&SimParams {
        num_scans: NUM_SCANS,
        ..SimParams::default()
    })
    .unwrap();
    let SimulatedScans {
        clouds,
        world_from_scan,
    } = scans;
    let overlap = overlap_matrix(&clouds, &world_from_scan, OVERLAP_RADIUS).unwrap();
    for (index, cloud) in clouds.iter().enumerate() {
        write_ply(&folder.join(format!("cloud_bin_{index}.ply")), cloud);
    }
    let (mut log, mut info) = (Vec::new(), String::new());
    let mut csv = String::from("i,j,mean,min\n");
    for (i, j) in (0..NUM_SCANS).flat_map(|i| (i + 1..NUM_SCANS).map(move |j| (i, j))) {
        writeln!(csv, "{i},{j},{0},{0}", overlap[(i, j)]).unwrap();
        if overlap[(i, j)] > 0.1 {
            let i_from_j = world_from_scan[i].inv_mul(&world_from_scan[j]);
            let [scan_i, scan_j] =
                [i, j].map(|scan| OverlapIndex::new(&clouds[scan], OVERLAP_RADIUS));
            let overlapping = scan_i.overlapping_points(&scan_j, &i_from_j);
            writeln!(info, "{i} {j} {NUM_SCANS}").unwrap();
            let points = PointPairs::new(overlapping.clone(), overlapping).unwrap();
            for row in information_matrix(&points, 1.0).row_iter() {
                let row: Vec<String> = row.iter().map(f64::to_string).collect();
                writeln!(info, "{}", row.join(" ")).unwrap();
            }
            log.push(LogEntry {
                i,
                j,
                num_scans: NUM_SCANS,
                i_from_j,
            });
        }
    }
    assert!(log.len() > 3);
    write_gt_log(folder.join("gt.log"), &log).unwrap();
    fs::write(folder.join("gt.info"), info).unwrap();
    fs::write(folder.join("overlap.csv"), csv).unwrap();
    world_from_scan
}

fn write_ply(file: &Path, cloud: &[Point3<f64>]) {
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nend_header\n",
        cloud.len()
    );
    for point in cloud {
        writeln!(text, "{} {} {}", point.x, point.y, point.z).unwrap();
    }
    fs::write(file, text).unwrap();
}

fn experiments(root: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_experiments"))
        .current_dir(root)
        .args(arguments)
        .output()
        .unwrap()
}

const ONLY: &str = "recall,ablation,views,retrieval,connectivity,time";

#[test]
fn a_broken_scene_is_named_the_others_go_on_and_a_second_run_resumes() {
    let root = tempfile::tempdir().unwrap();
    let root = root.path();
    write_scene(&root.join("scenes/room"));
    write_scene(&root.join("scenes/broken"));
    fs::remove_file(root.join("scenes/broken/cloud_bin_2.ply")).unwrap();

    let arguments = ["scenes", "--out", "out", "--runs", "2", "--only", ONLY];
    let first = experiments(root, &arguments);
    let errors = String::from_utf8(first.stderr).unwrap();
    assert_eq!(first.status.code(), Some(2), "{errors}");
    assert!(
        errors.contains("broken") && errors.contains("cloud_bin_2"),
        "{errors}"
    );
    let tables = fs::read_to_string(root.join("out/tables.md")).unwrap();
    for title in [
        "### Registration recall (%), list gt, fpfh descriptors",
        "### In the paper: registration recall (%)",
        "### Ablation, recall (%), list gt, fpfh descriptors",
        "### Synchronization methods on the same pose graphs",
        "### Recall (%) over the number of scans",
        "### Retrieval of overlapping pairs",
        "### Connectivity over K",
        "### Time per stage",
    ] {
        assert!(tables.contains(title), "{title}");
    }
    for figure in [
        "views",
        "responses",
        "deciles",
        "confidence_overlap",
        "connectivity",
        "time",
    ] {
        let svg = fs::read_to_string(root.join(format!("out/{figure}_fpfh.svg"))).unwrap();
        assert!(svg.starts_with("<svg"), "{figure}");
    }
    let records = fs::read_to_string(root.join("out/records/recall/fpfh/room.csv")).unwrap();
    let recall = records
        .lines()
        .find(|line| line.starts_with("3DMatch preset,0,gt,"))
        .unwrap();
    let recall: f64 = recall.rsplit(',').next().unwrap().parse().unwrap();
    assert!(recall > 0.5, "{recall}");

    for row in tables
        .lines()
        .filter(|line| line.starts_with("| baseline") || line.starts_with("| consensus"))
    {
        assert!(!row.contains("|  "), "{row}");
    }

    // A second run reads what the first left, a later one with other settings does not.
    let marked = records.replace("3DMatch preset,0,gt,", "kept from before,0,gt,");
    fs::write(root.join("out/records/recall/fpfh/room.csv"), marked).unwrap();
    experiments(root, &arguments);
    let tables = fs::read_to_string(root.join("out/tables.md")).unwrap();
    assert!(tables.contains("kept from before"));
    fs::write(root.join("scenes/room/gt.txt"), "another file").unwrap();
    let other = ["scenes", "--out", "out", "--runs", "2", "--only", "recall"];
    experiments(root, &other);
    let tables = fs::read_to_string(root.join("out/tables.md")).unwrap();
    assert!(!tables.contains("kept from before"));
    assert!(!tables.contains("### Time"));
}

#[test]
fn poses_or_pairs_without_matrices_are_judged_by_angle_and_distance() {
    let root = tempfile::tempdir().unwrap();
    let root = root.path();
    let [eth, scannet] = ["eth", "scannet"].map(|name| root.join("scenes").join(name));
    let world_from_scan = write_scene(&eth);
    fs::remove_file(eth.join("gt.info")).unwrap();
    write_scene(&scannet);
    for file in ["gt.log", "gt.info", "overlap.csv"] {
        fs::remove_file(scannet.join(file)).unwrap();
    }
    let poses: Vec<_> = world_from_scan.iter().copied().enumerate().collect();
    write_poses_3x4(scannet.join("poses.txt"), &poses).unwrap();

    let arguments = [
        "scenes",
        "--out",
        "out",
        "--runs",
        "1",
        "--only",
        "recall,views",
    ];
    let output = experiments(root, &arguments);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    for (scene, list) in [("eth", "gt"), ("scannet", "poses")] {
        let file = format!("out/records/recall/fpfh/{scene}.csv");
        let records = fs::read_to_string(root.join(file)).unwrap();
        let wanted = format!("preset,0,{list},");
        let recall = records.lines().find(|line| line.contains(&wanted)).unwrap();
        let recall: f64 = recall.rsplit(',').next().unwrap().parse().unwrap();
        assert!(recall > 0.5, "{scene}: {recall}");
    }
}

#[test]
fn what_cannot_be_done_is_said_and_fails() {
    let root = tempfile::tempdir().unwrap();
    let root = root.path();
    fs::create_dir(root.join("empty")).unwrap();
    for (arguments, expected) in [
        (&["missing"][..], "missing"),
        (&["empty"], "empty"),
        (&["empty", "--scenes", "attic"], "empty"),
        (&["--descriptors", "d"], "FOLDER"),
        (&["empty", "--voxel", "-1"], "positive"),
        (&["empty", "--runs", "0"], "1..=1000"),
        (&["empty", "--only", "everything"], "everything"),
        (&["empty", "--descriptors", "nowhere"], "nowhere"),
        (
            &["empty", "--only", "recall", "--graphs", "a.g2o"],
            "--graphs",
        ),
    ] {
        let output = experiments(root, arguments);
        let errors = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success(), "{arguments:?}");
        assert!(errors.contains(expected), "{arguments:?}: {errors}");
    }
}
