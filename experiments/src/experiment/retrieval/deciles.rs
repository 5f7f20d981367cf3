//! Confidences: does the overlap grow with them?

use std::path::{Path, PathBuf};

use gmpcr_eval::{DecileSummary, OverlapDeciles, SceneMean, overlap_deciles};
use nalgebra::DMatrix;

use crate::failure::Failure;
use crate::figures::{Panel, Series, write_figure};
use crate::records::{Record, Selection};
use crate::table::Table;

/// Configuration of the records of single pairs.
pub const PAIRS: &str = "pairs";
/// Configuration of the records of deciles.
pub const DECILES: &str = "deciles";

/// Confidence and overlap of every pair, and the overlap by deciles of confidence.
pub fn run(confidence: &DMatrix<f64>, overlap: &DMatrix<f64>) -> Result<Vec<Record>, Failure> {
    let n = confidence.nrows();
    let pairs = || (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j)));
    let of_pairs = |matrix: &DMatrix<f64>| pairs().map(|pair| matrix[pair]).collect::<Vec<_>>();
    let (confidence, overlap) = (of_pairs(confidence), of_pairs(overlap));
    let largest = confidence.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let mut records = Vec::new();
    for (pair, (c, o)) in confidence.iter().zip(&overlap).enumerate() {
        records.push(Record::new(PAIRS, pair, "confidence", c / largest));
        records.push(Record::new(PAIRS, pair, "overlap", *o));
    }
    let deciles = overlap_deciles(&confidence, &overlap)?;
    for (decile, mean) in deciles.deciles.iter().enumerate() {
        let mean = mean.map(|mean| Record::new(DECILES, 0, format!("decile {decile}"), mean));
        records.extend(mean);
    }
    let all = deciles
        .all_pairs
        .map(|mean| Record::new(DECILES, 0, "all pairs", mean));
    records.extend(all);
    Ok(records)
}

pub fn report(
    records: &Selection,
    descriptors: &str,
    figure: &dyn Fn(&str) -> PathBuf,
    text: &mut String,
) -> Result<(), Failure> {
    draw_pairs(records, &figure("confidence_overlap"))?;
    let of_scene = |(scene, _): &(&str, _)| {
        let mean = |metric: &str| Some(records.scene_spread(scene, DECILES, metric)?.mean);
        OverlapDeciles {
            deciles: std::array::from_fn(|decile| mean(&format!("decile {decile}"))),
            all_pairs: mean("all pairs"),
        }
    };
    let scenes: Vec<_> = records.scenes.iter().map(of_scene).collect();
    let Some(summary) = DecileSummary::of(&scenes) else {
        return Ok(());
    };
    decile_table(&summary, descriptors).append_to(text);
    text.push_str(
        "\nPaper (8 scenes, YOHO descriptors): 0.485 in the tenth decile, 0.10 over all pairs.\n",
    );
    Ok(write_figure(&figure("deciles"), &[decile_panel(&summary)])?)
}

fn decile_table(summary: &DecileSummary, descriptors: &str) -> Table {
    let title = format!("Mean overlap per decile of confidence, {descriptors} descriptors");
    let header = (1..=10).map(|decile| decile.to_string());
    let mut table = Table::new(title, header.chain(["all pairs".to_owned()]));
    let cell = |mean: &Option<SceneMean>| {
        mean.map_or("–".to_owned(), |mean| format!("{:.3}", mean.mean))
    };
    let mut cells: Vec<String> = summary.deciles.iter().map(cell).collect();
    cells.push(format!("{:.3}", summary.all_pairs));
    table.row(cells);
    table
}

fn decile_panel(summary: &DecileSummary) -> Panel {
    let (mut points, mut half_widths) = (Vec::new(), Vec::new());
    for (decile, mean) in summary.deciles.iter().enumerate() {
        if let Some(mean) = mean {
            points.push((decile as f64 + 1.0, mean.mean));
            half_widths.push(mean.half_width.unwrap_or(0.0));
        }
    }
    let series = Series::new("scene mean", points);
    Panel::new(
        "overlap over confidence",
        "decile of confidence",
        "mean overlap",
    )
    .band(&series, &half_widths, "95 % interval")
    .level("all pairs", summary.all_pairs)
}

fn draw_pairs(records: &Selection, figure: &Path) -> Result<(), Failure> {
    let of_scene = |(scene, _): &(&str, _)| {
        let confidence = records.of_scene(scene, PAIRS, "confidence");
        let overlap = records.of_scene(scene, PAIRS, "overlap");
        let points = confidence
            .iter()
            .zip(&overlap)
            .map(|((_, c), (_, o))| (*c, *o));
        Series::new(*scene, points.collect())
    };
    let series: Vec<_> = records.scenes.iter().map(of_scene).collect();
    let x_label = "confidence / largest of the scene";
    let panel = Panel::new("pairs of scans", x_label, "overlap").scatter(&series);
    Ok(write_figure(figure, &[panel])?)
}
