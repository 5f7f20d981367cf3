//! What holds for every set of scans: threads, order, frames, and input that is no good.

#![allow(clippy::unwrap_used)]

use gmpcr::nalgebra::{Isometry3, Point3, Vector3};
use std::sync::Mutex;
use std::time::Duration;

use gmpcr::correspondence::{Keypoints, correspondences};
use gmpcr::retrieval::RetrievalParams;
use gmpcr::{
    Descriptors, Error, IncrementalRegistration, Observer, Params, Registration, Scan, Stage,
    register, register_correspondences, register_matches, register_observed, register_pair,
};

/// A fixed number in (−1, 1) that looks random.
fn scattered(k: usize) -> f64 {
    let x = (k as f64 + 1.0) * 0.754_877_666_246_692_7;
    2.0 * (x * x * 91.7).fract() - 1.0
}

/// `num_scans` views of one cloud of `num_points`: each sees the points `[first, first + seen)` of a
/// cycle, off by up to `noise`, under a pose of its own.
struct Views {
    num_scans: usize,
    seen: usize,
    noise: f64,
}

const NUM_POINTS: usize = 400;
const DIMENSION: usize = 8;

impl Views {
    fn pose(&self, scan: usize) -> Isometry3<f64> {
        let vector =
            |salt: usize| Vector3::from_fn(|axis, _| scattered(scan * 31 + axis * 7 + salt));
        Isometry3::new(vector(1) * 4.0, vector(2) * 2.5)
    }

    fn scan(&self, scan: usize) -> Scan {
        let first = scan * NUM_POINTS / self.num_scans;
        let visible = (first..first + self.seen).map(|k| k % NUM_POINTS);
        let (mut points, mut rows) = (Vec::new(), Vec::new());
        for k in visible {
            let place = Point3::from(Vector3::from_fn(|axis, _| 2.0 * scattered(3 * k + axis)));
            let off = Vector3::from_fn(|axis, _| scattered(k * 5 + scan * 911 + axis));
            points.push(self.pose(scan).inverse_transform_point(&place) + off * self.noise);
            let entry = |d| {
                (scattered(k * DIMENSION + d + 77) + 0.01 * scattered(k + scan * 13 + d)) as f32
            };
            rows.extend((0..DIMENSION).map(entry));
        }
        Scan::new(points, Descriptors::new(rows, DIMENSION).unwrap()).unwrap()
    }

    fn scans(&self) -> Vec<Scan> {
        (0..self.num_scans).map(|scan| self.scan(scan)).collect()
    }
}

const VIEWS: Views = Views {
    num_scans: 9,
    seen: 160,
    noise: 0.01,
};

fn with_threads(threads: usize, scans: &[Scan], params: &Params) -> Registration {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap();
    pool.install(|| register(scans, params)).unwrap()
}

fn difference(a: &Isometry3<f64>, b: &Isometry3<f64>) -> f64 {
    (a.to_matrix() - b.to_matrix()).norm()
}

/// Rotations do not depend on where a scan's frame has its origin or which way an edge points.
/// Translations do, by the noise: their residuals `R_i t̂_ij + t_i − t_j` are taken at the origin.
fn assert_same_up_to_origin(a: &Isometry3<f64>, b: &Isometry3<f64>) {
    assert!(a.rotation.angle_to(&b.rotation) < 1e-6, "{a} and {b}");
    assert!(
        (a.translation.vector - b.translation.vector).norm() < 0.01,
        "{a} and {b}"
    );
}

#[test]
fn views_of_one_cloud_are_registered() {
    let registration = register(&VIEWS.scans(), &Params::default()).unwrap();
    assert!(registration.connectivity.is_connected);
    for scan in 0..VIEWS.num_scans {
        let ground_truth = VIEWS.pose(0).inv_mul(&VIEWS.pose(scan));
        let error = registration
            .i_from_j(0, scan)
            .unwrap()
            .inv_mul(&ground_truth);
        assert!(
            error.translation.vector.norm() < 0.03,
            "scan {scan}: {error}"
        );
        assert!(error.rotation.angle() < 0.02, "scan {scan}: {error}");
        assert!(registration.is_registered(scan));
    }
}

