//! Real scans, where they are there, without any option.

use crate::common::{Run, Workplace, real_data};

fn recall(result: &str, truth: &str, list: &str) -> f64 {
    let json = Run::ending_with(0, &["eval", result, truth, "--json"]).json();
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
    let result = place.text("out/result.json");
    let truth = folder.join("gt_3dmatch.log");
    assert!(recall(&result, truth.to_str().unwrap(), "gt_3dmatch") > 0.7);
}
