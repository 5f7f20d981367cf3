//! Connectivity of the pose graph over the neighborhood size K (paper, table "Connectivity of pose
//! graphs constructed by GMPCR under different Top-K settings").

use std::path::Path;

use gmpcr::posegraph::{Connectivity, InvalidParameter, PairConfidences, PoseGraphParams};
use gmpcr_eval::ConnectivitySummary;

use crate::failure::Failure;
use crate::figures::{Panel, Series, write_figure};
use crate::records::{Record, Selection};
use crate::registering::registered;
use crate::scene::Scene;
use crate::table::Table;

const MAX_NEIGHBORS: usize = 10;
/// Between the preset and the size of the neighborhood.
const K: &str = ", K = ";

pub fn run(scene: &Scene) -> Result<Vec<Record>, Failure> {
    let mut records = Vec::new();
    for (preset, params) in &scene.presets {
        let confidences = &registered(scene, params, 0)?.confidences;
        for k in 1..=MAX_NEIGHBORS {
            let configuration = format!("{preset}{K}{k}");
            let figures = connectivity(confidences, k)?;
            let record = |metric, value| Record::new(&configuration, 0, metric, value);
            records.extend([
                record("components", figures.num_components as f64),
                record("largest component", figures.largest_component_ratio),
                record("reachability", figures.reachability),
                record("edges", figures.num_edges as f64),
            ]);
        }
    }
    Ok(records)
}

/// The presets that there are figures for.
fn presets(records: &Selection) -> Vec<String> {
    let of_configuration =
        |name: &String| Some(name.strip_suffix("1")?.strip_suffix(K)?.to_owned());
    records
        .configurations()
        .iter()
        .filter_map(of_configuration)
        .collect()
}

fn connectivity(
    confidences: &PairConfidences,
    neighbors: usize,
) -> Result<Connectivity, InvalidParameter> {
    let pair = |position: usize| {
        (
            confidences.pairs()[position].i,
            confidences.pairs()[position].j,
        )
    };
    let selected = confidences.top_k_union(&PoseGraphParams { neighbors })?;
    let edges: Vec<_> = selected.into_iter().map(pair).collect();
    Ok(Connectivity::new(confidences.num_scans(), &edges, 0))
}

pub fn report(
    records: &Selection,
    descriptors: &str,
    figure: &Path,
    text: &mut String,
) -> Result<(), Failure> {
    let title = format!("Connectivity over K, {descriptors} descriptors");
    let header = [
        "preset, K",
        "connected",
        "C max",
        "LCC min (%)",
        "R min (%)",
        "mean edges",
    ];
    let mut table = Table::new(title, header);
    let (mut connected, mut largest) = (Vec::new(), Vec::new());
    for preset in presets(records) {
        let mut lines = (Vec::new(), Vec::new());
        for k in 1..=MAX_NEIGHBORS {
            let configuration = format!("{preset}{K}{k}");
            let Some(summary) = summary(records, &configuration) else {
                continue;
            };
            let ratio = summary.num_connected as f64 / summary.num_scenes as f64;
            lines.0.push((k as f64, 100.0 * ratio));
            lines
                .1
                .push((k as f64, 100.0 * summary.min_largest_component_ratio));
            table.row(row(configuration, &summary));
        }
        connected.push(Series::new(&preset, lines.0));
        largest.push(Series::new(preset, lines.1));
    }
    table.append_to(text);
    let panels = [
        ("connected scenes", "scenes (%)", connected),
        ("worst scene", "largest component (%)", largest),
    ];
    let panels = panels.map(|(title, y_label, lines)| {
        Panel::new(title, "K", y_label)
            .y_range(0.0, 100.0)
            .lines(&lines)
    });
    Ok(write_figure(figure, &panels)?)
}

fn row(configuration: String, summary: &ConnectivitySummary) -> [String; 6] {
    [
        configuration,
        format!("{}/{}", summary.num_connected, summary.num_scenes),
        summary.max_components.to_string(),
        format!("{:.1}", 100.0 * summary.min_largest_component_ratio),
        format!("{:.1}", 100.0 * summary.min_reachability),
        format!("{:.1}", summary.mean_num_edges),
    ]
}

fn summary(records: &Selection, configuration: &str) -> Option<ConnectivitySummary> {
    let of_scene = |(scene, _): &(&str, _)| {
        let figure = |metric| Some(records.scene_spread(scene, configuration, metric)?.mean);
        let num_components = figure("components")? as usize;
        Some(Connectivity {
            is_connected: num_components <= 1,
            num_components,
            largest_component_ratio: figure("largest component")?,
            reachability: figure("reachability")?,
            num_edges: figure("edges")? as usize,
        })
    };
    let scenes: Vec<_> = records.scenes.iter().filter_map(of_scene).collect();
    ConnectivitySummary::of(&scenes)
}