#[test]
fn exact_views_give_exact_poses() {
    let views = Views {
        noise: 0.0,
        ..VIEWS
    };
    let registration = register(&views.scans(), &Params::default()).unwrap();
    for scan in 0..views.num_scans {
        let ground_truth = views.pose(0).inv_mul(&views.pose(scan));
        assert!(difference(&registration.world_from_scan[scan], &ground_truth) < 1e-9);
    }
}

#[test]
fn one_thread_and_many_give_the_same_bits() {
    let scans = VIEWS.scans();
    for params in [Params::threedmatch(), Params::threedlomatch()] {
        let one = with_threads(1, &scans, &params);
        for threads in [2, 3, 8] {
            let many = with_threads(threads, &scans, &params);
            assert_eq!(one.world_from_scan, many.world_from_scan);
            assert_eq!(one.confidences, many.confidences);
            assert_eq!(one.edges, many.edges);
            assert_eq!(one.synchronization, many.synchronization);
        }
    }
}

#[test]
fn permuting_the_scans_permutes_the_poses() {
    let scans = VIEWS.scans();
    let order = [4, 0, 7, 2, 8, 1, 6, 3, 5];
    let permuted: Vec<Scan> = order.iter().map(|&k| scans[k].clone()).collect();
    let a = register(&scans, &Params::default()).unwrap();
    let b = register(&permuted, &Params::default()).unwrap();
    for (new, &old) in order.iter().enumerate() {
        let [a, b] = [a.i_from_j(order[0], old), b.i_from_j(0, new)].map(Option::unwrap);
        assert_same_up_to_origin(&a, &b);
    }
}

#[test]
fn moving_a_scan_moves_its_pose_and_keeps_the_support() {
    let scans = VIEWS.scans();
    let transformation = Isometry3::new(Vector3::new(3.0, -1.0, 2.0), Vector3::new(0.5, 1.5, -1.0));
    let mut moved = scans.clone();
    let points = scans[3]
        .points()
        .iter()
        .map(|p| transformation * p)
        .collect();
    moved[3] = Scan::new(points, scans[3].descriptors().clone()).unwrap();
    let [a, b] = [scans, moved].map(|scans| register(&scans, &Params::default()).unwrap());
    for scan in 0..VIEWS.num_scans {
        let expected = if scan == 3 {
            a.world_from_scan[3] * transformation.inverse()
        } else {
            a.world_from_scan[scan]
        };
        assert_same_up_to_origin(&b.world_from_scan[scan], &expected);
    }
    for (a, b) in a.edges.iter().zip(&b.edges) {
        assert!((a.confidence - b.confidence).abs() < 1e-9);
        assert_eq!((a.i, a.j, a.inlier_ratio), (b.i, b.j, b.inlier_ratio));
    }
}

#[test]
fn a_pair_is_the_inverse_of_the_swapped_pair() {
    let [a, b] = [VIEWS.scan(0), VIEWS.scan(1)];
    let forward = register_pair(&a, &b, &Params::default()).unwrap();
    let backward = register_pair(&b, &a, &Params::default()).unwrap();
    assert!((forward.raw_confidence / backward.raw_confidence - 1.0).abs() < 1e-9);
    let [forward, backward] = [forward, backward].map(|pair| pair.estimate.pose.unwrap());
    let product = forward.target_from_source * backward.target_from_source;
    assert!(difference(&product, &Isometry3::identity()) < 1e-9);
    let ground_truth = VIEWS.pose(0).inv_mul(&VIEWS.pose(1));
    assert!(difference(&forward.target_from_source, &ground_truth) < 0.05);
}

