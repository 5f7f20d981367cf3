//! `gmpcr eval`: a result against the truth.

use std::fmt::Write;
use std::path::Path;

use gmpcr::nalgebra::{Isometry3, Matrix6};
use gmpcr_eval::{
    Gauge, GroundTruthPair, PairError, PairErrors, PoseError, Protocol, RotationSign, WorldPoses,
    absolute_errors, registration_recall,
};
use gmpcr_io::{Layout, LogEntry, PairList, read_gt_info, read_gt_log, read_poses, read_scene};
use serde_json::{Map, Value, json};

use crate::arguments::EvalArguments;
use crate::outcome::{Answer, Failure};
use crate::result::ResultFile;
use crate::table::{counted, significant, table};

pub fn run(arguments: &EvalArguments, is_verbose: bool) -> Result<Answer, Failure> {
    let result = ResultFile::read(&arguments.result)?;
    let truth = Truth::read(&arguments.truth, result.scans.len())?;
    let components = result.scans.iter().map(|scan| scan.component).collect();
    let world_from_scan = result.world_from_scan();
    let known = world_from_scan.iter().copied().map(Some).collect();
    let mut evaluation = Evaluation {
        arguments,
        result: &result,
        is_verbose,
        estimate: WorldPoses::new(known, components)?,
        text: String::new(),
        json: Map::new(),
    };
    for list in &truth.lists {
        evaluation.judge_list(list)?;
    }
    if let Some(truth) = &truth.world_from_scan {
        evaluation.judge_poses(truth, &world_from_scan)?;
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
    fn read(path: &Path, num_scans: usize) -> Result<Self, Failure> {
        if path.is_dir() {
            return Self::of_scene(path, num_scans);
        }
        let extension = path.extension();
        match extension.is_some_and(|extension| extension.eq_ignore_ascii_case("log")) {
            true => Ok(Self {
                lists: vec![pair_list(path, num_scans)?],
                world_from_scan: None,
            }),
            false => Ok(Self {
                lists: Vec::new(),
                world_from_scan: Some(poses(path, num_scans)?),
            }),
        }
    }

    fn of_scene(folder: &Path, num_scans: usize) -> Result<Self, Failure> {
        let Some(layout) = Layout::of(folder)? else {
            let reason =
                "the folder has the layout of no benchmark: name its file of pairs or poses";
            return Err(Failure::of(folder, reason));
        };
        let scene = read_scene(folder, layout)?;
        if scene.scans.len() != num_scans {
            return Err(other_scans(folder, scene.scans.len(), num_scans));
        }
        Ok(Self {
            lists: scene.truth.match_lists,
            world_from_scan: scene.truth.world_from_scan,
        })
    }
}

fn other_scans(truth: &Path, num_true: usize, num_scans: usize) -> Failure {
    let reason = format!("the truth is of {num_true} scans, the result of {num_scans}");
    Failure::of(truth, reason)
}

/// The pairs of a `.log`, with the matrices of the `.info` of the same name where there is one.
fn pair_list(path: &Path, num_scans: usize) -> Result<PairList, Failure> {
    let pairs = read_gt_log(path)?;
    let Some(last) = pairs.iter().map(|pair| pair.i.max(pair.j)).max() else {
        return Err(Failure::of(path, "there is no pair in it"));
    };
    if last >= num_scans {
        return Err(other_scans(path, last.saturating_add(1), num_scans));
    }
    let info = path.with_extension("info");
    let information = match info.exists() {
        true => Some(information_of(&pairs, &info)?),
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

fn information_of(pairs: &[LogEntry], info: &Path) -> Result<Vec<Matrix6<f64>>, Failure> {
    let entries = read_gt_info(info)?;
    let ends = entries.iter().map(|entry| (entry.i, entry.j));
    if !ends.eq(pairs.iter().map(|pair| (pair.i, pair.j))) {
        return Err(Failure::of(
            info,
            "it does not list the pairs of the .log beside it",
        ));
    }
    Ok(entries.into_iter().map(|entry| entry.information).collect())
}

fn poses(path: &Path, num_scans: usize) -> Result<Vec<Option<Isometry3<f64>>>, Failure> {
    let rows = read_poses(path)?;
    if rows.is_empty() {
        return Err(Failure::of(path, "there is no pose in it"));
    }
    let mut poses = vec![None; num_scans];
    for (scan, pose) in rows {
        match poses.get_mut(scan) {
            Some(place @ None) => *place = Some(pose),
            Some(Some(_)) => return Err(Failure::of(path, format!("scan {scan} has two poses"))),
            None => return Err(other_scans(path, scan.saturating_add(1), num_scans)),
        }
    }
    Ok(poses)
}

struct Evaluation<'a> {
    arguments: &'a EvalArguments,
    result: &'a ResultFile,
    is_verbose: bool,
    estimate: WorldPoses,
    text: String,
    json: Map<String, Value>,
}

impl Evaluation<'_> {
    /// Lists with information matrices have the recall of their benchmark, too, which is in metres.
    fn judge_list(&mut self, list: &PairList) -> Result<(), Failure> {
        let pairs = list
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
            });
        let pairs: Vec<_> = pairs.collect();
        let errors = PairErrors::of_pairs(&pairs, &self.estimate)?;
        let recall = match &list.information {
            Some(_) => {
                let protocol = protocol_of(list);
                let sign = RotationSign::Benchmark;
                registration_recall(&pairs, &self.estimate, protocol, sign)?.share()
            }
            None => None,
        };
        let &EvalArguments {
            max_rotation,
            max_translation,
            ..
        } = self.arguments;
        let within = errors.recall_within(max_rotation.to_radians(), max_translation);
        let _ = writeln!(
            self.text,
            "{} ({})",
            list.name,
            counted(pairs.len(), "pair")
        );
        if list.information.is_some() {
            let recall = percent(recall);
            let _ = writeln!(
                self.text,
                "  registration recall, RMSE below 0.2 m  {recall}"
            );
        }
        let thresholds = format!("within {max_rotation}° and {max_translation}");
        let _ = writeln!(self.text, "  {thresholds:<37}  {}", percent(within));
        let _ = writeln!(
            self.text,
            "  {:<37}  {}",
            "without a common frame",
            errors.num_missing()
        );
        if self.is_verbose {
            self.text += &pair_table(&errors);
        }
        let entry = json!({
            "pairs": pairs.len(),
            "registration_recall": recall,
            "share_within": within,
            "max_rotation_degrees": max_rotation,
            "max_translation": max_translation,
            "without_common_frame": errors.num_missing(),
            "mean_error": errors.mean().map(error_json),
            "median_error": errors.median().map(error_json),
        });
        self.json.insert(list.name.clone(), entry);
        Ok(())
    }

    /// Errors of all relative poses, and of the poses of the largest component after the best motion.
    fn judge_poses(
        &mut self,
        truth: &[Option<Isometry3<f64>>],
        poses: &[Isometry3<f64>],
    ) -> Result<(), Failure> {
        let known: Vec<(usize, Isometry3<f64>)> = truth
            .iter()
            .enumerate()
            .filter_map(|(scan, pose)| Some((scan, (*pose)?)))
            .collect();
        let pairs = known.iter().enumerate().flat_map(|(k, a)| {
            let others = known[k + 1..].iter();
            others.map(move |b| GroundTruthPair {
                i: a.0,
                j: b.0,
                i_from_j: a.1.inv_mul(&b.1),
                information: Matrix6::zeros(),
            })
        });
        let relative = PairErrors::of_pairs(&pairs.collect::<Vec<_>>(), &self.estimate)?;
        let largest = self.result.largest_component();
        let component = |scan: usize| self.result.scans[scan].component;
        let judged = known.iter().filter(|(scan, _)| component(*scan) == largest);
        let (estimated, expected): (Vec<_>, Vec<_>) =
            judged.map(|&(scan, pose)| (poses[scan], pose)).unzip();
        let errors = absolute_errors(&estimated, &expected, Gauge::LeastAbsolute)?;
        let absolute = PairErrors {
            pairs: errors.into_iter().enumerate().map(of_one_scan).collect(),
        };

        let num_judged = counted(absolute.pairs.len(), "scan");
        let rows = [
            row("relative poses of all pairs", &relative),
            row(
                &format!("poses of the largest frame ({num_judged})"),
                &absolute,
            ),
        ];
        let _ = writeln!(
            self.text,
            "{} with a true pose",
            counted(known.len(), "scan")
        );
        let header = [
            "error",
            "rotation: mean",
            "median",
            "translation: mean",
            "median",
        ];
        self.text += &table(&header, rows);
        let _ = writeln!(
            self.text,
            "pairs without a common frame {}",
            relative.num_missing()
        );
        let json = |errors: &PairErrors| {
            json!({
                "mean": errors.mean().map(error_json),
                "median": errors.median().map(error_json),
            })
        };
        let entry = json!({
            "scans": known.len(),
            "without_common_frame": relative.num_missing(),
            "relative": json(&relative),
            "absolute": json(&absolute),
            "absolute_scans": absolute.pairs.len(),
        });
        self.json.insert("poses".into(), entry);
        Ok(())
    }
}

