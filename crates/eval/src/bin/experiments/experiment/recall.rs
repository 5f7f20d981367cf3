//! Registration recall and pose errors (paper, tables "Registration recall on 3DMatch, 3DLoMatch, and
//! ETH" and "Rotation and translation error on ScanNet").

use std::error::Error;

use gmpcr_eval::{SCANNET_DEGREES, SCANNET_METRES};

use crate::arguments::Arguments;
use crate::records::{Record, Selection};
use crate::reference;
use crate::registering::{Judge, registered, threedlomatch, threedmatch, world_poses};
use crate::scene::Scene;
use crate::table::{Table, number, percent};

const PRESETS: [&str; 2] = ["3DMatch preset", "3DLoMatch preset"];

pub fn run(scene: &Scene, arguments: &Arguments) -> Result<Vec<Record>, Box<dyn Error>> {
    let mut records = Vec::new();
    for run in 0..arguments.runs as usize {
        let presets = [threedmatch(arguments), threedlomatch(arguments)];
        for (configuration, params) in PRESETS.into_iter().zip(presets) {
            let found = registered(scene, &params, run, arguments)?;
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
    recalls(records, descriptors, text);
    pose_errors(records, descriptors, text);
    name_unjudgeable(records, text);
}

fn recalls(records: &Selection, descriptors: &str, text: &mut String) {
    for list in lists(records) {
        let title = format!(
            "Registration recall (%), list {list}, {descriptors} descriptors: mean ± deviation over sampling starts"
        );
        let mut header = vec!["configuration".to_owned()];
        header.extend(records.scenes.iter().map(|(scene, _)| (*scene).to_owned()));
        let means = ["scene mean", "pooled", "conjugate sign", "15°, 0.3 m"];
        header.extend(means.map(str::to_owned));
        let mut table = Table::new(title, header);
        for configuration in records.configurations() {
            let mut row = vec![configuration.clone()];
            row.extend(
                records
                    .scenes
                    .iter()
                    .map(|(scene, _)| percent(records.scene_spread(scene, &configuration, &list))),
            );
            let mean = |metric: &str| percent(records.mean_spread(&configuration, metric));
            let (registered, pairs) = (format!("{list} registered"), format!("{list} pairs"));
            row.push(mean(&list));
            row.push(percent(records.ratio_spread(
                &configuration,
                &registered,
                &pairs,
            )));
            row.push(mean(&format!("{list} conjugate")));
            row.push(mean(&format!("{list} within 15° and 0.3 m")));
            table.row(row);
        }
        table.append_to(text);
    }
    reference::recall_table().append_to(text);
}

fn pose_errors(records: &Selection, descriptors: &str, text: &mut String) {
    let title =
        format!("Shares of pairs (%) under thresholds and pose errors, {descriptors} descriptors");
    let mut header = vec!["list, configuration".to_owned()];
    header.extend(SCANNET_DEGREES.map(|limit| format!("{limit}°")));
    header.extend(["mean", "median"].map(|statistic| format!("{statistic} (°)")));
    header.extend(SCANNET_METRES.map(|limit| format!("{limit} m")));
    header.extend(["mean", "median"].map(|statistic| format!("{statistic} (m)")));
    let mut table = Table::new(title, header);
    for list in lists(records) {
        for configuration in records.configurations() {
            let mean = |metric: String| records.mean_spread(&configuration, &metric);
            let share = |metric: String| number(mean(metric), 100.0, 1);
            let mut row = vec![format!("{list}, {configuration}")];
            row.extend(SCANNET_DEGREES.map(|limit| share(format!("{list} under {limit}°"))));
            for statistic in ["mean", "median"] {
                row.push(number(mean(format!("{list} {statistic} degrees")), 1.0, 2));
            }
            row.extend(SCANNET_METRES.map(|limit| share(format!("{list} under {limit} m"))));
            for statistic in ["mean", "median"] {
                row.push(number(mean(format!("{list} {statistic} metres")), 1.0, 3));
            }
            table.row(row);
        }
    }
    table.append_to(text);
}

/// The lists of pairs that there are figures for.
pub fn lists(records: &Selection) -> Vec<String> {
    let mut lists: Vec<String> = Vec::new();
    for record in records.scenes.iter().flat_map(|(_, records)| *records) {
        if let Some(list) = record.metric.strip_suffix(" within 15° and 0.3 m")
            && !lists.iter().any(|known| known == list)
        {
            lists.push(list.to_owned());
        }
    }
    lists
}

/// Pairs whose information matrix is empty cannot be judged and count as not registered.
fn name_unjudgeable(records: &Selection, text: &mut String) {
    for (scene, records) in &records.scenes {
        let mut named: Vec<&str> = Vec::new();
        for record in records
            .iter()
            .filter(|r| r.metric.contains(" unjudgeable pair "))
        {
            if !named.contains(&record.metric.as_str()) {
                named.push(&record.metric);
            }
        }
        for metric in named {
            text.push_str(&format!(
                "\n{scene}: {metric}: empty information matrix, counted as not registered\n"
            ));
        }
    }
}