#[test]
fn the_pair_and_the_whole_agree() {
    let [a, b] = [VIEWS.scan(0), VIEWS.scan(1)];
    let pair = register_pair(&a, &b, &Params::default()).unwrap();
    let whole = register(&[a, b], &Params::default()).unwrap();
    let pose = pair.estimate.pose.unwrap();
    assert_eq!(whole.edges[0].i_from_j, pose.target_from_source);
    assert_eq!(
        whole.confidences.pairs()[0].raw_confidence,
        pair.raw_confidence
    );
    assert_eq!(whole.edges[0].confidence, 1.0);
    assert!(difference(&whole.world_from_scan[1], &pose.target_from_source) < 1e-9);
}

#[test]
fn scans_of_two_places_stay_apart() {
    // Far from each other in descriptor space as in space: nothing is compatible.
    let mut scans = VIEWS.scans();
    let elsewhere = |scan: &Scan| {
        let far = |(k, _): (usize, &Point3<f64>)| {
            Point3::from(Vector3::from_fn(|axis, _| 1e3 * scattered(k * 11 + axis)))
        };
        let points = scan.points().iter().enumerate().map(far).collect();
        Scan::new(points, scan.descriptors().clone()).unwrap()
    };
    scans.push(elsewhere(&scans[0]));
    let registration = register(&scans, &Params::default()).unwrap();
    assert_eq!(
        registration.components.members(),
        [(0..9).collect(), vec![9]]
    );
    assert_eq!(registration.i_from_j(0, 9), None);
    assert!(!registration.is_registered(9));
    assert_eq!(registration.world_from_scan[9], Isometry3::identity());
    assert_eq!(registration.connectivity.num_components, 2);
}

#[test]
fn no_scans_are_an_error_and_one_scan_is_its_own_frame() {
    assert!(matches!(
        register(&[], &Params::default()),
        Err(Error::NoScans)
    ));
    let registration = register(&[VIEWS.scan(0)], &Params::default()).unwrap();
    assert_eq!(registration.world_from_scan, [Isometry3::identity()]);
    assert!(registration.edges.is_empty() && !registration.is_registered(0));
}

#[test]
fn scans_without_points_or_with_very_few_stay_alone() {
    let empty =
        |dimension| Scan::new(vec![], Descriptors::new(vec![], dimension).unwrap()).unwrap();
    let tiny = |len: usize| {
        let points = VIEWS.scan(0).points()[..len].to_vec();
        let rows = VIEWS.scan(0).descriptors().values()[..len * DIMENSION].to_vec();
        Scan::new(points, Descriptors::new(rows, DIMENSION).unwrap()).unwrap()
    };
    let mut scans = VIEWS.scans();
    scans.extend([empty(DIMENSION), tiny(1), tiny(2), empty(1)]);
    let registration = register(&scans, &Params::default()).unwrap();
    for scan in 0..VIEWS.num_scans {
        assert!(registration.is_registered(scan));
    }
    for scan in VIEWS.num_scans..scans.len() {
        assert!(!registration.is_registered(scan), "scan {scan}");
    }
    let all_empty = register(&[empty(3), empty(3)], &Params::default()).unwrap();
    assert_eq!(all_empty.components.members().len(), 2);
}

#[test]
fn fewer_points_than_samples_are_all_used() {
    let views = Views {
        num_scans: 3,
        seen: 150,
        noise: 0.0,
    };
    let mut params = Params::default();
    params.correspondence.num_samples = 10_000;
    let registration = register(&views.scans(), &params).unwrap();
    assert!((0..3).all(|scan| registration.is_registered(scan)));
}

#[test]
fn more_neighbors_than_scans_select_every_pair_of_positive_confidence() {
    let mut params = Params::default();
    params.posegraph.neighbors = 1000;
    let registration = register(&VIEWS.scans(), &params).unwrap();
    let positive = registration
        .confidences
        .pairs()
        .iter()
        .filter(|pair| pair.raw_confidence > 0.0);
    assert_eq!(
        registration.edges.len() + registration.unresolved.len(),
        positive.count()
    );
}

