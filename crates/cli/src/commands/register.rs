//! `gmpcr register`: from scans to poses, pose graph, merged cloud and report.

use std::fmt::Write;
use std::path::Path;

use gmpcr::{Edge, Warning, register_observed};
use serde_json::json;

use crate::arguments::RegisterArguments;
use crate::config::Config;
use crate::input::Input;
use crate::outcome::{Answer, Failure};
use crate::output::{FILES, Output, prepare};
use crate::progress::Progress;
use crate::result::ResultFile;
use crate::scan_files::files_of;
use crate::table::{counted, significant, table};
use crate::warnings::in_words;

pub fn run(
    arguments: &RegisterArguments,
    is_verbose: bool,
    progress: &Progress,
) -> Result<Answer, Failure> {
    let config = Config::new(&arguments.tuning)?;
    let files = files_of(&arguments.inputs)?;
    prepare(&arguments.out, &files)?;
    let input = match &arguments.descriptors {
        Some(folder) => Input::with_descriptors(&files, folder, &config, progress)?,
        None => Input::with_fpfh(&files, &config, progress)?,
    };
    check_number(&input)?;
    let params = config.params(input.set.voxel_size);
    let registration =
        register_observed(&input.set.scans, &params, progress).map_err(Failure::of_registration)?;
    let warnings = in_words(&input, &registration, registration.warnings(&params));
    let world_from_local = registration.world_from_scan.clone();
    let registration = input.set.in_cloud_frames(registration);
    let result = ResultFile::new(&input, &config, registration, warnings);
    let voxel_size = input.set.voxel_size;
    let output = Output {
        title: &title(arguments),
        input: &input,
        params: &params,
        result: &result,
        world_from_local: &world_from_local,
        downsample: arguments.downsample.map(|size| size.unwrap_or(voxel_size)),
    };
    output.write(&arguments.out, progress)?;
    progress.finish();
    Ok(Answer {
        text: summary(&result, is_verbose) + &written(&arguments.out),
        json: Some(json!(result)),
        is_complete: result.registration.components.members().len() == 1,
    })
}

/// A single scan would be in place, but nobody means that.
fn check_number(input: &Input) -> Result<(), Failure> {
    let files = input.files.iter();
    let problems: Vec<_> = files.filter_map(|file| file.problem.as_deref()).collect();
    let (num_files, num_readable) = (input.files.len(), input.files.len() - problems.len());
    if num_readable >= 2 {
        return Ok(());
    }
    let first = problems.first();
    let first = first.map_or(String::new(), |problem| format!("; {problem}"));
    let reason =
        format!("{num_readable} of {num_files} scans could be read: at least two are needed");
    Err((reason + &first).into())
}

/// The folder of the first input, or of the descriptors.
fn title(arguments: &RegisterArguments) -> String {
    let first = arguments.inputs.first().or(arguments.descriptors.as_ref());
    let first = first.and_then(|path| path.canonicalize().ok());
    let folder = first.map(|path| match path.is_dir() {
        true => path,
        false => path.parent().map(Path::to_owned).unwrap_or(path),
    });
    let name = folder.as_deref().and_then(Path::file_name);
    name.map_or("scans".into(), |name| name.to_string_lossy().into_owned())
}

fn written(folder: &Path) -> String {
    let names = FILES.map(|(name, _)| name);
    format!("\n{} written to {}\n", names.join(", "), folder.display())
}

fn summary(result: &ResultFile, is_verbose: bool) -> String {
    const FEW: usize = 8;
    let mut text = overview(result);
    let edges = &result.registration.edges;
    if is_verbose {
        let _ = write!(
            text,
            "\n{}\n{}",
            scan_table(result),
            edge_table(result, 0..edges.len())
        );
    } else {
        let weakest = result.registration.weakest_edges().into_iter().take(5);
        let _ = write!(text, "\nweakest edges\n{}", edge_table(result, weakest));
    }
    if !result.warnings.is_empty() {
        let _ = writeln!(text, "\nwarnings");
    }
    let num_shown = if is_verbose { usize::MAX } else { FEW };
    for finding in result.warnings.iter().take(num_shown) {
        let _ = writeln!(text, "- {}", finding.text);
    }
    let num_hidden = result.warnings.len().saturating_sub(num_shown);
    if num_hidden > 0 {
        let _ = writeln!(text, "- and {num_hidden} more, see report.html");
    }
    text
}

