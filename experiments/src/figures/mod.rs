//! Figures as SVG files: a row of panels, each with its data, and one legend to their right.
//!
//! Values that are not finite are left out. The same panels always give the same bytes.

mod axis;
mod draw;

use std::path::{Path, PathBuf};

use gmpcr_io::write_text;
use thiserror::Error;

use axis::{Point, is_drawable};

/// Why there is no figure.
#[derive(Debug, Error)]
pub enum FigureError {
    /// The backend gave up.
    #[error("cannot draw the figure {}: {reason}", .path.display())]
    Draw {
        /// File that was asked for.
        path: PathBuf,
        /// What the backend says.
        reason: String,
    },
    /// The file could not be written.
    #[error(transparent)]
    Write(#[from] gmpcr_io::Error),
}

/// Points under one name.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the legend.
    pub label: String,
    /// The points (x, y).
    pub points: Vec<Point>,
}

impl Series {
    /// `points` under the name `label`.
    pub fn new(label: impl Into<String>, points: Vec<Point>) -> Self {
        Self {
            label: label.into(),
            points,
        }
    }
}

/// One pair of axes and what is drawn on them, in order of the calls.
#[derive(Debug, Clone)]
pub struct Panel {
    title: String,
    x_label: String,
    y_label: String,
    y_range: Option<(f64, f64)>,
    /// Names of the rows at y = 0, −1, −2, …; none where y is a number.
    categories: Vec<String>,
    marks: Vec<Mark>,
}

/// A shape and its name in the legend; marks of one name have one color.
#[derive(Debug, Clone)]
struct Mark {
    label: String,
    shape: Shape,
}

/// What can be drawn on a panel, in the panel's units and finite.
#[derive(Debug, Clone)]
enum Shape {
    /// Connected points with markers.
    Line(Vec<Point>),
    /// Connected points in the color of bands.
    Curve(Vec<Point>),
    /// Area around a curve.
    Band(Vec<Point>),
    /// Separate points.
    Dots(Vec<Point>),
    /// Outline of a histogram, from baseline to baseline.
    Steps(Vec<Point>),
    /// Boxes between two opposite corners.
    Boxes(Vec<[Point; 2]>),
    /// Horizontal line through the whole panel.
    Level(f64),
}

impl Shape {
    /// Points that a fitted range has to hold.
    fn extent(&self) -> Vec<Point> {
        match self {
            Self::Line(points)
            | Self::Curve(points)
            | Self::Band(points)
            | Self::Dots(points)
            | Self::Steps(points) => points.clone(),
            Self::Boxes(boxes) => boxes.concat(),
            Self::Level(_) => Vec::new(),
        }
    }
}

impl Panel {
    /// Empty axes.
    pub fn new(title: &str, x_label: &str, y_label: &str) -> Self {
        Self {
            title: title.to_owned(),
            x_label: x_label.to_owned(),
            y_label: y_label.to_owned(),
            y_range: None,
            categories: Vec::new(),
            marks: Vec::new(),
        }
    }

    /// Fixes the range of y, which otherwise fits the data; what lies beyond moves to the border.
    pub fn y_range(mut self, low: f64, high: f64) -> Self {
        self.y_range = Some((low, high));
        self
    }

    /// Lines with markers.
    pub fn lines(self, series: &[Series]) -> Self {
        series.iter().fold(self, |panel, one| {
            panel.with(&one.label, Shape::Line(drawable(&one.points)))
        })
    }

    /// Separate, half-transparent points.
    pub fn scatter(self, series: &[Series]) -> Self {
        series.iter().fold(self, |panel, one| {
            panel.with(&one.label, Shape::Dots(drawable(&one.points)))
        })
    }

    /// A curve and the area `y ± half_widths` around it, one half-width per point.
    pub fn band(self, series: &Series, half_widths: &[f64], band_label: &str) -> Self {
        let rows = series.points.iter().zip(half_widths);
        let edge = |sign: f64| rows.clone().map(move |(p, half)| (p.0, p.1 + sign * half));
        let outline: Vec<Point> = edge(1.0).chain(edge(-1.0).rev()).collect();
        self.with(band_label, Shape::Band(drawable(&outline)))
            .with(&series.label, Shape::Curve(drawable(&series.points)))
    }

