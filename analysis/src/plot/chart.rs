//! Charts: curves, points with error bars, and theory lines over two axes.

use super::axis::{Axis, FLAT_RELATIVE, Layout, extremes};
use super::canvas::{
    Canvas, DrawingError, INK, PALE, curve_color, draw, failure, fine, stroke, text_style,
    text_width,
};
use super::chart_size::{ChartSize, WIDTH};
use super::word_labels::draw_words;
use kinetoscope_console::text::plural;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use serde::{Deserialize, Serialize};

/// A point with the standard error of y.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Point {
    /// x.
    pub(crate) x: f64,
    /// y.
    pub(crate) y: f64,
    /// The standard error of y.
    pub(crate) error: Option<f64>,
}

impl Point {
    /// A point without an error bar.
    pub(crate) const fn bare(x: f64, y: f64) -> Self {
        Self { x, y, error: None }
    }
}

/// Style of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum CurveStyle {
    /// A line through the points.
    Line,
    /// A dashed line through the points, for theory.
    Theory,
    /// Dots with error bars, for data.
    Data,
}

/// A named set of points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Curve {
    /// The name in the legend.
    pub(crate) name: String,
    /// The style.
    pub(crate) style: CurveStyle,
    /// Index of the color; related curves share one.
    pub(crate) color: usize,
    /// The points, in the order of the line.
    pub(crate) points: Vec<Point>,
}

impl Curve {
    /// A curve without error bars, thinned to the visible points.
    pub(crate) fn new(
        name: impl Into<String>,
        style: CurveStyle,
        color: usize,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        let points = points.into_iter().map(|(x, y)| Point::bare(x, y)).collect();
        Self { name: name.into(), style, color, points: thinned(points) }
    }

    /// A line through the points.
    pub(crate) fn line(
        name: impl Into<String>,
        color: usize,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        Self::new(name, CurveStyle::Line, color, points)
    }

    /// A dashed line through the points.
    pub(crate) fn theory(
        name: impl Into<String>,
        color: usize,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        Self::new(name, CurveStyle::Theory, color, points)
    }
}

/// Curves over two axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Chart {
    /// The horizontal axis.
    pub(crate) x: Axis,
    /// The vertical axis.
    pub(crate) y: Axis,
    /// Whether both axes have the same scale.
    pub(crate) equal_aspect: bool,
    /// The curves; later ones are drawn on top.
    pub(crate) curves: Vec<Curve>,
    /// A remark below the chart; may be empty.
    pub(crate) remark: String,
}

const PLOT_HEIGHT: i32 = 360;
const TITLE_HEIGHT: i32 = 40;
const LEGEND_ROW_HEIGHT: i32 = 22;
const BOTTOM_LABELS: i32 = 58;
const RIGHT_MARGIN: i32 = 32;
const LEGEND_LEFT: i32 = 92;
const LEGEND_TEXT: i32 = 16;
const TITLE_TEXT: i32 = 20;
const TICK_TEXT: i32 = 15;
const LEGEND_SAMPLE: i32 = 30;
const LEGEND_GAP: i32 = 22;
const REMARK_HEIGHT: i32 = 24;
const REMARK_TEXT: i32 = 14;
const REMARK_MARGIN: i32 = 16;

impl Chart {
    /// The points of the data that logarithmic axes cannot show, in words; `None` if there are none.
    pub(super) fn hidden_data(&self) -> Option<String> {
        let data = self.curves.iter().filter(|curve| curve.style == CurveStyle::Data);
        let is_hidden = |point: &&Point| {
            let is_number = point.x.is_finite() && point.y.is_finite();
            is_number && !(self.x.can_show(point.x) && self.y.can_show(point.y))
        };
        let hidden = data.flat_map(|curve| &curve.points).filter(is_hidden).count() as u64;
        let points = plural(hidden, "point");
        (hidden > 0).then(|| format!("{points} at 0 or below: not on a logarithmic axis"))
    }

    /// The remark, with the points of the data that logarithmic axes cannot show.
    pub(crate) fn full_remark(&self) -> String {
        let own = Some(self.remark.clone()).filter(|remark| !remark.is_empty());
        own.into_iter().chain(self.hidden_data()).collect::<Vec<_>>().join("; ")
    }

