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
use crate::reference;
use crate::registering::{Judge, generator, registered, sampled, threedmatch};
use crate::scene::Scene;
use crate::table::{Table, percent};

const NUM_VIEWS: [usize; 5] = [10, 20, 30, 40, 50];
const ALL: &str = "all";
const METHODS: [&str; 3] = ["adaptive", "sghr", "consensus"];

pub fn run(scene: &Scene, arguments: &Arguments) -> Result<Vec<Record>, Box<dyn Error>> {
    let num_scans = scene.scans.len();
    let params = threedmatch(arguments);
    let mut records = Vec::new();
    for run in 0..arguments.runs as usize {
        let scans = sampled(&scene.scans, &params, run, arguments);
        let smaller = NUM_VIEWS.into_iter().filter(|&count| count < num_scans);
        for count in smaller.chain([num_scans]) {
            // Purposes up to the number of scans are taken by the sampling.
            let mut rng = generator(arguments.seed, run, num_scans + count);
            let mut views = sample(&mut rng, num_scans, count).into_vec();
            views.sort_unstable();
            let subset: Vec<_> = views.iter().map(|&view| scans[view].clone()).collect();
            let graph = if count == num_scans {
                registered(scene, &params, run, arguments)?.graph.clone()
            } else {
                register(&subset, &params)?.graph
            };
            for method in [Method::default(), History::Sghr.into(), Method::Consensus] {
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
    let title =
        format!("Registration recall (%) over the number of views, {descriptors} descriptors");
    let mut header = vec!["list, method".to_owned()];
    header.extend(NUM_VIEWS.map(|count| count.to_string()));
    header.push(ALL.to_owned());
    let mut table = Table::new(title, header);
    let mut panels = Vec::new();
    for list in &lists {
        let mut lines = Vec::new();
        for method in METHODS {
            let share = |label: &str| records.mean_spread(&format!("{method} {label}"), list);
            let labels = NUM_VIEWS.map(|count| count.to_string());
            let mut row = vec![format!("{list}, {method}")];
            row.extend(labels.iter().map(|label| percent(share(label))));
            row.push(percent(share(ALL)));
            table.row(row);
            let points = NUM_VIEWS
                .iter()
                .zip(&labels)
                .filter_map(|(&count, label)| Some((count as f64, 100.0 * share(label)?.mean)));
            let all = share(ALL).map(|spread| (60.0, 100.0 * spread.mean));
            lines.push(Series::new(method, points.chain(all).collect()));
        }
        let panel = Panel::new(list, "views (60: all)", "registration recall (%)");
        panels.push(panel.y_range(0.0, 100.0).lines(&lines));
    }
    table.append_to(text);
    reference::views_table().append_to(text);
    Ok(write_figure(figure, &panels)?)
}