#[test]
fn equal_points_are_reported_as_unresolved() {
    let rows: Vec<f32> = (0..100 * DIMENSION).map(|k| scattered(k) as f32).collect();
    let scan = Scan::new(
        vec![Point3::new(1.0, 2.0, 3.0); 100],
        Descriptors::new(rows, DIMENSION).unwrap(),
    );
    let scan = scan.unwrap();
    let registration = register(&[scan.clone(), scan], &Params::default()).unwrap();
    assert!(registration.edges.is_empty());
    assert_eq!(registration.unresolved.len(), 1);
    assert_eq!(registration.unresolved[0].cliques_seen, 1);
    assert_eq!(registration.components.members().len(), 2);
}

#[test]
fn equal_descriptors_match_too_little_for_an_edge() {
    let mut scans = VIEWS.scans();
    for scan in &mut scans {
        let rows = Descriptors::new(vec![0.5; scan.len() * DIMENSION], DIMENSION).unwrap();
        *scan = Scan::new(scan.points().to_vec(), rows).unwrap();
    }
    let registration = register(&scans, &Params::default()).unwrap();
    assert!(registration.edges.is_empty() && registration.unresolved.is_empty());
    assert_eq!(registration.components.members().len(), scans.len());
}

#[test]
fn descriptors_of_different_dimension_are_an_error_that_names_the_scan() {
    let mut scans = VIEWS.scans();
    let rows = vec![0.0; scans[4].len() * 33];
    scans[4] = Scan::new(
        scans[4].points().to_vec(),
        Descriptors::new(rows, 33).unwrap(),
    )
    .unwrap();
    let message = register(&scans, &Params::default())
        .unwrap_err()
        .to_string();
    assert_eq!(
        message,
        "scan 4 has descriptors of dimension 33, but scan 0 of dimension 8"
    );
    let message = register_pair(&scans[3], &scans[4], &Params::default())
        .unwrap_err()
        .to_string();
    assert_eq!(
        message,
        "scan 1 has descriptors of dimension 33, but scan 0 of dimension 8"
    );
}

#[test]
fn parameters_out_of_range_are_an_error() {
    let mut params = Params::default();
    params.compatibility.tolerance = -0.1;
    let message = register(&VIEWS.scans(), &params).unwrap_err().to_string();
    assert_eq!(
        message,
        "parameter compatibility.tolerance is -0.1: it must be finite and positive"
    );
    assert!(register_pair(&VIEWS.scan(0), &VIEWS.scan(1), &params).is_err());
}

#[test]
fn the_unit_of_the_points_does_not_matter() {
    let plain = register(&VIEWS.scans(), &Params::default()).unwrap();
    for scale in [1e-90, 1e-9, 1e9, 1e90] {
        let mut scans = VIEWS.scans();
        for scan in &mut scans {
            let points = scan.points().iter().map(|p| p * scale).collect();
            *scan = Scan::new(points, scan.descriptors().clone()).unwrap();
        }
        let params = Params::default().scaled(scale);
        let scaled = register(&scans, &params).unwrap();
        for (a, b) in plain.world_from_scan.iter().zip(&scaled.world_from_scan) {
            assert!(a.rotation.angle_to(&b.rotation) < 1e-6, "scale {scale}");
            let offset = a.translation.vector - b.translation.vector / scale;
            assert!(offset.norm() < 1e-6, "scale {scale}: {offset}");
        }
        // With a tolerance that does not fit there is less to find, but nothing fails.
        let unfit = register(&scans, &Params::default()).unwrap();
        assert_eq!(unfit.world_from_scan.len(), scans.len());
    }
}

