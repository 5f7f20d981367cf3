//! The method without its parts (paper, table "Ablation study"), and other synchronization methods on
//! the method's own pose graphs.

use std::collections::BTreeSet;

use gmpcr::posegraph::{PoseGraph, PoseGraphError};
use gmpcr::sync::{Method, SyncParams};
use gmpcr::{Registration, register};
use rayon::prelude::*;

use super::recall::{lists, recall_table};
use crate::arguments::Arguments;
use crate::failure::Failure;
use crate::methods::{sghr, synchronized, without_recovery};
use crate::records::{Record, Selection};
use crate::registering::{Judge, registered, sampled, world_poses};
use crate::scene::Scene;

/// The rows of the paper's table.
pub const ROWS: [&str; 5] = [
    "baseline",
    "+ pair selection",
    "+ spectral filtering",
    "+ memory coefficient",
    "+ recovery term (full)",
];

/// Methods that the paper's table has.
const METHODS_OF_ROWS: [&str; 3] = ["adaptive", "no-recovery", "sghr"];

/// What SGHR's authors use.
const SGHR_ITERATIONS: usize = 50;

pub fn run(scene: &Scene, arguments: &Arguments) -> Result<Vec<Record>, Failure> {
    let mut records = Vec::new();
    for run in 0..arguments.runs as usize {
        let full = scene.main_params();
        let mut without = full.clone();
        without.compatibility.retained_fraction = 1.0;
        without.posegraph.neighbors = scene.scans.len().max(1);

        let found = registered(scene, full, run)?;
        let scans = sampled(scene, &without, run);
        let unselected = register(&scans, &without)?;
        let (graph, complete_graph) = (&found.graph, &unselected.graph);
        let unfiltered_graph = &selected_part(&unselected, full.posegraph.neighbors)?;

        let sync = |method| SyncParams {
            method,
            ..full.sync.clone()
        };
        let longer = SyncParams {
            iterations: SGHR_ITERATIONS,
            ..sync(sghr())
        };
        let mut rows = vec![
            (ROWS[0], complete_graph, sync(sghr())),
            (ROWS[1], unfiltered_graph, sync(sghr())),
            (ROWS[2], graph, sync(sghr())),
            (ROWS[3], graph, without_recovery(&full.sync)),
            (ROWS[4], graph, full.sync.clone()),
            ("sghr, 50 iterations", graph, longer),
        ];
        let methods = Method::ALL.iter().copied();
        let others = methods.filter(|method| !METHODS_OF_ROWS.contains(&method.name()));
        rows.extend(others.map(|method| (method.name(), graph, sync(method))));
        records.extend(judge_rows(scene, run, &rows)?);
    }
    Ok(records)
}

/// The edges of a registration of all pairs that a selection by confidence would have kept.
fn selected_part(unselected: &Registration, neighbors: usize) -> Result<PoseGraph, PoseGraphError> {
    let confidences = &unselected.confidences;
    let ends = |position: usize| {
        let pair = &confidences.pairs()[position];
        (pair.i, pair.j)
    };
    let selected: BTreeSet<_> = confidences
        .top_k_union(neighbors)
        .into_iter()
        .map(ends)
        .collect();
    let edges = unselected.graph.edges().iter();
    let kept = edges.filter(|edge| selected.contains(&(edge.i, edge.j)));
    PoseGraph::new(confidences.num_scans(), kept.copied().collect())
}

type Row<'a> = (&'a str, &'a PoseGraph, SyncParams);

fn judge_rows(scene: &Scene, run: usize, rows: &[Row]) -> Result<Vec<Record>, Failure> {
    let judge = |(configuration, graph, params): &Row| {
        let found = synchronized(graph, params)?;
        let poses = world_poses(&found.world_from_scan, &found.components);
        let judge = Judge {
            scene,
            configuration,
            run,
        };
        Ok(judge.judge(&poses)?)
    };
    let judged: Result<Vec<_>, Failure> = rows.par_iter().map(judge).collect();
    Ok(judged?.concat())
}

pub fn report(records: &Selection, descriptors: &str, text: &mut String) {
    let (rows, others): (Vec<_>, Vec<_>) = records
        .configurations()
        .into_iter()
        .partition(|row| ROWS.contains(&row.as_str()));
    let methods: Vec<String> = std::iter::once(ROWS[4].to_owned()).chain(others).collect();
    for list in lists(records) {
        let title = format!("Ablation, recall (%), list {list}, {descriptors} descriptors");
        recall_table(title, &rows, &list, records).append_to(text);
    }
    for list in lists(records) {
        let title = format!(
            "Synchronization methods on the same pose graphs, recall (%), list {list}, {descriptors} descriptors"
        );
        recall_table(title, &methods, &list, records).append_to(text);
    }
}
