//! Laws of the candidates, whatever the descriptors.

#![allow(clippy::unwrap_used, reason = "a test may fail")]

use std::collections::BTreeSet;

use gmpcr_correspondence::{Descriptors, DimensionsDiffer};
use gmpcr_posegraph::{PairConfidences, ScoredPair};
use gmpcr_retrieval::{Index, RetrievalError, RetrievalParams, candidate_pairs};
use proptest::prelude::*;

type Pair = (usize, usize);

fn further_pairs(scored: &PairConfidences, params: &RetrievalParams) -> Vec<Pair> {
    gmpcr_retrieval::further_pairs(scored, params).unwrap()
}

/// A fixed number in (−1, 1) that looks random.
fn scattered(k: usize) -> f32 {
    let x = (k as f64 + 1.0) * 0.754_877_666_246_692_7;
    (2.0 * (x * x * 91.7).fract() - 1.0) as f32
}

fn scan(num_rows: usize, dimension: usize, salt: usize) -> Descriptors {
    let values = (0..num_rows * dimension).map(|k| scattered(k + salt * 7_919));
    Descriptors::new(values.collect(), dimension).unwrap()
}

/// Scans of which each has half of its descriptors in common with the next.
fn chain(num_scans: usize, num_rows: usize) -> Vec<Descriptors> {
    let dimension = 8;
    let world = scan((num_scans + 1) * num_rows / 2, dimension, 0);
    let rows_of = |k: usize| (k * num_rows / 2..k * num_rows / 2 + num_rows).collect::<Vec<_>>();
    (0..num_scans).map(|k| world.select(&rows_of(k))).collect()
}

fn references(scans: &[Descriptors]) -> Vec<&Descriptors> {
    scans.iter().collect()
}

/// Retrieval of however few scans.
fn always() -> RetrievalParams {
    RetrievalParams {
        min_scans: 0,
        ..RetrievalParams::default()
    }
}

fn per_scan(candidates_per_scan: usize) -> RetrievalParams {
    RetrievalParams {
        candidates_per_scan,
        ..always()
    }
}

fn ordered(a: usize, b: usize) -> Pair {
    (a.min(b), a.max(b))
}

fn all_pairs(num_scans: usize) -> Vec<Pair> {
    (0..num_scans)
        .flat_map(|i| (i + 1..num_scans).map(move |j| (i, j)))
        .collect()
}

fn scored(num_scans: usize, pairs: &[Pair], confidence: impl Fn(Pair) -> f64) -> PairConfidences {
    let pairs = pairs.iter().map(|&(i, j)| ScoredPair {
        i,
        j,
        raw_confidence: confidence((i, j)),
    });
    PairConfidences::new(num_scans, pairs.collect()).unwrap()
}

#[test]
fn scans_with_common_descriptors_propose_each_other() {
    let scans = chain(60, 40);
    let pairs = candidate_pairs(&references(&scans), &per_scan(2)).unwrap();
    let expected: Vec<_> = (0..59).map(|k| (k, k + 1)).collect();
    assert!(expected.iter().all(|pair| pairs.contains(pair)));
}

#[test]
fn another_order_of_the_scans_gives_the_same_candidates() {
    let scans = chain(50, 60);
    let order: Vec<usize> = (0..50).map(|k| (k * 17 + 5) % 50).collect();
    let reordered: Vec<_> = order.iter().map(|&k| &scans[k]).collect();
    let (index, other) = (
        Index::new(&references(&scans)).unwrap(),
        Index::new(&reordered).unwrap(),
    );
    for (place, &scan) in order.iter().enumerate() {
        // The two scans that have descriptors in common with it; behind them come equal numbers of votes.
        let num_partners = if scan == 0 || scan == 49 { 1 } else { 2 };
        let partners = |index: &Index, scan, name: &dyn Fn(usize) -> usize| -> BTreeSet<usize> {
            index
                .candidates_of(scan, num_partners)
                .into_iter()
                .map(name)
                .collect()
        };
        let expected = partners(&index, scan, &|k| k);
        assert_eq!(partners(&other, place, &|k| order[k]), expected);
    }
}

#[test]
fn a_copy_of_a_scan_is_its_best_candidate() {
    let mut scans: Vec<_> = (0..30).map(|k| scan(50, 16, k)).collect();
    scans.extend(scans.clone());
    let index = Index::new(&references(&scans)).unwrap();
    for k in 0..60 {
        assert_eq!(index.candidates_of(k, 1), [(k + 30) % 60]);
    }
}