    /// A dashed horizontal line at `y`.
    pub fn level(self, label: &str, y: f64) -> Self {
        if is_drawable(y) {
            self.with(label, Shape::Level(y))
        } else {
            self
        }
    }

    /// Overlaid histograms: the heights of each over equal parts of `low..high`.
    pub fn histograms(self, heights: &[(String, Vec<f64>)], low: f64, high: f64) -> Self {
        heights.iter().fold(self, |panel, (label, heights)| {
            panel.with(label, Shape::Steps(drawable(&steps(heights, low, high))))
        })
    }

    /// One horizontal bar per category, the first on top, stacked of one value of each part.
    ///
    /// Bars run along x, so that long names of categories stay readable. A value that is missing,
    /// not finite or negative counts as zero.
    pub fn stacked_bars(mut self, categories: &[String], parts: &[(String, Vec<f64>)]) -> Self {
        self.categories = categories.to_vec();
        let mut ends = vec![0.0; categories.len()];
        for (label, values) in parts {
            let mut boxes = Vec::new();
            for (row, end) in ends.iter_mut().enumerate() {
                let value = values.get(row).copied().filter(|v| is_drawable(*v));
                let start = *end;
                *end += value.unwrap_or(0.0).max(0.0);
                let y = -(row as f64);
                boxes.push([(start, y + 0.35), (*end, y - 0.35)]);
            }
            self = self.with(label, Shape::Boxes(boxes));
        }
        self
    }

    /// Adds a mark.
    fn with(mut self, label: &str, shape: Shape) -> Self {
        let label = label.to_owned();
        self.marks.push(Mark { label, shape });
        self
    }
}

/// Writes `panels` side by side to the SVG file `path`, which is complete or as it was before.
///
/// The legend names each label of the row once; labels of several panels look the same in them.
///
/// # Errors
/// [`FigureError`] if the backend fails or the file cannot be written.
pub fn write_figure(path: &Path, panels: &[Panel]) -> Result<(), FigureError> {
    let svg = draw::render(panels).map_err(|error| FigureError::Draw {
        path: path.to_owned(),
        reason: error.to_string(),
    })?;
    Ok(write_text(path, &svg)?)
}

/// The points of which both coordinates can be drawn.
fn drawable(points: &[Point]) -> Vec<Point> {
    let both = |p: &&Point| is_drawable(p.0) && is_drawable(p.1);
    points.iter().filter(both).copied().collect()
}

