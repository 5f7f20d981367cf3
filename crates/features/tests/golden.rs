//! Normals and descriptors of Open3D, stored with the recipe of their cloud in `fixtures`.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may fail")]

use gmpcr_features::{FPFH_DIMENSION, FpfhParams, NormalParams, estimate_normals, fpfh};
use nalgebra::{Point3, Vector3};

const NORMALS: NormalParams = NormalParams {
    radius: 0.12,
    max_neighbors: 12,
    viewpoint: Point3::new(0.0, 0.0, 0.0),
};
const FPFH: FpfhParams = FpfhParams {
    radius: 0.2,
    max_neighbors: 30,
};

struct Golden {
    points: Vec<Point3<f64>>,
    normals: Vec<Vector3<f64>>,
    descriptors: Vec<Vec<f64>>,
}

fn golden() -> Golden {
    let lines = include_str!("fixtures/bumpy_sheet.txt")
        .lines()
        .filter(|l| !l.starts_with('#'));
    let rows: Vec<Vec<f64>> = lines
        .map(|line| line.split(' ').map(|word| word.parse().unwrap()).collect())
        .collect();
    Golden {
        points: rows
            .iter()
            .map(|row| Point3::from_slice(&row[..3]))
            .collect(),
        normals: rows
            .iter()
            .map(|row| Vector3::from_column_slice(&row[3..6]))
            .collect(),
        descriptors: rows.iter().map(|row| row[6..].to_vec()).collect(),
    }
}

fn assert_descriptors_are_golden(normals: &[Vector3<f64>], golden: &Golden) {
    let descriptors = fpfh(&golden.points, normals, &FPFH).unwrap();
    assert_eq!(descriptors.len(), 120);
    for (ours, theirs) in descriptors.iter().zip(&golden.descriptors) {
        assert_eq!(theirs.len(), FPFH_DIMENSION);
        for (a, b) in ours.iter().zip(theirs) {
            assert!((f64::from(*a) - b).abs() < 2e-5, "{a} instead of {b}");
        }
    }
}

#[test]
fn normals_are_those_of_open3d() {
    let golden = golden();
    let normals = estimate_normals(&golden.points, &NORMALS).unwrap();
    assert_eq!(normals.len(), 120);
    for (ours, theirs) in normals.iter().zip(&golden.normals) {
        // Open3D sums about the origin and loses some digits of the covariance.
        assert!((ours - theirs).norm() < 1e-9, "{ours} instead of {theirs}");
    }
}

#[test]
fn descriptors_are_those_of_open3d() {
    let golden = golden();
    assert_descriptors_are_golden(&golden.normals, &golden);
}

#[test]
fn descriptors_on_own_normals_are_those_of_open3d() {
    let golden = golden();
    let normals = estimate_normals(&golden.points, &NORMALS).unwrap();
    assert_descriptors_are_golden(&normals, &golden);
}
