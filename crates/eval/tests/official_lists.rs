//! The official 3DMatch and 3DLoMatch lists against the poses that they were computed from.
//!
//! Needs scene folders with `poses.txt` and `official_*.log/.info` in the folder that `GMPCR_DATA` names; says so and
//! passes where there is none.

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use gmpcr_eval::{GroundTruthPair, PairErrors, Protocol, WorldPoses, registration_recall};
use nalgebra::{Isometry3, Matrix3, Matrix6, Point3, Rotation3, UnitQuaternion, Vector3};

use common::information_matrix;

const SCENES: [&str; 3] = ["redkitchen", "hotel_umd3", "mit_lab"];

fn data() -> Option<PathBuf> {
    let folder = PathBuf::from(std::env::var_os("GMPCR_DATA").unwrap_or_default());
    if folder.is_dir() {
        return Some(folder);
    }
    println!("skipped: no data in GMPCR_DATA={}", folder.display());
    None
}

fn numbers(line: &str) -> Vec<f64> {
    line.split_whitespace()
        .map(|word| word.parse().expect("a number"))
        .collect()
}

/// A transformation from the first three rows of its 4×4 matrix.
fn transformation(rows: &[f64]) -> Isometry3<f64> {
    let at = |row: usize, column: usize| rows[4 * row + column];
    let rotation = Rotation3::from_matrix(&Matrix3::from_fn(at));
    let translation = Vector3::new(at(0, 3), at(1, 3), at(2, 3));
    Isometry3::from_parts(
        translation.into(),
        UnitQuaternion::from_rotation_matrix(&rotation),
    )
}

type Entry = (usize, usize, Vec<f64>);

/// Entries of a header `i j n` and `rows` lines of numbers each.
fn entries(path: &Path, rows: usize) -> Vec<Entry> {
    let text = fs::read_to_string(path).expect("a readable list");
    let lines: Vec<Vec<f64>> = text
        .lines()
        .map(numbers)
        .filter(|line| !line.is_empty())
        .collect();
    let entry = |chunk: &[Vec<f64>]| {
        (
            chunk[0][0] as usize,
            chunk[0][1] as usize,
            chunk[1..].concat(),
        )
    };
    lines.chunks(rows + 1).map(entry).collect()
}

fn ground_truth(scene: &Path, list: &str) -> Vec<GroundTruthPair> {
    let log = entries(&scene.join(format!("official_{list}.log")), 4);
    let info = entries(&scene.join(format!("official_{list}.info")), 6);
    assert_eq!(log.len(), info.len());
    let pair = |((i, j, rows), (info_i, info_j, matrix)): (Entry, Entry)| {
        assert_eq!((i, j), (info_i, info_j));
        let information = Matrix6::from_row_slice(&matrix);
        GroundTruthPair {
            i,
            j,
            i_from_j: transformation(&rows),
            information,
        }
    };
    log.into_iter().zip(info).map(pair).collect()
}

fn poses(scene: &Path) -> Vec<Isometry3<f64>> {
    let text = fs::read_to_string(scene.join("poses.txt")).expect("readable poses");
    text.lines()
        .map(|line| transformation(&numbers(line)[1..]))
        .collect()
}

#[test]
fn ground_truth_poses_register_every_pair_of_the_official_lists() {
    let Some(data) = data() else { return };
    for scene in SCENES {
        let folder = data.join(scene);
        let world = WorldPoses::of_one_frame(&poses(&folder));
        for (list, protocol) in [
            ("3dmatch", Protocol::ThreeDMatch),
            ("3dlomatch", Protocol::ThreeDLoMatch),
        ] {
            let pairs = ground_truth(&folder, list);
            let recall = registration_recall(&pairs, &world, protocol).unwrap();
            let judged = recall.total - recall.unjudgeable.len();
            assert!(judged > 10, "{scene} {list}");
            assert_eq!(recall.registered, judged, "{scene} {list}");
            let errors = PairErrors::of_pairs(&pairs, &world).unwrap();
            assert!(
                errors.median().unwrap().translation < 0.01,
                "{scene} {list}"
            );
            println!("{scene} {list}: {}/{}", recall.registered, recall.total);
        }
    }
}

#[test]
fn a_scan_that_is_one_meter_off_loses_its_pairs() {
    let Some(data) = data() else { return };
    let folder = data.join(SCENES[0]);
    let mut world_from_scan = poses(&folder);
    world_from_scan[7] *= Isometry3::translation(1.0, 0.0, 0.0);
    let world = WorldPoses::of_one_frame(&world_from_scan);
    let pairs = ground_truth(&folder, "3dlomatch");
    let recall = registration_recall(&pairs, &world, Protocol::ThreeDLoMatch).unwrap();
    let with_scan = pairs
        .iter()
        .filter(|pair| pair.i == 7 || pair.j == 7)
        .count();
    assert!(with_scan > 0);
    assert_eq!(recall.total - recall.registered, with_scan);
}

/// `GᵀG` summed over points has a fixed pattern; the official matrices must show the same one.
#[test]
fn official_matrices_have_the_form_of_a_sum_over_points() {
    let Some(data) = data() else { return };
    for pair in ground_truth(&data.join(SCENES[0]), "3dmatch") {
        let official = pair.information;
        let count = official.m11;
        let mean = Point3::new(official[(1, 5)], official[(2, 3)], official[(0, 4)]) / count;
        let ours = count * information_matrix(&[mean]);
        let difference = (official - ours).fixed_view::<3, 6>(0, 0).amax();
        assert!(difference < 1e-6 * official.amax(), "{difference}");
        // The lower right block also holds the spread of the points, which is never negative.
        let spread = (official - ours).fixed_view::<3, 3>(3, 3).into_owned();
        assert!(spread.symmetric_eigenvalues().min() > -1e-4 * count);
    }
}
