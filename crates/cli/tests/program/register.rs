//! `gmpcr register` on good scans.

use std::fs;

use gmpcr_io::{read_g2o, read_open3d_pose_graph, read_ply, read_poses_3x4, read_poses_tum};

use crate::common::{Run, Workplace, assert_close, pose, poses, program, room, write_ply};

const FILES: [&str; 7] = [
    "merged.ply",
    "posegraph.g2o",
    "posegraph.json",
    "poses.tum",
    "poses.txt",
    "report.html",
    "result.json",
];

#[test]
fn a_folder_becomes_all_files_which_agree() {
    let place = Workplace::with_scans();
    let result = place.register(0, "scans", "out", &[]);
    let poses = poses(&result);
    assert_close(&poses, &room().world_from_scan);
    assert_eq!(place.files("out"), FILES);

    let out = place.path("out");
    let indexed: Vec<_> = poses.iter().copied().enumerate().collect();
    for (read, expected) in read_poses_3x4(out.join("poses.txt"))
        .unwrap()
        .iter()
        .zip(&indexed)
    {
        assert_eq!(read.0, expected.0);
        assert!((read.1.to_matrix() - expected.1.to_matrix()).norm() < 1e-12);
    }
    let stamps: Vec<f64> = read_poses_tum(out.join("poses.tum"))
        .unwrap()
        .iter()
        .map(|pose| pose.0)
        .collect();
    assert_eq!(stamps, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);

    let g2o = read_g2o(out.join("posegraph.g2o")).unwrap();
    let open3d = read_open3d_pose_graph(out.join("posegraph.json")).unwrap();
    assert_eq!((g2o.vertices.len(), open3d.nodes.len()), (6, 6));
    assert_eq!(g2o.edges.len(), open3d.edges.len());
    assert!(g2o.edges.len() >= 5);
    for (a, b) in g2o.edges.iter().zip(&open3d.edges) {
        assert_eq!((a.i, a.j), (b.target, b.source));
        assert!((a.i_from_j.to_matrix() - b.target_from_source.to_matrix()).norm() < 1e-9);
    }
    let num_points: usize = room().clouds.iter().map(Vec::len).sum();
    assert_eq!(
        read_ply(out.join("merged.ply")).unwrap().points.len(),
        num_points
    );
    let report = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(report.contains("scan_5.ply") && report.ends_with("</html>\n"));
}

#[test]
fn the_result_tells_everything() {
    let place = Workplace::with_scans();
    let result = place.register(0, "scans", "out", &["--set", "sync.iterations=7"]);
    assert_eq!(result["parameters"]["sync.iterations"], 7);
    assert_eq!(result["voxel_is_estimated"], true);
    assert_eq!(result["confidences"].as_array().unwrap().len(), 15);
    assert_eq!(result["scans"][2]["name"], "scan_2.ply");
    for edge in result["edges"].as_array().unwrap() {
        assert_eq!(edge["weights"].as_array().unwrap().len(), 8);
        assert!(edge["inlier_ratio"].as_f64().unwrap() > 0.0);
        assert!(edge["rotation_residual"].is_number());
    }
    let stages = result["stages"].as_array().unwrap().iter();
    let stages: Vec<_> = stages
        .map(|stage| stage["name"].as_str().unwrap())
        .collect();
    assert_eq!(stages[..3], ["reading", "voxel", "features"]);
    assert_eq!(stages[7], "synchronisation");
}

#[test]
fn one_thread_and_two_write_the_same_bytes() {
    let place = Workplace::with_scans();
    for threads in ["1", "2"] {
        let arguments = ["register", &place.text("scans"), "-o", &place.text(threads)];
        let status = program(&arguments)
            .env("RAYON_NUM_THREADS", threads)
            .output()
            .unwrap()
            .status;
        assert!(status.success());
    }
    for name in [
        "merged.ply",
        "posegraph.g2o",
        "posegraph.json",
        "poses.tum",
        "poses.txt",
    ] {
        let [one, two] = ["1", "2"].map(|folder| fs::read(place.path(folder).join(name)).unwrap());
        assert!(one == two, "{name}");
    }
}

