//! Time of each stage (paper, table "Average runtime for registering one 3DMatch scene").

use std::path::Path;

use gmpcr::{Stage, register};

use crate::arguments::Arguments;
use crate::failure::Failure;
use crate::figures::{Panel, write_figure};
use crate::records::{Record, Selection};
use crate::scene::Scene;
use crate::table::{Table, number};

const CONFIGURATION: &str = "main preset";
/// The stage before the registration.
const FEATURES: &str = "features";
const NUM_SCANS: &str = "scans";

pub fn run(scene: &Scene, arguments: &Arguments) -> Result<Vec<Record>, Failure> {
    let mut records = vec![
        Record::new(CONFIGURATION, 0, NUM_SCANS, scene.scans.len() as f64),
        Record::new(CONFIGURATION, 0, FEATURES, scene.feature_time.as_secs_f64()),
    ];
    for run in 0..arguments.runs as usize {
        let found = register(&scene.scans, scene.main_params())?;
        records.extend(found.times.stages().map(|(stage, time)| {
            Record::new(CONFIGURATION, run, stage.name(), time.as_secs_f64())
        }));
    }
    Ok(records)
}

/// The stages that there are times for, in order.
fn stages(records: &Selection) -> Vec<String> {
    let is_stage = |metric: &&str| *metric != NUM_SCANS;
    records.distinct(|record| Some(record.metric.as_str()).filter(is_stage))
}

pub fn report(
    records: &Selection,
    descriptors: &str,
    figure: &Path,
    text: &mut String,
) -> Result<(), Failure> {
    let stages = stages(records);
    let mut header = vec!["scene".to_owned(), "scans".to_owned()];
    header.extend(stages.iter().map(|stage| format!("{stage} (ms)")));
    let title = format!("Time per stage, {descriptors} descriptors");
    let mut table = Table::new(title, header);
    let seconds = |scene: &str, stage: &str| records.scene_spread(scene, CONFIGURATION, stage);
    for (scene, _) in &records.scenes {
        let mut row = vec![
            (*scene).to_owned(),
            number(seconds(scene, NUM_SCANS), 1.0, 0),
        ];
        let times = stages.iter().map(|stage| seconds(scene, stage));
        row.extend(times.map(|time| number(time, 1e3, 1)));
        table.row(row);
    }
    table.append_to(text);
    let mean = |stage: &str| {
        records
            .mean_spread(CONFIGURATION, stage)
            .map_or(0.0, |t| t.mean)
    };
    let synchronization = mean(Stage::Synchronization.name());
    let total: f64 = stages.iter().map(|stage| mean(stage)).sum();
    let title = format!("Average time per scene (s), {descriptors} descriptors");
    let mut table = Table::new(title, ["main module", "synchronization", "total"]);
    table.row([total - synchronization, synchronization, total].map(|time| format!("{time:.3}")));
    table.append_to(text);
    let names = records.names();
    let part = |stage: &String| {
        let times = names
            .iter()
            .map(|scene| seconds(scene, stage).map_or(0.0, |time| time.mean));
        (stage.clone(), times.collect())
    };
    let parts: Vec<(String, Vec<f64>)> = stages.iter().map(part).collect();
    let panel = Panel::new("time per stage", "seconds", "").stacked_bars(&names, &parts);
    Ok(write_figure(figure, &[panel])?)
}
