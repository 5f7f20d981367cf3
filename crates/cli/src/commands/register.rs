//! `gmpcr register`: from scans to poses, pose graph, merged cloud and report.

use std::fmt::Write;
use std::path::Path;

use gmpcr::{Registration, register_observed};
use serde_json::json;

use crate::arguments::RegisterArguments;
use crate::attention::{Notice, NoticeKind, notices};
use crate::config::Config;
use crate::described::{DescribedScans, WorkingVoxel};
use crate::georeference::FileFrames;
use crate::links::Links;
use crate::outcome::{Answer, Failure};
use crate::output::{FILES, Output, prepare};
use crate::progress::Progress;
use crate::result::{EdgeResult, ResultFile};
use crate::scans::files_of;
use crate::table::{counted, significant, table};

pub fn run(
    arguments: &RegisterArguments,
    is_verbose: bool,
    progress: &Progress,
) -> Result<Answer, Failure> {
    let config = Config::new(&arguments.tuning)?;
    let files = files_of(&arguments.inputs)?;
    prepare(&arguments.out, &files)?;
    let input = match &arguments.descriptors {
        Some(folder) => DescribedScans::by_descriptors(&files, folder, &config, progress)?,
        None => DescribedScans::by_fpfh(&files, &config, progress)?,
    };
    check_number(&input)?;
    let params = config.params(input.voxel.size);
    let registration =
        register_observed(&input.scans, &params, progress).map_err(Failure::of_registration)?;
    let frames = FileFrames::of(&registration, &input.clouds);
    let notices = notices(&input.clouds, &registration, &params);
    let result = ResultFile::new(&input, &config, &registration, &frames, notices);
    let output = Output {
        title: &title(arguments),
        input: &input,
        params: &params,
        registration: &registration,
        frames: &frames,
        result: &result,
        thin: arguments.thin.map(|size| size.unwrap_or(input.voxel.size)),
    };
    output.write(&arguments.out, progress)?;
    progress.finish();
    Ok(Answer {
        text: summary(&registration, &input, &result, is_verbose) + &written(&arguments.out),
        json: Some(json!(result)),
        is_complete: registration.components.members().len() == 1,
    })
}

/// A single scan would be in place, but nobody means that.
fn check_number(input: &DescribedScans) -> Result<(), Failure> {
    let readable = input.clouds.iter().filter(|cloud| cloud.problem.is_none());
    if readable.count() >= 2 {
        return Ok(());
    }
    let problems: Vec<_> = input
        .clouds
        .iter()
        .filter_map(|cloud| cloud.problem.as_deref())
        .collect();
    let first = problems
        .first()
        .map_or(String::new(), |problem| format!("; {problem}"));
    Err(format!(
        "{} of {} scans could be read: at least two are needed{first}",
        input.clouds.len() - problems.len(),
        input.clouds.len()
    )
    .into())
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

fn summary(
    registration: &Registration,
    input: &DescribedScans,
    result: &ResultFile,
    is_verbose: bool,
) -> String {
    const FEW: usize = 8;
    let mut text = overview(registration, input, result);
    if is_verbose {
        let _ = write!(
            text,
            "\n{}\n{}",
            scan_table(result),
            edge_table(result, 0..result.edges.len())
        );
    } else {
        let weakest = Links::of(registration).weakest().into_iter().take(5);
        let _ = write!(text, "\nweakest links\n{}", edge_table(result, weakest));
    }
    if !result.notices.is_empty() {
        let _ = writeln!(text, "\ndeserves a look");
    }
    let num_shown = if is_verbose { usize::MAX } else { FEW };
    for notice in result.notices.iter().take(num_shown) {
        let _ = writeln!(text, "- {}", notice.text);
    }
    let num_hidden = result.notices.len().saturating_sub(num_shown);
    if num_hidden > 0 {
        let _ = writeln!(text, "- and {num_hidden} more, see report.html");
    }
    text
}

fn overview(registration: &Registration, input: &DescribedScans, result: &ResultFile) -> String {
    let components = registration.components.members();
    let largest = registration.components.largest().len();
    let WorkingVoxel { size, is_estimated } = input.voxel;
    let origin = if is_estimated {
        "estimated"
    } else {
        "as given"
    };
    let total: f64 = result.stages.iter().map(|stage| stage.seconds).sum();
    let times = result
        .stages
        .iter()
        .map(|stage| format!("{} {}", stage.name, seconds(stage.seconds)));
    let rows = [
        (
            "scans in one frame",
            format!("{largest} of {}", input.clouds.len()),
        ),
        ("components", components.len().to_string()),
        ("on a single edge", on_single_edges(result)),
        (
            "edges",
            format!(
                "{} of {} pairs",
                result.edges.len(),
                result.confidences.len()
            ),
        ),
        ("working voxel", format!("{} ({origin})", significant(size))),
        (
            "time",
            format!(
                "{}: {}",
                seconds(total),
                times.collect::<Vec<_>>().join(", ")
            ),
        ),
    ];
    let mut text = String::new();
    for (name, value) in rows {
        let _ = writeln!(text, "{name:<19} {value}");
    }
    text
}

fn bridges(result: &ResultFile) -> impl Iterator<Item = &Notice> {
    let notices = result.notices.iter();
    notices.filter(|notice| notice.kind == NoticeKind::Bridge)
}

/// How many scans are where they are because of one edge, which nothing confirms.
fn on_single_edges(result: &ResultFile) -> String {
    let mut scans: Vec<usize> = bridges(result)
        .flat_map(|notice| notice.scans.iter().copied())
        .collect();
    scans.sort_unstable();
    scans.dedup();
    counted(scans.len(), "scan")
}

fn scan_table(result: &ResultFile) -> String {
    let rows = result.scans.iter().enumerate().map(|(k, scan)| {
        let edges = result
            .edges
            .iter()
            .filter(|edge| edge.i == k || edge.j == k);
        [
            scan.name.clone(),
            scan.component.to_string(),
            scan.points.to_string(),
            scan.described.to_string(),
            edges.count().to_string(),
        ]
    });
    table(&["scan", "component", "points", "described", "edges"], rows)
}

fn edge_table(result: &ResultFile, positions: impl IntoIterator<Item = usize>) -> String {
    let header = [
        "scans",
        "confidence",
        "inliers",
        "weight before",
        "after",
        "off by",
    ];
    // The result follows a single edge wherever it leads.
    let is_bridge =
        |edge: &EdgeResult| bridges(result).any(|notice| notice.edge == Some((edge.i, edge.j)));
    let rows = positions.into_iter().map(|position| {
        let edge = &result.edges[position];
        let residual = edge.rotation_residual.zip(edge.translation_residual);
        let residual = residual.filter(|_| !is_bridge(edge));
        [
            format!(
                "{} – {}",
                result.scans[edge.i].name, result.scans[edge.j].name
            ),
            format!("{:.3}", edge.confidence),
            format!("{:.0} %", 100.0 * edge.inlier_ratio),
            significant(edge.initial_weight),
            significant(edge.final_weight),
            residual.map_or("-".into(), |(angle, length)| {
                format!("{angle:.1}°, {}", significant(length))
            }),
        ]
    });
    table(&header, rows)
}

fn seconds(time: f64) -> String {
    match time {
        0.0..0.1 => format!("{:.1} ms", 1e3 * time),
        _ => format!("{time:.2} s"),
    }
}
