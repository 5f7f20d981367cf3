//! Laws that recall and pair errors obey, tried on random poses.

mod common;

use gmpcr_eval::{
    Error, GroundTruthPair, Outcome, OverlapIndex, PairErrors, Protocol, Recall, WorldPoses,
    pairwise_recall, registration_recall,
};
use nalgebra::{Isometry3, Matrix6, Point3, Vector3};
use proptest::prelude::*;

use common::information_matrix;

const BOTH: [Protocol; 2] = [Protocol::ThreeDMatch, Protocol::ThreeDLoMatch];

fn transformation() -> impl Strategy<Value = Isometry3<f64>> {
    let vector = || prop::array::uniform3(-2.0..2.0_f64).prop_map(Vector3::from);
    (vector(), vector()).prop_map(|(translation, rotation)| Isometry3::new(translation, rotation))
}

fn poses() -> impl Strategy<Value = Vec<Isometry3<f64>>> {
    prop::collection::vec(transformation(), 3..7)
}

/// All pairs i < j of the poses, judged by three points two meters ahead.
fn all_pairs(world_from_scan: &[Isometry3<f64>]) -> Vec<GroundTruthPair> {
    let points = [(0.3, 0.2, 2.0), (-0.4, 0.1, 2.5), (0.0, -0.5, 1.8)];
    let information = information_matrix(&points.map(|(x, y, z)| Point3::new(x, y, z)));
    let size = world_from_scan.len();
    (0..size)
        .flat_map(|i| (i + 1..size).map(move |j| (i, j)))
        .map(|(i, j)| {
            let i_from_j = world_from_scan[i].inv_mul(&world_from_scan[j]);
            GroundTruthPair {
                i,
                j,
                i_from_j,
                information,
            }
        })
        .collect()
}

proptest! {
    #[test]
    fn the_ground_truth_registers_every_pair(ground_truth in poses()) {
        let estimate = WorldPoses::of_one_frame(&ground_truth);
        for protocol in BOTH {
            let recall = registration_recall(&all_pairs(&ground_truth), &estimate, protocol).unwrap();
            prop_assert_eq!(recall.ratio(), Some(1.0));
        }
        let errors = PairErrors::of_all(&ground_truth, &estimate).unwrap();
        prop_assert_eq!(errors.recall(), Some(1.0));
    }

    #[test]
    fn a_common_transformation_of_all_poses_changes_nothing(
        ground_truth in poses(), gauge in transformation(), nudge in transformation(),
    ) {
        let mut estimate = ground_truth.clone();
        estimate[1] *= Isometry3::identity().lerp_slerp(&nudge, 0.1);
        let moved: Vec<_> = estimate.iter().map(|pose| gauge * pose).collect();
        let [plain, gauged] = [estimate, moved].map(|poses| {
            let poses = WorldPoses::of_one_frame(&poses);
            registration_recall(&all_pairs(&ground_truth), &poses, Protocol::ThreeDLoMatch).unwrap()
        });
        for (a, b) in plain.pairs.iter().zip(&gauged.pairs) {
            prop_assert!((squared_error(a.outcome) - squared_error(b.outcome)).abs() < 1e-10);
        }
    }

    #[test]
    fn disturbing_one_scan_misses_exactly_its_pairs(ground_truth in poses(), scan in 0..3_usize) {
        let mut estimate = ground_truth.clone();
        estimate[scan].translation.x += 5.0;
        let poses = WorldPoses::of_one_frame(&estimate);
        let recall =
            registration_recall(&all_pairs(&ground_truth), &poses, Protocol::ThreeDLoMatch).unwrap();
        for pair in &recall.pairs {
            let touched = pair.i == scan || pair.j == scan;
            prop_assert_eq!(matches!(pair.outcome, Outcome::Missed { .. }), touched);
        }
        prop_assert_eq!(recall.total - recall.registered, ground_truth.len() - 1);
    }

    #[test]
    fn a_pair_listed_the_other_way_round_has_the_same_rotation_error(
        ground_truth in poses(), nudge in transformation(),
    ) {
        let mut estimate = ground_truth.clone();
        estimate[0] *= nudge;
        let poses = WorldPoses::of_one_frame(&estimate);
        let pairs = all_pairs(&ground_truth);
        let swapped: Vec<_> = pairs.iter().map(swap).collect();
        let forth = PairErrors::of_pairs(&pairs, &poses).unwrap();
        let back = PairErrors::of_pairs(&swapped, &poses).unwrap();
        for (a, b) in forth.pairs.iter().zip(&back.pairs) {
            let difference = a.error.unwrap().rotation - b.error.unwrap().rotation;
            prop_assert!(difference.abs() < 1e-9);
        }
    }

    #[test]
    fn the_protocols_agree_on_a_pair_and_its_swapped_copy(i in 0..9_usize, j in 0..9_usize) {
        for protocol in BOTH {
            prop_assert_eq!(protocol.counts(i, j), protocol.counts(j, i));
        }
    }
}

/// The squared error; not a number where there is none, which equals nothing.
fn squared_error(outcome: Outcome) -> f64 {
    match outcome {
        Outcome::Registered { error } | Outcome::Missed { error } => error,
        Outcome::NoEstimate | Outcome::Unjudgeable => f64::NAN,
    }
}

