//! What confidences and spectral responses are worth (paper, section "Pose Graph Construction
//! Quality" and the figure "Spectral evidence for the two selection stages").

use std::error::Error;
use std::path::{Path, PathBuf};

use gmpcr::Params;
use gmpcr::compatibility::{CompatibilityGraph, DominantEigenpair};
use gmpcr::correspondence::{Keypoints, correspondences, match_descriptors};
use gmpcr_eval::{DecileSummary, GroundTruthPair, OverlapDeciles, auc, overlap_deciles, retrieval};
use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::figures::{Panel, Series, write_figure};
use crate::records::{Record, Selection};
use crate::registering::registered;
use crate::scene::Scene;
use crate::table::{Table, number, percent};

const NEIGHBORS: [usize; 3] = [4, 8, 12];
const UNFILTERED: &str = "confidence without spectral filtering";
const MATCHES: &str = "number of mutual matches";
const DECILES: &str = "deciles";
const RESPONSE: &str = "spectral response";
const LOW_OVERLAP: &str = "3dlomatch";
/// Bins of the distribution of responses in [0, 1].
const BINS: usize = 20;

pub fn run(scene: &Scene) -> Result<Vec<Record>, Box<dyn Error>> {
    let mut records = responses(scene)?;
    let Some(overlap) = &scene.overlap else {
        return Ok(records);
    };
    let mut rankings = Vec::new();
    for (preset, params) in &scene.presets {
        rankings.push((format!("confidence, {preset}"), confidences(scene, params)?));
    }
    let mut unfiltered = scene.main_params().clone();
    unfiltered.compatibility.retained_fraction = 1.0;
    rankings.push((UNFILTERED.to_owned(), confidences(scene, &unfiltered)?));
    rankings.push((
        MATCHES.to_owned(),
        mutual_matches(scene, scene.main_params())?,
    ));
    for (configuration, confidence) in &rankings {
        for k in NEIGHBORS {
            let confidence = |i, j| confidence[(i, j)];
            let found = retrieval(scene.scans.len(), k, confidence, |i, j| overlap[(i, j)]);
            if let Some(found) = found {
                let record = |metric: &str, value| {
                    Record::new(configuration.as_str(), 0, format!("{metric} at {k}"), value)
                };
                records.extend([record("R", found.recall), record("regret", found.regret)]);
            }
        }
    }
    records.extend(evidence(&rankings[0].1, overlap)?);
    Ok(records)
}

/// Symmetric matrix of raw confidences.
fn confidences(scene: &Scene, params: &Params) -> Result<DMatrix<f64>, Box<dyn Error>> {
    let confidences = &registered(scene, params, 0)?.confidences;
    let mut matrix = DMatrix::zeros(scene.scans.len(), scene.scans.len());
    for pair in confidences.pairs() {
        matrix[(pair.i, pair.j)] = pair.raw_confidence;
    }
    Ok(matrix)
}

/// Number of mutual matches of every pair: what pairs could be ranked by without geometry.
fn mutual_matches(scene: &Scene, params: &Params) -> Result<DMatrix<f64>, Box<dyn Error>> {
    let keypoints = keypoints(scene, params);
    let n = keypoints.len();
    let pairs: Vec<_> = (0..n)
        .flat_map(|i| (i + 1..n).map(move |j| (i, j)))
        .collect();
    let count = |&(i, j): &(usize, usize)| {
        match_descriptors(keypoints[i].descriptors(), keypoints[j].descriptors()).map(|m| m.len())
    };
    let counts: Result<Vec<usize>, _> = pairs.par_iter().map(count).collect();
    let mut matrix = DMatrix::zeros(n, n);
    for (pair, count) in pairs.into_iter().zip(counts?) {
        matrix[pair] = count as f64;
    }
    Ok(matrix)
}

fn keypoints(scene: &Scene, params: &Params) -> Vec<Keypoints> {
    let num_samples = params.correspondence.num_samples;
    let sample = |scan| Keypoints::sample(scan, num_samples);
    scene.scans.par_iter().map(sample).collect()
}

