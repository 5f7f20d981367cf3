//! The figures: time on the left, memory on the right, both axes logarithmic.

use std::error::Error;

use plotters::coord::Shift;
use plotters::coord::combinators::{BindKeyPoints, IntoLogRange};
use plotters::element::DashedPathElement;
use plotters::prelude::*;

use crate::measure::{REGISTRATION, SYNCHRONIZATION};
use crate::table::{BEFORE, PEAK, SCORING_SECONDS, SECONDS, Table, docs};

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), Box<dyn Error>>;

/// Blue, vermilion, green: colors that color-blind readers tell apart (Okabe and Ito, 2008).
const PALETTE: [RGBColor; 3] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
];
/// Color of the axes and of the memory of the data.
const GRAY: RGBColor = RGBColor(90, 90, 90);
/// Color of the reference slopes.
const PALE: RGBColor = RGBColor(170, 170, 170);
const GRID: RGBColor = RGBColor(228, 228, 228);

struct Curve {
    label: String,
    points: Vec<(f64, f64)>,
    color: RGBColor,
    is_dashed: bool,
}

pub fn registration(table: &Table) -> Drawn {
    let draw = Curves(table, REGISTRATION, &["exhaustive", "retrieval"]);
    let mut times = draw.of("", &[(SECONDS, 1.0)]);
    let scoring = draw.of(": scoring alone", &[(SCORING_SECONDS, 1.0)]);
    times.extend(scoring.into_iter().map(|curve| Curve {
        is_dashed: true,
        ..curve
    }));
    figure("growth-registration.svg", "scans", &times, &draw.memory())
}

pub fn synchronization(table: &Table) -> Drawn {
    let variants = ["adaptive", "consensus", "consensus joined at random"];
    let draw = Curves(table, SYNCHRONIZATION, &variants);
    let times = draw.of("", &[(SECONDS, 1.0)]);
    figure(
        "growth-synchronization.svg",
        "poses",
        &times,
        &draw.memory(),
    )
}

/// A part of the table and its variants.
struct Curves<'a>(&'a Table, &'a str, &'a [&'a str]);

impl Curves<'_> {
    /// One curve for each variant.
    fn of(&self, suffix: &str, columns: &[(usize, f64)]) -> Vec<Curve> {
        let Self(table, part, variants) = self;
        let colored = variants.iter().zip(PALETTE);
        let curve = |(what, color): (&&str, _)| Curve {
            label: format!("{what}{suffix}"),
            points: table.points(part, what, columns),
            color,
            is_dashed: false,
        };
        colored.map(curve).collect()
    }

    /// What each variant takes beyond the data, and what the data alone take.
    fn memory(&self) -> Vec<Curve> {
        let Self(table, part, variants) = self;
        let data = Curve {
            label: "the data, before".to_owned(),
            points: table.points(part, variants[0], &[(BEFORE, 1.0)]),
            color: GRAY,
            is_dashed: true,
        };
        let mut curves = self.of(": peak − before", &[(PEAK, 1.0), (BEFORE, -1.0)]);
        curves.push(data);
        curves
    }
}

fn figure(name: &str, x_label: &str, times: &[Curve], peaks: &[Curve]) -> Drawn {
    if times.iter().all(|curve| curve.points.is_empty()) {
        return Ok(());
    }
    let path = docs(name);
    let root = SVGBackend::new(&path, (1160, 440)).into_drawing_area();
    root.fill(&WHITE)?;
    let (left, right) = root.split_horizontally(580);
    panel(&left, "time", x_label, "processor time (s)", times)?;
    panel(&right, "memory", x_label, "memory (MiB)", peaks)?;
    Ok(root.present()?)
}

fn panel(area: &Area, title: &str, x_label: &str, y_label: &str, curves: &[Curve]) -> Drawn {
    let points = || curves.iter().flat_map(|curve| &curve.points).copied();
    let Some(((left, right), (low, high))) =
        span(points().map(|p| p.0)).zip(span(points().map(|p| p.1)))
    else {
        return Ok(());
    };
    let mut sizes: Vec<f64> = points().map(|p| p.0).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.dedup();
    // Room above for the legend, and to the right for the names of the slopes.
    let (bottom, top) = (low / 1.3, high * (high / low).powf(0.4) * 1.3);
    let x_axis = (left / 1.1..right * 1.1 * (right / left).powf(0.06)).log_scale();
    let y_axis = (bottom..top).log_scale();
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 20))
        .margin(12)
        .x_label_area_size(48)
        .y_label_area_size(70)
        .build_cartesian_2d(
            x_axis.with_key_points(sizes),
            y_axis.with_key_points(ticks(bottom, top)),
        )?;
    chart
        .configure_mesh()
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .axis_style(GRAY)
        .label_style(("sans-serif", 14))
        .axis_desc_style(("sans-serif", 16))
        .x_desc(x_label)
        .y_desc(y_label)
        .x_label_formatter(&|size| grouped(*size))
        .y_label_formatter(&|value| grouped(*value))
        .draw()?;

    for (power, label) in [(1, "∝ N"), (2, "∝ N²")] {
        let end = right.min(left * (high / low).powf(1.0 / f64::from(power)));
        let tip = (end, low * (end / left).powi(power));
        chart.draw_series(LineSeries::new([(left, low), tip], PALE))?;
        let style = ("sans-serif", 14).into_font().color(&PALE);
        chart.draw_series([Text::new(label, tip, style)])?;
    }
    for curve in curves {
        let (style, points) = (curve.color.stroke_width(2), curve.points.iter().copied());
        // One long dash is a solid key.
        let dash = if curve.is_dashed { 6 } else { 100 };
        let key = move |(x, y)| DashedPathElement::new([(x, y), (x + 22, y)], dash, 4, style);
        if curve.is_dashed {
            chart.draw_series(DashedLineSeries::new(points, dash, 4, style))?
        } else {
            chart.draw_series(LineSeries::new(points, style).point_size(3))?
        }
        .label(&curve.label)
        .legend(key);
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .label_font(("sans-serif", 14))
        .background_style(WHITE)
        .draw()?;
    Ok(())
}

fn span(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |span, v| {
        let (low, high) = span.unwrap_or((v, v));
        Some((low.min(v), high.max(v)))
    })
}

/// Powers of ten, with their doubles and quintuples where they span little.
fn ticks(low: f64, high: f64) -> Vec<f64> {
    let factors: &[f64] = if high / low < 300.0 {
        &[1.0, 2.0, 5.0]
    } else {
        &[1.0]
    };
    let powers = low.log10().floor() as i32..=high.log10().ceil() as i32;
    let ticks = powers.flat_map(|power| factors.iter().map(move |f| f * 10_f64.powi(power)));
    ticks.filter(|tick| (low..high).contains(tick)).collect()
}

/// The shortest digits, thousands apart.
fn grouped(value: f64) -> String {
    if value < 1e4 {
        return format!("{}", (value * 1e6).round() / 1e6);
    }
    let value = value.round() as u64;
    format!("{}\u{202f}{:03}", value / 1000, value % 1000)
}
