//! The smaller commands.

use std::fs;

use gmpcr::nalgebra::Isometry3;
use gmpcr_io::{LogEntry, read_g2o, write_gt_log, write_poses_3x4, write_poses_tum};

use crate::common::{Run, Workplace, assert_close, pose, room};

#[test]
fn a_pair_has_a_transformation_with_its_support() {
    let place = Workplace::with_scans();
    let [a, b] = ["scans/scan_0.ply", "scans/scan_1.ply"].map(|name| place.text(name));
    let json = Run::ending_with(0, &["pair", &a, &b, "--json"]).json();
    let found = pose(&json["target_from_source"]);
    assert_close(
        &[Isometry3::identity(), found],
        &room().world_from_scan[..2],
    );
    assert!(json["raw_confidence"].as_f64().unwrap() > 50.0);
    assert!(json["inlier_ratio"].as_f64().unwrap() > 0.1);
    assert!(json["clique_size"].as_u64().unwrap() >= 3);
    let text = Run::ending_with(0, &["pair", &a, &b]).stdout;
    assert!(
        text.contains("from the frame of scan_1.ply into that of scan_0.ply"),
        "{text}"
    );
}

#[test]
fn scans_without_overlap_have_no_transformation() {
    let place = Workplace::with_scans();
    let lone = place.write("lone.xyz", "0 0 1\n0.1 0 1\n0 0.1 1\n");
    let run = Run::ending_with(2, &["pair", &lone, &place.text("scans/scan_0.ply")]);
    assert!(
        run.stdout.contains("no transformation found"),
        "{}",
        run.stdout
    );
}

#[test]
fn poses_of_a_graph_are_solved_by_every_method() {
    let place = Workplace::with_scans();
    place.register(0, "scans", "out", &[]);
    let graph = place.text("out/posegraph.g2o");
    let solved = place.text("solved.g2o");
    for method in gmpcr::sync::Method::ALL {
        let json = Run::ending_with(
            0,
            &[
                "sync",
                &graph,
                "-o",
                &solved,
                "--method",
                method.name(),
                "--json",
            ],
        )
        .json();
        assert_eq!(json["method"], method.name());
        assert!(
            json["after"]["rotation_degrees"]["median"]
                .as_f64()
                .unwrap()
                < 5.0
        );
        assert!(json["before"]["rotation_degrees"]["median"].is_number());
        assert_eq!(
            read_g2o(place.path("solved.g2o")).unwrap().vertices.len(),
            6
        );
    }
    let text = Run::ending_with(0, &["sync", &graph]).stdout;
    assert!(text.contains("before") && text.contains("after"), "{text}");
}

#[test]
fn edges_are_enough_and_components_are_counted() {
    let place = Workplace::new();
    let edge = |i: usize, j: usize| {
        format!("EDGE_SE3:QUAT {i} {j} 1 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n")
    };
    let chain = place.write("chain.g2o", edge(0, 1) + &edge(1, 2));
    let run = Run::ending_with(0, &["sync", &chain]);
    assert!(!run.stdout.contains("before"), "{}", run.stdout);
    let parts = place.write("parts.g2o", edge(0, 1) + &edge(5, 9));
    let json = Run::ending_with(2, &["sync", &parts, "--json"]).json();
    assert_eq!(
        (json["poses"].as_u64(), json["components"].as_u64()),
        (Some(4), Some(2))
    );
}

#[test]
fn scans_are_inspected_before_they_are_registered() {
    let place = Workplace::with_scans();
    let json = Run::ending_with(0, &["info", &place.text("scans"), "--json"]).json();
    let scan = &json["scans"][0];
    assert_eq!(scan["points"], room().clouds[0].len());
    let resolution = scan["resolution"].as_f64().unwrap();
    assert!((0.01..0.06).contains(&resolution), "{resolution}");
    let overlaps = json["overlaps"].as_array().unwrap();
    assert!(
        overlaps
            .iter()
            .any(|overlap| overlap["ratio"].as_f64().unwrap() > 0.3)
    );
    let text = Run::ending_with(0, &["info", &place.text("scans")]).stdout;
    assert!(
        text.contains("scan_5.ply") && text.contains("voxel size"),
        "{text}"
    );
}

