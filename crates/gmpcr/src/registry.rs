use std::collections::BTreeMap;
use std::mem;
use std::time::{Duration, Instant};

use gmpcr_cliques::PoseEstimate;
use gmpcr_correspondence::{Keypoints, Scan};
use gmpcr_posegraph::{Connectivity, PairConfidences, PoseEdge, PoseGraph, ScoredPair};
use gmpcr_sync::{Synchronization, synchronize};
use rayon::prelude::*;

use crate::pair::{raw_confidence, register_keypoints};
use crate::registration::{EdgeEvidence, Registration, StageTimes, UnresolvedPair};
use crate::{Error, Observer, Params, Stage};

/// Scans that come and go: keeps what is known of each scan and each pair, so that a change costs only
/// what it changes.
///
/// Adding the N-th scan samples it and scores its `N − 1` pairs; [`registration`](Self::registration)
/// then chooses edges among all pairs, estimates the motions of those that were not chosen before, and
/// synchronises. The result has the same bits as [`register`](crate::register) of the same scans in the
/// same order. Memory holds the keypoints, one confidence per pair and one motion per edge.
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
    /// Raw confidences: entry `i` of row `j` is that of the pair `(i, j)`, `i < j`.
    scores: Vec<Vec<f64>>,
    /// What the pairs have to say that the last registration selected.
    selected: BTreeMap<(usize, usize), SelectedPair>,
    /// What was spent since the last registration.
    times: StageTimes,
}

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
            scores: Vec::new(),
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

    /// Adds scans behind the others, samples them and scores all their pairs.
    ///
    /// # Errors
    /// [`Error::DimensionsDiffer`] if descriptors differ in dimension, also from those of earlier scans,
    /// and [`Error::Cancelled`] if the observer says so. Then the registry is as it was.
    pub fn add(&mut self, scans: &[Scan], observer: &dyn Observer) -> Result<(), Error> {
        self.check_dimensions(scans)?;
        let num_before = self.keypoints.len();
        let mut times = self.times;
        let sampled = timed(&mut times.sampling, || self.sample(scans, observer))?;
        self.keypoints.extend(sampled);
        let scored = timed(&mut times.scoring, || self.score_from(num_before, observer));
        match scored {
            Ok(rows) => {
                self.scores.extend(rows);
                self.times = times;
                Ok(())
            }
            Err(error) => {
                self.keypoints.truncate(num_before);
                Err(error)
            }
        }
    }

    /// Removes a scan; those behind it move up by one.
    ///
    /// # Panics
    /// If the scan does not exist.
    pub fn remove(&mut self, scan: usize) {
        self.keypoints.remove(scan);
        self.scores.remove(scan);
        for row in &mut self.scores[scan..] {
            row.remove(scan);
        }
        let moved = |k: usize| k - usize::from(k > scan);
        let kept = mem::take(&mut self.selected).into_iter();
        let kept = kept.filter(|&((i, j), _)| i != scan && j != scan);
        self.selected = kept
            .map(|((i, j), pair)| ((moved(i), moved(j)), pair))
            .collect();
    }

    /// Registers the scans.
    ///
    /// # Errors
    /// [`Error::NoScans`] if there is none, and [`Error::Cancelled`] if the observer says so.
    pub fn registration(&mut self, observer: &dyn Observer) -> Result<Registration, Error> {
        if self.is_empty() {
            return Err(Error::NoScans);
        }
        let mut times = self.times;
        let confidences = self.confidences();
        let selected = timed(&mut times.selection, || {
            Items::of(Stage::Selection, 1, observer)
                .one(|| Ok(confidences.top_k_union(self.params.posegraph.neighbors)))
        })?;
        timed(&mut times.pose_estimation, || {
            self.estimate_selected(&confidences, &selected, observer)
        })?;
        let (graph, evidence, unresolved) = self.build_graph(&confidences, &selected);
        let synchronization = timed(&mut times.synchronization, || {
            Items::of(Stage::Synchronization, 1, observer)
                .one(|| Ok(synchronize(&graph, &self.params.sync)))
        })?;
        self.times = StageTimes::default();
        Ok(assemble(
            graph,
            evidence,
            unresolved,
            confidences,
            synchronization,
            times,
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

    /// The rows of scores of the scans from `first` on.
    fn score_from(&self, first: usize, observer: &dyn Observer) -> Result<Vec<Vec<f64>>, Error> {
        let new = first..self.keypoints.len();
        let pairs: Vec<_> = new
            .clone()
            .flat_map(|j| (0..j).map(move |i| (i, j)))
            .collect();
        let items = Items::of(Stage::Scoring, pairs.len(), observer);
        let score = |(i, j): (usize, usize)| {
            raw_confidence(&self.keypoints[i], &self.keypoints[j], &self.params)
                .map_err(|differ| Error::of_pair(i, j, differ))
        };
        let scored = pairs.into_par_iter().map(|pair| items.one(|| score(pair)));
        let scored: Result<Vec<f64>, Error> = scored.collect();
        let mut scored = scored?.into_iter();
        Ok(new.map(|j| scored.by_ref().take(j).collect()).collect())
    }

    fn confidences(&self) -> PairConfidences {
        let num_scans = self.keypoints.len();
        let pairs = (0..num_scans).flat_map(|i| (i + 1..num_scans).map(move |j| (i, j)));
        let scored = pairs.map(|(i, j)| ScoredPair {
            i,
            j,
            raw_confidence: self.scores[j][i],
        });
        PairConfidences::new(num_scans, scored.collect()).expect("all pairs, in order, are scored")
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
        let estimate = |&(i, j): &(usize, usize)| {
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

fn timed<T>(time: &mut Duration, stage: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = stage();
    *time += start.elapsed();
    result
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
