//! Laws of rigid sets and of joint refinement.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may fail")]

mod common;

use common::{distance, nudge, room, scan};
use gmpcr_refine::{
    IcpParams, JointParams, JointRefinement, PairCounts, PairMap, PosedSurface, Sequential,
    SetIcpParams, Surface, VerifyParams, refine_jointly, refine_pair, refine_sets, verify_pair,
    verify_sets,
};
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;

/// Works on the last pair first.
struct Backwards;

impl PairMap for Backwards {
    fn map<T: Send>(&self, count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
        let mut results: Vec<T> = (0..count).rev().map(work).collect();
        results.reverse();
        results
    }
}

fn frames(count: usize) -> Vec<Isometry3<f64>> {
    let frame = |k: usize| {
        let k = k as f64;
        Isometry3::new(
            Vector3::new(k.sin(), k.cos(), 0.3 * k) * 9.0,
            Vector3::new(0.4 * k, -0.9, k.cos()),
        )
    };
    (0..count).map(frame).collect()
}

/// Scans of parts of the room, each in a frame of its own: all lack one of the planes.
fn scans(room_from_scan: &[Isometry3<f64>], noise: f64) -> Vec<Surface> {
    let part = |k: usize| {
        let mut part = room();
        part.remove(k % 3 + 1);
        part
    };
    let scan_of =
        |(k, pose): (usize, &Isometry3<f64>)| scan(&part(k), &pose.inverse(), noise, k as u64 + 1);
    room_from_scan.iter().enumerate().map(scan_of).collect()
}

fn posed<'a>(surfaces: &'a [Surface], poses: &[Isometry3<f64>]) -> Vec<PosedSurface<'a>> {
    let pairs = surfaces.iter().zip(poses);
    pairs
        .map(|(surface, pose)| PosedSurface::new(surface, *pose))
        .collect()
}

/// The pose in the room of scan `k`, displaced unless it is the first.
fn displaced(poses: &[Isometry3<f64>], size: f64) -> Vec<Isometry3<f64>> {
    let error = |k: f64| {
        nudge(
            [0.03 * k.sin() * size, 0.03 * k.cos() * size, -0.02 * size],
            [0.7 * k.cos() * size, -0.6 * size, 0.7 * k.sin() * size],
        )
    };
    let each = poses.iter().enumerate();
    each.map(|(k, pose)| {
        if k == 0 {
            *pose
        } else {
            error(k as f64) * pose
        }
    })
    .collect()
}

fn worst(found: &[Isometry3<f64>], expected: &[Isometry3<f64>]) -> f64 {
    // Compared in the room.
    let apart = |(a, b): (&Isometry3<f64>, &Isometry3<f64>)| {
        distance(&(a * b.inverse()), &Isometry3::identity())
    };
    found.iter().zip(expected).map(apart).fold(0.0, f64::max)
}

fn joint(scans: &[PosedSurface]) -> JointRefinement {
    refine_jointly(scans, &JointParams::precise(), &Sequential).unwrap()
}

#[test]
fn noise_free_planes_lead_to_the_exact_poses() {
    let poses = frames(6);
    let surfaces = scans(&poses, 0.0);
    let start = displaced(&poses, 1.0);
    let found = joint(&posed(&surfaces, &start));
    assert_eq!(found.frame_from_scan[0], poses[0]);
    assert!(worst(&found.frame_from_scan, &poses) < 1e-2 * worst(&start, &poses));
    assert!(worst(&found.frame_from_scan, &poses) < 5e-3);
    assert!(found.converged);
    assert_eq!(found.pairs.len(), 15);
    for pair in &found.pairs {
        assert!(pair.i < pair.j && pair.equations.rms < 1e-2 && pair.counts.overlap() > 300);
    }
}

#[test]
fn joint_refinement_is_better_than_the_worst_pair() {
    let poses = frames(6);
    let surfaces = scans(&poses, 0.1);
    let found = joint(&posed(&surfaces, &displaced(&poses, 1.0)));
    assert!(worst(&found.frame_from_scan, &poses) < 0.08);
}

