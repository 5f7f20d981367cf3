use std::time::{Duration, Instant};

use gmpcr_cliques::PoseEstimate;
use gmpcr_correspondence::{Keypoints, Scan};
use gmpcr_posegraph::{Connectivity, PairConfidences, PoseEdge, PoseGraph, ScoredPair};
use gmpcr_sync::{Synchronization, synchronize};
use rayon::prelude::*;

use crate::pair::{PairRegistration, raw_confidence, register_keypoints};
use crate::registration::{EdgeEvidence, Registration, StageTimes, UnresolvedPair};
use crate::{Error, Observer, Params, Stage};

/// Registers scans: one pose per scan, consistent over all of them, with the evidence.
///
/// The pipeline of the paper, stage by stage; each stage is a crate of its own. `O(N²)` pairs are
/// scored, at most `N K` of them get a pose. Memory holds the keypoints, one confidence per pair
/// and one motion per edge.
///
/// Scans that share no reliable pair stay in components of their own; a single scan, and a scan
/// without points, are such components. A scan with fewer points than `N_s` uses all of them, and
/// `K` at or above the number of scans selects every pair of positive confidence.
///
/// # Errors
/// [`Error`] if there is no scan, a parameter is out of range, or the descriptors differ in
/// dimension (a scan without points has none).
pub fn register(scans: &[Scan], params: &Params) -> Result<Registration, Error> {
    register_observed(scans, params, &())
}

/// As [`register`], with an observer that is told of the progress and may end the work.
///
/// # Errors
/// Those of [`register`], and [`Error::Cancelled`] if the observer says so.
pub fn register_observed(
    scans: &[Scan],
    params: &Params,
    observer: &dyn Observer,
) -> Result<Registration, Error> {
    params.validate()?;
    check_dimensions(scans)?;
    let mut times = StageTimes::default();

    let keypoints = timed(&mut times.sampling, || sample_all(scans, params, observer))?;
    let confidences = timed(&mut times.scoring, || {
        score_all_pairs(&keypoints, params, observer)
    })?;
    let selected = timed(&mut times.selection, || {
        Items::of(Stage::Selection, 1, observer)
            .one(|| Ok(confidences.top_k_union(params.posegraph.neighbors)))
    })?;
    let pairs = timed(&mut times.pose_estimation, || {
        register_selected(&keypoints, &confidences, &selected, params, observer)
    })?;
    let (graph, evidence, unresolved) = build_graph(&confidences, &selected, pairs);
    let synchronization = timed(&mut times.synchronization, || {
        Items::of(Stage::Synchronization, 1, observer).one(|| Ok(synchronize(&graph, &params.sync)))
    })?;

    Ok(assemble(
        graph,
        evidence,
        unresolved,
        confidences,
        synchronization,
        times,
    ))
}

fn timed<T>(time: &mut Duration, stage: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = stage();
    *time = start.elapsed();
    result
}

fn check_dimensions(scans: &[Scan]) -> Result<(), Error> {
    if scans.is_empty() {
        return Err(Error::NoScans);
    }
    let described = scans
        .iter()
        .enumerate()
        .filter(|(_, scan)| !scan.is_empty());
    let mut dimensions = described.map(|(k, scan)| (k, scan.descriptors().dimension()));
    let Some((first, expected)) = dimensions.next() else {
        return Ok(());
    };
    match dimensions.find(|&(_, dimension)| dimension != expected) {
        Some((scan, dimension)) => Err(Error::DimensionsDiffer {
            first,
            expected,
            scan,
            dimension,
        }),
        None => Ok(()),
    }
}

/// The observed items of a stage.
struct Items<'a> {
    stage: Stage,
    observer: &'a dyn Observer,
}

impl<'a> Items<'a> {
    fn of(stage: Stage, num_items: usize, observer: &'a dyn Observer) -> Self {
        observer.begin(stage, num_items);
        Self { stage, observer }
    }

    /// Does one item, unless the observer has had enough.
    fn one<T>(&self, work: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
        if self.observer.is_cancelled() {
            return Err(Error::Cancelled { stage: self.stage });
        }
        let result = work();
        self.observer.item_done();
        result
    }
}

fn sample_all(
    scans: &[Scan],
    params: &Params,
    observer: &dyn Observer,
) -> Result<Vec<Keypoints>, Error> {
    let num_samples = params.correspondence.num_samples;
    let items = Items::of(Stage::Sampling, scans.len(), observer);
    let sample = |scan| items.one(|| Ok(Keypoints::sample(scan, num_samples)));
    scans.par_iter().map(sample).collect()
}

