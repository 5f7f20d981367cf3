use std::collections::BTreeMap;
use std::mem;
use std::time::{Duration, Instant};

use gmpcr_cliques::PoseEstimate;
use gmpcr_correspondence::{Keypoints, Scan};
use gmpcr_posegraph::{Connectivity, PairConfidences, PoseEdge, PoseGraph, ScoredPair};
use gmpcr_retrieval::{candidate_pairs, further_pairs};
use gmpcr_sync::{Synchronization, synchronize};
use rayon::prelude::*;

use crate::pair::{raw_confidence, register_keypoints};
use crate::registration::{EdgeEvidence, Registration, StageTimes, UnresolvedPair};
use crate::{Error, Observer, Params, Stage};

/// Scans that come and go: keeps what is known of each scan and each pair, so that a change costs only
/// what it changes.
///
/// Adding a scan samples it. [`registration`](Self::registration) then scores the pairs that were not
/// scored before (the `N − 1` of the N-th scan, or fewer where they are retrieved), chooses edges
/// among all scored pairs, estimates the motions of those that were not chosen before, and synchronises. The
/// result has the same bits as [`register`](crate::register) of the same scans in the same order. Memory
/// holds the keypoints, one confidence per scored pair and one motion per edge.
///
/// Pairs are retrieved where there are [`retrieval.min_scans`](gmpcr_retrieval::RetrievalParams::min_scans)
/// scans or more: each scan proposes others by its descriptors, and then neighbours of the neighbours
/// that it has by the confidences. The index of the descriptors is then made anew for each registration, on
/// one thread (0.4 s for 400 scans).
///
/// ```
/// use gmpcr::{Descriptors, Params, Registry, Scan, register};
///
/// let scan = |turn: f64| {
///     let points = (0..40).map(|k| f64::from(k)).map(|k| [(k + turn).sin(), (2.0 * k).cos(), 0.1 * k]);
///     let rows = Descriptors::new((0..40).map(|k| k as f32).collect(), 1)?;
///     Ok::<_, gmpcr::Error>(Scan::new(points.map(Into::into).collect(), rows)?)
/// };
/// let mut registry = Registry::new(Params::default())?;
/// registry.add(&[scan(0.0)?, scan(0.01)?], &())?;
/// registry.add(&[scan(0.02)?], &())?;
/// let three = registry.registration(&())?;
/// let batch = register(&[scan(0.0)?, scan(0.01)?, scan(0.02)?], &Params::default())?;
/// assert_eq!(three.world_from_scan, batch.world_from_scan);
///
/// registry.remove(1);
/// assert_eq!(registry.registration(&())?.world_from_scan.len(), 2);
/// # Ok::<(), gmpcr::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Registry {
    params: Params,
    keypoints: Vec<Keypoints>,
    /// Raw confidences of pairs `(i, j)`, `i < j`.
    scores: BTreeMap<Pair, f64>,
    /// What the pairs have to say that the last registration selected.
    selected: BTreeMap<Pair, SelectedPair>,
    /// What was spent since the last registration.
    times: StageTimes,
}

/// Two scans, the lower index first.
type Pair = (usize, usize);

#[derive(Clone, Debug)]
struct SelectedPair {
    num_correspondences: usize,
    estimate: PoseEstimate,
}

impl Registry {
    /// A registry without scans.
    ///
    /// # Errors
    /// [`Error::Parameter`] if one is out of range.
    pub fn new(params: Params) -> Result<Self, Error> {
        params.validate()?;
        Ok(Self {
            params,
            keypoints: Vec::new(),
            scores: BTreeMap::new(),
            selected: BTreeMap::new(),
            times: StageTimes::default(),
        })
    }

    /// Number of scans.
    pub fn len(&self) -> usize {
        self.keypoints.len()
    }

    /// Whether there are no scans.
    pub fn is_empty(&self) -> bool {
        self.keypoints.is_empty()
    }

