//! Range, ticks and tick labels of one axis.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

/// A point (x, y) in the units of a panel.
pub(super) type Point = (f64, f64);

/// Most steps between two ticks of one axis.
const MAX_STEPS: f64 = 8.0;

/// Whether a value is finite, and small enough that differences and margins are so too.
pub(super) fn is_drawable(value: f64) -> bool {
    value.abs() < 1e100
}

/// Smallest and largest drawable value, if there is one.
pub(super) fn span(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|v| is_drawable(*v)).fold(None, |span, v| {
        let (low, high) = span.unwrap_or((v, v));
        Some((low.min(v), high.max(v)))
    })
}

/// Range of an axis: the `fixed` one, or else the `span` of the data with a relative `margin`.
///
/// A lower end of exactly zero gets no margin. The range is never empty; without data it is 0..1.
pub(super) fn range(
    fixed: Option<(f64, f64)>,
    span: Option<(f64, f64)>,
    margin: f64,
) -> (f64, f64) {
    let fixed = fixed.filter(|(low, high)| is_drawable(*low) && is_drawable(*high));
    let margin = if fixed.is_some() { 0.0 } else { margin };
    let Some((a, b)) = fixed.or(span) else {
        return (0.0, 1.0);
    };
    let (low, high) = (a.min(b), a.max(b));
    let size = high.abs().max(low.abs());
    if high - low <= (1e-9 * size).max(1e-100) {
        let half = if size > 1e-99 { 0.1 * size } else { 1.0 };
        return (low - half, high + half);
    }
    let pad = margin * (high - low);
    (if low == 0.0 { low } else { low - pad }, high + pad)
}

/// A range with the ticks to draw on it; values beyond lie on its border.
pub(super) struct Axis {
    low: f64,
    high: f64,
    ticks: Vec<(f64, String)>,
}

impl Axis {
    /// Numbers with ticks at multiples of 1, 2 or 5 times a power of ten.
    pub(super) fn of_numbers((low, high): (f64, f64)) -> Self {
        let rough = (high - low) / MAX_STEPS;
        let power = 10_f64.powf(rough.log10().floor());
        let mut factors = [1.0, 2.0, 5.0].into_iter();
        let factor = factors.find(|f| f * power >= rough * 0.999);
        let step = factor.unwrap_or(10.0) * power;
        let first = (low / step - 1e-6).ceil() as i64;
        let last = (high / step + 1e-6).floor() as i64;
        let ticks = (first..=last).map(|k| k as f64 * step);
        let ticks = ticks.map(|value| (value, label(value, step))).collect();
        Self { low, high, ticks }
    }

    /// Names at 0, −1, −2, …, the first on top.
    pub(super) fn of_rows(names: &[String]) -> Self {
        let ticks = names.iter().enumerate();
        Self {
            low: 0.4 - names.len() as f64,
            high: 0.6,
            ticks: ticks.map(|(k, n)| (-(k as f64), n.clone())).collect(),
        }
    }

    /// Number of characters of the longest tick label.
    pub(super) fn longest_label(&self) -> usize {
        let lengths = self.ticks.iter().map(|(_, label)| label.chars().count());
        lengths.max().unwrap_or(0)
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (start, end): (i32, i32)) -> i32 {
        let fraction = ((value - self.low) / (self.high - self.low)).clamp(0.0, 1.0);
        start + (fraction * f64::from(end - start)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() {
            return Vec::new();
        }
        self.ticks.iter().map(|(value, _)| *value).collect()
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, value: &f64) -> String {
        let tick = self.ticks.iter().find(|(at, _)| at == value);
        tick.map_or_else(String::new, |(_, label)| label.clone())
    }
}

/// `value` with as many digits as multiples of `step` need.
fn label(value: f64, step: f64) -> String {
    let decimals = -(step.log10() + 1e-9).floor();
    if (-5.0..=5.0).contains(&decimals) {
        format!("{value:.*}", decimals.max(0.0) as usize)
    } else {
        format!("{value:.1e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64) -> Vec<String> {
        let ticks = Axis::of_numbers((low, high)).ticks;
        ticks.into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(labels(0.0, 100.0), ["0", "20", "40", "60", "80", "100"]);
        assert_eq!(
            labels(-0.03, 0.52),
            ["0.0", "0.1", "0.2", "0.3", "0.4", "0.5"]
        );
        assert_eq!(labels(1.9, 12.2), ["2", "4", "6", "8", "10", "12"]);
        assert_eq!(
            labels(0.0, 2e7),
            ["0.0e0", "5.0e6", "1.0e7", "1.5e7", "2.0e7"]
        );
    }

    #[test]
    fn a_range_is_never_empty() {
        assert_eq!(range(None, None, 0.05), (0.0, 1.0));
        assert_eq!(range(None, Some((0.0, 0.0)), 0.05), (-1.0, 1.0));
        assert_eq!(range(Some((100.0, 0.0)), None, 0.05), (0.0, 100.0));
        assert_eq!(
            range(Some((f64::NAN, 0.0)), Some((0.0, 100.0)), 0.1),
            (0.0, 110.0)
        );
        assert_eq!(range(None, Some((0.0, 1e-320)), 0.05), (-1.0, 1.0 + 1e-320));
        let (low, high) = range(None, Some((5.0, 5.0)), 0.05);
        assert!(low < 5.0 && high > 5.0);
    }
}