#[test]
fn a_copied_descriptor_has_one_vote() {
    // Scan 1 repeats one descriptor of scan 0, scan 2 has two of them once.
    let [a, b, c] = [vec![0.0, 9.0, 20.0], vec![20.0; 30], vec![0.1, 9.1, 300.0]]
        .map(|values| Descriptors::new(values, 1).unwrap());
    let index = Index::new(&[&a, &b, &c]).unwrap();
    assert_eq!(index.candidates_of(0, 2), [2, 1]);
}

#[test]
fn scans_of_other_clusters_come_last() {
    let far = |k: usize| 100.0 * (k % 3) as f32;
    let scans: Vec<_> = (0..30)
        .map(|k| {
            let values = scan(40, 8, k).values().iter().map(|v| v + far(k)).collect();
            Descriptors::new(values, 8).unwrap()
        })
        .collect();
    let index = Index::new(&references(&scans)).unwrap();
    for k in 0..30 {
        let candidates = index.candidates_of(k, 9);
        assert!(
            candidates.iter().all(|candidate| candidate % 3 == k % 3),
            "{k}: {candidates:?}"
        );
    }
}

#[test]
fn few_scans_are_compared_exhaustively() {
    for num_scans in 0..=6 {
        let scans: Vec<_> = (0..num_scans).map(|k| scan(30, 4, k)).collect();
        let pairs = candidate_pairs(&references(&scans), &per_scan(5)).unwrap();
        assert_eq!(pairs, all_pairs(num_scans));
    }
}

#[test]
fn the_work_grows_with_the_number_of_scans_and_not_with_its_square() {
    let num_distances = |num_scans: usize| {
        let scans: Vec<_> = (0..num_scans).map(|k| scan(20, 4, k)).collect();
        Index::new(&references(&scans)).unwrap().num_distances()
    };
    let per_row = |num_scans: usize| num_distances(num_scans) as f64 / (20 * num_scans) as f64;
    for num_scans in [50, 100, 200, 400, 800] {
        assert!(per_row(num_scans) <= 8.0 * 63.0 / 2.0);
    }
    // All pairs of 800 scans: 20 · 20 · 800 · 799 / 2.
    assert!(num_distances(800) * 30 < 20 * 20 * 800 * 799 / 2);
}

#[test]
fn scans_without_descriptors_are_left_out() {
    let empty = Descriptors::new(vec![], 5).unwrap(); // an empty scan has no dimension
    let [a, b] = [1, 2].map(|salt| scan(10, 3, salt));
    let scans = [&empty, &a, &empty, &b];
    assert_eq!(candidate_pairs(&scans, &per_scan(9)).unwrap(), [(1, 3)]);
    assert_eq!(Index::new(&scans).unwrap().candidates_of(0, 9), []);
    assert_eq!(
        candidate_pairs(&[&empty, &empty], &per_scan(9)).unwrap(),
        []
    );
}

#[test]
fn identical_descriptors_have_candidates_too() {
    let same = Descriptors::new(vec![0.5; 40 * 4], 4).unwrap();
    let pairs = candidate_pairs(&[&same; 25], &per_scan(3)).unwrap();
    assert!(pairs.len() <= 75);
    assert!((0..25).all(|scan| pairs.iter().any(|&(i, j)| i == scan || j == scan)));
}

#[test]
fn scans_of_one_descriptor_find_their_neighbors_within_the_leaves() {
    // On a line all trees cut at the same places.
    let scans = (0..256).map(|k| Descriptors::new(vec![k as f32], 1).unwrap());
    let scans: Vec<_> = scans.collect();
    let pairs = candidate_pairs(&references(&scans), &per_scan(2)).unwrap();
    let missing = (0..255).filter(|&k| !pairs.contains(&(k, k + 1)));
    assert_eq!(missing.collect::<Vec<_>>(), [63, 127, 191]);
}

#[test]
fn descriptors_that_overflow_are_compared_too() {
    let scans: Vec<_> = (0..40)
        .map(|k| scan(20, 8, k).values().iter().map(|v| v * 3e38).collect())
        .map(|values| Descriptors::new(values, 8).unwrap())
        .collect();
    let pairs = candidate_pairs(&references(&scans), &per_scan(3)).unwrap();
    assert!(!pairs.is_empty());
}