    /// Adds scans behind the others and samples them.
    ///
    /// # Errors
    /// [`Error::DimensionsDiffer`] if descriptors differ in dimension, also from those of earlier scans,
    /// and [`Error::Cancelled`] if the observer says so. Then the registry is as it was.
    pub fn add(&mut self, scans: &[Scan], observer: &dyn Observer) -> Result<(), Error> {
        self.check_dimensions(scans)?;
        let (sampled, time) = timed(|| self.sample(scans, observer))?;
        self.keypoints.extend(sampled);
        self.times.sampling += time;
        Ok(())
    }

    /// Removes a scan; those behind it move up by one.
    ///
    /// # Panics
    /// If the scan does not exist.
    pub fn remove(&mut self, scan: usize) {
        self.keypoints.remove(scan);
        without(scan, &mut self.scores);
        without(scan, &mut self.selected);
    }

    /// Registers the scans.
    ///
    /// # Errors
    /// [`Error::NoScans`] if there is none, and [`Error::Cancelled`] if the observer says so. What was found
    /// out until then is kept, stage by stage.
    pub fn registration(&mut self, observer: &dyn Observer) -> Result<Registration, Error> {
        if self.is_empty() {
            return Err(Error::NoScans);
        }
        let (confidences, time) = timed(|| self.score(observer))?;
        self.times.scoring += time;
        let (selected, time) = timed(|| {
            Items::of(Stage::Selection, 1, observer)
                .one(|| Ok(confidences.top_k_union(self.params.posegraph.neighbors)))
        })?;
        self.times.selection += time;
        let ((), time) = timed(|| self.estimate_selected(&confidences, &selected, observer))?;
        self.times.pose_estimation += time;
        let (graph, evidence, unresolved) = self.build_graph(&confidences, &selected);
        let (synchronization, time) = timed(|| {
            Items::of(Stage::Synchronization, 1, observer)
                .one(|| Ok(synchronize(&graph, &self.params.sync)))
        })?;
        self.times.synchronization += time;
        Ok(assemble(
            graph,
            evidence,
            unresolved,
            confidences,
            synchronization,
            mem::take(&mut self.times),
        ))
    }

    /// Scans without points have no dimension.
    fn check_dimensions(&self, scans: &[Scan]) -> Result<(), Error> {
        let known = self
            .keypoints
            .iter()
            .map(|keypoints| keypoints.descriptors());
        let all = known.chain(scans.iter().map(Scan::descriptors)).enumerate();
        let mut described = all.filter(|(_, descriptors)| !descriptors.is_empty());
        let Some((first, expected)) = described.next() else {
            return Ok(());
        };
        match described.find(|(_, other)| other.dimension() != expected.dimension()) {
            Some((scan, other)) => Err(Error::DimensionsDiffer {
                first,
                expected: expected.dimension(),
                scan,
                dimension: other.dimension(),
            }),
            None => Ok(()),
        }
    }

    fn sample(&self, scans: &[Scan], observer: &dyn Observer) -> Result<Vec<Keypoints>, Error> {
        let num_samples = self.params.correspondence.num_samples;
        let items = Items::of(Stage::Sampling, scans.len(), observer);
        let sample = |scan| items.one(|| Ok(Keypoints::sample(scan, num_samples)));
        scans.par_iter().map(sample).collect()
    }

    /// Confidences of all pairs that are worth it, of which those not known yet are scored.
    fn score(&mut self, observer: &dyn Observer) -> Result<PairConfidences, Error> {
        if observer.is_cancelled() {
            return Err(Error::Cancelled {
                stage: Stage::Scoring,
            });
        }
        let params = self.params.retrieval.clone();
        let descriptors = self.keypoints.iter().map(Keypoints::descriptors);
        let mut pairs = candidate_pairs(&descriptors.collect::<Vec<_>>(), &params)
            .expect("added scans have descriptors of one dimension");
        self.score_pairs(&pairs, observer)?;
        let mut confidences = self.confidences(&pairs);
        for _ in 0..params.expansions {
            let further = further_pairs(&confidences, &params);
            if further.is_empty() {
                break;
            }
            self.score_pairs(&further, observer)?;
            pairs.extend(further);
            pairs.sort_unstable();
            confidences = self.confidences(&pairs);
        }
        Ok(confidences)
    }

