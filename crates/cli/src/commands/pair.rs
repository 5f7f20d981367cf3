//! `gmpcr pair`: the transformation between two scans, and its support.

use std::fmt::Write;

use gmpcr::geometry::matrix_rows::rows;
use gmpcr::nalgebra::Isometry3;
use gmpcr::{PairRegistration, register_pair};
use serde_json::{Value, json};

use crate::arguments::PairArguments;
use crate::config::Config;
use crate::input::Input;
use crate::outcome::{Answer, Failure};
use crate::progress::Progress;
use crate::scan_files::files_of;
use crate::table::significant;

pub fn run(arguments: &PairArguments, progress: &Progress) -> Result<Answer, Failure> {
    let config = Config::new(&arguments.tuning)?;
    let files = [arguments.target.clone(), arguments.source.clone()];
    let input = Input::with_fpfh(&files_of(&files)?, &config, progress)?;
    progress.finish();
    if let Some(problem) = input.files.iter().find_map(|file| file.problem.as_ref()) {
        return Err(problem.as_str().into());
    }
    let [target, source] = input.set.scans.as_slice() else {
        return Err(format!(
            "{} scans are in the two files: one in each is needed",
            input.files.len()
        )
        .into());
    };
    let pair = register_pair(target, source, &config.params(input.set.voxel_size))?;
    let pose = pair.estimate.pose.as_ref();
    let target_from_source =
        pose.map(|pose| input.set.between_clouds(0, &pose.target_from_source, 1));
    Ok(Answer {
        text: text(&pair, target_from_source.as_ref(), &input),
        json: Some(json(&pair, target_from_source.as_ref(), &input, &config)),
        is_complete: target_from_source.is_some(),
    })
}

fn json(
    pair: &PairRegistration,
    target_from_source: Option<&Isometry3<f64>>,
    input: &Input,
    config: &Config,
) -> Value {
    let pose = pair.estimate.pose.as_ref();
    json!({
        "target": input.name(0),
        "source": input.name(1),
        "target_from_source": target_from_source.map(rows),
        "raw_confidence": pair.raw_confidence,
        "correspondences": pair.correspondences.len(),
        "retained": pair.retained.len(),
        "inlier_ratio": pose.map(|pose| pose.inlier_ratio),
        "clique_size": pose.map(|pose| pose.clique.nodes.len()),
        "mean_affinity": pose.map(|pose| pose.clique.mean_affinity),
        "cliques_seen": pair.estimate.cliques_seen,
        "budget_exhausted": pair.estimate.budget_exhausted,
        "voxel_size": input.set.voxel_size,
        "parameters": config.to_json(),
    })
}

fn text(
    pair: &PairRegistration,
    target_from_source: Option<&Isometry3<f64>>,
    input: &Input,
) -> String {
    let [target, source] = [0, 1].map(|scan| input.name(scan));
    let mut text = match target_from_source {
        Some(found) => transformation(found, target, source),
        None => {
            format!("no transformation found: {source} and {target} seem to share no surface\n\n")
        }
    };
    let inliers = pair.estimate.pose.as_ref().map(|pose| {
        format!(
            "{:.0} % of the retained ones, clique of {}",
            100.0 * pose.inlier_ratio,
            pose.clique.nodes.len()
        )
    });
    let rows = [
        (
            "correspondences",
            format!(
                "{}, {} retained",
                pair.correspondences.len(),
                pair.retained.len()
            ),
        ),
        ("inliers", inliers.unwrap_or("none".into())),
        ("raw confidence", format!("{:.1}", pair.raw_confidence)),
        ("voxel size", significant(input.set.voxel_size)),
    ];
    for (name, value) in rows {
        let _ = writeln!(text, "{name:<16} {value}");
    }
    text
}

fn transformation(target_from_source: &Isometry3<f64>, target: &str, source: &str) -> String {
    let mut text = format!("from the frame of {source} into that of {target}\n");
    for row in rows(target_from_source).chunks(4) {
        for value in row {
            let _ = write!(text, "{value:>22.15}");
        }
        text.push('\n');
    }
    let _ = writeln!(
        text,
        "a rotation of {:.2}° and a translation of {}\n",
        target_from_source.rotation.angle().to_degrees(),
        significant(target_from_source.translation.vector.norm())
    );
    text
}
