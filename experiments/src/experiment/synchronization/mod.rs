//! All synchronization methods on pose graphs with outlier edges.

mod family;
mod problem;
mod report;

use std::fs;
use std::time::Instant;

use gmpcr::sync::{Method, SyncParams, synchronize};
use gmpcr_eval::{Gauge, PoseError, absolute_errors};
use gmpcr_sim::PoseGraphSimParams;
use nalgebra::Isometry3;
use rand::RngExt;
use rayon::prelude::*;

use crate::arguments::Arguments;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::records::{Record, Store, Unit};
use crate::registering::generator;
use crate::scene::fingerprint;

use family::{Family, families};
use problem::Problem;
pub use report::report;

const EXPERIMENT: &str = "sync";
const FILES: &str = "files";
const STATISTICS: [&str; 5] = [
    "rotation mean",
    "rotation median",
    "translation mean",
    "translation median",
    "seconds",
];

/// Units of work: a ratio of outlier edges of a family, or a file.
pub fn num_units(arguments: &Arguments) -> usize {
    let of_families = families()
        .iter()
        .map(|family| family.outliers.len())
        .sum::<usize>();
    of_families + arguments.graphs.len()
}

/// Runs what is not in the store yet.
pub fn run_all(
    arguments: &Arguments,
    store: &mut Store,
    progress: &Progress,
    failures: &mut Vec<String>,
) {
    for family in families() {
        for &percent in family.outliers {
            let label = format!("{}, {percent} % outliers", family.title);
            let unit = Unit {
                experiment: EXPERIMENT,
                descriptors: family.name,
                scene: &scene_of(percent),
                input: "simulated",
            };
            let run = || run_family(&family, percent, arguments);
            run_unit(&unit, label, run, store, progress, failures);
        }
    }
    for file in &arguments.graphs {
        let input = fingerprint(&[file]);
        let unit = Unit {
            experiment: EXPERIMENT,
            descriptors: FILES,
            scene: &file.display().to_string().replace(['/', '\\'], "_"),
            input: &input,
        };
        let label = file.display().to_string();
        let run = || Problem::read(file).and_then(|problem| run_methods(&problem, 0));
        run_unit(&unit, label, run, store, progress, failures);
    }
}

fn run_unit(
    unit: &Unit,
    label: String,
    run: impl FnOnce() -> Result<Vec<Record>, Failure>,
    store: &mut Store,
    progress: &Progress,
    failures: &mut Vec<String>,
) {
    if !store.holds(unit) {
        progress.begin(label.clone());
        let outcome = run().and_then(|records| store.add(unit, records));
        failures.extend(outcome.err().map(|error| format!("{label}: {error}")));
    }
    progress.advance(1);
}

/// Ratios sort as their names do.
fn scene_of(percent: u32) -> String {
    format!("{percent:02}")
}

/// All graphs of a family with this ratio of outlier edges; the first is kept as a file.
fn run_family(
    family: &Family,
    percent: u32,
    arguments: &Arguments,
) -> Result<Vec<Record>, Failure> {
    let mut records = Vec::new();
    for run in 0..family.num_graphs(arguments.runs as usize) {
        let params = PoseGraphSimParams {
            seed: generator(arguments.seed, run, percent as usize).random(),
            outlier_ratio: f64::from(percent) / 100.0,
            ..family.params
        };
        let problem = Problem::simulate(&params)?;
        if run == 0 {
            let folder = arguments.out.join("graphs");
            fs::create_dir_all(&folder)?;
            let file = folder.join(format!("{}_{}.g2o", family.name, scene_of(percent)));
            problem.write(&file, &params)?;
        }
        records.extend(run_methods(&problem, run)?);
    }
    Ok(records)
}

fn run_methods(problem: &Problem, run: usize) -> Result<Vec<Record>, Failure> {
    let records = Method::ALL
        .par_iter()
        .map(|&method| run_method(problem, method, run));
    let records: Result<Vec<_>, Failure> = records.collect();
    Ok(records?.concat())
}

fn run_method(problem: &Problem, method: Method, run: usize) -> Result<Vec<Record>, Failure> {
    let params = SyncParams {
        method,
        ..SyncParams::default()
    };
    let start = Instant::now();
    let found = synchronize(&problem.graph, &params)?;
    let seconds = start.elapsed().as_secs_f64();
    let mut errors = Vec::new();
    for scans in found.components.members() {
        let of_component =
            |poses: &[Isometry3<f64>]| scans.iter().map(|&scan| poses[scan]).collect::<Vec<_>>();
        let estimate = of_component(&found.world_from_scan);
        let ground_truth = of_component(&problem.world_from_scan);
        errors.extend(absolute_errors(
            &estimate,
            &ground_truth,
            Gauge::LeastAbsolute,
        )?);
    }
    let (mean, median) = (PoseError::mean(&errors), PoseError::median(&errors));
    let degrees = |error: Option<PoseError>| error.map(|error| error.rotation_degrees());
    let meters = |error: Option<PoseError>| error.map(|error| error.translation);
    let values = [
        degrees(mean),
        degrees(median),
        meters(mean),
        meters(median),
        Some(seconds),
    ];
    let record = |(statistic, value): (_, Option<f64>)| {
        Some(Record::new(method.name(), run, statistic, value?))
    };
    let records = STATISTICS.into_iter().zip(values).filter_map(record);
    Ok(records.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_written_graph_is_read_as_the_same_problem() {
        let params = PoseGraphSimParams {
            num_scans: 12,
            ..PoseGraphSimParams::default()
        };
        let problem = Problem::simulate(&params).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("graph.g2o");
        problem.write(&file, &params).unwrap();
        let read = Problem::read(&file).unwrap();
        assert_eq!(read.graph.edges().len(), problem.graph.edges().len());
        let [ours, theirs] = [&problem, &read].map(|p| run_methods(p, 0).unwrap());
        for (a, b) in ours
            .iter()
            .zip(&theirs)
            .filter(|(a, _)| a.metric != "seconds")
        {
            assert!((a.value - b.value).abs() < 1e-6, "{a:?}, {b:?}");
        }
        let of_method = |method: Method| {
            ours.iter()
                .filter(move |r| r.configuration == method.name())
        };
        for &method in Method::ALL {
            let error = of_method(method)
                .find(|r| r.metric == "rotation mean")
                .unwrap();
            assert!(error.value < 4.0, "{error:?}");
        }
    }
}