/// Outline of bars of the given heights over equal parts of `low..high`.
fn steps(heights: &[f64], low: f64, high: f64) -> Vec<Point> {
    let edge = |k: usize| low + (high - low) * k as f64 / heights.len() as f64;
    let tops = heights.iter().enumerate();
    let tops = tops.flat_map(|(k, height)| [(edge(k), *height), (edge(k + 1), *height)]);
    let mut outline = vec![(low, 0.0)];
    outline.extend(tops);
    outline.push((high, 0.0));
    outline
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn svg(panels: &[Panel]) -> String {
        draw::render(panels).unwrap()
    }

    fn assert_valid(svg: &str) {
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
        assert!(!svg.contains("NaN") && !svg.contains("inf\""));
    }

    fn named(label: &str, values: &[f64]) -> (String, Vec<f64>) {
        (label.to_owned(), values.to_vec())
    }

    fn one_of_each() -> Vec<Panel> {
        let series = [
            Series::new("Geman-McClure", vec![(2.0, 0.1), (4.0, 0.7), (8.0, 0.9)]),
            Series::new("a < b & c", vec![(2.0, 0.3), (4.0, 0.2)]),
        ];
        let samples = [
            named("inliers", &[0.1, 0.9, 0.8]),
            named("outliers", &[0.1, 0.2]),
        ];
        let categories = ["kitchen".to_owned(), "studyroom".to_owned()];
        let new = |title| Panel::new(title, "the x", "the y");
        vec![
            new("lines").lines(&series).y_range(0.0, 1.0),
            new("band")
                .band(&series[0], &[0.1; 3], "95 %")
                .level("mean", 0.5),
            new("scatter").scatter(&series),
            new("histogram").histograms(&samples, 0.0, 1.0),
            new("bars").stacked_bars(&categories, &[named("match", &[1.0, 2.0])]),
        ]
    }

    #[test]
    fn every_figure_holds_its_labels() {
        let wanted: [&[&str]; 5] = [
            &["lines", "Geman-McClure", "a &lt; b &amp; c"],
            &["band", "Geman-McClure", "95 %", "mean"],
            &["scatter", "Geman-McClure", "a &lt; b &amp; c"],
            &["histogram", "inliers", "outliers"],
            &["bars", "kitchen", "studyroom", "match"],
        ];
        for (panel, labels) in one_of_each().iter().zip(wanted) {
            let svg = svg(std::slice::from_ref(panel));
            assert_valid(&svg);
            for label in labels.iter().chain(&["the x", "the y"]) {
                assert!(svg.contains(label), "{label}");
            }
        }
    }

    #[test]
    fn a_row_names_a_common_label_once() {
        let svg = svg(&one_of_each());
        assert_eq!(svg.matches("Geman-McClure").count(), 1);
        assert_eq!(svg.matches("the x").count(), 5);
    }

    #[test]
    fn the_same_panels_give_the_same_bytes() {
        assert_eq!(svg(&one_of_each()), svg(&one_of_each()));
    }

    #[test]
    fn nothing_to_draw_gives_a_valid_file() {
        let new = || Panel::new("", "", "");
        let none = Series::new("none", Vec::new());
        assert_valid(&svg(&[]));
        assert_valid(&svg(&[new()]));
        assert_valid(&svg(&[
            new().lines(std::slice::from_ref(&none)),
            new().band(&none, &[1.0], ""),
            new().scatter(&[]),
            new().histograms(&[named("none", &[])], 0.0, 1.0),
            new().stacked_bars(&[], &[named("none", &[1.0])]),
            new().stacked_bars(&["none".to_owned()], &[]),
        ]));
    }

    #[test]
    fn values_that_are_not_finite_are_left_out() {
        let bad = [f64::NAN, f64::INFINITY, f64::MAX];
        let good = [(0.0, 1.0), (1.0, 2.0)];
        let mixed: Vec<Point> = bad.iter().flat_map(|b| [(*b, 1.0), (0.5, *b)]).collect();
        let mixed = Series::new("s", [&good[..], &mixed].concat());
        let clean = Series::new("s", good.to_vec());
        let row = |s: Series| {
            let values: Vec<f64> = s.points.iter().map(|p| p.0).collect();
            let new = || Panel::new("", "", "");
            [
                new().lines(std::slice::from_ref(&s)).level("", f64::NAN),
                new().scatter(std::slice::from_ref(&s)),
                new().band(&s, &[0.1; 8], "band"),
                new().stacked_bars(&["c".to_owned()], &[named("p", &values[..1])]),
            ]
        };
        assert_eq!(svg(&row(mixed)), svg(&row(clean)));
        assert_valid(&svg(&[Panel::new("", "", "")
            .y_range(f64::NAN, 1.0)
            .histograms(&[named("bad", &bad)], 0.0, 1.0)
            .stacked_bars(&["c".to_owned()], &[named("p", &bad[1..])])]));
    }

    #[test]
    fn a_histogram_is_outlined_from_baseline_to_baseline() {
        let outline = [
            (0.0, 0.0),
            (0.0, 3.0),
            (1.0, 3.0),
            (1.0, 5.0),
            (2.0, 5.0),
            (2.0, 0.0),
        ];
        assert_eq!(steps(&[3.0, 5.0], 0.0, 2.0), outline);
        assert_eq!(steps(&[], 0.0, 2.0), [(0.0, 0.0), (2.0, 0.0)]);
    }

    #[test]
    fn a_figure_replaces_the_old_file_and_leaves_no_other() {
        let folder = std::env::temp_dir().join(format!("figures-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("figure.svg");
        fs::write(&path, "old").unwrap();
        write_figure(&path, &one_of_each()).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), svg(&one_of_each()));
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        let error = write_figure(&folder.join("missing/figure.svg"), &[]).unwrap_err();
        assert!(error.to_string().contains("missing/figure.svg"));
        fs::remove_dir_all(&folder).unwrap();
    }
}
