//! Recall over the number of scans that are registered at once (paper, table "Registration recall under
//! increasing numbers of views"): seeded random subsets of each scene.

use std::path::Path;

use gmpcr::posegraph::{Components, PoseGraph};
use gmpcr::register;
use gmpcr::sync::{Method, SyncParams, synchronize};
use gmpcr_eval::WorldPoses;
use nalgebra::Isometry3;
use rand::seq::index::sample;

use super::recall::lists;
use crate::arguments::Arguments;
use crate::failure::Failure;
use crate::figures::{Panel, Series, write_figure};
use crate::records::{Record, Selection};
use crate::registering::{Judge, generator, registered, sampled};
use crate::scene::Scene;
use crate::table::{Table, percent};

/// Sizes of the subsets.
const SIZES: [usize; 5] = [10, 20, 30, 40, 50];
const ALL: &str = "all";
/// The number of scans as a metric.
const NUM_SCANS: &str = "scans";
const METHODS: [Method; 3] = [Method::Adaptive, Method::Sghr, Method::Consensus];

pub fn run(scene: &Scene, arguments: &Arguments) -> Result<Vec<Record>, Failure> {
    let num_scans = scene.scans.len();
    let params = scene.main_params();
    let mut records = Vec::new();
    for run in 0..arguments.runs as usize {
        let scans = sampled(scene, params, run);
        for count in SIZES.into_iter().filter(|&count| count < num_scans) {
            let subset = random_subset(scene, run, count);
            let chosen: Vec<_> = subset.iter().map(|&scan| scans[scan].clone()).collect();
            let graph = register(&chosen, params)?.pose_graph();
            records.extend(judge_methods(
                scene,
                run,
                &count.to_string(),
                &subset,
                &graph,
            )?);
        }
        let all: Vec<usize> = (0..num_scans).collect();
        let graph = &registered(scene, params, run)?.pose_graph();
        records.extend(judge_methods(scene, run, ALL, &all, graph)?);
    }
    Ok(records)
}

/// Ascending scans, drawn anew in each run.
fn random_subset(scene: &Scene, run: usize, count: usize) -> Vec<usize> {
    let num_scans = scene.scans.len();
    // Purposes up to the number of scans are taken by the sampling.
    let mut rng = generator(scene.seed, run, num_scans + count);
    let mut subset = sample(&mut rng, num_scans, count).into_vec();
    subset.sort_unstable();
    subset
}

/// The recall of each method on the graph of some scans.
fn judge_methods(
    scene: &Scene,
    run: usize,
    label: &str,
    subset: &[usize],
    graph: &PoseGraph,
) -> Result<Vec<Record>, Failure> {
    let sync = &scene.main_params().sync;
    let mut records = Vec::new();
    for method in METHODS {
        let sync = SyncParams {
            method,
            ..sync.clone()
        };
        let found = synchronize(graph, &sync)?;
        let (poses, components) = (&found.world_from_scan, &found.components);
        let poses = poses_of_subset(scene.scans.len(), subset, poses, components);
        let configuration = format!("{} {label}", method.name());
        let judge = Judge {
            scene,
            configuration: &configuration,
            run,
        };
        let count = subset.len() as f64;
        records.push(Record::new(&configuration, run, NUM_SCANS, count));
        let is_in_subset = |i, j| subset.contains(&i) && subset.contains(&j);
        records.extend(judge.judge_pairs(&poses, is_in_subset)?);
    }
    Ok(records)
}

/// Poses of all scans, of which only some were registered.
fn poses_of_subset(
    num_scans: usize,
    subset: &[usize],
    world_from_scan: &[Isometry3<f64>],
    components: &Components,
) -> WorldPoses {
    let (mut poses, mut labels) = (vec![None; num_scans], vec![usize::MAX; num_scans]);
    for (node, (&scan, pose)) in subset.iter().zip(world_from_scan).enumerate() {
        (poses[scan], labels[scan]) = (Some(*pose), components.label(node));
    }
    WorldPoses::new(poses, labels).expect("one label per pose")
}

pub fn report(
    records: &Selection,
    descriptors: &str,
    figure: &Path,
    text: &mut String,
) -> Result<(), Failure> {
    let lists = lists(records);
    let title = format!("Recall (%) over the number of scans, {descriptors} descriptors");
    let mut header = vec!["scenes, list, method".to_owned()];
    header.extend(SIZES.map(|count| count.to_string()));
    header.push(ALL.to_owned());
    let mut table = Table::new(title, header);
    let large = Selection {
        scenes: records
            .scenes
            .iter()
            .filter(has_all_subsets)
            .copied()
            .collect(),
    };
    let num_large = large.scenes.len();
    if num_large > 1 {
        add_rows(
            &format!("mean of {num_large} with more than 50"),
            &large,
            &lists,
            &mut table,
        );
    }
    for (scene, alone) in records.names().iter().zip(records.alone()) {
        add_rows(scene, &alone, &lists, &mut table);
    }
    table.append_to(text);
    let drawn = if num_large > 0 { &large } else { records };
    let panels: Vec<Panel> = lists.iter().map(|list| panel(drawn, list)).collect();
    Ok(write_figure(figure, &panels)?)
}

/// Scenes without the larger subsets would enter some columns and not others.
fn has_all_subsets((_, records): &&(&str, &[Record])) -> bool {
    let largest = format!("{} {}", METHODS[0], SIZES[SIZES.len() - 1]);
    records.iter().any(|record| record.configuration == largest)
}

/// A row per list and method: the mean over these scenes.
fn add_rows(label: &str, records: &Selection, lists: &[String], table: &mut Table) {
    for list in lists {
        for method in METHODS {
            let mut row = vec![format!("{label}, {list}, {method}")];
            let labels = SIZES.map(|count| count.to_string());
            let recall = |label: &str| records.mean_spread(&format!("{method} {label}"), list);
            row.extend(labels.iter().map(|label| percent(recall(label))));
            row.push(percent(recall(ALL)));
            table.row(row);
        }
    }
}

/// Recall over the number of scans; all scans are the mean size of the scenes.
fn panel(records: &Selection, list: &str) -> Panel {
    let line = |method: Method| {
        let mean = |label: &str, metric: &str| {
            Some(
                records
                    .mean_spread(&format!("{method} {label}"), metric)?
                    .mean,
            )
        };
        let subsets = SIZES.map(|count| Some((count as f64, mean(&count.to_string(), list)?)));
        let all = mean(ALL, NUM_SCANS).and_then(|size| Some((size, mean(ALL, list)?)));
        let points = subsets.into_iter().chain([all]).flatten();
        Series::new(
            method.name(),
            points
                .map(|(size, recall)| (size, 100.0 * recall))
                .collect(),
        )
    };
    Panel::new(list, "scans", "registration recall (%)")
        .y_range(0.0, 100.0)
        .lines(&METHODS.map(line))
}