    /// The chart as an SVG document; `None` if no curve has a point that the axes can show. Without a size, it has that of the
    /// report.
    pub(super) fn svg(
        &self,
        title: &str,
        size: Option<ChartSize>,
    ) -> Result<Option<String>, DrawingError> {
        let width = size.map_or(WIDTH, ChartSize::layout_width);
        let curves = self.visible_curves();
        let Some((mut x, mut y)) = self.layouts(&curves) else { return Ok(None) };
        let legend = legend_rows(&curves, width);
        let legend_height = legend.len() as i32 * LEGEND_ROW_HEIGHT;
        let remark = wrapped(&self.full_remark(), width - 2 * REMARK_MARGIN, REMARK_TEXT);
        let remark_height = if remark.is_empty() {
            0
        } else {
            REMARK_HEIGHT + (remark.len() as i32 - 1) * REMARK_TEXT
        };
        let around = TITLE_HEIGHT + legend_height + BOTTOM_LABELS + 10;
        let plot_height = match size {
            Some(size) => size.plot_height(around + remark_height)?,
            None if self.equal_aspect => 480,
            None => PLOT_HEIGHT,
        };
        if self.equal_aspect {
            let plot_width = width - left_labels(&y) - RIGHT_MARGIN;
            self.equalize(&mut x, &mut y, f64::from(plot_width) / f64::from(plot_height));
        }
        let height = around + plot_height;
        let svg = draw(width, height + remark_height, |sheet| {
            let style = text_style(title_size(title, width), HPos::Center, VPos::Center);
            sheet.draw(&Text::new(title, (fine(width / 2), fine(22)), style)).map_err(failure)?;
            for (row, entries) in legend.iter().enumerate() {
                draw_legend_row(sheet, TITLE_HEIGHT + row as i32 * LEGEND_ROW_HEIGHT, entries)?;
            }
            let (sheet, below) = sheet.split_vertically(fine(height));
            for (row, line) in remark.iter().enumerate() {
                let style = text_style(REMARK_TEXT, HPos::Center, VPos::Center);
                let middle =
                    (fine(width / 2), fine(REMARK_HEIGHT / 2 - 4 + row as i32 * REMARK_TEXT));
                below.draw(&Text::new(line.clone(), middle, style)).map_err(failure)?;
            }
            let (_, plot) = sheet.split_vertically(fine(TITLE_HEIGHT + legend_height));
            draw_plot(&plot, &x, &y, &curves)?;
            if x.has_words() {
                let sides = [left_labels(&y), width - RIGHT_MARGIN];
                draw_words(&sheet, &x, sides, height - BOTTOM_LABELS)?;
            }
            let across = (left_labels(&y) + width - RIGHT_MARGIN) / 2;
            let down = TITLE_HEIGHT + legend_height + plot_height / 2;
            let style = text_style(16, HPos::Center, VPos::Center);
            let below = (fine(across), fine(height - 16));
            sheet.draw(&Text::new(x.caption.clone(), below, style.clone())).map_err(failure)?;
            let upright = style.transform(FontTransform::Rotate270);
            let position = (fine(18), fine(down));
            sheet.draw(&Text::new(y.caption.clone(), position, upright)).map_err(failure)
        })?;
        Ok(Some(size.map_or(svg.clone(), |size| size.shown(&svg, width, height + remark_height))))
    }

    /// Whether the chart shows more than one number: its data is not one dot, and its curves are not one flat line.
    pub(super) fn is_informative(&self) -> bool {
        let curves = self.visible_curves();
        let varies = |values: &mut dyn Iterator<Item = f64>| {
            extremes(values).is_some_and(|(least, greatest)| {
                greatest - least > FLAT_RELATIVE * greatest.abs().max(least.abs())
            })
        };
        let data = curves.iter().filter(|curve| curve.style != CurveStyle::Theory);
        varies(&mut data.flat_map(|curve| &curve.points).map(|point| point.x))
            && varies(&mut curves.iter().flat_map(|curve| &curve.points).map(|point| point.y))
    }

    /// The curves with visible points, without points that the axes cannot show.
    fn visible_curves(&self) -> Vec<Curve> {
        let mut curves = self.curves.clone();
        for curve in &mut curves {
            curve.points.retain(|point| self.x.can_show(point.x) && self.y.can_show(point.y));
        }
        curves.retain(|curve| !curve.points.is_empty());
        curves
    }

