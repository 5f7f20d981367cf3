//! Laws that hold within and between the protocols, tried on random poses, overlaps and scores.

#![allow(clippy::unwrap_used)]

mod common;

use approx::{assert_relative_eq, relative_eq};
use gmpcr_eval::{
    ConnectivitySummary, Gauge, GroundTruthPair, PairErrors, Protocol, Recall, Spread, WorldPoses,
    absolute_errors, auc, mean_recall, mean_retrieval, overlap_deciles, pairwise_recall,
    pooled_recall, pose_error, registration_error, registration_recall, retrieval,
};
use gmpcr_posegraph::Connectivity;
use nalgebra::{Isometry3, Matrix6, Point3, UnitQuaternion, Vector3};
use proptest::prelude::*;

use common::information_matrix;

const BOTH: [Protocol; 2] = [Protocol::ThreeDMatch, Protocol::ThreeDLoMatch];

fn vector() -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-2.0..2.0_f64).prop_map(Vector3::from)
}

fn transformation() -> impl Strategy<Value = Isometry3<f64>> {
    (vector(), vector()).prop_map(|(translation, rotation)| Isometry3::new(translation, rotation))
}

/// Poses of the ground truth, and estimates that are off by a few centimeters and degrees: some pairs pass each
/// threshold, some do not.
fn ground_truth_and_estimate() -> impl Strategy<Value = (Vec<Isometry3<f64>>, Vec<Isometry3<f64>>)>
{
    let off = |pose: Isometry3<f64>, nudge| pose * Isometry3::identity().lerp_slerp(&nudge, 0.1);
    prop::collection::vec((transformation(), transformation()), 3..7).prop_map(move |scans| {
        let estimate = scans.iter().map(|&(pose, nudge)| off(pose, nudge));
        let estimate = estimate.collect();
        (scans.into_iter().map(|scan| scan.0).collect(), estimate)
    })
}

fn information() -> Matrix6<f64> {
    let points = [(0.3, 0.2, 2.0), (-0.4, 0.1, 2.5), (0.0, -0.5, 1.8)];
    information_matrix(&points.map(|(x, y, z)| Point3::new(x, y, z)))
}

/// All pairs i < j of `size` scans.
fn pairs_of(size: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..size).flat_map(move |i| (i + 1..size).map(move |j| (i, j)))
}

fn all_pairs(world_from_scan: &[Isometry3<f64>]) -> Vec<GroundTruthPair> {
    let pair = |(i, j): (usize, usize)| GroundTruthPair {
        i,
        j,
        i_from_j: world_from_scan[i].inv_mul(&world_from_scan[j]),
        information: information(),
    };
    pairs_of(world_from_scan.len()).map(pair).collect()
}

fn recall_of(pairs: &[GroundTruthPair], estimate: &[Isometry3<f64>], protocol: Protocol) -> Recall {
    let poses = WorldPoses::of_one_frame(estimate);
    registration_recall(pairs, &poses, protocol).unwrap()
}

fn errors_of(pairs: &[GroundTruthPair], estimate: &[Isometry3<f64>]) -> PairErrors {
    PairErrors::of_pairs(pairs, &WorldPoses::of_one_frame(estimate)).unwrap()
}

