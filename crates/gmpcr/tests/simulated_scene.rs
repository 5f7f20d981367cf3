//! Simulated depth-camera scans of furnished rooms, from raw clouds to poses against the ground truth.
#![cfg(feature = "fpfh")]
#![allow(clippy::unwrap_used)]

use gmpcr::features::FeatureParams;
use gmpcr::{Cloud, Params, compute_features_with, register};
use gmpcr_eval::{PairErrors, WorldPoses, overlap_matrix};
use gmpcr_sim::{SimParams, simulate};

#[test]
fn overlapping_scans_of_furnished_rooms_are_registered() {
    let (mut num_pairs, mut num_registered) = (0, 0);
    for seed in [1, 2, 7] {
        let params = SimParams {
            seed,
            num_scans: 14,
            ..SimParams::default()
        };
        let scans = simulate(&params).unwrap();
        let clouds = scans.clouds.iter().cloned().map(|points| Cloud {
            points,
            viewpoint: None,
        });
        let in_voxels = FeatureParams::from_voxel_size(1.0);
        let set = compute_features_with(clouds.collect(), Some(0.05), &in_voxels, &()).unwrap();
        let registration = register(&set.scans, &Params::threedmatch()).unwrap();

        let poses = registration
            .world_from_scan
            .iter()
            .copied()
            .map(Some)
            .collect();
        let poses = WorldPoses::new(poses, registration.components.labels().to_vec()).unwrap();
        let errors = PairErrors::of_all(&scans.world_from_scan, &poses).unwrap();
        let overlap = overlap_matrix(&scans.clouds, &scans.world_from_scan, 0.0375).unwrap();
        let is_match = |i, j| overlap[(i, j)] > 0.3;
        for pair in errors.pairs.iter().filter(|pair| is_match(pair.i, pair.j)) {
            let is_registered = |error: gmpcr_eval::PoseError| {
                error.rotation_degrees() < 15.0 && error.translation < 0.3
            };
            num_pairs += 1;
            num_registered += usize::from(pair.error.is_some_and(is_registered));
        }
    }
    let recall = num_registered as f64 / num_pairs as f64;
    assert!(num_pairs > 60, "{num_pairs} overlapping pairs");
    assert!(recall > 0.85, "{num_registered} of {num_pairs}");
}
