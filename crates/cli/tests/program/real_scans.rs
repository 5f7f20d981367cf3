//! Real scans, where they are there, without any option.

use crate::common::{Run, Workplace, program, real_data};

fn recall(result: &str, ground_truth: &str, list: &str) -> f64 {
    let json = Run::ending_with(0, &["eval", result, ground_truth, "--json"]).json();
    json[list]["registration_recall"].as_f64().unwrap()
}

#[test]
fn rooms_are_registered_without_any_option() {
    let Some(folder) = real_data("redkitchen") else {
        return;
    };
    let folder = folder.to_str().unwrap();
    let place = Workplace::new();
    let out = place.text("out");
    Run::ending_with(0, &["register", folder, "-o", &out]);
    let result = place.text("out/result.json");
    assert!(recall(&result, folder, "3dmatch") > 0.93);
    assert!(recall(&result, folder, "3dlomatch") > 0.88);
}

#[test]
fn an_object_is_registered_by_the_same_command() {
    let Some(folder) = real_data("stanford_bunny") else {
        return;
    };
    let place = Workplace::new();
    let out = place.text("out");
    Run::ending_with(0, &["register", folder.to_str().unwrap(), "-o", &out]);
    let (result, ground_truth) = (place.text("out/result.json"), folder.join("poses.txt"));
    let json = Run::ending_with(
        0,
        &["eval", &result, ground_truth.to_str().unwrap(), "--json"],
    )
    .json();
    // Of an object of 15 cm.
    let median = &json["poses"]["relative"]["median"];
    assert!(
        median["rotation_degrees"].as_f64().unwrap() < 8.0,
        "{json:#}"
    );
    assert!(median["translation"].as_f64().unwrap() < 0.015, "{json:#}");
}

#[cfg(target_os = "linux")]
#[test]
fn sixty_fragments_need_less_than_300_megabytes() {
    let Some(folder) = real_data("redkitchen") else {
        return;
    };
    let place = Workplace::new();
    let arguments = ["register", folder.to_str().unwrap(), "-q", "-o"];
    let mut child = program(&[&arguments[..], &[&place.text("out")]].concat())
        .spawn()
        .unwrap();
    let status = format!("/proc/{}/status", child.id());
    let mut peak_kilobytes = 0;
    while child.try_wait().unwrap().is_none() {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let peak = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kilobytes = peak.and_then(|peak| peak.trim().trim_end_matches(" kB").parse().ok());
        peak_kilobytes = kilobytes.unwrap_or(peak_kilobytes);
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    assert!(
        (20_000..300_000).contains(&peak_kilobytes),
        "{peak_kilobytes} kB"
    );
}
