//! Real scans with learned descriptors against a float64 reference run of the whole method, stage
//! by stage. The data are in the folder that `GMPCR_DATA` names: `descriptors/<scene>` and
//! `expected/<scene>_learned.json`. Without them the tests say that they skip.

#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};

use gmpcr::correspondence::farthest_point_sampling;
use gmpcr::nalgebra::{Isometry3, Matrix3x4};
use gmpcr::{Params, Registration, Scan, register};
use gmpcr_io::descriptor_files;
use serde_json::Value;

fn data() -> Option<PathBuf> {
    let folder = PathBuf::from(std::env::var_os("GMPCR_DATA").unwrap_or_default());
    let is_present = folder.join("expected").is_dir();
    if !is_present {
        eprintln!("skipped: no real scans in GMPCR_DATA={}", folder.display());
    }
    is_present.then_some(folder)
}

fn learned_scans(folder: &Path) -> Vec<Scan> {
    let files = descriptor_files(folder).unwrap();
    files.iter().map(|files| files.read().unwrap()).collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn rows(value: &Value) -> Matrix3x4<f64> {
    let rows = value.as_array().unwrap().iter();
    let entries: Vec<f64> = rows
        .flat_map(|row| row.as_array().unwrap().iter().map(number))
        .collect();
    Matrix3x4::from_row_slice(&entries)
}

fn difference(transformation: &Isometry3<f64>, expected: &Value) -> f64 {
    let matrix = transformation.to_matrix();
    (matrix.fixed_rows::<3>(0) - rows(expected)).amax()
}

/// Largest differences to a reference run.
#[derive(Debug, Default)]
struct Agreement {
    confidence: f64,
    inlier_ratio: f64,
    transformation: f64,
    initial_weight: f64,
    final_weight: f64,
    pose: f64,
}

fn agreement(registration: &Registration, expected: &Value) -> Agreement {
    let mut found = Agreement::default();
    let keep = |largest: &mut f64, value: f64| {
        assert!(value.is_finite());
        *largest = largest.max(value);
    };
    let raw = expected["raw_confidence"].as_object().unwrap();
    assert_eq!(registration.confidences.pairs().len(), raw.len());
    for pair in registration.confidences.pairs() {
        let reference = number(&raw[&format!("{},{}", pair.i, pair.j)]);
        // The file holds nine decimals.
        let error = (pair.raw_confidence - reference).abs() - 1e-9;
        keep(&mut found.confidence, error / reference);
    }
    let edges = expected["edges"].as_array().unwrap();
    assert_eq!(registration.edges.len(), edges.len());
    for (k, edge) in edges.iter().enumerate() {
        let found_edge = &registration.edges[k];
        assert_eq!(
            (found_edge.i as f64, found_edge.j as f64),
            (number(&edge["i"]), number(&edge["j"]))
        );
        assert_eq!(
            found_edge.num_correspondences as f64,
            number(&edge["n_correspondences"])
        );
        let transformation = difference(&found_edge.i_from_j, &edge["relative"]);
        keep(&mut found.transformation, transformation);
        keep(
            &mut found.inlier_ratio,
            (found_edge.inlier_ratio - number(&edge["inlier_ratio"])).abs(),
        );
        let error = |weight: f64, key: &str| (weight - number(&edge[key])).abs();
        keep(
            &mut found.initial_weight,
            error(found_edge.synchronization.initial_weight, "initial_weight"),
        );
        keep(
            &mut found.final_weight,
            error(found_edge.synchronization.final_weight, "final_weight"),
        );
    }
    let poses = expected["poses"].as_array().unwrap();
    assert_eq!(registration.world_from_scan.len(), poses.len());
    for (pose, expected) in registration.world_from_scan.iter().zip(poses) {
        keep(&mut found.pose, difference(pose, expected));
    }
    found
}

fn check(scene: &str) {
    let Some(data) = data() else { return };
    let file = data.join(format!("expected/{scene}_learned.json"));
    let expected: Value = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let scans = learned_scans(&data.join("descriptors").join(scene));
    let params = Params::threedmatch();
    let sampled = expected["sampled"].as_array().unwrap();
    assert_eq!(scans.len(), sampled.len());
    for (scan, sampled) in scans.iter().zip(sampled) {
        let samples =
            farthest_point_sampling(scan.descriptors(), params.correspondence.num_samples);
        let reference = sampled.as_array().unwrap().iter();
        let reference: Vec<usize> = reference.map(|row| number(row) as usize).collect();
        assert_eq!(samples, reference);
    }
    let registration = register(&scans, &params).unwrap();
    let found = agreement(&registration, &expected);
    assert!(found.confidence < 1e-6, "{found:?}");
    assert!(found.inlier_ratio < 1e-9, "{found:?}");
    assert!(
        found.transformation < 1e-6 && found.pose < 1e-6,
        "{found:?}"
    );
    assert!(
        found.initial_weight < 1e-9 && found.final_weight < 1e-9,
        "{found:?}"
    );
}

#[test]
fn redkitchen_agrees_with_the_reference_run() {
    check("redkitchen");
}

#[test]
fn hotel_umd3_agrees_with_the_reference_run() {
    check("hotel_umd3");
}

#[test]
fn mit_lab_agrees_with_the_reference_run() {
    check("mit_lab");
}