#[test]
fn the_order_of_work_does_not_change_the_bits() {
    let poses = frames(5);
    let surfaces = scans(&poses, 0.05);
    let set = posed(&surfaces, &displaced(&poses, 1.0));
    let backwards = refine_jointly(&set, &JointParams::precise(), &Backwards).unwrap();
    assert_eq!(joint(&set), backwards);
    assert_eq!(joint(&set), joint(&set));

    let (a, b) = set.split_at(2);
    let (x, params) = (Isometry3::identity(), SetIcpParams::default());
    let forwards = refine_sets(a, b, &x, &params, &Sequential).unwrap();
    assert_eq!(
        forwards,
        refine_sets(a, b, &x, &params, &Backwards).unwrap()
    );
    let verify = VerifyParams::default();
    let forwards = verify_sets(a, b, &x, &verify, &Sequential).unwrap();
    assert_eq!(
        forwards,
        verify_sets(a, b, &x, &verify, &Backwards).unwrap()
    );
}

#[test]
fn the_order_of_the_scans_does_not_matter() {
    let poses = frames(5);
    let surfaces = scans(&poses, 0.05);
    let set = posed(&surfaces, &displaced(&poses, 1.0));
    let order = [0, 3, 1, 4, 2];
    let permuted = order.map(|k| set[k]);
    let (found, other) = (joint(&set), joint(&permuted));
    for (position, k) in order.into_iter().enumerate() {
        let apart = worst(
            &[other.frame_from_scan[position]],
            &[found.frame_from_scan[k]],
        );
        assert!(apart < 1e-4, "{apart}");
    }
}

#[test]
fn moving_the_shared_frame_moves_the_poses() {
    let poses = frames(4);
    let surfaces = scans(&poses, 0.05);
    let start = displaced(&poses, 1.0);
    let world_from_room =
        Isometry3::new(Vector3::new(5e3, -2e3, 1e3), Vector3::new(1.0, 0.5, -2.0));
    let moved: Vec<_> = start.iter().map(|pose| world_from_room * pose).collect();
    let here = joint(&posed(&surfaces, &start));
    let there = joint(&posed(&surfaces, &moved));
    let back: Vec<_> = there
        .frame_from_scan
        .iter()
        .map(|pose| world_from_room.inverse() * pose)
        .collect();
    assert!(worst(&back, &here.frame_from_scan) < 1e-6);
}

#[test]
fn a_group_that_meets_no_other_is_refined_where_it_is() {
    let poses = frames(4);
    let surfaces = scans(&poses, 0.0);
    // Scans 2 and 3 are in another place; one more overlaps with nothing.
    let elsewhere = Isometry3::translation(500.0, 0.0, 0.0);
    let mut start = displaced(&poses, 0.5);
    for pose in &mut start[2..] {
        *pose = elsewhere * *pose;
    }
    let mut set = posed(&surfaces, &start);
    let far = Isometry3::translation(0.0, 900.0, 0.0);
    set.push(PosedSurface::new(&surfaces[0], far));
    let found = joint(&set);
    assert_eq!(found.frame_from_scan[4], far);
    let pairs: Vec<_> = found.pairs.iter().map(|pair| (pair.i, pair.j)).collect();
    assert_eq!(pairs, [(0, 1), (2, 3)]);
    assert!(worst(&found.frame_from_scan[..2], &poses[..2]) < 5e-3);
    let relative = |poses: &[Isometry3<f64>]| poses[2].inverse() * poses[3];
    let in_room = poses[2] * relative(&found.frame_from_scan) * poses[3].inverse();
    assert!(distance(&in_room, &Isometry3::identity()) < 5e-3);
    let middle =
        |poses: &[Isometry3<f64>]| poses[2].translation.vector + poses[3].translation.vector;
    assert!((middle(&found.frame_from_scan) - middle(&start)).norm() < 2.0);
}