/// Lists of pairs of little overlap count consecutive fragments, others do not.
fn protocol_of(list: &PairList) -> Protocol {
    match list.name.to_ascii_lowercase().contains("lomatch") {
        true => Protocol::ThreeDLoMatch,
        false => Protocol::ThreeDMatch,
    }
}

fn pair_table(errors: &PairErrors) -> String {
    let rows = errors.pairs.iter().map(|pair| {
        let error = pair.error.as_ref();
        [
            format!("{} – {}", pair.i, pair.j),
            degrees(error),
            length(error),
        ]
    });
    table(&["pair", "rotation", "translation"], rows)
}

/// The error of a scan, to be averaged like those of pairs.
fn of_one_scan((scan, error): (usize, PoseError)) -> PairError {
    PairError {
        i: scan,
        j: scan,
        error: Some(error),
    }
}

fn row(name: &str, errors: &PairErrors) -> [String; 5] {
    let (mean, median) = (errors.mean(), errors.median());
    let [mean, median] = [mean.as_ref(), median.as_ref()];
    [
        name.to_owned(),
        degrees(mean),
        degrees(median),
        length(mean),
        length(median),
    ]
}

fn error_json(error: PoseError) -> Value {
    json!({ "rotation_degrees": error.rotation_degrees(), "translation": error.translation })
}

fn percent(share: Option<f64>) -> String {
    share.map_or("no pairs".into(), |share| format!("{:.1} %", 100.0 * share))
}

fn degrees(error: Option<&PoseError>) -> String {
    error.map_or("-".into(), |error| {
        format!("{:.3}°", error.rotation_degrees())
    })
}

fn length(error: Option<&PoseError>) -> String {
    error.map_or("-".into(), |error| significant(error.translation))
}