/// Confidence and overlap of every pair, and the overlap by deciles of confidence.
fn evidence(
    confidence: &DMatrix<f64>,
    overlap: &DMatrix<f64>,
) -> Result<Vec<Record>, Box<dyn Error>> {
    let n = confidence.nrows();
    let pairs = || (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j)));
    let of_pairs = |matrix: &DMatrix<f64>| pairs().map(|pair| matrix[pair]).collect::<Vec<_>>();
    let (confidence, overlap) = (of_pairs(confidence), of_pairs(overlap));
    let largest = confidence.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let mut records = Vec::new();
    for (pair, (c, o)) in confidence.iter().zip(&overlap).enumerate() {
        records.push(Record::new("pairs", pair, "confidence", c / largest));
        records.push(Record::new("pairs", pair, "overlap", *o));
    }
    let deciles = overlap_deciles(&confidence, &overlap)?;
    for (decile, mean) in deciles.deciles.iter().enumerate() {
        let mean = mean.map(|mean| Record::new(DECILES, 0, format!("decile {decile}"), mean));
        records.extend(mean);
    }
    let all = deciles
        .all_pairs
        .map(|mean| Record::new(DECILES, 0, "all pairs", mean));
    records.extend(all);
    Ok(records)
}

/// How well the spectral response tells inliers from outliers, list by list; that of 3DLoMatch with
/// its own preset.
fn responses(scene: &Scene) -> Result<Vec<Record>, Box<dyn Error>> {
    let mut records = Vec::new();
    for list in &scene.lists {
        let last = scene.presets.len() - 1;
        let place = if list.name == LOW_OVERLAP { last } else { 0 };
        let (_, params) = &scene.presets[place];
        let keypoints = keypoints(scene, params);
        let judge = |pair: &GroundTruthPair| judged_responses(&keypoints, pair, params);
        let judged: Result<Vec<_>, _> = list.pairs.par_iter().map(judge).collect();
        let mut areas = Vec::new();
        let mut counts = [[0usize; BINS]; 2];
        for (responses, is_inlier) in judged? {
            areas.extend(auc(&responses, &is_inlier)?);
            for (response, is_inlier) in responses.iter().zip(is_inlier) {
                let bin = (response * BINS as f64) as usize;
                counts[usize::from(is_inlier)][bin.min(BINS - 1)] += 1;
            }
        }
        let record = |metric: String, value| Record::new(RESPONSE, 0, metric, value);
        let name = &list.name;
        if !areas.is_empty() {
            let (sum, count) = (areas.iter().sum::<f64>(), areas.len() as f64);
            records.push(record(format!("{name} auc"), sum / count));
            records.push(record(format!("{name} auc sum"), sum));
            records.push(record(format!("{name} auc pairs"), count));
        }
        for (class, counts) in ["outliers", "inliers"].into_iter().zip(counts) {
            for (bin, count) in counts.into_iter().enumerate() {
                records.push(record(format!("{name} {class} {bin}"), count as f64));
            }
        }
    }
    Ok(records)
}

/// Spectral response, in units of the pair's largest, and correctness of each correspondence.
fn judged_responses(
    keypoints: &[Keypoints],
    truth: &GroundTruthPair,
    params: &Params,
) -> Result<(Vec<f64>, Vec<bool>), gmpcr::correspondence::DimensionsDiffer> {
    let max = params.correspondence.max_correspondences;
    let pairs = correspondences(&keypoints[truth.i], &keypoints[truth.j], max)?;
    let graph = CompatibilityGraph::new(&pairs, params.compatibility.tolerance);
    let response = DominantEigenpair::new(graph.scg()).vector;
    let largest = response.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let is_inlier = |distance: f64| distance <= params.cliques.inlier_threshold;
    Ok((
        response.iter().map(|entry| entry / largest).collect(),
        pairs.residuals(&truth.i_from_j).map(is_inlier).collect(),
    ))
}

pub fn report(
    records: &Selection,
    descriptors: &str,
    figure: &dyn Fn(&str) -> PathBuf,
    text: &mut String,
) -> Result<(), Box<dyn Error>> {
    let title = format!("Retrieval of overlapping pairs, {descriptors} descriptors");
    let mut header = vec!["ranking".to_owned()];
    header.extend(NEIGHBORS.map(|k| format!("R@{k} (%)")));
    header.extend(NEIGHBORS.map(|k| format!("regret at {k}")));
    let mut table = Table::new(title, header);
    let not_rankings = ["pairs", DECILES, RESPONSE];
    for ranking in records.configurations() {
        if not_rankings.contains(&ranking.as_str()) {
            continue;
        }
        let mean = |metric: String| records.mean_spread(&ranking, &metric);
        let mut row = vec![ranking.clone()];
        row.extend(NEIGHBORS.map(|k| percent(mean(format!("R at {k}")))));
        row.extend(NEIGHBORS.map(|k| number(mean(format!("regret at {k}")), 1.0, 4)));
        table.row(row);
    }
    table.append_to(text);
    report_responses(records, descriptors, &figure("responses"), text)?;
    report_deciles(records, descriptors, &figure("deciles"), text)?;
    draw_pairs(records, &figure("confidence_overlap"))
}