#[test]
fn huge_coordinates_of_opposite_sign_give_finite_poses() {
    let side = |x: f64| {
        let place = |k: usize| Point3::new(x, scattered(k), scattered(k + 99));
        let rows = (0..16 * 4).map(|k| scattered(k + 7) as f32).collect();
        let rows = Descriptors::new(rows, 4).unwrap();
        Scan::new((0..16).map(place).collect(), rows).unwrap()
    };
    let registration = register(&[side(1e100), side(-1e100)], &Params::default()).unwrap();
    let is_finite = |pose: &Isometry3<f64>| pose.to_matrix().iter().all(|x| x.is_finite());
    assert!(registration.world_from_scan.iter().all(is_finite));
}

#[test]
fn relative_poses_without_support_are_unresolved_and_connect_nothing() {
    let mut params = Params::default();
    params.cliques.inlier_threshold = 1e-12;
    let registration = register(&VIEWS.scans()[..3], &params).unwrap();
    assert!(registration.edges.is_empty() && !registration.unresolved.is_empty());
    assert!(!registration.connectivity.is_connected);
    assert_eq!(registration.components.members().len(), 3);
}

#[test]
fn the_frame_can_be_that_of_any_scan() {
    let registration = register(&VIEWS.scans(), &Params::default()).unwrap();
    let expected = registration.i_from_j(4, 7).unwrap();
    let moved = registration.in_frame_of(4);
    assert_eq!(moved.world_from_scan[4], Isometry3::identity());
    assert!(difference(&moved.world_from_scan[7], &expected) < 1e-12);
}

/// Writes down the stages with their announced and finished items, and gives up after a number of
/// items.
#[derive(Default)]
struct Witness {
    stages: Mutex<Vec<(Stage, usize, usize)>>,
    patience: Option<usize>,
}

impl Observer for Witness {
    fn begin(&self, stage: Stage, num_items: usize) {
        self.stages.lock().unwrap().push((stage, num_items, 0));
    }

    fn item_done(&self) {
        self.stages.lock().unwrap().last_mut().unwrap().2 += 1;
    }

    fn is_cancelled(&self) -> bool {
        let done: usize = self
            .stages
            .lock()
            .unwrap()
            .iter()
            .map(|stage| stage.2)
            .sum();
        self.patience.is_some_and(|patience| done >= patience)
    }
}

#[test]
fn an_observer_sees_every_item_and_changes_nothing() {
    let (scans, params) = (VIEWS.scans(), Params::default());
    let witness = Witness::default();
    let observed = register_observed(&scans, &params, &witness).unwrap();
    let unseen = register(&scans, &params).unwrap();
    assert_eq!(observed.world_from_scan, unseen.world_from_scan);

    let stages = witness.stages.into_inner().unwrap();
    let num_selected = unseen.edges.len() + unseen.unresolved.len();
    let items = [9, 36, 1, num_selected, 1];
    let expected = Stage::ALL[2..]
        .iter()
        .zip(items)
        .map(|(&stage, n)| (stage, n, n));
    assert_eq!(stages, expected.collect::<Vec<_>>());
}

#[test]
fn a_cancelled_registration_names_the_stage() {
    let scans = VIEWS.scans();
    for (patience, expected) in [
        (0, Stage::Sampling),
        (9, Stage::Scoring),
        (45, Stage::Selection),
    ] {
        let witness = Witness {
            patience: Some(patience),
            ..Witness::default()
        };
        let outcome = register_observed(&scans, &Params::default(), &witness);
        match outcome {
            Err(Error::Cancelled { stage }) => assert_eq!(stage, expected),
            other => panic!("{other:?}"),
        }
    }
}

/// Bit for bit, but for the times.
fn assert_same(a: &Registration, b: &Registration) {
    assert_eq!(a.world_from_scan, b.world_from_scan);
    assert_eq!(a.components, b.components);
    assert_eq!(a.edges, b.edges);
    assert_eq!(a.unresolved, b.unresolved);
    assert_eq!(a.confidences, b.confidences);
    assert_eq!(a.synchronization, b.synchronization);
}

