//! `gmpcr pair`: the motion between two scans, and the evidence for it.

use std::fmt::Write;

use gmpcr::nalgebra::Isometry3;
use gmpcr::{PairRegistration, register_pair};
use serde_json::json;

use crate::arguments::PairArguments;
use crate::config::Config;
use crate::described::DescribedScans;
use crate::georeference::between_files;
use crate::outcome::{Answer, Failure};
use crate::progress::Progress;
use crate::result::rows;
use crate::scans::files_of;
use crate::table::significant;

pub fn run(arguments: &PairArguments, progress: &Progress) -> Result<Answer, Failure> {
    let config = Config::new(&arguments.tuning)?;
    let files = [arguments.target.clone(), arguments.source.clone()];
    let input = DescribedScans::by_fpfh(&files_of(&files)?, &config, progress)?;
    progress.finish();
    if let Some(problem) = input.clouds.iter().find_map(|cloud| cloud.problem.as_ref()) {
        return Err(problem.as_str().into());
    }
    let ([target, source], [cloud_i, cloud_j]) = (input.scans.as_slice(), input.clouds.as_slice())
    else {
        return Err(format!(
            "{} scans are in the two files: one in each is needed",
            input.scans.len()
        )
        .into());
    };
    let pair = register_pair(target, source, &config.params(input.voxel.size))?;
    let pose = pair.estimate.pose.as_ref();
    let motion = pose.map(|pose| between_files(cloud_i, &pose.target_from_source, cloud_j));
    let json = json!({
        "target": cloud_i.name,
        "source": cloud_j.name,
        "target_from_source": motion.as_ref().map(rows),
        "raw_confidence": pair.raw_confidence,
        "correspondences": pair.correspondences.len(),
        "retained": pair.retained.len(),
        "inlier_ratio": pose.map(|pose| pose.inlier_ratio),
        "clique_size": pose.map(|pose| pose.clique.nodes.len()),
        "mean_affinity": pose.map(|pose| pose.clique.mean_affinity),
        "cliques_seen": pair.estimate.cliques_seen,
        "budget_exhausted": pair.estimate.budget_exhausted,
        "voxel": input.voxel.size,
        "parameters": config.to_json(),
    });
    Ok(Answer {
        text: text(&pair, motion.as_ref(), &input),
        json: Some(json),
        is_complete: motion.is_some(),
    })
}

fn text(
    pair: &PairRegistration,
    motion: Option<&Isometry3<f64>>,
    input: &DescribedScans,
) -> String {
    let [target, source] = [&input.clouds[0].name, &input.clouds[1].name];
    let mut text = String::new();
    match motion {
        Some(motion) => {
            let _ = writeln!(text, "from the frame of {source} into that of {target}");
            for row in rows(motion).chunks(4) {
                for value in row {
                    let _ = write!(text, "{value:>22.15}");
                }
                text.push('\n');
            }
            let [turn, shift] = [
                motion.rotation.angle().to_degrees(),
                motion.translation.vector.norm(),
            ];
            let _ = writeln!(
                text,
                "a turn of {turn:.2}° and a shift of {}\n",
                significant(shift)
            );
        }
        None => {
            let _ = writeln!(
                text,
                "no motion found: {source} and {target} seem to share no surface\n"
            );
        }
    }
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
        ("explained", inliers.unwrap_or("none".into())),
        ("raw confidence", format!("{:.1}", pair.raw_confidence)),
        ("working voxel", significant(input.voxel.size)),
    ];
    for (name, value) in rows {
        let _ = writeln!(text, "{name:<16} {value}");
    }
    text
}
