//! `gmpcr register` on good scans.

use std::fs;

use gmpcr_io::{read_g2o, read_open3d_pose_graph, read_ply, read_poses, read_poses_tum};

use crate::common::{Run, Workplace, assert_close, poses, program, registration, room, write_ply};

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
    for (read, expected) in read_poses(out.join("poses.txt"))
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
    assert_eq!(result["format"], 2);
    assert_eq!(result["scans"][2]["name"], "scan_2.ply");
    let points = result["scans"][2]["points"].as_u64().unwrap();
    let with_features = result["scans"][2]["with_features"].as_u64().unwrap();
    assert!(0 < with_features && with_features < points);
    let json = &result["registration"];
    assert_eq!(json["confidences"]["pairs"].as_array().unwrap().len(), 15);
    for edge in json["edges"].as_array().unwrap() {
        assert_eq!(edge["weights"].as_array().unwrap().len(), 8);
        assert!(edge["inlier_ratio"].as_f64().unwrap() > 0.0);
        // Radians.
        assert!(edge["rotation_residual"].as_f64().unwrap() <= std::f64::consts::PI);
    }
    let stages = result["stages"].as_array().unwrap().iter();
    let stages: Vec<_> = stages
        .map(|stage| stage["name"].as_str().unwrap())
        .collect();
    assert_eq!(stages[..3], ["reading", "voxel size", "features"]);
    assert_eq!(stages[7], "synchronization");
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
    let folder = place.create("millimeters");
    for (k, cloud) in room().clouds.iter().enumerate() {
        let scaled: Vec<_> = cloud.iter().map(|point| point * 1000.0).collect();
        write_ply(&folder.join(format!("scan_{k}.ply")), &scaled);
    }
    let result = place.register(0, "millimeters", "out", &[]);
    let mut poses = poses(&result);
    for pose in &mut poses {
        pose.translation.vector /= 1000.0;
    }
    assert_close(&poses, &room().world_from_scan);
    assert!(result["voxel_size"].as_f64().unwrap() > 10.0);
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
    let registration = registration(&result);
    let largest = registration.components.largest();
    assert!(largest.starts_with(&[0, 1, 2, 3, 4, 5]) && !largest.contains(&7));
    assert_close(&registration.world_from_scan[..6], &room().world_from_scan);
    let warnings = result["warnings"].as_array().unwrap();
    let warning = warnings
        .iter()
        .find(|warning| warning["scan"] == 7)
        .unwrap();
    assert_eq!(warning["kind"], "unregistered");
    assert_eq!(
        warning["text"],
        "void.ply is not registered: it holds no points"
    );
}

#[test]
fn downsampling_leaves_fewer_points() {
    let place = Workplace::with_scans();
    let sizes = [
        ("whole", &[][..]),
        ("voxel_size", &["--downsample"]),
        ("coarse", &["--downsample=0.5"]),
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
fn verbosity_decides_what_is_printed() {
    let place = Workplace::with_scans();
    let (scans, out) = (place.text("scans"), place.text("out"));
    let run = |options: &[&str]| {
        Run::ending_with(0, &[&["register", &scans, "-o", &out], options].concat())
    };

    let usual = run(&[]);
    for part in [
        "scans in one frame  6 of 6",
        "components          1",
        "behind a bridge     0 scans",
        "edges               ",
        " of 15 scored pairs",
        "weakest edges",
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
fn retrieval_scores_some_pairs_and_no_others_are_in_the_result() {
    let place = Workplace::with_scans();
    let options = [
        "retrieval.min_scans=0",
        "retrieval.candidates_per_scan=1",
        "retrieval.expansions=0",
    ];
    let options = options.map(|option| ["--set", option]).concat();
    let (scans, out) = (place.text("scans"), place.text("out"));
    let arguments = [&["register", &scans, "-o", &out], &options[..]].concat();
    let run = Run::of(&arguments);
    let registration = registration(&place.result("out"));
    let confidences = &registration.confidences;
    assert!((3..=6).contains(&confidences.pairs().len()));
    assert_eq!(confidences.pairs().len(), confidences.normalized().len());
    for edge in &registration.edges {
        let mut pairs = confidences.pairs().iter();
        assert!(pairs.any(|pair| (pair.i, pair.j) == (edge.i, edge.j)));
    }
    let scored = format!(" of {} scored pairs", confidences.pairs().len());
    assert!(run.stdout.contains(&scored), "{}", run.stdout);
    let report = fs::read_to_string(place.path("out/report.html")).unwrap();
    let (_, listed) = report.split_once("\"scored_pairs\":").unwrap();
    let listed = serde_json::Deserializer::from_str(listed).into_iter::<Vec<[f64; 3]>>();
    let listed = listed.into_iter().next().unwrap().unwrap();
    assert_eq!(listed.len(), confidences.pairs().len());
}

#[test]
fn warnings_are_sentences_that_name_the_files() {
    let place = Workplace::with_scans();
    let (scans, out) = (place.text("scans"), place.text("out"));
    let warnings = |neighbors: &str| {
        let run = Run::of(&["register", &scans, "-o", &out, "--set", neighbors]);
        let result = place.result("out");
        let warnings = result["warnings"].as_array().unwrap();
        let warning = |warning: &serde_json::Value| {
            let [kind, text] = ["kind", "text"].map(|key| warning[key].as_str().unwrap());
            assert!(
                run.stdout.contains(&format!("- {text}\n")),
                "{}",
                run.stdout
            );
            // Without the numbers in parentheses.
            let text = match (text.split_once(" ("), text.split_once(')')) {
                (Some((before, _)), Some((_, after))) => format!("{before}{after}"),
                _ => text.to_owned(),
            };
            format!("{kind}: {text}")
        };
        warnings.iter().map(warning).collect::<Vec<_>>()
    };
    assert_eq!(
        warnings("posegraph.neighbors=1"),
        [
            "separate_frame: scan_0.ply, scan_1.ply share a frame of their own: no edge connects \
             them to the largest one",
            "bridge: only the edge scan_4.ply – scan_5.ply connects scan_5.ply to the rest: \
             nothing confirms its pose",
            "bridge: only the edge scan_3.ply – scan_4.ply connects scan_4.ply, scan_5.ply to the \
             rest: nothing confirms their poses",
            "bridge: only the edge scan_2.ply – scan_3.ply connects scan_2.ply to the rest: \
             nothing confirms its pose",
        ]
    );
    let contradictions = warnings("posegraph.neighbors=3");
    let [contradiction] = contradictions.as_slice() else {
        panic!("{contradictions:?}");
    };
    let before =
        "contradiction: the relative pose of scan_0.ply and scan_5.ply contradicts the result by ";
    assert!(contradiction.starts_with(before), "{contradiction}");
    assert!(
        contradiction.ends_with(": two similar places?"),
        "{contradiction}"
    );
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
    let ground_truth = [3, 0, 1].map(|k| room().world_from_scan[k]);
    assert_eq!(result["scans"][0]["name"], "scan_3.ply");
    assert_close(&poses(&result), &ground_truth);
}

#[test]
fn results_among_the_scans_are_not_taken_for_scans() {
    let place = Workplace::with_scans();
    for _ in 0..2 {
        let result = place.register(0, "scans", "scans", &[]);
        assert_eq!(result["scans"].as_array().unwrap().len(), 6);
    }
}
