//! `gmpcr eval`: a result against the truth.

use std::fmt::Write;
use std::path::Path;

use gmpcr::nalgebra::Isometry3;
use gmpcr_eval::{
    Gauge, GroundTruthPair, PairErrors, PoseError, Protocol, RotationSign, WorldPoses,
    absolute_errors, registration_recall,
};
use gmpcr_io::{Layout, LogEntry, PairList, read_gt_info, read_gt_log, read_poses, read_scene};
use serde_json::{Map, Value, json};

use crate::arguments::EvalArguments;
use crate::outcome::{Answer, Failure};
use crate::result::ResultFile;
use crate::table::{significant, table};

pub fn run(arguments: &EvalArguments, is_verbose: bool) -> Result<Answer, Failure> {
    let result = ResultFile::read(&arguments.result)?;
    let truth = Truth::read(&arguments.truth)?;
    let components = result.scans.iter().map(|scan| scan.component).collect();
    let poses = result.world_from_scan();
    let estimate = WorldPoses::new(poses.iter().copied().map(Some).collect(), components)?;
    let mut evaluation = Evaluation::default();
    for list in &truth.lists {
        evaluation.judge_list(list, &estimate, is_verbose)?;
    }
    if let Some(world_from_scan) = &truth.world_from_scan {
        evaluation.judge_poses(world_from_scan, &poses, &result, &estimate)?;
    }
    Ok(Answer {
        text: evaluation.text,
        json: Some(Value::Object(evaluation.json)),
        is_complete: result.components.len() == 1,
    })
}

struct Truth {
    lists: Vec<PairList>,
    /// By scan; `None` where a scan has no true pose.
    world_from_scan: Option<Vec<Option<Isometry3<f64>>>>,
}

impl Truth {
    fn read(path: &Path) -> Result<Self, Failure> {
        if path.is_dir() {
            return Self::of_scene(path);
        }
        let is_log = path
            .extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case("log"));
        match is_log {
            true => Ok(Self {
                lists: vec![pair_list(path)?],
                world_from_scan: None,
            }),
            false => Ok(Self {
                lists: Vec::new(),
                world_from_scan: Some(poses(path)?),
            }),
        }
    }

    fn of_scene(folder: &Path) -> Result<Self, Failure> {
        let Some(layout) = Layout::of(folder)? else {
            return Err(format!(
                "{} has the layout of no benchmark: name its file of pairs or poses",
                folder.display()
            )
            .into());
        };
        let truth = read_scene(folder, layout)?.truth;
        Ok(Self {
            lists: truth.match_lists,
            world_from_scan: truth.world_from_scan,
        })
    }
}

/// The pairs of a `.log`, with the matrices of the `.info` of the same name where there is one.
fn pair_list(path: &Path) -> Result<PairList, Failure> {
    let pairs = read_gt_log(path)?;
    let info = path.with_extension("info");
    let information = match info.exists() {
        true => Some(matched_information(&pairs, &info)?),
        false => None,
    };
    Ok(PairList {
        name: path
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
        file: path.to_owned(),
        pairs,
        information,
    })
}

fn matched_information(
    pairs: &[LogEntry],
    info: &Path,
) -> Result<Vec<gmpcr::nalgebra::Matrix6<f64>>, Failure> {
    let entries = read_gt_info(info)?;
    let ends = |k: usize| (pairs[k].i, pairs[k].j);
    let agree = entries.len() == pairs.len()
        && entries
            .iter()
            .enumerate()
            .all(|(k, entry)| (entry.i, entry.j) == ends(k));
    match agree {
        true => Ok(entries.into_iter().map(|entry| entry.information).collect()),
        false => Err(format!(
            "{} does not list the pairs of the .log beside it",
            info.display()
        )
        .into()),
    }
}

fn poses(path: &Path) -> Result<Vec<Option<Isometry3<f64>>>, Failure> {
    let rows = read_poses(path)?;
    let num_scans = rows.iter().map(|(scan, _)| scan + 1).max().unwrap_or(0);
    if num_scans > 10 * rows.len() + 1000 {
        return Err(format!("{}: there is no scan {}", path.display(), num_scans - 1).into());
    }
    let mut poses = vec![None; num_scans];
    for (scan, pose) in rows {
        poses[scan] = Some(pose);
    }
    Ok(poses)
}

#[derive(Default)]
struct Evaluation {
    text: String,
    json: Map<String, Value>,
}

impl Evaluation {
    fn judge_list(
        &mut self,
        list: &PairList,
        poses: &WorldPoses,
        is_verbose: bool,
    ) -> Result<(), Failure> {
        let pairs: Vec<_> = list
            .pairs
            .iter()
            .enumerate()
            .map(|(k, pair)| GroundTruthPair {
                i: pair.i,
                j: pair.j,
                i_from_j: pair.i_from_j,
                information: list
                    .information
                    .as_ref()
                    .map(|all| all[k])
                    .unwrap_or_default(),
            })
            .collect();
        let errors = PairErrors::of_pairs(&pairs, poses)?;
        let within = errors.recall();
        let recall = match &list.information {
            // Lists of pairs of little overlap count consecutive fragments, the others do not.
            Some(_) => {
                let protocol = match list.name.to_ascii_lowercase().contains("lomatch") {
                    true => Protocol::ThreeDLoMatch,
                    false => Protocol::ThreeDMatch,
                };
                registration_recall(&pairs, poses, protocol, RotationSign::Benchmark)?.share()
            }
            None => None,
        };
        let _ = writeln!(self.text, "{} ({} pairs)", list.name, pairs.len());
        if list.information.is_some() {
            let _ = writeln!(self.text, "  registration recall   {}", percent(recall));
        }
        let _ = writeln!(self.text, "  within 15° and 0.3    {}", percent(within));
        let _ = writeln!(
            self.text,
            "  without a common frame {}",
            errors.num_missing()
        );
        if is_verbose {
            self.text += &pair_table(&errors);
        }
        let entry = json!({
            "pairs": pairs.len(),
            "registration_recall": recall,
            "within_15_degrees_and_0.3": within,
            "without_common_frame": errors.num_missing(),
            "mean_error": errors.mean().map(error_json),
            "median_error": errors.median().map(error_json),
        });
        self.json.insert(list.name.clone(), entry);
        Ok(())
    }

