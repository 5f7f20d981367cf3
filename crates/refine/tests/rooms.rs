//! Depth-camera scans of a simulated flat, with ground truth.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may fail")]

use gmpcr_features::{NormalParams, estimate_normals, voxel_grid};
use gmpcr_refine::{
    IcpParams, JointParams, PairCounts, PosedSurface, Sequential, Surface, SurfaceParams,
    VerifyParams, refine_jointly, refine_pair, verify_pair,
};
use gmpcr_sim::{SimParams, SimulatedScans, simulate};
use nalgebra::{Isometry3, Point3, Vector3};

const VOXEL: f64 = 0.05;

struct Rooms {
    surfaces: Vec<Surface>,
    world_from_scan: Vec<Isometry3<f64>>,
}

impl Rooms {
    fn new() -> Self {
        let params = SimParams {
            num_scans: 10,
            ..SimParams::default()
        };
        let SimulatedScans {
            clouds,
            world_from_scan,
        } = simulate(&params).unwrap();
        let surface = |cloud: &Vec<Point3<f64>>| {
            let points = voxel_grid(cloud, VOXEL).unwrap();
            let normal_params = NormalParams {
                radius: 2.0 * VOXEL,
                ..NormalParams::default()
            };
            let normals = estimate_normals(&points, &normal_params).unwrap();
            let surface = Surface::new(&points, &normals, &SurfaceParams::from_voxel_size(VOXEL));
            surface.unwrap().seen_from(Point3::origin(), cloud).unwrap()
        };
        Self {
            surfaces: clouds.iter().map(surface).collect(),
            world_from_scan,
        }
    }

    fn i_from_j(&self, i: usize, j: usize) -> Isometry3<f64> {
        self.world_from_scan[i].inv_mul(&self.world_from_scan[j])
    }

    fn counts(&self, i: usize, j: usize, i_from_j: &Isometry3<f64>) -> PairCounts {
        let (i, j) = (&self.surfaces[i], &self.surfaces[j]);
        verify_pair(i, j, i_from_j, &VerifyParams::default()).unwrap()
    }

    /// Pairs that overlap by a tenth, with their counts at the ground truth.
    fn overlapping(&self) -> Vec<(usize, usize, PairCounts)> {
        let count = self.surfaces.len();
        let pairs = (0..count).flat_map(|i| (i + 1..count).map(move |j| (i, j)));
        let counted = pairs.map(|(i, j)| (i, j, self.counts(i, j, &self.i_from_j(i, j))));
        counted
            .filter(|(_, _, counts)| counts.overlap() > 120)
            .collect()
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn free_space_tells_the_ground_truth_from_other_poses() {
    let rooms = Rooms::new();
    let pairs = rooms.overlapping();
    assert!(pairs.len() > 12, "{}", pairs.len());
    let error = Isometry3::new(Vector3::new(0.5, -0.4, 0.3), Vector3::new(0.2, 0.3, -0.2));
    for (i, j, at_ground_truth) in &pairs {
        assert!(at_ground_truth.has_visibility() && !at_ground_truth.is_contradicted());
        assert!(
            at_ground_truth.violations() * 50 < at_ground_truth.overlap(),
            "{at_ground_truth:?}"
        );
        let elsewhere = rooms.counts(*i, *j, &(rooms.i_from_j(*i, *j) * error));
        assert!(elsewhere.smaller_side_ratio() < at_ground_truth.smaller_side_ratio());
    }
    let side = |counts: &PairCounts| counts.smaller_side_ratio();
    assert!(median(pairs.iter().map(|(_, _, counts)| side(counts)).collect()) > 0.9);
    let elsewhere = pairs
        .iter()
        .map(|(i, j, _)| side(&rooms.counts(*i, *j, &(rooms.i_from_j(*i, *j) * error))));
    assert!(median(elsewhere.collect()) < 0.4);
}

#[test]
fn refinement_finds_poses_to_a_fraction_of_a_voxel() {
    let rooms = Rooms::new();
    let error = Isometry3::new(
        Vector3::new(0.04, -0.03, 0.03),
        Vector3::new(0.02, 0.02, -0.02),
    );
    let errors = rooms.overlapping().into_iter().map(|(i, j, _)| {
        let ground_truth = rooms.i_from_j(i, j);
        let (of_i, of_j) = (&rooms.surfaces[i], &rooms.surfaces[j]);
        let found =
            refine_pair(of_i, of_j, &(ground_truth * error), &IcpParams::precise()).unwrap();
        let center = found.equations.center;
        (found.i_from_j * center - ground_truth * center).norm()
    });
    let errors: Vec<_> = errors.collect();
    assert!(median(errors.clone()) < 0.2 * VOXEL, "{errors:?}");
}

#[test]
fn all_scans_together_are_better_than_pairs() {
    let rooms = Rooms::new();
    let ground_truth = &rooms.world_from_scan;
    let error = |k: usize| {
        let size = if k == 0 {
            0.0
        } else {
            0.03 * (7.0 * k as f64).sin()
        };
        Isometry3::new(
            Vector3::new(size, -0.7 * size, 0.5 * size),
            Vector3::new(0.4, 0.3, -0.5) * size,
        )
    };
    let each = rooms.surfaces.iter().zip(ground_truth).enumerate();
    let scans: Vec<_> = each
        .map(|(k, (surface, pose))| PosedSurface::new(surface, pose * error(k)))
        .collect();
    let found = refine_jointly(&scans, &JointParams::precise(), &Sequential).unwrap();
    assert!(found.pairs.len() > 12 && found.frame_from_scan[0] == ground_truth[0]);
    let errors = |poses: Vec<Isometry3<f64>>| {
        let apart = |k: usize| {
            let center = rooms.surfaces[k].center();
            (poses[k] * center - ground_truth[k] * center).norm()
        };
        median((1..poses.len()).map(apart).collect())
    };
    let before = errors(scans.iter().map(|scan| scan.frame_from_scan).collect());
    let after = errors(found.frame_from_scan.clone());
    assert!(
        after < 0.2 * VOXEL && after < 0.5 * before,
        "{before} {after}"
    );
}