#[test]
fn scans_that_come_and_go_are_registered_as_if_they_had_come_at_once() {
    come_and_go(Params::default());
}

#[test]
fn scans_that_come_and_go_have_the_pairs_retrieved_that_they_would_have_had_at_once() {
    come_and_go(Params {
        retrieval: RetrievalParams {
            min_scans: 5,
            candidates_per_scan: 2,
            expansions: 2,
            candidates_per_expansion: 1,
        },
        ..Params::default()
    });
}

fn come_and_go(params: Params) {
    let all = VIEWS.scans();
    let mut incremental = IncrementalRegistration::new(params.clone()).unwrap();
    let mut scans = Vec::new();
    for added in [&all[..4], &all[4..5], &[], &all[5..]] {
        incremental.add(added, &()).unwrap();
        scans.extend_from_slice(added);
        let (grown, batch) = (
            incremental.register(&()).unwrap(),
            register(&scans, &params).unwrap(),
        );
        assert_same(&grown, &batch);
    }
    for removed in [8, 0, 3] {
        let id = incremental.ids()[removed];
        assert!(incremental.remove(id) && !incremental.remove(id));
        scans.remove(removed);
        let (shrunk, batch) = (
            incremental.register(&()).unwrap(),
            register(&scans, &params).unwrap(),
        );
        assert_same(&shrunk, &batch);
    }
    incremental.add(&all[..1], &()).unwrap();
    scans.push(all[0].clone());
    assert_same(
        &incremental.register(&()).unwrap(),
        &register(&scans, &params).unwrap(),
    );
    assert_eq!(incremental.ids().len(), 7);
}

#[test]
fn a_scan_more_has_its_own_pairs_scored_only() {
    let scans = VIEWS.scans();
    let mut incremental = IncrementalRegistration::new(Params::default()).unwrap();
    incremental.add(&scans[..8], &()).unwrap();
    incremental.register(&()).unwrap();
    let witness = Witness::default();
    incremental.add(&scans[8..], &witness).unwrap();
    incremental.register(&witness).unwrap();
    let stages = witness.stages.into_inner().unwrap();
    assert_eq!(
        stages[..2],
        [(Stage::Sampling, 1, 1), (Stage::Scoring, 8, 8)]
    );
}

#[test]
fn retrieved_pairs_are_scored_round_by_round_and_others_never() {
    let mut params = Params::default();
    params.posegraph.neighbors = 2;
    params.retrieval = RetrievalParams {
        min_scans: 0,
        candidates_per_scan: 2,
        expansions: 1,
        candidates_per_expansion: 1,
    };
    let scans = VIEWS.scans();
    let witness = Witness::default();
    let registration = register_observed(&scans, &params, &witness).unwrap();
    let num_scored = registration.confidences.pairs().len();
    assert!(num_scored < 36, "{num_scored}");
    let stages = witness.stages.into_inner().unwrap();
    let rounds = stages.iter().filter(|(stage, ..)| *stage == Stage::Scoring);
    assert_eq!(rounds.map(|(_, begun, _)| begun).sum::<usize>(), num_scored);
    assert!(registration.connectivity.is_connected);
    for (scan, pose) in registration.world_from_scan.iter().enumerate() {
        let ground_truth = VIEWS.pose(0).inverse() * VIEWS.pose(scan);
        assert!(
            difference(pose, &ground_truth) < 0.05,
            "scan {scan}: {pose}"
        );
    }
}