fn swap(pair: &GroundTruthPair) -> GroundTruthPair {
    GroundTruthPair {
        i: pair.j,
        j: pair.i,
        i_from_j: pair.i_from_j.inverse(),
        ..*pair
    }
}

/// Scans in a line, one meter apart; the last of four is `off` meters away from its place.
fn line(off: f64) -> (Vec<GroundTruthPair>, WorldPoses) {
    let at = |x: f64| Isometry3::translation(x, 0.0, 0.0);
    let ground_truth = [0.0, 1.0, 2.0, 3.0].map(at);
    (
        all_pairs(&ground_truth),
        WorldPoses::of_one_frame(&[0.0, 1.0, 2.0, 3.0 + off].map(at)),
    )
}

#[test]
fn a_line_of_scans_is_counted_as_by_hand() {
    let (pairs, poses) = line(0.5);
    let threedmatch = registration_recall(&pairs, &poses, Protocol::ThreeDMatch).unwrap();
    assert_eq!((threedmatch.registered, threedmatch.total), (1, 3));
    let lomatch = registration_recall(&pairs, &poses, Protocol::ThreeDLoMatch).unwrap();
    assert_eq!((lomatch.registered, lomatch.total), (3, 6));
}

#[test]
fn the_limit_is_twenty_centimeters_squared() {
    for (off, registered) in [(0.199, 6), (0.201, 3)] {
        let (pairs, poses) = line(off);
        let recall = registration_recall(&pairs, &poses, Protocol::ThreeDLoMatch).unwrap();
        assert_eq!(recall.registered, registered);
    }
}

#[test]
fn scans_of_different_components_or_without_a_pose_are_not_registered() {
    let (pairs, _) = line(0.0);
    let at = |x: f64| Some(Isometry3::translation(x, 0.0, 0.0));
    let split = WorldPoses::new(vec![at(0.0), at(1.0), at(2.0), at(3.0)], vec![0, 0, 1, 1]);
    let recall = registration_recall(&pairs, &split.unwrap(), Protocol::ThreeDLoMatch).unwrap();
    assert_eq!((recall.registered, recall.total), (2, 6));
    let lost = WorldPoses::new(vec![at(0.0), at(1.0), at(2.0), None], vec![0; 4]);
    let recall = registration_recall(&pairs, &lost.unwrap(), Protocol::ThreeDLoMatch).unwrap();
    assert_eq!((recall.registered, recall.total), (3, 6));
    assert!(recall.unjudgeable.is_empty());
}

#[test]
fn a_pair_without_information_is_named_and_counts_as_not_registered() {
    let (mut pairs, poses) = line(0.0);
    pairs[1].information = Matrix6::zeros();
    let recall = registration_recall(&pairs, &poses, Protocol::ThreeDLoMatch).unwrap();
    assert_eq!((recall.registered, recall.total), (5, 6));
    assert_eq!(recall.unjudgeable, [(0, 2)]);
    let nothing = pairwise_recall(&pairs, 4, Protocol::ThreeDLoMatch, |_, _| None).unwrap();
    assert_eq!(nothing.unjudgeable, [(0, 2)]);
}

#[test]
fn an_empty_list_has_no_recall() {
    let (pairs, poses) = line(0.0);
    let none = registration_recall(&[], &poses, Protocol::ThreeDLoMatch).unwrap();
    assert_eq!((none.ratio(), none.total), (None, 0));
    let consecutive = registration_recall(&pairs[..1], &poses, Protocol::ThreeDMatch).unwrap();
    assert_eq!(consecutive.ratio(), None);
}

#[test]
fn an_estimate_that_is_not_a_number_is_missed() {
    let (pairs, _) = line(0.0);
    let nowhere = Some(Isometry3::translation(f64::NAN, 0.0, 0.0));
    let recall = pairwise_recall(&pairs, 4, Protocol::ThreeDLoMatch, |_, _| nowhere).unwrap();
    assert_eq!((recall.registered, recall.total), (0, 6));
}

#[test]
fn a_pair_that_names_no_two_scans_is_refused_by_name() {
    let (mut pairs, poses) = line(0.0);
    pairs[2].j = 9;
    let error = registration_recall(&pairs, &poses, Protocol::ThreeDMatch).unwrap_err();
    assert_eq!(
        error,
        Error::NoSuchScan {
            i: 0,
            j: 9,
            num_scans: 4
        }
    );
    assert_eq!(error.to_string(), "pair (0, 9) names a scan outside 0..4");
    pairs[2].j = 0;
    let error = PairErrors::of_pairs(&pairs, &poses).unwrap_err();
    assert_eq!(error, Error::SamePair { scan: 0 });
}

#[test]
fn the_public_types_may_be_sent_and_shared_between_threads() {
    fn assert_send_and_sync<T: Send + Sync>() {}
    assert_send_and_sync::<Error>();
    assert_send_and_sync::<GroundTruthPair>();
    assert_send_and_sync::<OverlapIndex>();
    assert_send_and_sync::<PairErrors>();
    assert_send_and_sync::<Recall>();
    assert_send_and_sync::<WorldPoses>();
}
