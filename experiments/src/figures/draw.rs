//! Panels drawn with plotters.

use std::io;

use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axis::{self, Axis, Point};
use super::{Mark, Panel, Shape};

/// Area with pixel coordinates.
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// What the backend can answer.
type Drawn = Result<(), DrawingAreaErrorKind<io::Error>>;
/// Place in pixels from the upper left corner.
type Pixel = (i32, i32);

/// Width and height of a panel in pixels; names of categories add to the width.
const PANEL: (u32, u32) = (600, 420);
/// Height of a category or of a line of the legend in pixels.
const ROW: u32 = 22;
/// Above and below the rows of a panel or of the legend: title, axis and margins, in pixels.
const AROUND_ROWS: u32 = 110;
/// Height above the axes for the title in pixels.
const TITLE: i32 = 38;
/// Width of the symbols of the legend in pixels.
const KEY: i32 = 30;
/// Width that a character of a tick label or of the legend is granted, in pixels.
const CHARACTER: usize = 7;
/// Lines with more points than this have no markers.
const MAX_MARKERS: usize = 60;
/// Colors that color-blind readers tell apart (Okabe and Ito, 2008), without the yellow,
/// which white paper swallows.
const PALETTE: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];
/// Color of curves with a band.
const TEAL: RGBColor = RGBColor(0, 128, 128);
/// Color of horizontal lines.
const GRAY: RGBColor = RGBColor(110, 110, 110);
/// Color of axes.
const AXIS: RGBColor = RGBColor(90, 90, 90);
/// Color of the grid.
const GRID: RGBColor = RGBColor(225, 225, 225);

/// The panels side by side and their legend, as the text of an SVG file.
pub(super) fn render(panels: &[Panel]) -> Result<String, DrawingAreaErrorKind<io::Error>> {
    let legend = legend(panels);
    let longest = legend.iter().map(|mark| mark.label.chars().count()).max();
    let legend_width = longest.map_or(0, |n| KEY as usize + 30 + CHARACTER * n) as u32;
    let rows = panels.iter().map(|panel| panel.categories.len());
    let rows = rows.chain([legend.len()]).max().unwrap_or(0) as u32;
    let names = panels.iter().flat_map(|panel| &panel.categories);
    let longest_name = names.map(|name| name.chars().count()).max().unwrap_or(0);
    let panel_width = PANEL.0 + (CHARACTER * longest_name) as u32;
    let panels_width = panel_width * panels.len().max(1) as u32;
    let height = PANEL.1.max(AROUND_ROWS + ROW * rows);

    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, (panels_width + legend_width, height));
    let root = root.into_drawing_area();
    root.fill(&WHITE)?;
    let (left, right) = root.split_horizontally(panels_width);
    let areas = left.split_evenly((1, panels.len().max(1)));
    for (panel, area) in panels.iter().zip(&areas) {
        draw_panel(&root, area, panel, &legend)?;
    }
    draw_legend(&right, &legend)?;
    root.present()?;
    drop((root, left, right, areas));
    Ok(svg)
}

/// The first mark of each label.
fn legend(panels: &[Panel]) -> Vec<&Mark> {
    let mut first: Vec<&Mark> = Vec::new();
    for mark in panels.iter().flat_map(|panel| &panel.marks) {
        if !mark.label.is_empty() && first.iter().all(|other| other.label != mark.label) {
            first.push(mark);
        }
    }
    first
}

/// Color, dashes and marker of a mark.
#[derive(Clone, Copy)]
struct Look {
    color: RGBColor,
    is_dashed: bool,
    marker: usize,
}

/// Looks follow the order of the legend; a second round through the colors is dashed.
fn look(mark: &Mark, legend: &[&Mark]) -> Look {
    let place = legend.iter().position(|other| other.label == mark.label);
    let place = place.unwrap_or(0);
    let numbered = PALETTE[place % PALETTE.len()];
    let (color, is_dashed, marker) = match mark.shape {
        Shape::Level(_) => (GRAY, true, 0),
        Shape::Curve(_) | Shape::Band(_) => (TEAL, false, 0),
        _ => (numbered, place >= PALETTE.len(), place),
    };
    Look {
        color,
        is_dashed,
        marker,
    }
}

