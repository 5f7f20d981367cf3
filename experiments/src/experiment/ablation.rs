//! The method without its parts (paper, table "Ablation study"), and other synchronization methods on
//! the method's own pose graphs.

use std::collections::BTreeSet;

use gmpcr::posegraph::{PoseGraph, PoseGraphParams};
use gmpcr::sync::{Method, SyncParams, synchronize};
use gmpcr::{Registration, register};
use rayon::prelude::*;

use super::recall::{lists, recall_table};
use crate::arguments::Arguments;
use crate::failure::Failure;
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
const METHODS_OF_ROWS: [Method; 3] = [Method::Adaptive, Method::NoRecovery, Method::Sghr];

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
        let (graph, complete_graph) = (&found.pose_graph(), &unselected.pose_graph());
        let unfiltered_graph = &selected_part(&unselected, complete_graph, &full.posegraph)?;

        let sync = |method| SyncParams {
            method,
            ..full.sync.clone()
        };
        let longer = SyncParams {
            iterations: SGHR_ITERATIONS,
            ..sync(Method::Sghr)
        };
        let mut rows = vec![
            (ROWS[0], complete_graph, sync(Method::Sghr)),
            (ROWS[1], unfiltered_graph, sync(Method::Sghr)),
            (ROWS[2], graph, sync(Method::Sghr)),
            (ROWS[3], graph, sync(Method::NoRecovery)),
            (ROWS[4], graph, full.sync.clone()),
            ("sghr, 50 iterations", graph, longer),
        ];
        let methods = Method::ALL.iter().copied();
        let others = methods.filter(|method| !METHODS_OF_ROWS.contains(method));
        rows.extend(others.map(|method| (method.name(), graph, sync(method))));
        records.extend(judge_rows(scene, run, &rows)?);
    }
    Ok(records)
}

/// The edges of a registration of all pairs that a selection by confidence would have kept.
fn selected_part(
    unselected: &Registration,
    complete_graph: &PoseGraph,
    params: &PoseGraphParams,
) -> Result<PoseGraph, Failure> {
    let confidences = &unselected.confidences;
    let ends = |position: usize| {
        let pair = &confidences.pairs()[position];
        (pair.i, pair.j)
    };
    let selected: BTreeSet<_> = confidences
        .top_k_union(params)?
        .into_iter()
        .map(ends)
        .collect();
    let edges = complete_graph.edges().iter();
    let kept = edges.filter(|edge| selected.contains(&(edge.i, edge.j)));
    Ok(PoseGraph::new(
        confidences.num_scans(),
        kept.copied().collect(),
    )?)
}

type Row<'a> = (&'a str, &'a PoseGraph, SyncParams);

fn judge_rows(scene: &Scene, run: usize, rows: &[Row]) -> Result<Vec<Record>, Failure> {
    let judge = |(configuration, graph, params): &Row| {
        let found = synchronize(graph, params)?;
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
