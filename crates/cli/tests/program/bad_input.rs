//! Input that is no good: a message that names the file and helps, and never half a result.

use std::fs;

use crate::common::{Run, Workplace, program, room, write_ply};
#[cfg(all(feature = "las", feature = "e57"))]
use crate::formats::write_las;

/// What the program says about input that it cannot use at all.
fn complaint(arguments: &[&str]) -> String {
    let run = Run::ending_with(1, arguments);
    assert_eq!(run.stdout, "");
    assert!(!run.stderr.contains("panicked"), "{}", run.stderr);
    run.stderr
}

fn assert_said(said: &str, parts: &[&str]) {
    for part in parts {
        assert!(said.contains(part), "{part:?} is not in {said:?}");
    }
}

#[test]
fn folders_and_files_that_are_not_there_are_named() {
    let place = Workplace::new();
    let out = place.text("out");
    let register = |input: &str| complaint(&["register", input, "-o", &out]);
    assert_said(
        &register(&place.text("nowhere")),
        &["nowhere: there is no such folder or file"],
    );
    place.create("empty");
    assert_said(&register(&place.text("empty")), &["empty holds no"]);
    assert_said(&complaint(&["sync", &place.text("no.g2o")]), &["no.g2o"]);
    assert_said(
        &complaint(&["eval", &place.text("no.json"), &out]),
        &["no.json"],
    );
    assert_said(
        &complaint(&["register", "--descriptors", &place.text("empty")]),
        &["empty"],
    );
}

#[test]
fn wrong_usage_ends_with_one_and_help_with_zero() {
    for arguments in [
        &["register"][..],
        &["frobnicate"],
        &["register", "x", "--voxel", "-1"],
        &["register", "x", "--preset", "moon"],
        &["sync", "x", "--method", "best"],
        &["info", "x", "-q", "-v"],
    ] {
        assert_eq!(Run::of(arguments).code, Some(1), "{arguments:?}");
    }
    assert_eq!(Run::of(&["--help"]).code, Some(0));
    assert_eq!(Run::of(&["--version"]).code, Some(0));
}

#[test]
fn parameters_that_cannot_be_are_named_before_any_work() {
    let place = Workplace::with_scans();
    let scans = place.text("scans");
    let out = place.text("out");
    let register =
        |option: &str, value: &str| complaint(&["register", &scans, "-o", &out, option, value]);
    assert_said(
        &register("--set", "posegraph.neighbor=3"),
        &["no parameter posegraph.neighbor;", "posegraph.neighbors"],
    );
    assert_said(
        &register("--set", "compatibility.retained_fraction=2"),
        &["retained_fraction", "(0, 1]"],
    );
    let file = place.write("bad.toml", "voxel_size = [1\n");
    assert_said(&register("--config", &file), &["bad.toml", "line 1"]);
    let file = place.write("odd.toml", "[sync]\nmethod = 3\n");
    assert_said(
        &register("--config", &file),
        &["odd.toml", "sync.method is 3"],
    );
    assert!(!place.path("out").exists());
}

/// A good file, cut in the middle.
#[cfg(all(feature = "las", feature = "e57"))]
fn cut(place: &Workplace, name: &str, content: &[u8]) {
    fs::write(
        place.path("scans").join(name),
        &content[..content.len() / 2],
    )
    .unwrap();
}

#[cfg(all(feature = "las", feature = "e57"))]
#[test]
fn files_that_are_cut_off_are_left_out_and_named() {
    let place = Workplace::with_scans();
    let whole = fs::read(place.path("scans/scan_5.ply")).unwrap();
    cut(&place, "scan_5.ply", &whole);
    let las = place.path("whole.las");
    write_las(&las, &room().clouds[5][..500]);
    cut(&place, "scan_6.las", &fs::read(&las).unwrap());
    fs::write(place.path("scans/scan_7.e57"), b"ASTM-E57 and no more").unwrap();
    fs::write(place.path("scans/scan_8.pcd"), b"").unwrap();

    let run = Run::ending_with(
        2,
        &["register", &place.text("scans"), "-o", &place.text("out")],
    );
    for name in ["scan_5.ply", "scan_6.las", "scan_7.e57", "scan_8.pcd"] {
        let line = run.stderr.lines().find(|line| line.contains(name));
        let line = line.unwrap_or_else(|| panic!("{name} is not in {}", run.stderr));
        assert_said(line, &["left out", "mend or remove the file"]);
    }
    assert_said(
        &run.stdout,
        &[
            "5 of 9",
            "scan_7.e57 is not registered: it could not be read",
        ],
    );
    let result = place.result("out");
    assert!(result["scans"][5]["problem"].is_string());
    assert_eq!(
        crate::common::registration(&result)
            .components
            .largest()
            .len(),
        5
    );
}

