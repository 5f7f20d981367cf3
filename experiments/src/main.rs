//! The paper's experiments on the scenes of a folder.
//!
//! ```text
//! cargo run --release -p gmpcr-experiments -- FOLDER                     # FPFH
//! cargo run --release -p gmpcr-experiments -- FOLDER --descriptors DIR   # learned ones too
//! cargo run --release -p gmpcr-experiments -- --only sync                # needs no data
//! ```
//!
//! Prints tables in the paper's shape beside the paper's own figures and writes them, the records
//! that they are made of, and figures to a folder. Records are kept per experiment and scene: a run
//! that was stopped goes on where it was. A scene that fails is reported, and the others go on.

mod arguments;
mod experiment;
mod failure;
mod figures;
mod progress;
mod records;
mod reference;
mod registering;
mod scene;
mod table;

use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use gmpcr_io::write_text;

use arguments::Arguments;
use experiment::{Experiment, synchronization};
use failure::Failure;
use progress::Progress;
use records::{Store, Unit};
use scene::{SceneSource, Sources};

/// Some scene or experiment failed; the results of the others are there.
const PARTIAL: u8 = 2;

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(failures) if failures.is_empty() => ExitCode::SUCCESS,
        Ok(failures) => {
            eprintln!("\n{} failed:", failures.len());
            failures.iter().for_each(|failure| eprintln!("  {failure}"));
            ExitCode::from(PARTIAL)
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Runs what is not in the store yet, then reports. Returns what failed.
fn run(arguments: &Arguments) -> Result<Vec<String>, Failure> {
    let start = Instant::now();
    arguments.check()?;
    let mut store = Store::open(&arguments.out, &arguments.settings(), arguments.fresh)?;
    let mut sources = Sources::find(arguments)?;
    run_pending(arguments, &mut sources, &mut store);
    let mut failures = sources.failures;
    failures.extend(report(arguments, &store, &sources.notes));
    println!(
        "{:.1} s; tables, records and figures are in {}",
        start.elapsed().as_secs_f64(),
        arguments.out.display()
    );
    Ok(failures)
}

/// Runs what is not in the store yet; what fails is added to the failures of the sources.
fn run_pending(arguments: &Arguments, sources: &mut Sources, store: &mut Store) {
    let experiments = arguments.experiments();
    let of_scenes: Vec<_> = experiments.iter().filter(|e| e.needs_scenes()).collect();
    let Sources {
        scenes, failures, ..
    } = sources;
    let mut num_units = scenes.len() * of_scenes.len();
    if experiments.contains(&Experiment::Sync) {
        num_units += synchronization::num_units(arguments);
    }
    let progress = Progress::new(num_units);
    for scene in scenes {
        run_scene(scene, &of_scenes, arguments, store, &progress, failures);
    }
    if experiments.contains(&Experiment::Sync) {
        synchronization::run_all(arguments, store, &progress, failures);
    }
    progress.finish();
}

/// Prints and writes the tables, and draws the figures. Returns what failed.
fn report(arguments: &Arguments, store: &Store, notes: &[String]) -> Vec<String> {
    let (mut text, mut failures) = (String::new(), Vec::new());
    for experiment in arguments.experiments() {
        let outcome = experiment.report(store, &arguments.out, &mut text);
        failures.extend(outcome.err().map(|error| error.to_string()));
    }
    for note in notes {
        text.push_str(&format!("\n{note}\n"));
    }
    println!("{text}");
    let outcome = write_text(arguments.out.join("tables.md"), &text);
    failures.extend(outcome.err().map(|error| error.to_string()));
    failures
}

/// Runs the experiments on one scene that are not in the store yet.
fn run_scene(
    source: &SceneSource,
    experiments: &[&Experiment],
    arguments: &Arguments,
    store: &mut Store,
    progress: &Progress,
    failures: &mut Vec<String>,
) {
    let unit = |experiment: Experiment| Unit {
        experiment: experiment.name(),
        descriptors: source.descriptors.name(),
        scene: source.name(),
        input: source.input(),
    };
    let is_pending = |experiment: &Experiment| !store.holds(&unit(*experiment));
    let mut pending: Vec<Experiment> = experiments.iter().map(|e| **e).collect();
    pending.retain(is_pending);
    progress.advance(experiments.len() - pending.len());
    if pending.is_empty() {
        return;
    }
    let label = format!("{}, {}", source.name(), source.descriptors.name());
    progress.begin(format!("{label}: reading"));
    let scene = match source.load(arguments) {
        Ok(scene) => scene,
        Err(error) => {
            failures.push(format!("{label}: {error}"));
            return progress.advance(pending.len());
        }
    };
    for experiment in pending {
        progress.begin(format!("{label}: {}", experiment.name()));
        let outcome = experiment
            .run(&scene, arguments)
            .and_then(|records| store.add(&unit(experiment), records));
        if let Err(error) = outcome {
            failures.push(format!("{label}, {}: {error}", experiment.name()));
        }
        progress.advance(1);
    }
}