    fn score_pairs(&mut self, pairs: &[Pair], observer: &dyn Observer) -> Result<(), Error> {
        let is_new = |pair: &Pair| !self.scores.contains_key(pair);
        let new: Vec<Pair> = pairs.iter().copied().filter(is_new).collect();
        let items = Items::of(Stage::Scoring, new.len(), observer);
        let score = |(i, j): Pair| {
            let raw_confidence =
                raw_confidence(&self.keypoints[i], &self.keypoints[j], &self.params)
                    .map_err(|differ| Error::of_pair(i, j, differ))?;
            Ok(((i, j), raw_confidence))
        };
        let scored = new.into_par_iter().map(|pair| items.one(|| score(pair)));
        let scored: Result<Vec<_>, Error> = scored.collect();
        self.scores.extend(scored?);
        Ok(())
    }

    /// Of pairs that are scored, in order.
    fn confidences(&self, pairs: &[Pair]) -> PairConfidences {
        let scored = pairs.iter().map(|&(i, j)| ScoredPair {
            i,
            j,
            raw_confidence: self.scores[&(i, j)],
        });
        PairConfidences::new(self.keypoints.len(), scored.collect())
            .expect("the pairs are different, in order, and scored by finite numbers")
    }

    /// Estimates the motions of selected pairs that were not selected before. They are matched and
    /// filtered again, which costs a share `K / N` of the scoring and saves the memory of keeping all
    /// pairs.
    fn estimate_selected(
        &mut self,
        confidences: &PairConfidences,
        selected: &[usize],
        observer: &dyn Observer,
    ) -> Result<(), Error> {
        let ends = selected.iter().map(|&position| {
            let ScoredPair { i, j, .. } = confidences.pairs()[position];
            (i, j)
        });
        let ends: Vec<_> = ends.collect();
        let items = Items::of(Stage::PoseEstimation, ends.len(), observer);
        let estimate = |&(i, j): &Pair| {
            if let Some(known) = self.selected.get(&(i, j)) {
                return Ok(((i, j), known.clone()));
            }
            let pair = register_keypoints(&self.keypoints[i], &self.keypoints[j], &self.params)
                .map_err(|differ| Error::of_pair(i, j, differ))?;
            let pair = SelectedPair {
                num_correspondences: pair.correspondences.len(),
                estimate: pair.estimate,
            };
            Ok(((i, j), pair))
        };
        let estimated = ends.par_iter().map(|pair| items.one(|| estimate(pair)));
        let estimated: Result<_, Error> = estimated.collect();
        self.selected = estimated?;
        Ok(())
    }

    /// The pose graph of the pairs that have a motion, with initial weights `w⁰ = s_ij · IR`.
    fn build_graph(
        &self,
        confidences: &PairConfidences,
        selected: &[usize],
    ) -> (PoseGraph, Vec<EdgeEvidence>, Vec<UnresolvedPair>) {
        let (mut edges, mut evidence, mut unresolved) = (Vec::new(), Vec::new(), Vec::new());
        // Both are in the order of the pairs.
        for (&position, (&(i, j), pair)) in selected.iter().zip(&self.selected) {
            let confidence = confidences.normalized()[position];
            let &PoseEstimate {
                ref pose,
                cliques_seen,
                budget_exhausted,
            } = &pair.estimate;
            let Some(pose) = pose.as_ref().filter(|pose| pose.inlier_ratio > 0.0) else {
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
                num_correspondences: pair.num_correspondences,
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
}

/// Forgets the pairs of a scan; scans behind it move up by one.
fn without<T>(scan: usize, of_pairs: &mut BTreeMap<Pair, T>) {
    let moved = |k: usize| k - usize::from(k > scan);
    let kept = mem::take(of_pairs).into_iter();
    let kept = kept.filter(|&((i, j), _)| i != scan && j != scan);
    *of_pairs = kept
        .map(|((i, j), value)| ((moved(i), moved(j)), value))
        .collect();
}

/// The result of a stage, and how long it took.
fn timed<T>(stage: impl FnOnce() -> Result<T, Error>) -> Result<(T, Duration), Error> {
    let start = Instant::now();
    Ok((stage()?, start.elapsed()))
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
