//! A registration in a screen of text.

use std::fmt::Write;

use gmpcr::{Edge, Warning};

use crate::result::ResultFile;
use crate::table::{counted, significant, table};

/// Overview, edges and warnings; the weakest edges and the first warnings only, unless the user wants all.
pub fn summary(result: &ResultFile, is_verbose: bool) -> String {
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
