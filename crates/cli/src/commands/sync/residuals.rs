//! By how much poses differ from the relative poses of the edges.

use gmpcr::nalgebra::Isometry3;
use gmpcr::posegraph::PoseGraph;
use gmpcr::sync::{EdgeResidual, edge_residuals};
use serde_json::{Value, json};

use crate::table::{significant, table};

/// Residuals of the edges, in ascending order.
pub struct Residuals {
    /// Degrees.
    rotation: Vec<f64>,
    /// In the unit of the file.
    translation: Vec<f64>,
}

impl Residuals {
    pub fn of(graph: &PoseGraph, world_from_scan: &[Isometry3<f64>]) -> Self {
        let residuals = edge_residuals(graph, world_from_scan);
        let sorted = |value: fn(&EdgeResidual) -> f64| {
            let mut values: Vec<f64> = residuals.iter().map(value).collect();
            values.sort_by(f64::total_cmp);
            values
        };
        Self {
            rotation: sorted(|residual| residual.rotation.to_degrees()),
            translation: sorted(|residual| residual.translation),
        }
    }

    pub fn to_json(&self) -> Value {
        let quantiles = |values| {
            let [median, high, largest] = quantiles(values);
            json!({ "median": median, "percentile_95": high, "largest": largest })
        };
        json!({
            "rotation_degrees": quantiles(&self.rotation),
            "translation": quantiles(&self.translation),
        })
    }
}

/// Median, 95th percentile and maximum of ascending values.
fn quantiles(values: &[f64]) -> [f64; 3] {
    let at = |fraction: f64| (fraction * values.len() as f64) as usize;
    [0.5, 0.95, 1.0].map(|fraction| values[at(fraction).min(values.len() - 1)])
}

/// Quantiles of the residuals of the file's poses, if it has all, and of the result's.
pub fn residual_table(before: Option<&Residuals>, after: &Residuals) -> String {
    let row = |name: &str, residuals: &Residuals| {
        let degrees = quantiles(&residuals.rotation).map(|value| format!("{value:.3}°"));
        let lengths = quantiles(&residuals.translation).map(significant);
        let cells = [name.to_owned()].into_iter().chain(degrees).chain(lengths);
        cells.collect::<Vec<_>>()
    };
    let before = before.map(|residuals| row("before", residuals));
    let header = [
        "residuals",
        "rotation: median",
        "95 %",
        "largest",
        "translation: median",
        "95 %",
        "largest",
    ];
    table(&header, before.into_iter().chain([row("after", after)]))
}