proptest! {
    #[test]
    fn a_perfect_solution_is_perfect_in_every_protocol(
        (ground_truth, _) in ground_truth_and_estimate(), gauge in transformation(),
    ) {
        let solution: Vec<_> = ground_truth.iter().map(|pose| gauge * pose).collect();
        let (pairs, poses) = (all_pairs(&ground_truth), WorldPoses::of_one_frame(&solution));
        for protocol in BOTH {
            let recall = registration_recall(&pairs, &poses, protocol).unwrap();
            prop_assert_eq!(recall.ratio(), Some(1.0));
        }
        let errors = errors_of(&pairs, &solution);
        prop_assert_eq!((errors.recall(), errors.num_missing()), (Some(1.0), 0));
        let ratios = errors.scannet_ratios().unwrap();
        prop_assert_eq!((ratios.rotation, ratios.translation), ([1.0; 5], [1.0; 5]));
        for error in absolute_errors(&solution, &ground_truth, Gauge::LeastSquares).unwrap() {
            prop_assert!(error.rotation < 1e-6 && error.translation < 1e-9);
        }
    }

    #[test]
    fn a_common_transformation_of_all_estimates_changes_no_error_of_a_pair(
        (ground_truth, estimate) in ground_truth_and_estimate(), gauge in transformation(),
    ) {
        let moved: Vec<_> = estimate.iter().map(|pose| gauge * pose).collect();
        let [plain, gauged] = [&estimate, &moved]
            .map(|poses| PairErrors::of_all(&ground_truth, &WorldPoses::of_one_frame(poses)).unwrap());
        for (a, b) in plain.pairs.iter().zip(&gauged.pairs) {
            let (a, b) = (a.error.unwrap(), b.error.unwrap());
            prop_assert!(relative_eq!(a.rotation, b.rotation, epsilon = 1e-6));
            prop_assert!(relative_eq!(a.translation, b.translation, epsilon = 1e-9));
        }
    }

    #[test]
    fn another_ground_truth_of_one_pair_changes_exactly_that_pair(
        (ground_truth, estimate) in ground_truth_and_estimate(), chosen in any::<prop::sample::Index>(),
    ) {
        let pairs = all_pairs(&ground_truth);
        let chosen = chosen.index(pairs.len());
        let mut disturbed = pairs.clone();
        disturbed[chosen].i_from_j *= Isometry3::new(Vector3::x() * 9.0, Vector3::y() * 0.5);
        let recalls = [&pairs, &disturbed].map(|pairs| recall_of(pairs, &estimate, Protocol::ThreeDLoMatch));
        let errors = [&pairs, &disturbed].map(|pairs| errors_of(pairs, &estimate));
        for place in 0..pairs.len() {
            prop_assert_eq!(recalls[0].pairs[place] != recalls[1].pairs[place], place == chosen);
            prop_assert_eq!(errors[0].pairs[place] != errors[1].pairs[place], place == chosen);
        }
    }

    #[test]
    fn exchanging_the_estimates_of_two_scans_changes_exactly_their_pairs(
        (ground_truth, estimate) in ground_truth_and_estimate(), a in 0..3_usize, step in 1..3_usize,
    ) {
        let b = (a + step) % 3;
        let mut exchanged = estimate.clone();
        exchanged.swap(a, b);
        let pairs = all_pairs(&ground_truth);
        let recalls = [&estimate, &exchanged].map(|poses| recall_of(&pairs, poses, Protocol::ThreeDLoMatch));
        let errors = [&estimate, &exchanged].map(|poses| errors_of(&pairs, poses));
        for (place, pair) in pairs.iter().enumerate() {
            let touched = [pair.i, pair.j].iter().any(|scan| [a, b].contains(scan));
            prop_assert_eq!(recalls[0].pairs[place] != recalls[1].pairs[place], touched);
            prop_assert_eq!(errors[0].pairs[place] != errors[1].pairs[place], touched);
        }
    }

    #[test]
    fn exactly_the_counted_pairs_without_information_are_unjudgeable(
        (ground_truth, _) in ground_truth_and_estimate(), is_empty in prop::collection::vec(any::<bool>(), 21),
    ) {
        let mut pairs = all_pairs(&ground_truth);
        for (pair, _) in pairs.iter_mut().zip(&is_empty).filter(|(_, is_empty)| **is_empty) {
            pair.information = Matrix6::zeros();
        }
        for protocol in BOTH {
            let recall = recall_of(&pairs, &ground_truth, protocol);
            let counted = pairs.iter().filter(|pair| protocol.counts(pair.i, pair.j));
            let empty = counted.filter(|pair| pair.information.m11 == 0.0).map(|pair| (pair.i, pair.j));
            prop_assert_eq!(&recall.unjudgeable, &empty.collect::<Vec<_>>());
            prop_assert_eq!(recall.registered, recall.total - recall.unjudgeable.len());
        }
    }

    #[test]
    fn the_protocols_agree_where_they_judge_the_same((ground_truth, estimate) in ground_truth_and_estimate()) {
        let (pairs, poses) = (all_pairs(&ground_truth), WorldPoses::of_one_frame(&estimate));
        let listed = PairErrors::of_pairs(&pairs, &poses).unwrap();
        prop_assert_eq!(&listed, &PairErrors::of_all(&ground_truth, &poses).unwrap());
        prop_assert_eq!(listed.recall(), listed.recall_within(15_f64.to_radians(), 0.3));
        let ratios = listed.scannet_ratios().unwrap();
        prop_assert!(ratios.rotation.is_sorted() && ratios.translation.is_sorted());
        prop_assert!(ratios.rotation[3] >= listed.recall().unwrap());

        let threedmatch = recall_of(&pairs, &estimate, Protocol::ThreeDMatch);
        let distant: Vec<_> = pairs.iter().copied().filter(|pair| pair.j > pair.i + 1).collect();
        prop_assert_eq!(&threedmatch, &recall_of(&distant, &estimate, Protocol::ThreeDLoMatch));
        let estimate_of = |i: usize, j: usize| Some(estimate[i].inv_mul(&estimate[j]));
        let pairwise = pairwise_recall(
            &pairs, ground_truth.len(), Protocol::ThreeDMatch, estimate_of,
        );
        prop_assert_eq!(&threedmatch, &pairwise.unwrap());
        prop_assert_eq!(mean_recall(std::slice::from_ref(&threedmatch)), threedmatch.ratio());
        prop_assert_eq!(pooled_recall(std::slice::from_ref(&threedmatch)), threedmatch.ratio());
    }

    #[test]
    fn without_a_rotation_the_registration_error_is_the_squared_translation_error(
        ground_truth in transformation(), translation in vector(),
    ) {
        let estimate = ground_truth * Isometry3::from_parts(translation.into(), UnitQuaternion::identity());
        let distance = pose_error(&estimate, &ground_truth).translation;
        let error = registration_error(&estimate, &ground_truth, &information()).unwrap();
        prop_assert!(relative_eq!(error, distance.powi(2), epsilon = 1e-9));
    }
}