    /// Errors of the largest component after the best rigid motion, and of all relative poses.
    fn judge_poses(
        &mut self,
        truth: &[Option<Isometry3<f64>>],
        poses: &[Isometry3<f64>],
        result: &ResultFile,
        estimate: &WorldPoses,
    ) -> Result<(), Failure> {
        if truth.len() > poses.len() {
            return Err(format!(
                "the truth has {} scans, the result {}",
                truth.len(),
                poses.len()
            )
            .into());
        }
        let known = |&scan: &usize| truth.get(scan).copied().flatten();
        let scans: Vec<usize> = (0..poses.len())
            .filter(|scan| known(scan).is_some())
            .collect();
        let pairs = scans
            .iter()
            .enumerate()
            .flat_map(|(k, &i)| scans[k + 1..].iter().map(move |&j| (i, j)));
        let pairs: Vec<_> = pairs
            .filter_map(|(i, j)| {
                Some(GroundTruthPair {
                    i,
                    j,
                    i_from_j: known(&i)?.inv_mul(&known(&j)?),
                    information: Default::default(),
                })
            })
            .collect();
        let relative = PairErrors::of_pairs(&pairs, estimate)?;
        let largest = result
            .components
            .iter()
            .rev()
            .max_by_key(|scans| scans.len());
        let judged: Vec<usize> = largest
            .into_iter()
            .flatten()
            .copied()
            .filter(|scan| known(scan).is_some())
            .collect();
        let estimated: Vec<_> = judged.iter().map(|&scan| poses[scan]).collect();
        let expected: Vec<_> = judged.iter().filter_map(known).collect();
        let absolute = absolute_errors(&estimated, &expected, Gauge::LeastAbsolute)?;

        let _ = writeln!(self.text, "{} scans with a true pose", scans.len());
        let (rotation, translation) = mean_and_median(&absolute);
        let rows = [
            row(
                "relative poses of all pairs",
                relative.mean(),
                relative.median(),
            ),
            vec![
                format!(
                    "absolute poses of the largest frame ({} scans)",
                    judged.len()
                ),
                degrees(rotation[0]),
                degrees(rotation[1]),
                length(translation[0]),
                length(translation[1]),
            ],
        ];
        self.text += &table(
            &[
                "error",
                "rotation: mean",
                "median",
                "translation: mean",
                "median",
            ],
            rows,
        );
        let _ = writeln!(
            self.text,
            "pairs without a common frame {}",
            relative.num_missing()
        );
        let entry = json!({
            "scans": scans.len(),
            "without_common_frame": relative.num_missing(),
            "relative": { "mean": relative.mean().map(error_json), "median": relative.median().map(error_json) },
            "absolute": {
                "scans": judged.len(),
                "mean": { "rotation_degrees": rotation[0], "translation": translation[0] },
                "median": { "rotation_degrees": rotation[1], "translation": translation[1] },
            },
        });
        self.json.insert("poses".into(), entry);
        Ok(())
    }
}

fn pair_table(errors: &PairErrors) -> String {
    let rows = errors.pairs.iter().map(|pair| {
        let error = pair.error.as_ref();
        [
            format!("{} – {}", pair.i, pair.j),
            degrees(error.map(PoseError::rotation_degrees)),
            length(error.map(|error| error.translation)),
        ]
    });
    table(&["pair", "rotation", "translation"], rows)
}

fn mean_and_median(errors: &[PoseError]) -> ([Option<f64>; 2], [Option<f64>; 2]) {
    let of = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        [
            (!values.is_empty()).then_some(mean),
            values.get(values.len() / 2).copied(),
        ]
    };
    (
        of(errors.iter().map(PoseError::rotation_degrees).collect()),
        of(errors.iter().map(|error| error.translation).collect()),
    )
}

fn row(name: &str, mean: Option<PoseError>, median: Option<PoseError>) -> Vec<String> {
    let [turns, shifts] = [
        [&mean, &median].map(|error| degrees(error.as_ref().map(PoseError::rotation_degrees))),
        [&mean, &median].map(|error| length(error.as_ref().map(|error| error.translation))),
    ];
    [name.to_owned()]
        .into_iter()
        .chain(turns)
        .chain(shifts)
        .collect()
}

fn error_json(error: PoseError) -> Value {
    json!({ "rotation_degrees": error.rotation_degrees(), "translation": error.translation })
}

fn percent(share: Option<f64>) -> String {
    share.map_or("no pairs".into(), |share| format!("{:.1} %", 100.0 * share))
}

fn degrees(angle: Option<f64>) -> String {
    angle.map_or("-".into(), |angle| format!("{angle:.3}°"))
}

fn length(length: Option<f64>) -> String {
    length.map_or("-".into(), significant)
}
