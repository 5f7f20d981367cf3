//! The figure of docs/architecture.md, stage by stage.

use std::mem;

use gmpcr_correspondence::{Keypoints, Scan};
use gmpcr_posegraph::{PairConfidences, PoseGraph, ScoredPair};
use gmpcr_retrieval::{candidate_pairs, further_pairs};
use gmpcr_sync::{Synchronization, synchronize};
use rayon::prelude::*;

use crate::known_pairs::{EstimatedPair, KnownPairs};
use crate::pair::{raw_confidence, register_correspondences_unchecked};
use crate::progress::StageProgress;
use crate::selected_pair::SelectedPair;
use crate::source::{Pair, Source};
use crate::{Error, Observer, Params, Registration, ScanId, Stage, StageTimes};

/// What the stages need to know. Scans are named by their positions in `ids`.
pub(crate) struct Pipeline<'a> {
    pub ids: &'a [ScanId],
    pub source: Source<'a>,
    pub params: &'a Params,
    pub observer: &'a dyn Observer,
}

/// The `N_s` points of each scan that differ most in descriptor space.
pub(crate) fn sample(
    scans: &[Scan],
    params: &Params,
    observer: &dyn Observer,
) -> Result<Vec<Keypoints>, Error> {
    let progress = StageProgress::begin(Stage::Sampling, scans.len(), observer);
    let sample = |scan| progress.item(|| Ok(Keypoints::sample(scan, &params.correspondence)?));
    scans.par_iter().map(sample).collect()
}

impl Pipeline<'_> {
    /// From sampled scans, or from given correspondences, to poses.
    ///
    /// What earlier runs found out about pairs is `known` and not computed again; what this run finds out is
    /// added stage by stage, also if it is cancelled.
    pub fn run(
        &self,
        known: &mut KnownPairs,
        times: &mut StageTimes,
    ) -> Result<Registration, Error> {
        let confidences = times.timed(Stage::Scoring, || self.score(known))?;
        let selected = times.timed(Stage::Selection, || self.select(&confidences))?;
        let pairs = times.timed(Stage::PoseEstimation, || {
            self.estimate(&confidences, &selected, known)
        })?;
        let graph = self.pose_graph(&pairs);
        let synchronization = times.timed(Stage::Synchronization, || self.synchronize(&graph))?;
        Ok(Registration::new(
            self.ids.to_vec(),
            pairs,
            confidences,
            synchronization,
            mem::take(times),
            self.params.clone(),
        ))
    }

    /// Scores all pairs of the source. Where scans are many, only pairs that retrieval proposes: by the
    /// descriptors first, then as neighbors of the neighbors that the scores show.
    fn score(&self, known: &mut KnownPairs) -> Result<PairConfidences, Error> {
        let params = &self.params.retrieval;
        let keypoints = match &self.source {
            Source::Keypoints(keypoints) if keypoints.len() >= params.min_scans => keypoints,
            all => return self.score_pairs(&all.pairs(), known),
        };
        if self.observer.is_cancelled() {
            return Err(Error::Cancelled {
                stage: Stage::Scoring,
            });
        }
        let descriptors: Vec<_> = keypoints.iter().map(Keypoints::descriptors).collect();
        let mut pairs = candidate_pairs(&descriptors, params)?;
        let mut confidences = self.score_pairs(&pairs, known)?;
        for _ in 0..params.expansions {
            let further = further_pairs(&confidences, params)?;
            if further.is_empty() {
                break;
            }
            pairs.extend(further);
            pairs.sort_unstable();
            confidences = self.score_pairs(&pairs, known)?;
        }
        Ok(confidences)
    }

    /// Per pair: correspondences, compatibility graphs, dominant eigenvector, spectral filter, confidence.
    fn score_pairs(
        &self,
        pairs: &[Pair],
        known: &mut KnownPairs,
    ) -> Result<PairConfidences, Error> {
        let is_new = |&(i, j): &Pair| known.score(self.ids[i], self.ids[j]).is_none();
        let new: Vec<Pair> = pairs.iter().copied().filter(is_new).collect();
        let progress = StageProgress::begin(Stage::Scoring, new.len(), self.observer);
        let score = |&(i, j): &Pair| {
            let correspondences = self.source.correspondences(i, j, self.params)?;
            raw_confidence(&correspondences, self.params)
        };
        let scored = new.par_iter().map(|pair| progress.item(|| score(pair)));
        let scores: Vec<f64> = scored.collect::<Result<_, Error>>()?;
        for ((i, j), score) in new.into_iter().zip(scores) {
            known.insert_score(self.ids[i], self.ids[j], score);
        }
        let scored = pairs.iter().map(|&(i, j)| ScoredPair {
            i,
            j,
            raw_confidence: known
                .score(self.ids[i], self.ids[j])
                .expect("the pair was scored above, or before"),
        });
        Ok(PairConfidences::new(self.ids.len(), scored.collect())
            .expect("the pairs are different, in order, and scored by finite numbers"))
    }

    /// The union of the `K` most confident pairs of each scan.
    fn select(&self, confidences: &PairConfidences) -> Result<Vec<usize>, Error> {
        StageProgress::begin(Stage::Selection, 1, self.observer)
            .item(|| Ok(confidences.top_k_union(&self.params.posegraph)?))
    }

    /// Per selected pair: maximal cliques, weighted Kabsch, inlier ratio. The pairs are matched and filtered
    /// again, which costs a fraction of about `2 K / N` of the scoring and saves the memory of keeping all pairs.
    fn estimate(
        &self,
        confidences: &PairConfidences,
        selected: &[usize],
        known: &mut KnownPairs,
    ) -> Result<Vec<SelectedPair>, Error> {
        let progress = StageProgress::begin(Stage::PoseEstimation, selected.len(), self.observer);
        let estimate = |i: usize, j: usize| {
            if let Some(pair) = known.estimate(self.ids[i], self.ids[j]) {
                return Ok(pair.clone());
            }
            let correspondences = self.source.correspondences(i, j, self.params)?;
            let pair = register_correspondences_unchecked(correspondences, self.params)?;
            Ok(EstimatedPair::from(pair))
        };
        let selected_pair = |&position: &usize| {
            let ScoredPair { i, j, .. } = confidences.pairs()[position];
            Ok(SelectedPair {
                i,
                j,
                confidence: confidences.normalized()[position],
                pair: progress.item(|| estimate(i, j))?,
            })
        };
        let pairs = selected.par_iter().map(selected_pair);
        let pairs: Vec<SelectedPair> = pairs.collect::<Result<_, Error>>()?;
        let estimates = pairs.iter().map(|selected| {
            let ends = (self.ids[selected.i], self.ids[selected.j]);
            (ends, selected.pair.clone())
        });
        known.replace_estimates(estimates.collect());
        Ok(pairs)
    }

    /// The relative poses that at least one correspondence supports, with weights `w⁰ = s_ij · IR`.
    fn pose_graph(&self, pairs: &[SelectedPair]) -> PoseGraph {
        let edges = pairs.iter().filter_map(SelectedPair::edge);
        PoseGraph::new(self.ids.len(), edges.collect())
            .expect("edges have usable relative poses, and confidences are at most one")
    }

    /// Per component of the graph: rotations, reweighted by the history of their residuals; translations.
    fn synchronize(&self, graph: &PoseGraph) -> Result<Synchronization, Error> {
        StageProgress::begin(Stage::Synchronization, 1, self.observer)
            .item(|| Ok(synchronize(graph, &self.params.sync)?))
    }
}
