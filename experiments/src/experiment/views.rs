//! Recall over the number of views registered at once (paper, table "Registration recall under
//! increasing numbers of views"): seeded random subsets of each scene.

use std::path::Path;

use gmpcr::posegraph::{Components, PoseGraph};
use gmpcr::register;
use gmpcr::sync::{Method, SyncParams};
use gmpcr_eval::WorldPoses;
use nalgebra::Isometry3;
use rand::seq::index::sample;

use super::recall::lists;
use crate::arguments::Arguments;
use crate::failure::Failure;
use crate::figures::{Panel, Series, write_figure};
use crate::methods::{sghr, synchronized};
use crate::records::{Record, Selection};
use crate::registering::{Judge, generator, registered, sampled};
use crate::scene::Scene;
use crate::table::{Table, percent};

const NUM_VIEWS: [usize; 5] = [10, 20, 30, 40, 50];
const ALL: &str = "all";
/// The number of views as a metric.
const VIEWS: &str = "views";
const METHODS: [&str; 3] = ["adaptive", "sghr", "consensus"];

pub fn run(scene: &Scene, arguments: &Arguments) -> Result<Vec<Record>, Failure> {
    let num_scans = scene.scans.len();
    let params = scene.main_params();
    let mut records = Vec::new();
    for run in 0..arguments.runs as usize {
        let scans = sampled(scene, params, run);
        for count in NUM_VIEWS.into_iter().filter(|&count| count < num_scans) {
            let views = random_views(scene, run, count);
            let subset: Vec<_> = views.iter().map(|&view| scans[view].clone()).collect();
            let graph = register(&subset, params)?.graph;
            records.extend(judge_methods(
                scene,
                run,
                &count.to_string(),
                &views,
                &graph,
            )?);
        }
        let all: Vec<usize> = (0..num_scans).collect();
        let graph = &registered(scene, params, run)?.graph;
        records.extend(judge_methods(scene, run, ALL, &all, graph)?);
    }
    Ok(records)
}

/// Ascending scans, drawn anew in each run.
fn random_views(scene: &Scene, run: usize, count: usize) -> Vec<usize> {
    let num_scans = scene.scans.len();
    // Purposes up to the number of scans are taken by the sampling.
    let mut rng = generator(scene.seed, run, num_scans + count);
    let mut views = sample(&mut rng, num_scans, count).into_vec();
    views.sort_unstable();
    views
}

/// The recall of each method on the graph of some views.
fn judge_methods(
    scene: &Scene,
    run: usize,
    label: &str,
    views: &[usize],
    graph: &PoseGraph,
) -> Result<Vec<Record>, Failure> {
    let sync = &scene.main_params().sync;
    let mut records = Vec::new();
    for method in [sync.method, sghr(), Method::Consensus] {
        let sync = SyncParams {
            method,
            ..sync.clone()
        };
        let found = synchronized(graph, &sync)?;
        let (poses, components) = (&found.world_from_scan, &found.components);
        let poses = poses_of_views(scene.scans.len(), views, poses, components);
        let configuration = format!("{} {label}", method.name());
        let judge = Judge {
            scene,
            configuration: &configuration,
            run,
        };
        let count = views.len() as f64;
        records.push(Record::new(&configuration, run, VIEWS, count));
        let is_seen = |i, j| views.contains(&i) && views.contains(&j);
        records.extend(judge.judge_pairs(&poses, is_seen)?);
    }
    Ok(records)
}

/// Poses of all scans, of which only some were registered.
fn poses_of_views(
    num_scans: usize,
    views: &[usize],
    world_from_view: &[Isometry3<f64>],
    components: &Components,
) -> WorldPoses {
    let (mut poses, mut labels) = (vec![None; num_scans], vec![usize::MAX; num_scans]);
    for (view, (&scan, pose)) in views.iter().zip(world_from_view).enumerate() {
        (poses[scan], labels[scan]) = (Some(*pose), components.label(view));
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
    let title = format!("Recall (%) over the number of views, {descriptors} descriptors");
    let mut header = vec!["scenes, list, method".to_owned()];
    header.extend(NUM_VIEWS.map(|count| count.to_string()));
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
    let largest = format!("{} {}", METHODS[0], NUM_VIEWS[NUM_VIEWS.len() - 1]);
    records.iter().any(|record| record.configuration == largest)
}

/// A row per list and method: the mean over these scenes.
fn add_rows(label: &str, records: &Selection, lists: &[String], table: &mut Table) {
    for list in lists {
        for method in METHODS {
            let mut row = vec![format!("{label}, {list}, {method}")];
            let labels = NUM_VIEWS.map(|count| count.to_string());
            let recall = |label: &str| records.mean_spread(&format!("{method} {label}"), list);
            row.extend(labels.iter().map(|label| percent(recall(label))));
            row.push(percent(recall(ALL)));
            table.row(row);
        }
    }
}

/// Recall over the number of views, all views being the mean size of the scenes.
fn panel(records: &Selection, list: &str) -> Panel {
    let line = |method: &str| {
        let mean = |label: &str, metric: &str| {
            Some(
                records
                    .mean_spread(&format!("{method} {label}"), metric)?
                    .mean,
            )
        };
        let subsets = NUM_VIEWS.map(|count| Some((count as f64, mean(&count.to_string(), list)?)));
        let all = mean(ALL, VIEWS).and_then(|views| Some((views, mean(ALL, list)?)));
        let points = subsets.into_iter().chain([all]).flatten();
        Series::new(
            method,
            points
                .map(|(views, recall)| (views, 100.0 * recall))
                .collect(),
        )
    };
    Panel::new(list, "views", "registration recall (%)")
        .y_range(0.0, 100.0)
        .lines(&METHODS.map(line))
}