fn overview(result: &ResultFile) -> String {
    let registration = &result.registration;
    let components = &registration.components;
    let (num_edges, num_pairs) = (
        registration.edges.len(),
        registration.confidences.pairs().len(),
    );
    let origin = match result.voxel_is_estimated {
        true => "estimated",
        false => "as given",
    };
    let rows = [
        (
            "scans in one frame",
            format!("{} of {}", components.largest().len(), result.scans.len()),
        ),
        ("components", components.members().len().to_string()),
        ("behind a bridge", behind_bridges(result)),
        ("edges", format!("{num_edges} of {num_pairs} scored pairs")),
        (
            "voxel size",
            format!("{} ({origin})", significant(result.voxel_size)),
        ),
        ("time", times(result)),
    ];
    let mut text = String::new();
    for (name, value) in rows {
        let _ = writeln!(text, "{name:<19} {value}");
    }
    text
}

fn times(result: &ResultFile) -> String {
    let total: f64 = result.stages.iter().map(|stage| stage.seconds).sum();
    let stages = result.stages.iter();
    let stages = stages.map(|stage| format!("{} {}", stage.name, seconds(stage.seconds)));
    let stages: Vec<_> = stages.collect();
    format!("{}: {}", seconds(total), stages.join(", "))
}

/// How many scans a bridge alone connects to the rest: nothing confirms their poses.
fn behind_bridges(result: &ResultFile) -> String {
    let mut scans: Vec<usize> = result
        .warnings
        .iter()
        .filter_map(|finding| match &finding.warning {
            Warning::Bridge { scans, .. } => Some(scans),
            _ => None,
        })
        .flatten()
        .copied()
        .collect();
    scans.sort_unstable();
    scans.dedup();
    counted(scans.len(), "scan")
}

fn scan_table(result: &ResultFile) -> String {
    let registration = &result.registration;
    let rows = result.scans.iter().enumerate().map(|(k, scan)| {
        let edges = registration.edges.iter();
        let edges = edges.filter(|edge| edge.i == k || edge.j == k);
        [
            scan.name.clone(),
            registration.components.label(k).to_string(),
            scan.points.to_string(),
            scan.with_features.to_string(),
            edges.count().to_string(),
        ]
    });
    table(
        &["scan", "component", "points", "with features", "edges"],
        rows,
    )
}

fn edge_table(result: &ResultFile, positions: impl IntoIterator<Item = usize>) -> String {
    let header = [
        "scans",
        "confidence",
        "inliers",
        "weight before",
        "after",
        "residual",
    ];
    // The result follows a bridge wherever it leads, so that its residual says nothing.
    let mut is_bridge = vec![false; result.registration.edges.len()];
    for finding in &result.warnings {
        if let Warning::Bridge { edge, .. } = finding.warning {
            is_bridge[edge] = true;
        }
    }
    let row = |position: usize| {
        edge_row(
            result,
            &result.registration.edges[position],
            is_bridge[position],
        )
    };
    table(&header, positions.into_iter().map(row))
}

fn edge_row(result: &ResultFile, edge: &Edge, is_bridge: bool) -> [String; 6] {
    let report = &edge.synchronization;
    let residual = report.rotation_residual.zip(report.translation_residual);
    let residual = residual.filter(|_| !is_bridge);
    [
        format!(
            "{} – {}",
            result.scans[edge.i].name, result.scans[edge.j].name
        ),
        format!("{:.3}", edge.confidence),
        format!("{:.0} %", 100.0 * edge.inlier_ratio),
        significant(report.initial_weight),
        significant(report.final_weight),
        residual.map_or("-".into(), |(angle, length)| {
            format!("{:.1}°, {}", angle.to_degrees(), significant(length))
        }),
    ]
}

fn seconds(time: f64) -> String {
    match time {
        0.0..0.1 => format!("{:.1} ms", 1e3 * time),
        _ => format!("{time:.2} s"),
    }
}