#[test]
fn every_form_of_ground_truth_is_understood() {
    let place = Workplace::with_scans();
    place.register(0, "scans", "out", &[]);
    let ground_truth = &room().world_from_scan;
    let indexed: Vec<_> = ground_truth.iter().copied().enumerate().collect();
    write_poses_3x4(place.path("rows.txt"), &indexed).unwrap();
    let stamped: Vec<_> = ground_truth
        .iter()
        .enumerate()
        .map(|(k, &pose)| (k as f64, pose))
        .collect();
    write_poses_tum(place.path("poses.tum"), &stamped).unwrap();
    let rows = fs::read_to_string(place.path("rows.txt")).unwrap();
    let kitti: Vec<_> = rows
        .lines()
        .map(|row| row.split_once(' ').unwrap().1)
        .collect();
    place.write("kitti.txt", kitti.join("\n"));
    let entry = |i: usize, j: usize| LogEntry {
        i,
        j,
        num_scans: 6,
        i_from_j: ground_truth[i].inv_mul(&ground_truth[j]),
    };
    write_gt_log(
        place.path("gt.log"),
        &[entry(0, 1), entry(1, 2), entry(0, 3)],
    )
    .unwrap();

    let result = place.text("out/result.json");
    for file in ["rows.txt", "poses.tum", "kitti.txt"] {
        let json = Run::ending_with(0, &["eval", &result, &place.text(file), "--json"]).json();
        for kind in ["relative", "absolute"] {
            let error = json["poses"][kind]["mean"]["rotation_degrees"]
                .as_f64()
                .unwrap();
            assert!(error < 3.0, "{file}: {error}");
        }
    }
    let json = Run::ending_with(0, &["eval", &result, &place.text("gt.log"), "--json"]).json();
    assert_eq!(json["gt"]["ratio_within"], 1.0);
    let text = Run::ending_with(0, &["eval", &result, &place.text("gt.log"), "-v"]).stdout;
    assert!(text.contains("0 – 3"), "{text}");
}

#[test]
fn printed_parameters_are_accepted_and_single_ones_win() {
    let place = Workplace::with_scans();
    let printed = Run::ending_with(0, &["params", "--preset", "eth"]).stdout;
    assert!(
        printed.contains("# Edges that each scan proposes, K.\nneighbors = 4\n"),
        "{printed}"
    );
    let file = place.write("params.toml", printed);
    let options = [
        "--config",
        &file,
        "--set",
        "posegraph.neighbors=3",
        "--voxel",
        "0.06",
    ];
    let result = place.register(0, "scans", "out", &options);
    let parameters = &result["parameters"];
    assert_eq!(parameters["correspondence.num_samples"], 400);
    assert_eq!(parameters["posegraph.neighbors"], 3);
    assert_eq!(result["voxel_size"], 0.06);
}

#[test]
fn help_fits_a_screen_and_shows_an_example() {
    for command in [
        "register",
        "pair",
        "sync",
        "info",
        "eval",
        "params",
        "completions",
    ] {
        let help = Run::ending_with(0, &[command, "--help"]).stdout;
        assert!(help.contains("Example: gmpcr"), "{help}");
        assert!(
            help.lines().count() <= 50,
            "{command}: {} lines",
            help.lines().count()
        );
        assert!(
            help.lines().all(|line| line.chars().count() <= 100),
            "{help}"
        );
    }
    let help = Run::ending_with(0, &["--help"]).stdout;
    assert!(
        help.contains("Exit codes") && help.lines().count() <= 40,
        "{help}"
    );
}

#[test]
fn shells_get_their_completions() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = Run::ending_with(0, &["completions", shell]).stdout;
        assert!(script.contains("descriptors"), "{shell}");
    }
}

#[test]
fn a_solved_graph_stays_in_the_world_of_its_file() {
    let place = Workplace::new();
    let vertex = |id: usize, x: f64| format!("VERTEX_SE3:QUAT {id} {x} 0 0 0 0 0 1\n");
    let edge = |i: usize, j: usize| {
        format!("EDGE_SE3:QUAT {i} {j} 1 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n")
    };
    let graph =
        vertex(10, 100.0) + &vertex(11, 0.0) + &vertex(50, -7.0) + &edge(10, 11) + &edge(11, 12);
    let (graph, out) = (place.write("world.g2o", graph), place.text("solved.g2o"));
    let run = Run::ending_with(2, &["sync", &graph, "-o", &out]);
    assert!(
        !run.stdout.contains("before"),
        "vertex 12 has no pose: {}",
        run.stdout
    );
    let vertices = read_g2o(&out).unwrap().vertices;
    let places = vertices
        .iter()
        .map(|v| (v.id, v.world_from_vertex.translation.x.round()));
    assert_eq!(
        places.collect::<Vec<_>>(),
        [(10, 100.0), (11, 101.0), (12, 102.0), (50, -7.0)]
    );
}

#[test]
fn parameters_are_printed_whatever_the_verbosity() {
    let text = Run::ending_with(0, &["params"]).stdout;
    assert_eq!(Run::ending_with(0, &["params", "-q"]).stdout, text);
    let json =
        Run::ending_with(0, &["params", "--set", "sync.method=no-recovery", "--json"]).json();
    assert_eq!(
        (
            json["sync.method"].as_str(),
            json["sync.history.recovery"].as_f64()
        ),
        (Some("no-recovery"), Some(0.1))
    );
}