    fn layouts(&self, curves: &[Curve]) -> Option<(Layout, Layout)> {
        let points = || curves.iter().flat_map(|curve| &curve.points);
        let ends = points().flat_map(|point| {
            let error = point.error.unwrap_or(0.0);
            [point.y - error, point.y, point.y + error]
        });
        let (left, right) = extremes(points().map(|point| point.x))?;
        let (bottom, top) = extremes(ends.filter(|end| self.y.can_show(*end)))?;
        Some((Layout::new(&self.x, left, right), Layout::new(&self.y, bottom, top)))
    }

    /// Makes both scales equal by widening the shorter range; `shape` is width over height.
    fn equalize(&self, x: &mut Layout, y: &mut Layout, shape: f64) {
        let exponent = x.exponent().max(y.exponent());
        x.adopt_exponent(&self.x, exponent);
        y.adopt_exponent(&self.y, exponent);
        let (width, height) = (x.high - x.low, y.high - y.low);
        if width < height * shape {
            let extra = (height * shape - width) / 2.0;
            x.set_range(x.low - extra, x.high + extra);
        } else {
            let extra = (width / shape - height) / 2.0;
            y.set_range(y.low - extra, y.high + extra);
        }
    }
}

/// The lines of a text that fit a width; a long word has a line of its own.
fn wrapped(text: &str, width: i32, size: i32) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if text_width(&format!("{line} {word}"), size) <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Space for the caption and the tick labels left of the axis.
fn left_labels(y: &Layout) -> i32 {
    46 + TICK_TEXT / 2 * (y.longest_text() as i32 + 1)
}

/// Size of the letters of a title: smaller if it is long, so that it fits the width.
fn title_size(title: &str, width: i32) -> i32 {
    let needed = text_width(title, TITLE_TEXT).max(1);
    (TITLE_TEXT * (width - RIGHT_MARGIN) / needed).clamp(TITLE_TEXT / 2, TITLE_TEXT)
}

/// Arranges the legend in rows that fit the canvas: position from the left, and curve. The parts of an interrupted curve after
/// the first have no name.
fn legend_rows(curves: &[Curve], width: i32) -> Vec<Vec<(i32, &Curve)>> {
    let mut rows: Vec<Vec<(i32, &Curve)>> = Vec::new();
    let mut left = i32::MAX;
    for curve in curves.iter().filter(|curve| !curve.name.is_empty()) {
        let entry = LEGEND_SAMPLE + 8 + text_width(&curve.name, LEGEND_TEXT) + LEGEND_GAP;
        if left.saturating_add(entry) > width - RIGHT_MARGIN {
            rows.push(Vec::new());
            left = LEGEND_LEFT;
        }
        if let Some(row) = rows.last_mut() {
            row.push((left, curve));
        }
        left += entry;
    }
    rows
}

fn draw_legend_row(
    sheet: &Canvas<'_>,
    top: i32,
    entries: &[(i32, &Curve)],
) -> Result<(), DrawingError> {
    let middle = fine(top + LEGEND_ROW_HEIGHT / 2);
    for (left, curve) in entries {
        let color = curve_color(curve.color);
        let ends = [(fine(*left), middle), (fine(left + LEGEND_SAMPLE), middle)];
        match curve.style {
            CurveStyle::Line => sheet.draw(&PathElement::new(ends, stroke(color, 4))),
            CurveStyle::Theory => {
                let [from, to] = ends;
                let dashes =
                    (from.0..to.0).step_by(fine(11).unsigned_abs() as usize).map(|start| {
                        let end = (start + fine(7)).min(to.0);
                        PathElement::new([(start, middle), (end, middle)], stroke(color, 3))
                    });
                dashes.into_iter().try_for_each(|dash| sheet.draw(&dash))
            }
            CurveStyle::Data => {
                let center = (fine(left + LEGEND_SAMPLE / 2), middle);
                sheet.draw(&Circle::new(center, fine(4), color.filled()))
            }
        }
        .map_err(failure)?;
        let style = text_style(LEGEND_TEXT, HPos::Left, VPos::Center);
        let at = (fine(left + LEGEND_SAMPLE + 8), middle);
        sheet.draw(&Text::new(curve.name.clone(), at, style)).map_err(failure)?;
    }
    Ok(())
}