#[test]
fn different_dimensions_do_not_compare() {
    let (a, b) = (scan(3, 33, 0), scan(3, 32, 1));
    let differ = RetrievalError::DimensionsDiffer(DimensionsDiffer { i: 33, j: 32 });
    assert_eq!(candidate_pairs(&[&a, &b], &per_scan(3)), Err(differ));
}

/// Scans in a row, of which those at most `reach` apart overlap.
fn row_confidence(reach: usize) -> impl Fn(Pair) -> f64 {
    move |(i, j)| (reach + 1).saturating_sub(j - i) as f64
}

#[test]
fn rounds_of_neighbors_find_all_overlaps_of_a_row_of_scans() {
    let (num_scans, confidence) = (100, row_confidence(4));
    let mut pairs: Vec<_> = (0..num_scans - 1).map(|k| (k, k + 1)).collect();
    for _ in 0..4 {
        let known = scored(num_scans, &pairs, &confidence);
        pairs.extend(further_pairs(&known, &always()));
        pairs.sort_unstable();
    }
    let overlapping = all_pairs(num_scans)
        .into_iter()
        .filter(|&pair| confidence(pair) > 0.0);
    assert!(
        overlapping
            .clone()
            .all(|pair| pairs.binary_search(&pair).is_ok())
    );
    assert!(pairs.len() < 3 * overlapping.count());
}

#[test]
fn each_scan_proposes_the_one_it_is_tied_to_most() {
    let pairs = [(0, 1), (0, 2), (1, 3), (2, 4)];
    let known = scored(5, &pairs, |(i, j)| 10.0 - (i + j) as f64);
    let params = RetrievalParams {
        candidates_per_expansion: 1,
        ..always()
    };
    // 0 is the best of 1 and 2, and 1 its own: by 1 it finds 3, which beats 4 found by 2.
    // 1 and 2 find each other by 0, 3 finds 0 by 1, and 4 finds 0 by 2.
    assert_eq!(further_pairs(&known, &params), [(0, 3), (0, 4), (1, 2)]);
}

#[test]
fn a_choice_of_either_makes_two_scans_neighbors() {
    // 3 has better neighbors than 0, but is the best of 0.
    let pairs = [(0, 3), (1, 3), (2, 3)];
    let known = scored(4, &pairs, |(i, _)| [1.0, 5.0, 9.0][i]);
    let params = RetrievalParams {
        candidates_per_expansion: 1,
        ..always()
    };
    assert_eq!(further_pairs(&known, &params), [(0, 2), (1, 2)]);
}

#[test]
fn there_is_nothing_to_add_to_all_pairs_or_to_none() {
    let params = always();
    assert_eq!(
        further_pairs(&scored(9, &all_pairs(9), |_| 1.0), &params),
        []
    );
    assert_eq!(
        further_pairs(&scored(9, &all_pairs(9)[..5], |_| 0.0), &params),
        []
    );
    assert_eq!(further_pairs(&scored(0, &[], |_| 1.0), &params), []);
}

fn scans() -> impl Strategy<Value = Vec<Descriptors>> {
    // Few values make equal descriptors and equal distances.
    let entry = prop_oneof![(0..3i32).prop_map(|k| k as f32), -1.0..1.0f32];
    (1..4usize).prop_flat_map(move |dimension| {
        let rows = prop::collection::vec(prop::collection::vec(entry.clone(), dimension), 0..30);
        let scan = rows.prop_map(move |rows| {
            Descriptors::new(rows.into_iter().flatten().collect(), dimension).unwrap()
        });
        prop::collection::vec(scan, 0..20)
    })
}

