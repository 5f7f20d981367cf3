//! Recall over the number of views registered at once (paper, table "Registration recall under
//! increasing numbers of views"): seeded random subsets of each scene.

use std::error::Error;
use std::path::Path;

use gmpcr::posegraph::Components;
use gmpcr::register;
use gmpcr::sync::{History, Method, SyncParams, synchronize};
use gmpcr_eval::WorldPoses;
use nalgebra::Isometry3;
use rand::seq::index::sample;

use super::recall::lists;
use crate::arguments::Arguments;
use crate::figures::{Panel, Series, write_figure};
use crate::records::{Record, Selection};
use crate::registering::{Judge, generator, registered, sampled};
use crate::scene::Scene;
use crate::table::{Table, percent};

const NUM_VIEWS: [usize; 5] = [10, 20, 30, 40, 50];
const ALL: &str = "all";
/// The number of views as a metric.
const VIEWS: &str = "views";
const METHODS: [&str; 3] = ["adaptive", "sghr", "consensus"];

pub fn run(scene: &Scene, arguments: &Arguments) -> Result<Vec<Record>, Box<dyn Error>> {
    let num_scans = scene.scans.len();
    let params = scene.main_params();
    let mut records = Vec::new();
    for run in 0..arguments.runs as usize {
        let scans = sampled(scene, params, run);
        let smaller = NUM_VIEWS.into_iter().filter(|&count| count < num_scans);
        for count in smaller.chain([num_scans]) {
            // Purposes up to the number of scans are taken by the sampling.
            let mut rng = generator(scene.seed, run, num_scans + count);
            let mut views = sample(&mut rng, num_scans, count).into_vec();
            views.sort_unstable();
            let subset: Vec<_> = views.iter().map(|&view| scans[view].clone()).collect();
            let graph = if count == num_scans {
                registered(scene, params, run)?.graph.clone()
            } else {
                register(&subset, params)?.graph
            };
            for method in [params.sync.method, History::Sghr.into(), Method::Consensus] {
                let sync = SyncParams {
                    method,
                    ..params.sync.clone()
                };
                let found = synchronize(&graph, &sync);
                let poses =
                    poses_of_views(num_scans, &views, &found.world_from_scan, &found.components);
                let label = if count == num_scans {
                    ALL.to_owned()
                } else {
                    count.to_string()
                };
                let configuration = format!("{} {label}", method.name());
                let judge = Judge {
                    scene,
                    configuration: &configuration,
                    run,
                };
                records.push(Record::new(&configuration, run, VIEWS, count as f64));
                let is_seen = |i, j| views.contains(&i) && views.contains(&j);
                records.extend(judge.judge_pairs(&poses, is_seen)?);
            }
        }
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
) -> Result<(), Box<dyn Error>> {
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
            let share = |label: &str| records.mean_spread(&format!("{method} {label}"), list);
            row.extend(labels.iter().map(|label| percent(share(label))));
            row.push(percent(share(ALL)));
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
                .map(|(views, share)| (views, 100.0 * share))
                .collect(),
        )
    };
    Panel::new(list, "views", "registration recall (%)")
        .y_range(0.0, 100.0)
        .lines(&METHODS.map(line))
}