fn draw_plot(
    area: &Canvas<'_>,
    x: &Layout,
    y: &Layout,
    curves: &[Curve],
) -> Result<(), DrawingError> {
    let mut chart = ChartBuilder::on(area)
        .margin_top(fine(10))
        .margin_right(fine(RIGHT_MARGIN))
        .x_label_area_size(fine(BOTTOM_LABELS))
        .y_label_area_size(fine(left_labels(y)))
        .build_cartesian_2d(x.clone(), y.clone())
        .map_err(failure)?;
    chart
        .configure_mesh()
        .axis_style(stroke(INK, 2))
        .bold_line_style(stroke(PALE, 2))
        .light_line_style(TRANSPARENT)
        .set_all_tick_mark_size(fine(5))
        .label_style(text_style(TICK_TEXT, HPos::Left, VPos::Top))
        // Words are drawn in lines of their own.
        .x_label_formatter(&|tick| if x.has_words() { String::new() } else { x.tick_text(*tick) })
        .y_label_formatter(&|tick| y.tick_text(*tick))
        .draw()
        .map_err(failure)?;
    for curve in curves {
        let color = curve_color(curve.color);
        let positions: Vec<(f64, f64)> =
            curve.points.iter().map(|point| (x.position(point.x), y.position(point.y))).collect();
        match curve.style {
            CurveStyle::Line => {
                chart.draw_series(LineSeries::new(positions, stroke(color, 3))).map_err(failure)?;
            }
            CurveStyle::Theory => {
                // Nothing lies between two words.
                let level = |&(x, y): &(f64, f64)| vec![(x - 0.2, y), (x + 0.2, y)];
                let parts = if x.has_words() {
                    positions.iter().map(level).collect()
                } else {
                    vec![positions]
                };
                for part in parts {
                    let dashes = DashedLineSeries::new(part, fine(7), fine(4), stroke(color, 3));
                    chart.draw_series(dashes).map_err(failure)?;
                }
            }
            CurveStyle::Data => {
                chart
                    .draw_series(
                        positions
                            .iter()
                            .map(|position| Circle::new(*position, fine(4), color.filled())),
                    )
                    .map_err(failure)?;
                chart.draw_series(error_bars(curve, x, y, color)).map_err(failure)?;
            }
        }
    }
    Ok(())
}

/// The error bars of a curve. A lower end that a logarithmic axis cannot show ends at the frame.
fn error_bars(
    curve: &Curve,
    x: &Layout,
    y: &Layout,
    color: RGBColor,
) -> Vec<PathElement<(f64, f64)>> {
    let cap = (x.high - x.low) * 0.006;
    let style = stroke(color, 3);
    let bar = |point: &Point| {
        let error = point.error.filter(|error| *error > 0.0)?;
        let (center, top) = (x.position(point.x), y.position(point.y + error));
        let low = y.position(point.y - error);
        let reached = low.is_finite() && low >= y.low;
        let bottom = if reached { low } else { y.low };
        let across = |height: f64| vec![(center - cap, height), (center + cap, height)];
        let mut paths = vec![vec![(center, bottom), (center, top)], across(top)];
        if reached {
            paths.push(across(bottom));
        }
        Some(paths)
    };
    curve
        .points
        .iter()
        .filter_map(bar)
        .flatten()
        .map(|path| PathElement::new(path, style))
        .collect()
}

/// Maximum number of points of a curve; more would not be visible.
const MAX_POINTS: usize = 1500;

/// Thins a long curve: keeps the minimum and maximum of each group of neighbors, in order.
pub(crate) fn thinned(points: Vec<Point>) -> Vec<Point> {
    if points.len() <= MAX_POINTS {
        return points;
    }
    let run = points.len().div_ceil(MAX_POINTS / 2);
    let mut kept = Vec::with_capacity(MAX_POINTS);
    for neighbors in points.chunks(run) {
        let by_height = |a: &&Point, b: &&Point| a.y.total_cmp(&b.y);
        let least = neighbors.iter().min_by(by_height);
        let greatest = neighbors.iter().max_by(by_height);
        if let (Some(a), Some(b)) = (least, greatest) {
            let (first, second) = if a.x <= b.x { (a, b) } else { (b, a) };
            kept.push(*first);
            kept.push(*second);
        }
    }
    kept
}