#[test]
fn the_unit_of_the_scans_does_not_matter() {
    let place = Workplace::new();
    let folder = place.create("millimetres");
    for (k, cloud) in room().clouds.iter().enumerate() {
        let scaled: Vec<_> = cloud.iter().map(|point| point * 1000.0).collect();
        write_ply(&folder.join(format!("scan_{k}.ply")), &scaled);
    }
    let result = place.register(0, "millimetres", "out", &[]);
    let mut poses = poses(&result);
    for pose in &mut poses {
        pose.translation.vector /= 1000.0;
    }
    assert_close(&poses, &room().world_from_scan);
    assert!(result["voxel"].as_f64().unwrap() > 10.0);
}

#[test]
fn scans_without_overlap_are_named_and_the_rest_is_written() {
    let place = Workplace::with_scans();
    // A lone wavy sheet that belongs to no room.
    let sheet: Vec<_> = (0..4000)
        .map(|k| (f64::from(k % 80) * 0.03, f64::from(k / 80) * 0.03))
        .map(|(x, y)| [x, y, 1.0 + 0.2 * (9.0 * x).sin() * (7.0 * y).cos()].into())
        .collect();
    write_ply(&place.path("scans").join("sheet.ply"), &sheet);
    write_ply(&place.path("scans").join("void.ply"), &[]);
    let run = Run::of(&["register", &place.text("scans"), "-o", &place.text("out")]);
    assert_eq!(run.code, Some(2), "{}", run.stderr);
    assert!(
        run.stdout
            .contains("void.ply is not registered: it holds no points"),
        "{}",
        run.stdout
    );
    assert_eq!(place.files("out"), FILES);
    let result = place.result("out");
    let first = result["scans"][0]["component"].as_u64().unwrap();
    assert_ne!(result["scans"][7]["component"], first);
    let good: Vec<_> = (0..6)
        .map(|k| pose(&result["scans"][k]["world_from_scan"]))
        .collect();
    assert_close(&good, &room().world_from_scan);
}

#[test]
fn thinning_leaves_fewer_points() {
    let place = Workplace::with_scans();
    let sizes = [
        ("whole", &[][..]),
        ("thin", &["--thin"]),
        ("coarse", &["--thin=0.5"]),
    ];
    let sizes = sizes.map(|(out, options)| {
        place.register(0, "scans", out, options);
        read_ply(place.path(out).join("merged.ply"))
            .unwrap()
            .points
            .len()
    });
    assert!(sizes[0] > sizes[1] && sizes[1] > 4 * sizes[2], "{sizes:?}");
}

#[test]
fn what_is_printed_follows_the_wish() {
    let place = Workplace::with_scans();
    let (scans, out) = (place.text("scans"), place.text("out"));
    let run = |options: &[&str]| {
        Run::ending_with(0, &[&["register", &scans, "-o", &out], options].concat())
    };

    let usual = run(&[]);
    for part in [
        "scans in one frame  6 of 6",
        "components          1",
        "weakest links",
        "(estimated)",
    ] {
        assert!(usual.stdout.contains(part), "{}", usual.stdout);
    }
    assert_eq!(
        usual.stderr, "",
        "no bars where standard error is no terminal"
    );
    let quiet = run(&["-q"]);
    assert_eq!((quiet.stdout.as_str(), quiet.stderr.as_str()), ("", ""));
    assert!(run(&["-v"]).stdout.lines().count() > usual.stdout.lines().count());
    let json = run(&["--json"]).json();
    assert_eq!(json["scans"], place.result("out")["scans"]);
}

#[test]
fn files_may_be_named_one_by_one() {
    let place = Workplace::with_scans();
    let files = [3, 0, 1].map(|k| place.text(&format!("scans/scan_{k}.ply")));
    let out = place.text("out");
    Run::ending_with(
        0,
        &["register", &files[0], &files[1], &files[2], "-o", &out],
    );
    let result = place.result("out");
    let truth = [3, 0, 1].map(|k| room().world_from_scan[k]);
    assert_eq!(result["scans"][0]["name"], "scan_3.ply");
    assert_close(&poses(&result), &truth);
}

#[test]
fn results_among_the_scans_are_not_taken_for_scans() {
    let place = Workplace::with_scans();
    for _ in 0..2 {
        let result = place.register(0, "scans", "scans", &[]);
        assert_eq!(result["scans"].as_array().unwrap().len(), 6);
    }
}