/// A value for each pair i < j of some scans.
#[derive(Debug, Clone)]
struct PairValues(Vec<f64>);

impl PairValues {
    fn get(&self, i: usize, j: usize) -> f64 {
        assert!(i < j, "asked for ({i}, {j})");
        self.0[j * (j - 1) / 2 + i]
    }

    /// The same values when scan `order[i]` is called i.
    fn renumbered(&self, order: &[usize]) -> Self {
        let value = |i: usize, j: usize| self.get(order[i].min(order[j]), order[i].max(order[j]));
        let pairs = (0..order.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
        Self(pairs.map(|(i, j)| value(i, j)).collect())
    }
}

/// Different values between 0 and 1, one per pair of `size` scans.
fn distinct(size: usize) -> impl Strategy<Value = PairValues> {
    let count = size * (size - 1) / 2;
    let ranks = Just((0..count).collect::<Vec<_>>()).prop_shuffle();
    ranks.prop_map(move |ranks| {
        PairValues(
            ranks
                .into_iter()
                .map(|rank| rank as f64 / count as f64)
                .collect(),
        )
    })
}

/// Confidences and overlaps without ties, and another numbering of the scans.
fn scene() -> impl Strategy<Value = (PairValues, PairValues, Vec<usize>)> {
    (2..8_usize).prop_flat_map(|size| {
        let order = Just((0..size).collect::<Vec<_>>()).prop_shuffle();
        (distinct(size), distinct(size), order)
    })
}

/// R@K and Regret.
type Figures = (f64, f64);

fn retrieve(confidence: &PairValues, overlap: &PairValues, size: usize, k: usize) -> Figures {
    let found = retrieval(
        size,
        k,
        |i, j| confidence.get(i, j),
        |i, j| overlap.get(i, j),
    );
    let found = found.unwrap();
    (found.recall, found.regret)
}

/// R@K and Regret by counting, for each scan, how many others are better.
fn slow_retrieval(confidence: &PairValues, overlap: &PairValues, size: usize, k: usize) -> Figures {
    let k = k.min(size - 1);
    let top = |values: &PairValues, scan: usize| -> Vec<usize> {
        let value = |other: usize| values.get(scan.min(other), scan.max(other));
        let others = || (0..size).filter(|&other| other != scan);
        let is_top = |&j: &usize| others().filter(|&l| value(l) > value(j)).count() < k;
        others().filter(is_top).collect()
    };
    let (mut hits, mut given_away) = (0, 0.0);
    for scan in 0..size {
        let (chosen, best) = (top(confidence, scan), top(overlap, scan));
        hits += chosen.iter().filter(|other| best.contains(other)).count();
        let sum = |scans: &[usize]| -> f64 {
            scans
                .iter()
                .map(|&other| overlap.get(scan.min(other), scan.max(other)))
                .sum()
        };
        given_away += sum(&best) - sum(&chosen);
    }
    let count = (size * k) as f64;
    (hits as f64 / count, given_away / count)
}

fn are_same(a: Figures, b: Figures) -> bool {
    relative_eq!(a.0, b.0, epsilon = 1e-12) && relative_eq!(a.1, b.1, epsilon = 1e-12)
}

proptest! {
    #[test]
    fn retrieval_equals_its_definition((confidence, overlap, order) in scene(), k in 1..9_usize) {
        let found = retrieve(&confidence, &overlap, order.len(), k);
        prop_assert!(are_same(found, slow_retrieval(&confidence, &overlap, order.len(), k)));
        prop_assert!((0.0..=1.0).contains(&found.0) && found.1 >= 0.0);
        // Without ties another choice is a worse one.
        prop_assert_eq!(found.0 == 1.0, found.1 == 0.0);
    }

    #[test]
    fn overlaps_as_confidences_retrieve_everything(
        values in prop::collection::vec(0..4_u8, 21), size in 2..8_usize, k in 1..9_usize,
    ) {
        let overlap = PairValues(values.into_iter().map(f64::from).collect());
        let found = retrieve(&overlap, &overlap, size, k);
        prop_assert_eq!(found, (1.0, 0.0));
    }

    #[test]
    fn renumbering_the_scans_changes_no_retrieval((confidence, overlap, order) in scene(), k in 1..9_usize) {
        let plain = retrieve(&confidence, &overlap, order.len(), k);
        let (confidence, overlap) = (confidence.renumbered(&order), overlap.renumbered(&order));
        prop_assert!(are_same(plain, retrieve(&confidence, &overlap, order.len(), k)));
    }

    #[test]
    fn only_the_order_of_the_confidences_counts((confidence, overlap, order) in scene(), k in 1..9_usize) {
        let increasing = PairValues(confidence.0.iter().map(|s| 7.0 * s.exp() - 9.0).collect());
        let plain = retrieve(&confidence, &overlap, order.len(), k);
        prop_assert_eq!(plain, retrieve(&increasing, &overlap, order.len(), k));
    }

    #[test]
    fn regret_grows_with_the_unit_of_the_overlaps((confidence, overlap, order) in scene(), k in 1..9_usize) {
        let percent = PairValues(overlap.0.iter().map(|overlap| 100.0 * overlap).collect());
        let plain = retrieve(&confidence, &overlap, order.len(), k);
        let scaled = retrieve(&confidence, &percent, order.len(), k);
        let expected = (plain.0, 100.0 * plain.1);
        prop_assert!(are_same(scaled, expected));
    }

    #[test]
    fn the_figures_of_a_connectivity_row_agree(
        graphs in prop::collection::vec((1..7_usize, prop::collection::vec((0..6_usize, 0..6_usize), 0..9)), 1..5),
    ) {
        let scenes: Vec<_> = graphs.iter().map(|(size, edges)| {
            let edges: Vec<_> = edges.iter().map(|(i, j)| (i % size, j % size)).collect();
            Connectivity::new(*size, &edges, 0)
        }).collect();
        let row = ConnectivitySummary::of(&scenes).unwrap();
        let all_connected = row.num_connected == row.num_scenes;
        prop_assert_eq!(all_connected, row.max_components == 1);
        prop_assert_eq!(all_connected, row.min_largest_component_ratio == 1.0);
        prop_assert_eq!(all_connected, row.min_reachability == 1.0);
        prop_assert!(row.min_reachability <= row.min_largest_component_ratio);
        let reversed: Vec<_> = scenes.iter().rev().copied().collect();
        prop_assert_eq!(Some(row), ConnectivitySummary::of(&reversed));
    }
}

/// Scores with many ties, and labels of both kinds.
fn labeled_scores() -> impl Strategy<Value = (Vec<f64>, Vec<bool>)> {
    prop::collection::vec((-4..5_i8, any::<bool>()), 0..24).prop_map(|mut samples| {
        samples.extend([(0, true), (1, false)]);
        samples
            .into_iter()
            .map(|(score, label)| (f64::from(score), label))
            .unzip()
    })
}

fn area(scores: &[f64], labels: &[bool]) -> f64 {
    auc(scores, labels).unwrap().unwrap()
}

/// The ratio of the comparisons that positives win, one by one.
fn slow_area(scores: &[f64], labels: &[bool]) -> f64 {
    let of_kind = |kind: bool| {
        scores
            .iter()
            .zip(labels)
            .filter(move |(_, label)| **label == kind)
    };
    let comparisons = of_kind(true).flat_map(|(p, _)| of_kind(false).map(move |(n, _)| (p, n)));
    let outcomes: Vec<f64> = comparisons
        .map(|(p, n)| {
            if p == n {
                0.5
            } else {
                f64::from(u8::from(p > n))
            }
        })
        .collect();
    outcomes.iter().sum::<f64>() / outcomes.len() as f64
}

proptest! {
    #[test]
    fn the_area_equals_its_definition((scores, labels) in labeled_scores()) {
        prop_assert_eq!(area(&scores, &labels), slow_area(&scores, &labels));
    }

    #[test]
    fn negated_scores_or_labels_give_the_complement((scores, labels) in labeled_scores()) {
        let complement = 1.0 - area(&scores, &labels);
        let negated: Vec<_> = scores.iter().map(|score| -score).collect();
        let opposite: Vec<_> = labels.iter().map(|label| !label).collect();
        prop_assert!(relative_eq!(area(&negated, &labels), complement, epsilon = 1e-12));
        prop_assert!(relative_eq!(area(&scores, &opposite), complement, epsilon = 1e-12));
    }

    #[test]
    fn only_the_order_of_the_scores_counts((scores, labels) in labeled_scores()) {
        let increasing: Vec<_> = scores.iter().map(|score| score.powi(3) + 2.0).collect();
        prop_assert_eq!(area(&scores, &labels), area(&increasing, &labels));
    }

    #[test]
    fn the_deciles_hold_every_pair_once(
        pairs in prop::collection::vec((-1.0..1.0_f64, 0.0..1.0_f64), 1..64),
    ) {
        let (confidence, overlap): (Vec<_>, Vec<_>) = pairs.iter().copied().unzip();
        let found = overlap_deciles(&confidence, &overlap).unwrap();
        let size = |group: usize| (group + 1) * pairs.len() / 10 - group * pairs.len() / 10;
        let sums = found.deciles.iter().enumerate().map(|(group, mean)| {
            assert_eq!(mean.is_some(), size(group) > 0);
            size(group) as f64 * mean.unwrap_or_default()
        });
        let all = found.all_pairs.unwrap() * pairs.len() as f64;
        prop_assert!(relative_eq!(sums.sum::<f64>(), all, epsilon = 1e-12, max_relative = 1e-12));
    }

    #[test]
    fn overlaps_as_confidences_give_ascending_deciles(
        overlap in prop::collection::vec(0.0..1.0_f64, 0..64),
    ) {
        let found = overlap_deciles(&overlap, &overlap).unwrap();
        let means: Vec<f64> = found.deciles.into_iter().flatten().collect();
        prop_assert!(means.windows(2).all(|pair| pair[0] <= pair[1] + 1e-12));
        let descending: Vec<_> = overlap.iter().map(|overlap| -overlap).collect();
        let found = overlap_deciles(&descending, &overlap).unwrap();
        let means: Vec<f64> = found.deciles.into_iter().flatten().collect();
        prop_assert!(means.windows(2).all(|pair| pair[0] + 1e-12 >= pair[1]));
    }

    #[test]
    fn neither_the_order_of_the_pairs_nor_the_scale_of_confidences_changes_a_decile(
        (confidence, overlap, _) in scene(),
    ) {
        let plain = overlap_deciles(&confidence.0, &overlap.0).unwrap();
        let scaled: Vec<_> = confidence.0.iter().rev().map(|s| s.exp()).collect();
        let reversed: Vec<_> = overlap.0.iter().rev().copied().collect();
        prop_assert_eq!(plain.deciles, overlap_deciles(&scaled, &reversed).unwrap().deciles);
    }

    #[test]
    fn a_spread_follows_offset_and_factor_of_its_values(
        values in prop::collection::vec(-5.0..5.0_f64, 1..20), factor in 0.1..9.0_f64, offset in -9.0..9.0_f64,
    ) {
        let plain = Spread::of(&values).unwrap();
        let mapped: Vec<_> = values.iter().map(|value| factor * value + offset).collect();
        let mapped = Spread::of(&mapped).unwrap();
        prop_assert!(relative_eq!(mapped.mean, factor * plain.mean + offset, epsilon = 1e-10));
        prop_assert!(relative_eq!(mapped.std_dev, factor * plain.std_dev, epsilon = 1e-10));
        prop_assert_eq!((mapped.min, mapped.max), (factor * plain.min + offset, factor * plain.max + offset));
        prop_assert!(plain.min <= plain.mean + 1e-12 && plain.mean <= plain.max + 1e-12);
        prop_assert!(plain.std_dev <= plain.max - plain.min);
    }
}

#[test]
fn each_scene_weighs_the_same_in_a_mean_retrieval() {
    // A scene of two scans, which is always perfect, and one of three where the choice is poor.
    let small = retrieval(2, 1, |_, _| 0.0, |_, _| 0.3).unwrap();
    let overlap = PairValues(vec![0.2, 0.4, 0.6]);
    let confidence = PairValues(vec![0.9, 0.5, 0.1]);
    let large = retrieval(3, 1, |i, j| confidence.get(i, j), |i, j| overlap.get(i, j)).unwrap();
    // Chosen 1, 0, 0; true 2, 2, 1.
    assert_eq!(large.recall, 0.0);
    assert_relative_eq!(large.regret, (0.2 + 0.4 + 0.2) / 3.0, epsilon = 1e-15);
    let mean = mean_retrieval(&[small, large]).unwrap();
    assert_eq!(mean.recall, 0.5);
    assert_relative_eq!(mean.regret, 0.4 / 3.0, epsilon = 1e-15);
}
