//! What confidences and spectral responses are worth (paper, section "Pose Graph Construction
//! Quality" and the figure "Spectral evidence for the two selection stages").

mod deciles;
mod responses;

use std::path::PathBuf;

use gmpcr::Params;
use gmpcr::correspondence::{InvalidParameter, Keypoints, match_descriptors};
use gmpcr_eval::retrieval;
use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::failure::Failure;
use crate::records::{Record, Selection};
use crate::registering::registered;
use crate::scene::Scene;
use crate::table::{Table, number, percent};

const NEIGHBORS: [usize; 3] = [4, 8, 12];
const UNFILTERED: &str = "confidence without spectral filtering";
const MATCHES: &str = "number of mutual matches";

pub fn run(scene: &Scene) -> Result<Vec<Record>, Failure> {
    let mut records = responses::run(scene)?;
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
    records.extend(deciles::run(&rankings[0].1, overlap)?);
    Ok(records)
}

/// Symmetric matrix of raw confidences.
fn confidences(scene: &Scene, params: &Params) -> Result<DMatrix<f64>, Failure> {
    let confidences = &registered(scene, params, 0)?.confidences;
    let mut matrix = DMatrix::zeros(scene.scans.len(), scene.scans.len());
    for pair in confidences.pairs() {
        matrix[(pair.i, pair.j)] = pair.raw_confidence;
    }
    Ok(matrix)
}

/// Number of mutual matches of every pair: what pairs could be ranked by without geometry.
fn mutual_matches(scene: &Scene, params: &Params) -> Result<DMatrix<f64>, Failure> {
    let keypoints = keypoints(scene, params)?;
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

fn keypoints(scene: &Scene, params: &Params) -> Result<Vec<Keypoints>, InvalidParameter> {
    let sample = |scan| Keypoints::sample(scan, &params.correspondence);
    scene.scans.par_iter().map(sample).collect()
}

pub fn report(
    records: &Selection,
    descriptors: &str,
    figure: &dyn Fn(&str) -> PathBuf,
    text: &mut String,
) -> Result<(), Failure> {
    let title = format!("Retrieval of overlapping pairs, {descriptors} descriptors");
    let mut header = vec!["ranking".to_owned()];
    header.extend(NEIGHBORS.map(|k| format!("R@{k} (%)")));
    header.extend(NEIGHBORS.map(|k| format!("regret at {k}")));
    let mut table = Table::new(title, header);
    let not_rankings = [deciles::PAIRS, deciles::DECILES, responses::RESPONSE];
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
    responses::report(records, descriptors, &figure("responses"), text)?;
    deciles::report(records, descriptors, figure, text)
}