fn score_all_pairs(
    keypoints: &[Keypoints],
    params: &Params,
    observer: &dyn Observer,
) -> Result<PairConfidences, Error> {
    let num_scans = keypoints.len();
    let pairs = (0..num_scans).flat_map(|i| (i + 1..num_scans).map(move |j| (i, j)));
    let score = |(i, j): (usize, usize)| {
        let raw_confidence = raw_confidence(&keypoints[i], &keypoints[j], params)
            .map_err(|differ| Error::of_pair(i, j, differ))?;
        Ok(ScoredPair {
            i,
            j,
            raw_confidence,
        })
    };
    let pairs: Vec<_> = pairs.collect();
    let items = Items::of(Stage::Scoring, pairs.len(), observer);
    let scored = pairs.into_par_iter().map(|pair| items.one(|| score(pair)));
    let scored: Result<_, Error> = scored.collect();
    Ok(PairConfidences::new(num_scans, scored?).expect("all pairs, in order, are scored"))
}

/// Matches and filters the selected pairs again, which costs a share `K / N` of the scoring and
/// saves the memory of keeping all pairs, and estimates their motions.
fn register_selected(
    keypoints: &[Keypoints],
    confidences: &PairConfidences,
    selected: &[usize],
    params: &Params,
    observer: &dyn Observer,
) -> Result<Vec<PairRegistration>, Error> {
    let items = Items::of(Stage::PoseEstimation, selected.len(), observer);
    let estimate = |&position: &usize| {
        let ScoredPair { i, j, .. } = confidences.pairs()[position];
        register_keypoints(&keypoints[i], &keypoints[j], params)
            .map_err(|differ| Error::of_pair(i, j, differ))
    };
    let selected = selected.par_iter();
    selected.map(|pair| items.one(|| estimate(pair))).collect()
}

/// The pose graph of the pairs that have a motion, with initial weights `w⁰ = s_ij · IR`.
fn build_graph(
    confidences: &PairConfidences,
    selected: &[usize],
    pairs: Vec<PairRegistration>,
) -> (PoseGraph, Vec<EdgeEvidence>, Vec<UnresolvedPair>) {
    let (mut edges, mut evidence, mut unresolved) = (Vec::new(), Vec::new(), Vec::new());
    for (&position, pair) in selected.iter().zip(pairs) {
        let ScoredPair { i, j, .. } = confidences.pairs()[position];
        let confidence = confidences.normalized()[position];
        let PoseEstimate {
            pose,
            cliques_seen,
            budget_exhausted,
        } = pair.estimate;
        let Some(pose) = pose.filter(|pose| pose.inlier_ratio > 0.0) else {
            unresolved.push(UnresolvedPair {
                i,
                j,
                confidence,
                cliques_seen,
                budget_exhausted,
            });
            continue;
        };
        let initial_weight = confidence * pose.inlier_ratio;
        edges.push(PoseEdge {
            i,
            j,
            i_from_j: pose.target_from_source,
            weight: initial_weight,
        });
        evidence.push(EdgeEvidence {
            i,
            j,
            num_correspondences: pair.correspondences.len(),
            confidence,
            inlier_ratio: pose.inlier_ratio,
            clique_size: pose.clique.nodes.len(),
            mean_affinity: pose.clique.mean_affinity,
            cliques_seen,
            budget_exhausted,
            initial_weight,
            final_weight: 0.0,
            rotation_residual: None,
            translation_residual: None,
        });
    }
    let graph = PoseGraph::new(confidences.num_scans(), edges)
        .expect("motions of usable points are finite, and confidences at most one");
    (graph, evidence, unresolved)
}

fn assemble(
    graph: PoseGraph,
    mut evidence: Vec<EdgeEvidence>,
    unresolved: Vec<UnresolvedPair>,
    confidences: PairConfidences,
    synchronization: Synchronization,
    times: StageTimes,
) -> Registration {
    for (edge, report) in evidence.iter_mut().zip(&synchronization.edges) {
        edge.final_weight = report.final_weight;
        edge.rotation_residual = report.rotation_residual;
        edge.translation_residual = report.translation_residual;
    }
    let ends: Vec<_> = graph.edges().iter().map(|edge| (edge.i, edge.j)).collect();
    Registration {
        connectivity: Connectivity::new(graph.num_scans(), &ends, 0),
        world_from_scan: synchronization.world_from_scan,
        components: synchronization.components,
        synchronization: synchronization.reports,
        graph,
        evidence,
        unresolved,
        confidences,
        times,
    }
}