#[test]
fn one_readable_scan_is_too_few() {
    let place = Workplace::with_scans();
    let empty = place.write("empty.ply", "");
    let scan = place.text("scans/scan_0.ply");
    let said = complaint(&["register", &scan, &empty, "-o", &place.text("out")]);
    assert_said(&said, &["1 of 2 scans could be read", "empty.ply"]);
    assert!(place.files("out").is_empty());
    assert_said(&complaint(&["pair", &scan, &empty]), &["empty.ply"]);
}

#[test]
fn unknown_kinds_of_files_are_told_the_known_ones() {
    let place = Workplace::with_scans();
    let file = place.write("scan.stl", "solid");
    let said = complaint(&["pair", &file, &place.text("scans/scan_0.ply")]);
    assert_said(&said, &["scan.stl", ".ply", ".npy"]);
    assert_eq!(said.contains(".las"), cfg!(feature = "las"), "{said}");
    assert_eq!(said.contains(".e57"), cfg!(feature = "e57"), "{said}");
}

#[test]
fn descriptors_of_different_kinds_are_told_apart() {
    let place = Workplace::new();
    let folder = place.create("learned");
    for (k, dimension) in [(0, 4), (1, 4), (2, 5)] {
        for (kind, columns) in [("kpts", 3), ("desc", dimension)] {
            let text = |shape: usize| {
                format!("{{'descr': '<f4', 'fortran_order': False, 'shape': (5, {shape}), }}")
            };
            let header = format!("{:<117}\n", text(columns));
            let mut bytes = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
            bytes.extend(header.bytes());
            for entry in 0..5 * columns {
                bytes.extend((entry as f32).to_le_bytes());
            }
            fs::write(folder.join(format!("{k}.{kind}.npy")), bytes).unwrap();
        }
    }
    let said = complaint(&[
        "register",
        "--descriptors",
        folder.to_str().unwrap(),
        "-o",
        &place.text("out"),
    ]);
    assert_said(
        &said,
        &["2.desc.npy has descriptors of 5 numbers", "0.desc.npy of 4"],
    );
}

#[test]
fn output_that_cannot_be_is_refused_before_any_work() {
    let place = Workplace::with_scans();
    let file = place.write("file", "");
    let said = complaint(&[
        "register",
        &place.text("scans"),
        "-o",
        &format!("{file}/out"),
    ]);
    assert_said(&said, &["file/out", "choose another folder with --out"]);
    // A folder stands where a file is to be: all others are written.
    place.create("out/merged.ply");
    let said = complaint(&["register", &place.text("scans"), "-o", &place.text("out")]);
    assert_said(&said, &["merged.ply", "the other files are complete"]);
    assert_eq!(place.files("out").len(), 7);
    assert_eq!(place.result("out")["scans"].as_array().unwrap().len(), 6);
}

/// The shell limits the size of files; a disk that is full looks the same to the program.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_no_half_file() {
    let place = Workplace::with_scans();
    let script = "trap '' XFSZ; ulimit -f 150; exec \"$0\" register \"$1\" -o \"$2\"";
    let run: Run = std::process::Command::new("bash")
        .args(["-c", script, program(&[]).get_program().to_str().unwrap()])
        .args([place.text("scans"), place.text("out")])
        .output()
        .unwrap()
        .into();
    assert_eq!(run.code, Some(1), "{}{}", run.stdout, run.stderr);
    assert_said(&run.stderr, &["merged.ply", "report.html", "make room"]);
    let files = place.files("out");
    assert!(
        !files.contains(&"merged.ply".to_owned()) && files.contains(&"result.json".to_owned()),
        "{files:?}"
    );
    assert!(
        files.iter().all(|name| !name.ends_with(".part")),
        "{files:?}"
    );
}

#[test]
fn what_is_no_result_is_told() {
    let place = Workplace::with_scans();
    let ground_truth = place.write("poses.txt", "0 1 0 0 0 0 1 0 0 0 0 1 0\n");
    let foreign = place.write("foreign.json", "{\"scans\": 3}");
    assert_said(
        &complaint(&["eval", &foreign, &ground_truth]),
        &["foreign.json: no result.json"],
    );
    place.register(0, "scans", "out", &[]);
    let result = place.text("out/result.json");
    let many: String = (0..9)
        .map(|k| format!("{k} 1 0 0 0 0 1 0 0 0 0 1 0\n"))
        .collect();
    let many = place.write("many.txt", many);
    assert_said(
        &complaint(&["eval", &result, &many]),
        &["many.txt: a pose of scan 6, but there are 6 scans"],
    );
}

