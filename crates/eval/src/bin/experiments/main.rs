//! The paper's experiments on the scenes of a folder.
//!
//! ```text
//! cargo run --release -p gmpcr-eval --bin experiments -- FOLDER                     # FPFH
//! cargo run --release -p gmpcr-eval --bin experiments -- FOLDER --descriptors DIR   # learned ones too
//! cargo run --release -p gmpcr-eval --bin experiments -- --only sync                # needs no data
//! ```
//!
//! Prints tables in the paper's shape beside the paper's own figures and writes them, the records
//! that they are made of, and figures to a folder. Records are kept per experiment and scene: a run
//! that was stopped goes on where it was. A scene that fails is reported, and the others go on.

mod arguments;
mod experiment;
mod figures;
mod records;
mod reference;
mod registering;
mod scene;
mod table;

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};

use arguments::Arguments;
use experiment::Experiment;
use records::{Store, Unit};
use scene::{SceneSource, scene_sources};

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
fn run(arguments: &Arguments) -> Result<Vec<String>, Box<dyn Error>> {
    let start = Instant::now();
    let mut store = Store::open(&arguments.out, &arguments.settings(), arguments.fresh)?;
    let mut failures = Vec::new();
    let sources = match &arguments.folder {
        Some(folder) => scene_sources(folder, arguments, &mut failures)?,
        None => Vec::new(),
    };
    let experiments = arguments.experiments();
    let (on_scenes, on_graphs): (Vec<_>, Vec<_>) = experiments
        .iter()
        .copied()
        .partition(|experiment| experiment.needs_scenes());

    let progress = progress_bar(sources.len() * on_scenes.len() + on_graphs.len());
    for source in &sources {
        let outcome = run_scene(source, &on_scenes, arguments, &mut store, &progress);
        failures.extend(outcome.err().unwrap_or_default());
    }
    if !on_graphs.is_empty() {
        let outcome = experiment::synchronization::run_all(arguments, &mut store, &progress);
        failures.extend(outcome.err().unwrap_or_default());
    }
    progress.finish_and_clear();

    let mut text = String::new();
    for experiment in experiments {
        experiment.report(&store, &arguments.out, &mut text)?;
    }
    println!("{text}");
    records::write_text(&arguments.out.join("tables.md"), &text)?;
    println!(
        "{:.1} s; tables, records and figures are in {}",
        start.elapsed().as_secs_f64(),
        arguments.out.display()
    );
    Ok(failures)
}

/// Runs the experiments on one scene that are not in the store yet.
fn run_scene(
    source: &SceneSource,
    experiments: &[Experiment],
    arguments: &Arguments,
    store: &mut Store,
    progress: &ProgressBar,
) -> Result<(), Vec<String>> {
    let unit = |experiment: Experiment| Unit {
        experiment: experiment.name(),
        descriptors: source.descriptors.name(),
        scene: source.name(),
    };
    let pending = experiments.iter().filter(|e| !store.holds(&unit(**e)));
    let pending: Vec<Experiment> = pending.copied().collect();
    progress.inc((experiments.len() - pending.len()) as u64);
    if pending.is_empty() {
        return Ok(());
    }
    let label = format!("{}, {}", source.name(), source.descriptors.name());
    progress.set_message(label.clone());
    let scene = source.load(arguments).map_err(|error| {
        progress.inc(pending.len() as u64);
        vec![format!("{label}: {error}")]
    })?;
    let mut failures = Vec::new();
    for experiment in pending {
        progress.set_message(format!("{label}: {}", experiment.name()));
        let outcome = experiment
            .run(&scene, arguments)
            .and_then(|records| Ok(store.add(unit(experiment), records)?));
        if let Err(error) = outcome {
            failures.push(format!("{label}, {}: {error}", experiment.name()));
        }
        progress.inc(1);
    }
    if failures.is_empty() {
        Ok(())
    } else {
        Err(failures)
    }
}

/// A bar on standard error; none where that is not a terminal.
fn progress_bar(length: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {elapsed} (eta {eta}) {msg}");
    let bar = ProgressBar::new(length as u64);
    match style {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
