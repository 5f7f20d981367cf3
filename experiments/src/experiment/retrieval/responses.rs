//! Spectral responses: do they tell inliers from outliers?

use std::path::Path;

use gmpcr::Params;
use gmpcr::compatibility::{CompatibilityGraph, DominantEigenpair};
use gmpcr::correspondence::{CorrespondenceError, Keypoints, correspondences};
use gmpcr_eval::{GroundTruthPair, auc};
use rayon::prelude::*;

use super::keypoints;
use crate::failure::Failure;
use crate::figures::{Panel, write_figure};
use crate::records::{Record, Selection};
use crate::scene::Scene;
use crate::table::{Table, number};

/// Configuration of the records.
pub const RESPONSE: &str = "spectral response";
const LOW_OVERLAP: &str = "3dlomatch";
/// Bins of the distribution of responses in [0, 1].
const BINS: usize = 20;

/// How well the spectral response tells inliers from outliers, list by list; that of 3DLoMatch with
/// its own preset.
pub fn run(scene: &Scene) -> Result<Vec<Record>, Failure> {
    let mut records = Vec::new();
    for list in &scene.lists {
        let last = scene.presets.len() - 1;
        let place = if list.name == LOW_OVERLAP { last } else { 0 };
        let (_, params) = &scene.presets[place];
        let keypoints = keypoints(scene, params)?;
        let judge = |pair: &GroundTruthPair| judged_responses(&keypoints, pair, params);
        let judged: Result<Vec<_>, _> = list.pairs.par_iter().map(judge).collect();
        records.extend(list_records(&list.name, judged?.as_slice())?);
    }
    Ok(records)
}

/// Area under the curve of each pair, and the distribution of the responses of each class.
fn list_records(list: &str, judged: &[JudgedResponses]) -> Result<Vec<Record>, gmpcr_eval::Error> {
    let mut areas = Vec::new();
    let mut counts = [[0usize; BINS]; 2];
    for (responses, is_inlier) in judged {
        areas.extend(auc(responses, is_inlier)?);
        for (response, &is_inlier) in responses.iter().zip(is_inlier) {
            let bin = (response * BINS as f64) as usize;
            counts[usize::from(is_inlier)][bin.min(BINS - 1)] += 1;
        }
    }
    let record = |metric: String, value| Record::new(RESPONSE, 0, metric, value);
    let mut records = Vec::new();
    if !areas.is_empty() {
        let (sum, count) = (areas.iter().sum::<f64>(), areas.len() as f64);
        records.push(record(format!("{list} auc"), sum / count));
        records.push(record(format!("{list} auc sum"), sum));
        records.push(record(format!("{list} auc pairs"), count));
    }
    for (class, counts) in ["outliers", "inliers"].into_iter().zip(counts) {
        for (bin, count) in counts.into_iter().enumerate() {
            records.push(record(format!("{list} {class} {bin}"), count as f64));
        }
    }
    Ok(records)
}

/// Responses of the correspondences of a pair, and which of them are inliers.
type JudgedResponses = (Vec<f64>, Vec<bool>);

/// Spectral response, in units of the pair's largest, and correctness of each correspondence.
fn judged_responses(
    keypoints: &[Keypoints],
    ground_truth: &GroundTruthPair,
    params: &Params,
) -> Result<JudgedResponses, CorrespondenceError> {
    let [i, j] = [ground_truth.i, ground_truth.j].map(|scan| &keypoints[scan]);
    let pairs = correspondences(i, j, &params.correspondence)?;
    let graph = CompatibilityGraph::new(&pairs, params.compatibility.tolerance);
    let response = DominantEigenpair::new(graph.scg()).vector;
    let largest = response.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let is_inlier = |distance: f64| distance <= params.cliques.inlier_threshold;
    Ok((
        response.iter().map(|entry| entry / largest).collect(),
        pairs
            .residuals(&ground_truth.i_from_j)
            .map(is_inlier)
            .collect(),
    ))
}

pub fn report(
    records: &Selection,
    descriptors: &str,
    figure: &Path,
    text: &mut String,
) -> Result<(), Failure> {
    let title = format!(
        "Mean AUC of the spectral response against inliers of the ground truth, {descriptors} descriptors"
    );
    let mut header = vec!["list".to_owned()];
    header.extend(records.names());
    let means = ["scene mean", "mean of all pairs", "paper (8 scenes, YOHO)"];
    header.extend(means.map(str::to_owned));
    let mut table = Table::new(title, header);
    let mut panels = Vec::new();
    for list in ["3dmatch", LOW_OVERLAP, "gt", "poses"] {
        let metric = format!("{list} auc");
        let Some(mean) = records.mean_spread(RESPONSE, &metric) else {
            continue;
        };
        let mut row = vec![list.to_owned()];
        let scenes = records.scenes.iter();
        row.extend(scenes.map(|(s, _)| number(records.scene_spread(s, RESPONSE, &metric), 1.0, 3)));
        let (sum, pairs) = (format!("{metric} sum"), format!("{metric} pairs"));
        let pooled = records.ratio_spread(RESPONSE, &sum, &pairs);
        let paper = if list == LOW_OVERLAP { "0.801" } else { "–" };
        row.extend([
            format!("{:.3}", mean.mean),
            number(pooled, 1.0, 3),
            paper.to_owned(),
        ]);
        table.row(row);
        let distributions = ["inliers", "outliers"].map(|class| distribution(records, list, class));
        let panel = Panel::new(
            list,
            "spectral response / largest",
            "ratio of the class (%)",
        );
        panels.push(panel.histograms(&distributions, 0.0, 1.0));
    }
    table.append_to(text);
    Ok(write_figure(figure, &panels)?)
}

/// Ratio in percent of the correspondences of a class in each bin of responses, all scenes together.
fn distribution(records: &Selection, list: &str, class: &str) -> (String, Vec<f64>) {
    let count = |bin: usize| -> f64 {
        let metric = format!("{list} {class} {bin}");
        let scenes = records.scenes.iter();
        let counts = scenes.flat_map(|(scene, _)| records.of_scene(scene, RESPONSE, &metric));
        counts.map(|(_, count)| count).sum()
    };
    let counts: Vec<f64> = (0..BINS).map(count).collect();
    let total = counts.iter().sum::<f64>().max(1.0);
    let ratios = counts.iter().map(|count| 100.0 * count / total);
    (class.to_owned(), ratios.collect())
}
