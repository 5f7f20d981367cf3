//! Tables and figure of the synchronization methods.

use std::path::Path;

use super::family::{Family, families};
use super::{EXPERIMENT, FILES, STATISTICS, scene_of};
use crate::failure::Failure;
use crate::figures::{Panel, Series, write_figure};
use crate::records::{Selection, Store};
use crate::reference::{self, System};
use crate::table::{Table, number};

/// Header of the column of times.
const TIME: &str = "ms";

pub fn report(store: &Store, folder: &Path, text: &mut String) -> Result<(), Failure> {
    let mut panels = Vec::new();
    for family in families() {
        let records = store.select(EXPERIMENT, family.name);
        if !records.scenes.is_empty() {
            report_family(&family, &records, text);
            panels.push(panel(&family, &records));
        }
    }
    if !panels.is_empty() {
        write_figure(&folder.join("sync.svg"), &panels)?;
    }
    let records = store.select(EXPERIMENT, FILES);
    for (scene, _) in &records.scenes {
        let header = ["method"].into_iter().chain(STATISTICS);
        let mut table = Table::new(format!("{scene}: errors (°, m) and time"), header);
        for method in records.configurations() {
            let figure =
                |statistic| number(records.scene_spread(scene, &method, statistic), 1.0, 3);
            table.row([method.clone()].into_iter().chain(STATISTICS.map(figure)));
        }
        table.append_to(text);
    }
    Ok(())
}

/// Mean rotation error of each method over the ratio of outlier edges.
fn panel(family: &Family, records: &Selection) -> Panel {
    let line = |method: String| {
        let points = family.outliers.iter().filter_map(|&percent| {
            let error = records.scene_spread(&scene_of(percent), &method, "rotation mean")?;
            Some((f64::from(percent), error.mean))
        });
        Series::new(method.clone(), points.collect())
    };
    let lines: Vec<_> = records.configurations().into_iter().map(line).collect();
    Panel::new(family.name, "outlier edges (%)", "mean rotation error (°)").lines(&lines)
}

/// The tables of a family: rotation errors with times and other systems, and translation errors.
fn report_family(family: &Family, records: &Selection, text: &mut String) {
    let methods = records.configurations();
    let num_graphs = methods.first().map_or(0, |method| {
        let scene = scene_of(family.outliers[0]);
        records.of_scene(&scene, method, STATISTICS[0]).len()
    });
    let title = format!(
        "{}: rotation error (°), mean / median over scans, mean of {num_graphs} graphs; wall time of one of two threads",
        family.title
    );
    let mut rotations = Table::new(title, header(family).chain([TIME.to_owned()]));
    let title = format!(
        "{}: translation error (m), mean / median over scans",
        family.title
    );
    let mut translations = Table::new(title, header(family));
    for method in methods {
        let row = |statistics, digits| error_cells(family, records, &method, statistics, digits);
        let time = time_cell(family, records, &method);
        rotations.row(row([STATISTICS[0], STATISTICS[1]], 2).chain([time]));
        translations.row(row([STATISTICS[2], STATISTICS[3]], 3));
    }
    for system in reference::systems(family.name) {
        rotations.row(system_cells(family, &system));
    }
    rotations.append_to(text);
    translations.append_to(text);
}

fn header(family: &Family) -> impl Iterator<Item = String> {
    let ratios = family.outliers.iter().map(|percent| format!("{percent} %"));
    std::iter::once("method".to_owned()).chain(ratios)
}

/// The method, and two statistics for each ratio of outliers.
fn error_cells(
    family: &Family,
    records: &Selection,
    method: &str,
    statistics: [&str; 2],
    digits: usize,
) -> impl Iterator<Item = String> {
    let cell = move |&percent: &u32| {
        let figure = |statistic| records.scene_spread(&scene_of(percent), method, statistic);
        statistics
            .map(|statistic| number(figure(statistic), 1.0, digits))
            .join(" / ")
    };
    std::iter::once(method.to_owned()).chain(family.outliers.iter().map(cell))
}

/// Milliseconds with the least and the most outliers.
fn time_cell(family: &Family, records: &Selection, method: &str) -> String {
    let ends = [family.outliers.first(), family.outliers.last()];
    let time = |&percent: &u32| {
        let seconds = records.scene_spread(&scene_of(percent), method, STATISTICS[4]);
        number(seconds, 1e3, 1)
    };
    let times: Vec<_> = ends.into_iter().flatten().map(time).collect();
    times.join("–")
}

/// Another system's figures in the columns that it has some for.
fn system_cells(family: &Family, system: &System) -> impl Iterator<Item = String> {
    let columns = header(family).skip(1).chain([TIME.to_owned()]);
    let cell = |column| {
        system
            .figures
            .get(&column)
            .map_or("–", String::as_str)
            .to_owned()
    };
    std::iter::once(format!("*{}*", system.name)).chain(columns.map(cell))
}