proptest! {
    #[test]
    fn candidates_are_other_scans_with_descriptors_and_pairs_their_union(
        scans in scans(),
        candidates_per_scan in 1..25usize,
    ) {
        let index = Index::new(&references(&scans)).unwrap();
        let mut union = BTreeSet::new();
        for scan in 0..scans.len() {
            let candidates = index.candidates_of(scan, candidates_per_scan);
            let distinct: BTreeSet<_> = candidates.iter().copied().collect();
            prop_assert_eq!(distinct.len(), candidates.len());
            prop_assert!(candidates.len() <= candidates_per_scan);
            prop_assert!(candidates.iter().all(|&other| other != scan && !scans[other].is_empty()));
            union.extend(candidates.iter().map(|&other| ordered(scan, other)));
        }
        let pairs = candidate_pairs(&references(&scans), &per_scan(candidates_per_scan)).unwrap();
        prop_assert_eq!(pairs, union.into_iter().collect::<Vec<_>>());
    }

    #[test]
    fn more_candidates_begin_with_the_fewer(scans in scans(), fewer in 1..10usize) {
        let index = Index::new(&references(&scans)).unwrap();
        for scan in 0..scans.len() {
            let more = index.candidates_of(scan, fewer + 1);
            let fewer = index.candidates_of(scan, fewer);
            prop_assert_eq!(&more[..fewer.len().min(more.len())], &fewer[..]);
        }
    }

    #[test]
    fn further_pairs_are_those_of_the_definition(
        confidences in prop::collection::vec(prop_oneof![Just(0.0), 0.1..9.0f64], 66),
        is_known in prop::collection::vec(any::<bool>(), 66),
        k in 1..12usize,
    ) {
        let all = all_pairs(12);
        let place = |pair: Pair| all.binary_search(&pair).unwrap();
        let pairs: Vec<_> = all.iter().copied().filter(|&pair| is_known[place(pair)]).collect();
        let known = scored(12, &pairs, |pair| confidences[place(pair)]);
        let params = RetrievalParams { candidates_per_expansion: k, ..always() };
        let further = further_pairs(&known, &params);
        prop_assert!(further.len() <= 12 * k);
        prop_assert_eq!(further, plain_further_pairs(&known, k));
    }
}

/// The definition of [`further_pairs`] in plain loops.
fn plain_further_pairs(known: &PairConfidences, k: usize) -> Vec<Pair> {
    let size = known.num_scans();
    let mut confidence = vec![vec![None; size]; size];
    for (pair, &value) in known.pairs().iter().zip(known.normalized()) {
        confidence[pair.i][pair.j] = Some(value);
        confidence[pair.j][pair.i] = Some(value);
    }
    let best = |mut ties: Vec<(usize, f64)>| -> Vec<usize> {
        ties.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        ties.into_iter().take(k).map(|(scan, _)| scan).collect()
    };
    let strength = |a: usize, b: usize| confidence[a][b].unwrap_or(0.0);
    let choice = |a: usize| {
        let ties = (0..size).map(|b| (b, strength(a, b)));
        best(ties.filter(|tie| tie.1 > 0.0).collect())
    };
    let chosen: Vec<Vec<usize>> = (0..size).map(choice).collect();
    let are_neighbors = |a: usize, b: usize| chosen[a].contains(&b) || chosen[b].contains(&a);
    let affinity = |a: usize, b: usize| -> f64 {
        let between = (0..size).filter(|&m| are_neighbors(a, m) && are_neighbors(m, b));
        between.map(|m| strength(a, m) * strength(m, b)).sum()
    };
    let mut pairs = BTreeSet::new();
    for (a, known_to_a) in confidence.iter().enumerate() {
        let others = (0..size).filter(|&b| b != a && known_to_a[b].is_none());
        let ties = others
            .map(|b| (b, affinity(a, b)))
            .filter(|tie| tie.1 > 0.0);
        pairs.extend(best(ties.collect()).into_iter().map(|b| ordered(a, b)));
    }
    pairs.into_iter().collect()
}

#[test]
fn fewer_scans_than_the_limit_have_all_their_pairs_proposed() {
    let scan = |value: f32| Descriptors::new(vec![value], 1).unwrap();
    let scans = [scan(0.0), Descriptors::new(vec![], 1).unwrap(), scan(5.0)];
    let pairs = |min_scans| {
        let params = RetrievalParams {
            min_scans,
            ..always()
        };
        candidate_pairs(&references(&scans), &params).unwrap()
    };
    assert_eq!(pairs(4), [(0, 1), (0, 2), (1, 2)]);
    let known = scored(3, &[(0, 1), (1, 2)], |_| 1.0);
    assert_eq!(further_pairs(&known, &always()), [(0, 2)]);
    assert_eq!(further_pairs(&known, &RetrievalParams::default()), []);
    assert_eq!(pairs(3), [(0, 2)]);
}
