//! `gmpcr eval`: results of either form, and the pairs that count.

use gmpcr::nalgebra::Isometry3;
use gmpcr_io::{LogEntry, write_gt_log};

use crate::common::{Run, Workplace};

/// Three scans a meter apart, of which the last is in a frame of its own.
const FORM_1: &str = r#"{
    "format": 1,
    "version": "0.1.0",
    "voxel": 0.05,
    "scans": [
        { "name": "a", "component": 0, "world_from_scan": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0] },
        { "name": "b", "component": 0, "world_from_scan": [1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0] },
        { "name": "c", "component": 1, "world_from_scan": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0] }
    ],
    "components": [[0, 1], [2]],
    "notices": []
}"#;

/// `gt.log` and `gt.info` of all pairs of three scans a meter apart, in a folder of this name.
fn write_list(place: &Workplace, folder: &str) -> String {
    const IDENTITY: &str = "1 0 0 0 0 0\n0 1 0 0 0 0\n0 0 1 0 0 0\n\
                            0 0 0 1 0 0\n0 0 0 0 1 0\n0 0 0 0 0 1\n";
    let entries = [(0, 1), (0, 2), (1, 2)].map(|(i, j)| LogEntry {
        i,
        j,
        num_scans: 3,
        i_from_j: Isometry3::translation((j - i) as f64, 0.0, 0.0),
    });
    write_gt_log(place.create(folder).join("gt.log"), &entries).unwrap();
    let information = entries.map(|entry| format!("{} {} 3\n{IDENTITY}", entry.i, entry.j));
    place.write(&format!("{folder}/gt.info"), information.concat());
    place.text(&format!("{folder}/gt.log"))
}

#[test]
fn results_of_the_first_form_are_still_read() {
    let place = Workplace::new();
    let result = place.write("result.json", FORM_1);
    let pose = |x: f64| format!("1 0 0 {x} 0 1 0 0 0 0 1 0\n");
    let ground_truth = place.write("poses.txt", [0.0, 1.0, 2.0].map(pose).concat());
    let json = Run::ending_with(2, &["eval", &result, &ground_truth, "--json"]).json();
    let poses = &json["poses"];
    assert_eq!(poses["scans"], 3);
    assert_eq!(poses["without_common_frame"], 2);
    assert_eq!(poses["absolute_scans"], 2);
    for kind in ["relative", "absolute"] {
        let error = poses[kind]["mean"]["translation"].as_f64().unwrap();
        assert!(error < 1e-9, "{kind}: {error}");
    }
}

#[test]
fn first_forms_changed_by_hand_are_refused() {
    let place = Workplace::new();
    let ground_truth = place.write("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n");
    for (part, replacement, reason) in [
        ("[2]]", "[]]", "scan 2 is in no component"),
        ("[2]]", "[1]]", "scan 1 is in two components"),
        ("[2]]", "[2, 9]]", "names a scan 9"),
        (
            "[1, 0, 0, 1,",
            "[7, 0, 0, 1,",
            "the pose of scan 1 is no rigid transformation",
        ),
        (
            "\"format\": 1",
            "\"format\": 0",
            "the form of the file is 0, known are 1 and 2",
        ),
    ] {
        assert!(FORM_1.contains(part));
        let result = place.write("result.json", FORM_1.replacen(part, replacement, 1));
        let run = Run::ending_with(1, &["eval", &result, &ground_truth]);
        assert!(run.stderr.contains(reason), "{}", run.stderr);
    }
}

#[test]
fn consecutive_pairs_count_in_3dlomatch_only() {
    let place = Workplace::new();
    let result = place.write("result.json", FORM_1);
    // Of the pairs 0 – 1, 0 – 2 and 1 – 2, only the first is registered.
    for (folder, expected) in [("3DMatch", 0.0), ("3DLoMatch", 1.0 / 3.0)] {
        let list = write_list(&place, folder);
        let json = Run::ending_with(2, &["eval", &result, &list, "--json"]).json();
        let list = &json[format!("{folder}/gt")];
        assert_eq!(list["pairs"], 3);
        assert_eq!(list["without_common_frame"], 2);
        assert_eq!(list["registration_recall"], expected);
    }
}