#[test]
fn ground_truth_that_cannot_be_is_named() {
    let place = Workplace::with_scans();
    place.register(0, "scans", "out", &[]);
    let result = place.text("out/result.json");
    let pose = "1 0 0 0 0 1 0 0 0 0 1 0";
    for (content, reason) in [
        (String::new(), "there is no pose in it"),
        (format!("0 {pose}\n0 {pose}\n"), "scan 0 has two poses"),
        (
            format!("18446744073709551615 {pose}\n"),
            "a pose of scan 18446744073709551615, but there are 6 scans",
        ),
    ] {
        let file = place.write("poses.txt", content);
        assert_said(
            &complaint(&["eval", &result, &file]),
            &["poses.txt", reason],
        );
    }
    let log = place.write("gt.log", "");
    assert_said(
        &complaint(&["eval", &result, &log]),
        &["gt.log", "there is no pair in it"],
    );
}

#[test]
fn results_changed_by_hand_are_refused() {
    let place = Workplace::with_scans();
    let result = place.register(0, "scans", "out", &[]);
    let ground_truth = place.write("poses.txt", "0 1 0 0 0 0 1 0 0 0 0 1 0\n");
    type Spoil = fn(&mut serde_json::Value);
    let cases: [(Spoil, &str); 4] = [
        (
            |r| r["registration"]["components"][0][0] = 999.into(),
            "no result.json",
        ),
        (
            |r| r["registration"]["components"] = serde_json::json!([]),
            "0 scans in components for 6 scans",
        ),
        (
            |r| r["registration"]["world_from_scan"][1][0] = 7.into(),
            "transformation 1 is not rigid",
        ),
        (
            |r| r["format"] = 3.into(),
            "the form of the file is 3, known are 1 and 2",
        ),
    ];
    for (spoil, reason) in cases {
        let mut spoiled = result.clone();
        spoil(&mut spoiled);
        let file = place.write("spoiled.json", spoiled.to_string());
        assert_said(
            &complaint(&["eval", &file, &ground_truth]),
            &["spoiled.json", reason],
        );
    }
}

#[test]
fn graphs_that_cannot_be_are_told_by_their_vertices() {
    let place = Workplace::new();
    let edge = |i: usize, j: usize, r: &str| {
        format!(
            "EDGE_SE3:QUAT {i} {j} 1 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 {r} 0 0 {r} 0 {r}\n"
        )
    };
    for (content, reason) in [
        (edge(7, 7, "1"), "an edge joins vertex 7 with itself"),
        (
            edge(7, 9, "1e308"),
            "the edge of vertices 7 and 9 has rotation information",
        ),
        (edge(7, 9, "-1"), "finite and not negative"),
        (edge(7, 9, "0"), "no EDGE_SE3:QUAT record with information"),
    ] {
        let file = place.write("odd.g2o", content);
        assert_said(&complaint(&["sync", &file]), &["odd.g2o", reason]);
    }
}

#[test]
fn a_return_at_the_end_of_the_world_is_left_out() {
    let place = Workplace::with_scans();
    let mut cloud = room().clouds[0].clone();
    cloud.push([f64::from(f32::MAX), 0.0, 0.0].into());
    write_ply(&place.path("scans/scan_0.ply"), &cloud);
    let run = Run::ending_with(
        0,
        &["register", &place.text("scans"), "-o", &place.text("out")],
    );
    assert_said(&run.stderr, &["scan_0.ply: 1 point far off left out"]);
}

#[test]
fn a_scan_is_not_overwritten() {
    let place = Workplace::with_scans();
    let merged = place.text("scans/merged.ply");
    fs::copy(place.path("scans/scan_0.ply"), &merged).unwrap();
    let scans = place.text("scans");
    let said = complaint(&[
        "register",
        &place.text("scans/scan_1.ply"),
        &merged,
        "-o",
        &scans,
    ]);
    assert_said(&said, &["merged.ply", "would be overwritten"]);
}

#[test]
fn a_voxel_too_small_to_downsample_is_an_error() {
    let place = Workplace::with_scans();
    let said = complaint(&[
        "register",
        &place.text("scans"),
        "-o",
        &place.text("out"),
        "--downsample=1e-30",
    ]);
    assert_said(&said, &["--downsample", "the other files are complete"]);
    assert_eq!(place.files("out").len(), 6);
}
