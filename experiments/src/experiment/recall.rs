//! Registration recall and pose errors (paper, tables "Registration recall on 3DMatch, 3DLoMatch, and
//! ETH" and "Rotation and translation error on ScanNet").

use gmpcr_eval::{SCANNET_DEGREES, SCANNET_METERS};

use crate::arguments::Arguments;
use crate::failure::Failure;
use crate::records::{Record, Selection};
use crate::registering::{Judge, registered, world_poses};
use crate::scene::Scene;
use crate::table::{Table, number, percent};

pub fn run(scene: &Scene, arguments: &Arguments) -> Result<Vec<Record>, Failure> {
    let mut records = Vec::new();
    for run in 0..arguments.runs as usize {
        for (configuration, params) in &scene.presets {
            let found = registered(scene, params, run)?;
            let poses = world_poses(&found.world_from_scan, &found.components);
            let judge = Judge {
                scene,
                configuration,
                run,
            };
            records.extend(judge.judge(&poses)?);
        }
    }
    Ok(records)
}

pub fn report(records: &Selection, descriptors: &str, text: &mut String) {
    for list in lists(records) {
        let title = format!("Registration recall (%), list {list}, {descriptors} descriptors");
        recall_table(title, &records.configurations(), &list, records).append_to(text);
    }
    pose_errors(records, descriptors, text);
    name_unjudgeable(records, text);
}

/// Recall on one list, a row per configuration: every scene, the mean over the scenes and all pairs
/// together, with its deviation over the runs.
pub fn recall_table(title: String, rows: &[String], list: &str, records: &Selection) -> Table {
    let mut header = vec!["configuration".to_owned()];
    header.extend(records.names());
    header.extend(["scene mean", "all pairs together"].map(str::to_owned));
    let mut table = Table::new(title, header);
    let (registered, pairs) = (format!("{list} registered"), format!("{list} pairs"));
    for row in rows {
        let mut cells = vec![row.clone()];
        let scenes = records.scenes.iter();
        cells.extend(scenes.map(|(scene, _)| percent(records.scene_spread(scene, row, list))));
        cells.push(percent(records.mean_spread(row, list)));
        cells.push(percent(records.ratio_spread(row, &registered, &pairs)));
        table.row(cells);
    }
    table
}

fn pose_errors(records: &Selection, descriptors: &str, text: &mut String) {
    let title = format!(
        "Ratios of all listed pairs (%) under thresholds, and errors of those with an estimate, {descriptors} descriptors"
    );
    let mut header = vec!["list, configuration".to_owned(), "15° and 0.3 m".to_owned()];
    header.extend(SCANNET_DEGREES.map(|limit| format!("{limit}°")));
    header.extend(["mean", "median"].map(|statistic| format!("{statistic} (°)")));
    header.extend(SCANNET_METERS.map(|limit| format!("{limit} m")));
    header.extend(["mean", "median"].map(|statistic| format!("{statistic} (m)")));
    header.push("without estimate (%)".to_owned());
    let mut table = Table::new(title, header);
    for list in lists(records) {
        for configuration in records.configurations() {
            let mean = |metric: String| records.mean_spread(&configuration, &metric);
            let ratio = |metric: String| number(mean(metric), 100.0, 1);
            let mut row = vec![format!("{list}, {configuration}")];
            row.push(ratio(format!("{list} within 15° and 0.3 m")));
            row.extend(SCANNET_DEGREES.map(|limit| ratio(format!("{list} under {limit}°"))));
            for statistic in ["mean", "median"] {
                row.push(number(mean(format!("{list} {statistic} degrees")), 1.0, 2));
            }
            row.extend(SCANNET_METERS.map(|limit| ratio(format!("{list} under {limit} m"))));
            for statistic in ["mean", "median"] {
                row.push(number(mean(format!("{list} {statistic} meters")), 1.0, 3));
            }
            row.push(ratio(format!("{list} without estimate")));
            table.row(row);
        }
    }
    table.append_to(text);
}

/// The lists of pairs that there are figures for.
pub fn lists(records: &Selection) -> Vec<String> {
    records.distinct(|record| record.metric.strip_suffix(" within 15° and 0.3 m"))
}

/// Pairs whose information matrix is empty cannot be judged and count as not registered.
fn name_unjudgeable(records: &Selection, text: &mut String) {
    for (scene, records) in records.names().iter().zip(records.alone()) {
        let is_named = |metric: &&str| metric.contains(" unjudgeable pair ");
        for metric in records.distinct(|record| Some(record.metric.as_str()).filter(is_named)) {
            text.push_str(&format!(
                "\n{scene}: {metric}: empty information matrix, counted as not registered\n"
            ));
        }
    }
}
