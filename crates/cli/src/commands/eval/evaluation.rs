//! Recalls and errors, in words and numbers.

use std::fmt::Write;

use gmpcr::nalgebra::Isometry3;
use gmpcr_eval::{
    Gauge, GroundTruthPair, PairErrors, PoseError, Protocol, WorldPoses, absolute_errors,
    registration_recall,
};
use gmpcr_io::PairList;
use serde_json::{Map, Value, json};

use super::estimate::Estimate;
use crate::arguments::EvalArguments;
use crate::outcome::Failure;
use crate::table::{counted, significant, table};

/// The text and the JSON of an evaluation, which grow judgment by judgment.
pub struct Evaluation<'a> {
    arguments: &'a EvalArguments,
    is_verbose: bool,
    estimate: &'a Estimate,
    poses: WorldPoses,
    pub text: String,
    pub json: Map<String, Value>,
}

impl<'a> Evaluation<'a> {
    pub fn new(
        estimate: &'a Estimate,
        arguments: &'a EvalArguments,
        is_verbose: bool,
    ) -> Result<Self, Failure> {
        let poses = estimate.world_from_scan.iter().copied().map(Some);
        Ok(Self {
            arguments,
            is_verbose,
            estimate,
            poses: WorldPoses::new(poses.collect(), estimate.labels.clone())?,
            text: String::new(),
            json: Map::new(),
        })
    }

    /// Lists with information matrices have the recall of their benchmark, too, which is in meters.
    pub fn judge_list(&mut self, list: &PairList) -> Result<(), Failure> {
        let entries = list
            .pairs
            .iter()
            .map(|pair| (pair.i, pair.j, pair.i_from_j));
        let pairs = GroundTruthPair::of_list(entries, list.information.as_deref())?;
        let errors = PairErrors::of_pairs(&pairs, &self.poses)?;
        let protocol = Protocol::of_list(&list.name, list.information.is_some());
        let recall = protocol.map(|protocol| registration_recall(&pairs, &self.poses, protocol));
        let recall = recall.transpose()?.map(|recall| recall.ratio());
        let &EvalArguments {
            max_rotation,
            max_translation,
            ..
        } = self.arguments;
        let within = errors.recall_within(max_rotation.to_radians(), max_translation);
        self.print_list(list, recall, within, &errors);
        let entry = json!({
            "pairs": pairs.len(),
            "registration_recall": recall.flatten(),
            "ratio_within": within,
            "max_rotation_degrees": max_rotation,
            "max_translation": max_translation,
            "without_common_frame": errors.num_missing(),
            "mean_error": errors.mean().map(error_json),
            "median_error": errors.median().map(error_json),
        });
        self.json.insert(list.name.clone(), entry);
        Ok(())
    }

    /// `recall` is that of the benchmark, if it has one; it and `within` are `None` of no pairs.
    fn print_list(
        &mut self,
        list: &PairList,
        recall: Option<Option<f64>>,
        within: Option<f64>,
        errors: &PairErrors,
    ) {
        let num_pairs = counted(list.pairs.len(), "pair");
        let _ = writeln!(self.text, "{} ({num_pairs})", list.name);
        let thresholds = format!(
            "within {}° and {}",
            self.arguments.max_rotation, self.arguments.max_translation
        );
        let mut rows = vec![
            (thresholds, percent(within)),
            (
                "without a common frame".into(),
                errors.num_missing().to_string(),
            ),
        ];
        if let Some(recall) = recall {
            let name = "registration recall, RMSE below 0.2 m".into();
            rows.insert(0, (name, percent(recall)));
        }
        for (name, value) in rows {
            let _ = writeln!(self.text, "  {name:<37}  {value}");
        }
        if self.is_verbose {
            self.text += &pair_table(errors);
        }
    }

    /// Errors of all relative poses, and of the poses of the largest component after the best alignment.
    pub fn judge_poses(&mut self, ground_truth: &[Option<Isometry3<f64>>]) -> Result<(), Failure> {
        let known = ground_truth.iter().enumerate();
        let known: Vec<(usize, Isometry3<f64>)> = known
            .filter_map(|(scan, pose)| Some((scan, (*pose)?)))
            .collect();
        let relative =
            PairErrors::of_pairs(&GroundTruthPair::all_pairs(ground_truth), &self.poses)?;
        let absolute = self.absolute_errors(&known)?;
        let num_judged = counted(absolute.len(), "scan");
        let of_frame = format!("poses of the largest frame ({num_judged})");
        let relative_errors = [relative.mean(), relative.median()];
        let absolute_errors = [PoseError::mean(&absolute), PoseError::median(&absolute)];
        let rows = [
            row("relative poses of all pairs", relative_errors),
            row(&of_frame, absolute_errors),
        ];
        let header = [
            "error",
            "rotation: mean",
            "median",
            "translation: mean",
            "median",
        ];
        let num_known = counted(known.len(), "scan");
        let num_missing = relative.num_missing();
        let _ = writeln!(self.text, "{num_known} with a known pose");
        self.text += &table(&header, rows);
        let _ = writeln!(self.text, "pairs without a common frame {num_missing}");
        let json = |[mean, median]: [Option<PoseError>; 2]| {
            let [mean, median] = [mean, median].map(|error| error.map(error_json));
            json!({ "mean": mean, "median": median })
        };
        let entry = json!({
            "scans": known.len(),
            "without_common_frame": num_missing,
            "relative": json(relative_errors),
            "absolute": json(absolute_errors),
            "absolute_scans": absolute.len(),
        });
        self.json.insert("poses".into(), entry);
        Ok(())
    }

    /// Of the scans of the largest component.
    fn absolute_errors(
        &self,
        known: &[(usize, Isometry3<f64>)],
    ) -> Result<Vec<PoseError>, Failure> {
        let largest = self.estimate.largest_component();
        let judged = known.iter();
        let judged = judged.filter(|(scan, _)| self.estimate.labels[*scan] == largest);
        let (estimated, expected): (Vec<_>, Vec<_>) = judged
            .map(|&(scan, pose)| (self.estimate.world_from_scan[scan], pose))
            .unzip();
        Ok(absolute_errors(
            &estimated,
            &expected,
            Gauge::LeastAbsolute,
        )?)
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

fn row(name: &str, errors: [Option<PoseError>; 2]) -> [String; 5] {
    let [mean, median] = errors.each_ref().map(Option::as_ref);
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

fn percent(ratio: Option<f64>) -> String {
    ratio.map_or("no pairs".into(), |ratio| format!("{:.1} %", 100.0 * ratio))
}

fn degrees(error: Option<&PoseError>) -> String {
    error.map_or("-".into(), |error| {
        format!("{:.3}°", error.rotation_degrees())
    })
}

fn length(error: Option<&PoseError>) -> String {
    error.map_or("-".into(), |error| significant(error.translation))
}