fn report_responses(
    records: &Selection,
    descriptors: &str,
    figure: &Path,
    text: &mut String,
) -> Result<(), Box<dyn Error>> {
    let title = format!(
        "Mean AUC of the spectral response against true inliers, {descriptors} descriptors"
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
            "share of the class (%)",
        );
        panels.push(panel.histograms(&distributions, 0.0, 1.0));
    }
    table.append_to(text);
    Ok(write_figure(figure, &panels)?)
}

/// Share in percent of the correspondences of a class in each bin of responses, all scenes together.
fn distribution(records: &Selection, list: &str, class: &str) -> (String, Vec<f64>) {
    let count = |bin: usize| -> f64 {
        let metric = format!("{list} {class} {bin}");
        let scenes = records.scenes.iter();
        let counts = scenes.flat_map(|(scene, _)| records.of_scene(scene, RESPONSE, &metric));
        counts.map(|(_, count)| count).sum()
    };
    let counts: Vec<f64> = (0..BINS).map(count).collect();
    let total = counts.iter().sum::<f64>().max(1.0);
    let shares = counts.iter().map(|count| 100.0 * count / total);
    (class.to_owned(), shares.collect())
}

fn report_deciles(
    records: &Selection,
    descriptors: &str,
    figure: &Path,
    text: &mut String,
) -> Result<(), Box<dyn Error>> {
    let of_scene = |(scene, _): &(&str, _)| {
        let mean = |metric: &str| Some(records.scene_spread(scene, DECILES, metric)?.mean);
        OverlapDeciles {
            deciles: std::array::from_fn(|decile| mean(&format!("decile {decile}"))),
            all_pairs: mean("all pairs"),
        }
    };
    let scenes: Vec<_> = records.scenes.iter().map(of_scene).collect();
    let Some(summary) = DecileSummary::of(&scenes) else {
        return Ok(());
    };
    let title = format!("Mean overlap per decile of confidence, {descriptors} descriptors");
    let header = (1..=10).map(|decile| decile.to_string());
    let mut table = Table::new(title, header.chain(["all pairs".to_owned()]));
    let (mut points, mut half_widths, mut cells) = (Vec::new(), Vec::new(), Vec::new());
    for (decile, mean) in summary.deciles.iter().enumerate() {
        cells.push(mean.map_or("–".to_owned(), |mean| format!("{:.3}", mean.mean)));
        if let Some(mean) = mean {
            points.push((decile as f64 + 1.0, mean.mean));
            half_widths.push(mean.half_width.unwrap_or(0.0));
        }
    }
    cells.push(format!("{:.3}", summary.all_pairs));
    table.row(cells);
    table.append_to(text);
    text.push_str(
        "\nPaper (8 scenes, YOHO descriptors): 0.485 in the tenth decile, 0.10 over all pairs.\n",
    );
    let panel = Panel::new(
        "overlap over confidence",
        "decile of confidence",
        "mean overlap",
    )
    .band(
        &Series::new("scene mean", points),
        &half_widths,
        "95 % interval",
    )
    .level("all pairs", summary.all_pairs);
    Ok(write_figure(figure, &[panel])?)
}

fn draw_pairs(records: &Selection, figure: &Path) -> Result<(), Box<dyn Error>> {
    let of_scene = |(scene, _): &(&str, _)| {
        let confidence = records.of_scene(scene, "pairs", "confidence");
        let overlap = records.of_scene(scene, "pairs", "overlap");
        let points = confidence
            .iter()
            .zip(&overlap)
            .map(|((_, c), (_, o))| (*c, *o));
        Series::new(*scene, points.collect())
    };
    let series: Vec<_> = records.scenes.iter().map(of_scene).collect();
    let x_label = "confidence / largest of the scene";
    let panel = Panel::new("pairs of scans", x_label, "overlap").scatter(&series);
    Ok(write_figure(figure, &[panel])?)
}