/// Axes, then the marks.
fn draw_panel(root: &Area, area: &Area, panel: &Panel, legend: &[&Mark]) -> Drawn {
    let extent: Vec<Point> = panel.marks.iter().flat_map(|m| m.shape.extent()).collect();
    let levels = panel.marks.iter().filter_map(|mark| match mark.shape {
        Shape::Level(y) => Some(y),
        _ => None,
    });
    let x_span = axis::span(extent.iter().map(|p| p.0));
    let y_span = axis::span(extent.iter().map(|p| p.1).chain(levels));
    let x_range = axis::range(None, x_span, 0.04);
    let x_axis = Axis::of_numbers(x_range);
    let y_axis = if panel.categories.is_empty() {
        Axis::of_numbers(axis::range(panel.y_range, y_span, 0.06))
    } else {
        Axis::of_rows(&panel.categories)
    };
    let y_label_width = CHARACTER * y_axis.longest_label() + 32;

    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .margin_top(TITLE)
        .margin_right(24)
        .x_label_area_size(48)
        .y_label_area_size(y_label_width as u32)
        .build_cartesian_2d(x_axis, y_axis)?;
    let mut mesh = chart.configure_mesh();
    if !panel.categories.is_empty() {
        mesh.disable_y_mesh();
    }
    mesh.bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .axis_style(AXIS)
        .label_style(("sans-serif", 15))
        .axis_desc_style(("sans-serif", 17))
        .x_desc(&panel.x_label)
        .y_desc(&panel.y_label)
        .draw()?;
    let place = |p: &Point| chart.plotting_area().map_coordinate(p);
    let (columns, lines) = chart.plotting_area().get_pixel_range();
    let above = ((columns.start + columns.end) / 2, lines.start - TITLE / 2);
    let text = ("sans-serif", 20).into_text_style(root);
    let text = text.pos(Pos::new(HPos::Center, VPos::Center));
    root.draw(&Text::new(panel.title.clone(), above, text))?;
    for mark in &panel.marks {
        draw_shape(root, &mark.shape, look(mark, legend), x_range, &place)?;
    }
    Ok(())
}

/// One shape, of which `place` gives the pixels.
fn draw_shape(
    root: &Area,
    shape: &Shape,
    look: Look,
    x_range: (f64, f64),
    place: &dyn Fn(&Point) -> Pixel,
) -> Drawn {
    let pixels = |points: &[Point]| points.iter().map(place).collect::<Vec<Pixel>>();
    match shape {
        Shape::Line(points) | Shape::Curve(points) => {
            let pixels = pixels(points);
            draw_path(root, &pixels, look)?;
            let markers = if pixels.len() > MAX_MARKERS {
                &[]
            } else {
                &pixels[..]
            };
            markers
                .iter()
                .try_for_each(|at| draw_marker(root, *at, look))
        }
        Shape::Dots(points) => pixels(points)
            .into_iter()
            .try_for_each(|at| root.draw(&Circle::new(at, 2, look.color.mix(0.35).filled()))),
        Shape::Band(outline) => root.draw(&Polygon::new(pixels(outline), look.color.mix(0.2))),
        Shape::Steps(outline) => {
            let outline = pixels(outline);
            draw_path(root, &outline, look)?;
            root.draw(&Polygon::new(outline, look.color.mix(0.3)))
        }
        Shape::Boxes(boxes) => boxes
            .iter()
            .try_for_each(|corners| draw_box(root, corners.each_ref().map(place), look)),
        Shape::Level(y) => {
            let ends = [(x_range.0, *y), (x_range.1, *y)];
            draw_path(root, &pixels(&ends), look)
        }
    }
}

/// One line per label, symbol first, from the top down.
fn draw_legend(area: &Area, legend: &[&Mark]) -> Drawn {
    let text = ("sans-serif", 16).into_text_style(area);
    let text = text.pos(Pos::new(HPos::Left, VPos::Center));
    for (row, mark) in legend.iter().enumerate() {
        let y = TITLE + 12 + row as i32 * ROW as i32;
        let (left, middle) = ((4, y), (4 + KEY / 2, y));
        let right = (4 + KEY, y);
        let corners = [(8, y - 6), (KEY, y + 6)];
        let look = look(mark, legend);
        match mark.shape {
            Shape::Line(_) | Shape::Curve(_) => {
                draw_path(area, &[left, right], look)?;
                draw_marker(area, middle, look)?;
            }
            Shape::Level(_) => draw_path(area, &[left, right], look)?,
            Shape::Dots(_) => area.draw(&Circle::new(middle, 4, look.color.filled()))?,
            Shape::Band(_) | Shape::Steps(_) => {
                area.draw(&Rectangle::new(corners, look.color.mix(0.3).filled()))?;
            }
            Shape::Boxes(_) => draw_box(area, corners, look)?,
        }
        area.draw(&Text::new(mark.label.clone(), (KEY + 14, y), text.clone()))?;
    }
    Ok(())
}

/// Connected line, dashed if the look says so.
fn draw_path(area: &Area, pixels: &[Pixel], look: Look) -> Drawn {
    let style = look.color.stroke_width(2);
    if look.is_dashed {
        let pixels = pixels.iter().copied();
        area.draw(&DashedPathElement::new(pixels, 7, 4, style))
    } else {
        area.draw(&PathElement::new(pixels, style))
    }
}

/// Circle, triangle, square or cross.
fn draw_marker(area: &Area, at: Pixel, look: Look) -> Drawn {
    let filled = look.color.filled();
    match look.marker % 4 {
        0 => area.draw(&Circle::new(at, 4, filled)),
        1 => area.draw(&TriangleMarker::new(at, 5, filled)),
        2 => {
            let corners = [(at.0 - 4, at.1 - 4), (at.0 + 4, at.1 + 4)];
            area.draw(&Rectangle::new(corners, filled))
        }
        _ => area.draw(&Cross::new(at, 4, look.color.stroke_width(2))),
    }
}

/// Filled box; pale where a path would be dashed.
fn draw_box(area: &Area, corners: [Pixel; 2], look: Look) -> Drawn {
    let opacity = if look.is_dashed { 0.4 } else { 1.0 };
    area.draw(&Rectangle::new(corners, look.color.mix(opacity).filled()))
}