#[test]
fn sets_without_pairs_stay_as_they_are() {
    let poses = frames(1);
    let surfaces = scans(&poses, 0.0);
    let empty = Surface::new(&[], &[], &Default::default()).unwrap();
    for set in [
        vec![],
        posed(&surfaces, &poses),
        vec![PosedSurface::new(&empty, poses[0]); 3],
    ] {
        let found = joint(&set);
        assert!(found.pairs.is_empty() && found.converged && found.steps == 0);
        let unchanged = found.frame_from_scan.iter().zip(&set);
        assert!(
            unchanged
                .clone()
                .all(|(pose, scan)| *pose == scan.frame_from_scan)
        );
        let found = refine_sets(
            &set,
            &set[..0],
            &poses[0],
            &SetIcpParams::default(),
            &Sequential,
        );
        assert_eq!(found.unwrap().a_from_b, poses[0]);
    }
}

#[test]
fn one_sheet_of_many_scans_does_not_explode() {
    let sheet = [room()[0]];
    let surfaces: Vec<_> = (1..5)
        .map(|seed| scan(&sheet, &Isometry3::identity(), 0.02, seed))
        .collect();
    let start: Vec<_> = (0..4)
        .map(|k| nudge([0.0; 3], [0.3, 0.0, 0.2 * f64::from(k)]))
        .collect();
    let found = joint(&posed(&surfaces, &start));
    for (pose, before) in found.frame_from_scan.iter().zip(&start) {
        assert!(pose.translation.z.abs() < 0.02, "{pose}");
        assert!(
            (pose.translation.vector - before.translation.vector)
                .xy()
                .norm()
                < 0.1,
            "{pose}"
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    #[test]
    fn two_rigid_sets_are_joined_exactly(
        rotation in prop::array::uniform3(-0.02..0.02), translation in prop::array::uniform3(-0.8..0.8),
    ) {
        let poses = frames(5);
        let surfaces = scans(&poses, 0.0);
        let set = posed(&surfaces, &poses);
        let (a, b) = set.split_at(2);
        // Set B in a frame of its own.
        let a_from_b = frames(7)[6];
        let b: Vec<_> = b
            .iter()
            .map(|scan| PosedSurface::new(scan.surface, a_from_b.inverse() * scan.frame_from_scan))
            .collect();
        let start = nudge(rotation, translation) * a_from_b;
        let params = SetIcpParams { polish_steps: 12, ..SetIcpParams::default() };
        let found = refine_sets(a, &b, &start, &params, &Sequential).unwrap();
        let in_room = found.a_from_b * a_from_b.inverse();
        prop_assert!(distance(&in_room, &Isometry3::identity()) < 5e-3, "{in_room}");
        prop_assert!(found.undetermined.is_empty() && found.num_pairs == 6);

        let verify = VerifyParams::default();
        let support = verify_sets(a, &b, &found.a_from_b, &verify, &Sequential).unwrap();
        let sum: PairCounts = support.pairs.iter().map(|pair| pair.counts).sum();
        prop_assert_eq!(&support.total, &sum);
        prop_assert_eq!((support.num_overlapping(), support.num_contradicted()), (6, 0));
        let first = &support.pairs[0];
        let (i, j) = (&a[first.i], &b[first.j]);
        let i_from_j = i.frame_from_scan.inverse() * found.a_from_b * j.frame_from_scan;
        let counts = verify_pair(i.surface, j.surface, &i_from_j, &verify).unwrap();
        prop_assert_eq!(first.counts, counts);
    }

    #[test]
    fn sets_of_one_scan_are_a_pair(translation in prop::array::uniform3(-0.8..0.8)) {
        let poses = frames(2);
        let surfaces = scans(&poses, 0.05);
        let set = posed(&surfaces, &[Isometry3::identity(); 2]);
        let (a, b) = set.split_at(1);
        let start = poses[0].inverse() * nudge([0.01, 0.0, -0.01], translation) * poses[1];
        let icp = IcpParams { first_radius: 3.0, steps: 5, ..IcpParams::default() };
        let params = SetIcpParams::default();
        let of_sets = refine_sets(a, b, &start, &params, &Sequential).unwrap();
        let of_pair = refine_pair(&surfaces[0], &surfaces[1], &start, &icp).unwrap();
        prop_assert!((of_sets.a_from_b.to_matrix() - of_pair.i_from_j.to_matrix()).norm() < 1e-9);
        prop_assert_eq!(of_sets.steps, of_pair.steps);
    }
}
