//! `gmpcr eval`: a result against the ground truth.

mod estimate;
mod evaluation;
mod ground_truth;

use serde_json::Value;

use crate::arguments::EvalArguments;
use crate::outcome::{Answer, Failure};
use estimate::Estimate;
use evaluation::Evaluation;
use ground_truth::GroundTruth;

pub fn run(arguments: &EvalArguments, is_verbose: bool) -> Result<Answer, Failure> {
    let estimate = Estimate::read(&arguments.result)?;
    let ground_truth = GroundTruth::read(&arguments.ground_truth, estimate.world_from_scan.len())?;
    let mut evaluation = Evaluation::new(&estimate, arguments, is_verbose)?;
    for list in &ground_truth.lists {
        evaluation.judge_list(list)?;
    }
    if let Some(poses) = &ground_truth.world_from_scan {
        evaluation.judge_poses(poses)?;
    }
    Ok(Answer {
        text: evaluation.text,
        json: Some(Value::Object(evaluation.json)),
        is_complete: estimate.components.len() == 1,
    })
}