#[test]
fn what_cannot_be_added_changes_nothing() {
    let scans = VIEWS.scans();
    let mut incremental = IncrementalRegistration::new(Params::default()).unwrap();
    assert!(matches!(incremental.register(&()), Err(Error::NoScans)));
    incremental.add(&scans[..3], &()).unwrap();
    let before = incremental.register(&()).unwrap();

    let other = Scan::new(
        vec![Point3::origin()],
        Descriptors::new(vec![0.0; 3], 3).unwrap(),
    )
    .unwrap();
    let outcome = incremental.add(&[other], &());
    assert!(matches!(
        outcome,
        Err(Error::DimensionsDiffer {
            first: 0,
            scan: 3,
            dimension: 3,
            ..
        })
    ));
    let impatient = |patience| Witness {
        patience: Some(patience),
        ..Witness::default()
    };
    let outcome = incremental.add(&scans[3..6], &impatient(0));
    assert!(matches!(outcome, Err(Error::Cancelled { .. })));
    assert_eq!(incremental.ids().len(), 3);
    assert_same(&incremental.register(&()).unwrap(), &before);

    incremental.add(&scans[3..6], &()).unwrap();
    for patience in [0, 12, 0] {
        let outcome = incremental.register(&impatient(patience));
        assert!(matches!(outcome, Err(Error::Cancelled { .. })));
    }
    let registration = incremental.register(&()).unwrap();
    // The scores were kept, and so was the time that they took.
    assert!(registration.times.of(Stage::Scoring) > Duration::ZERO);
    assert_same(
        &registration,
        &register(&scans[..6], &Params::default()).unwrap(),
    );
}

#[test]
fn ids_survive_the_removal_of_other_scans() {
    let scans = VIEWS.scans();
    let mut incremental = IncrementalRegistration::new(Params::default()).unwrap();
    let ids = incremental.add(&scans, &()).unwrap();
    let before = incremental.register(&()).unwrap();
    assert_eq!(before.ids, ids);
    incremental.remove(ids[0]);
    let after = incremental.register(&()).unwrap();
    assert_eq!(after.ids, ids[1..]);
    // The frame is that of the first scan that is left; fewer edges change poses by the noise.
    let expected = before.i_from_j(1, 5).unwrap();
    assert!(difference(after.pose_of(ids[5]).unwrap(), &expected) < 0.05);
    assert_eq!(after.pose_of(ids[0]), None);
    // A new scan never gets the id of a removed one.
    incremental.remove(ids[8]);
    let new = incremental.add(&scans[..1], &()).unwrap();
    assert!(!ids.contains(&new[0]));
    assert!(matches!(
        incremental.pair(ids[0], ids[1]),
        Err(Error::UnknownScan { scan }) if scan == ids[0]
    ));
    let pair = incremental.pair(ids[1], ids[2]).unwrap();
    assert_eq!(
        pair,
        register_pair(&scans[1], &scans[2], &Params::default()).unwrap()
    );
}

#[test]
fn given_correspondences_are_registered_like_those_of_descriptors() {
    let (scans, params) = (VIEWS.scans(), Params::default());
    let sample = |scan| Keypoints::sample(scan, &params.correspondence).unwrap();
    let keypoints: Vec<_> = scans.iter().map(sample).collect();
    let matches = (0..scans.len()).flat_map(|i| (i + 1..VIEWS.num_scans).map(move |j| (i, j)));
    let matches = matches.map(|(i, j)| {
        let pairs = correspondences(&keypoints[i], &keypoints[j], &params.correspondence);
        ((i, j), pairs.unwrap())
    });
    let matches = matches.collect();
    let given = register_matches(scans.len(), &matches, &params, &()).unwrap();
    assert_same(&given, &register(&scans, &params).unwrap());

    let pair = register_correspondences(&matches[&(0, 1)], &params).unwrap();
    assert_eq!(pair, register_pair(&scans[0], &scans[1], &params).unwrap());
}

#[test]
fn correspondences_that_cannot_be_are_an_error() {
    let points = vec![Point3::origin(); gmpcr::MAX_CORRESPONDENCES + 1];
    let many = gmpcr::geometry::PointPairs::new(points.clone(), points).unwrap();
    let params = Params::default();
    let message = register_correspondences(&many, &params)
        .unwrap_err()
        .to_string();
    assert!(
        message.starts_with("5001 correspondences of a pair: at most 5000"),
        "{message}"
    );
    let outcome = |i, j| {
        let matches = [((i, j), Default::default())].into();
        register_matches(3, &matches, &params, &())
            .unwrap_err()
            .to_string()
    };
    let reason = "a pair must have i < j < 3";
    for (i, j) in [(1, 1), (2, 1), (0, 3)] {
        assert_eq!(
            outcome(i, j),
            format!("correspondences of scans ({i}, {j}): {reason}")
        );
    }
    assert!(matches!(
        register_matches(0, &Default::default(), &params, &()),
        Err(Error::NoScans)
    ));
    let nothing = register_matches(2, &Default::default(), &params, &()).unwrap();
    assert_eq!(nothing.components.members().len(), 2);
}

#[test]
fn other_coordinates_of_the_scans_change_the_poses_alike() {
    let registration = register(&VIEWS.scans(), &Params::default()).unwrap();
    let frame =
        |scan: usize| Isometry3::new(Vector3::new(5e5, 1.0, scan as f64), Vector3::z() * 0.1);
    let new_from_old: Vec<_> = (0..VIEWS.num_scans).map(frame).collect();
    let moved = registration.clone().with_scan_frames(&new_from_old);
    let same = registration
        .clone()
        .with_scan_frames(&vec![Isometry3::identity(); VIEWS.num_scans]);
    assert_same(&same, &registration);
    assert!(difference(&moved.world_from_scan[0], &Isometry3::identity()) < 1e-9);
    for (edge, before) in moved.edges.iter().zip(&registration.edges) {
        let (i, j) = (edge.i, edge.j);
        let residual = moved.i_from_j(i, j).unwrap() * edge.i_from_j.inverse();
        let expected = registration.i_from_j(i, j).unwrap() * before.i_from_j.inverse();
        let expected = new_from_old[i] * expected * new_from_old[i].inverse();
        assert!(residual.rotation.angle_to(&expected.rotation) < 1e-9);
    }
    let point = VIEWS.scan(4).points()[0];
    let world = |registration: &Registration, point| registration.world_from_scan[4] * point;
    let old = new_from_old[0] * world(&registration, point);
    assert!((world(&moved, new_from_old[4] * point) - old).norm() < 1e-6);
}

#[test]
fn results_and_parameters_travel_between_threads() {
    fn travels<T: Send + Sync + std::fmt::Debug>() {}
    travels::<Registration>();
    travels::<IncrementalRegistration>();
    travels::<gmpcr::PairRegistration>();
    travels::<gmpcr::Warning>();
    travels::<Scan>();
    travels::<Params>();
    travels::<Error>();
}

#[cfg(feature = "serde")]
#[test]
fn results_and_parameters_come_back_from_files() {
    let registration = register(&VIEWS.scans(), &Params::default()).unwrap();
    let text = serde_json::to_string(&registration).unwrap();
    let read: Registration = serde_json::from_str(&text).unwrap();
    assert_eq!(read.ids, registration.ids);
    assert_eq!(read.components, registration.components);
    for (a, b) in read
        .world_from_scan
        .iter()
        .zip(&registration.world_from_scan)
    {
        assert!(difference(a, b) < 1e-14);
    }
    for (a, b) in read.edges.iter().zip(&registration.edges) {
        assert_eq!(a.synchronization, b.synchronization);
    }
    let params = Params::threedlomatch();
    let text = serde_json::to_string(&params).unwrap();
    assert_eq!(serde_json::from_str::<Params>(&text).unwrap(), params);
    let partial: Params = serde_json::from_str(r#"{ "posegraph": { "neighbors": 9 } }"#).unwrap();
    assert_eq!(partial.posegraph.neighbors, 9);
    assert!(serde_json::from_str::<Params>(r#"{ "posegraf": {} }"#).is_err());
}
