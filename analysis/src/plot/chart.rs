//! Charts: curves, points with error bars, and theory lines over two axes.

use super::axis::{Axis, FLAT_RELATIVE, Layout, Scale, extremes};
use super::canvas::{
    Canvas, DrawingError, INK, PALE, curve_color, dashes, draw, failure, fine, stroke, text_style,
    text_width,
};
use super::chart_size::{ChartSize, WIDTH};
use super::curve::{Curve, CurveStyle, Point};
use super::legend::{self, EndLabels, LEGEND_ROW_HEIGHT, RIGHT_MARGIN, area_style};
use super::word_labels::draw_words;
use kinetoscope_console::text::plural;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use serde::{Deserialize, Serialize};

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

/// Ratio of the greatest to the first value of a curve that grows.
const GROWTH: f64 = 30.0;

const PLOT_HEIGHT: i32 = 360;
const TITLE_HEIGHT: i32 = 40;
const BOTTOM_LABELS: i32 = 58;
const TOP_MARGIN: i32 = 10;
const TITLE_TEXT: i32 = 20;
const TICK_TEXT: i32 = 15;
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
        let entries = legend::entries(&curves);
        let rows = legend::rows(&entries, width);
        let mut legend_height = rows.len() as i32 * LEGEND_ROW_HEIGHT;
        let remark = wrapped(&self.full_remark(), width - 2 * REMARK_MARGIN, REMARK_TEXT);
        let remark_height = if remark.is_empty() {
            0
        } else {
            REMARK_HEIGHT + (remark.len() as i32 - 1) * REMARK_TEXT
        };
        let height_of_plot = |legend_height: i32| match size {
            Some(size) => {
                size.plot_height(TITLE_HEIGHT + legend_height + BOTTOM_LABELS + 10 + remark_height)
            }
            None if self.equal_aspect => Ok(480),
            None => Ok(PLOT_HEIGHT),
        };
        let mut plot_height = height_of_plot(legend_height)?;
        let labels = match size.map_or(Some(PLOT_HEIGHT), |_| height_of_plot(0).ok()) {
            Some(height) if !self.equal_aspect => EndLabels::new(&entries, &y, [width, height]),
            _ => None,
        };
        if labels.is_some() {
            legend_height = 0;
            plot_height = height_of_plot(0)?;
        }
        let margin = labels.as_ref().map_or(RIGHT_MARGIN, |labels| labels.width);
        if self.equal_aspect {
            let plot_width = width - left_labels(&y) - margin;
            self.equalize(&mut x, &mut y, f64::from(plot_width) / f64::from(plot_height));
        }
        let height = TITLE_HEIGHT + legend_height + BOTTOM_LABELS + 10 + plot_height;
        let sides = [left_labels(&y), width - margin];
        let svg = draw(width, height + remark_height, |sheet| {
            let style = text_style(title_size(title, width), HPos::Center, VPos::Center);
            sheet.draw(&Text::new(title, (fine(width / 2), fine(22)), style)).map_err(failure)?;
            if let Some(labels) = &labels {
                labels.draw(sheet, sides[1], TITLE_HEIGHT + TOP_MARGIN)?;
            } else {
                for (row, entries) in rows.iter().enumerate() {
                    let top = TITLE_HEIGHT + row as i32 * LEGEND_ROW_HEIGHT;
                    legend::draw_row(sheet, top, entries)?;
                }
            }
            let (sheet, below) = sheet.split_vertically(fine(height));
            for (row, line) in remark.iter().enumerate() {
                let style = text_style(REMARK_TEXT, HPos::Center, VPos::Center);
                let middle =
                    (fine(width / 2), fine(REMARK_HEIGHT / 2 - 4 + row as i32 * REMARK_TEXT));
                below.draw(&Text::new(line.clone(), middle, style)).map_err(failure)?;
            }
            let (_, plot) = sheet.split_vertically(fine(TITLE_HEIGHT + legend_height));
            draw_plot(&plot, &x, &y, &curves, margin)?;
            if x.has_words() {
                draw_words(&sheet, &x, sides, height - BOTTOM_LABELS)?;
            }
            let across = i32::midpoint(sides[0], sides[1]);
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
        let data = curves.iter().filter(|curve| !curve.style.is_comparison());
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
        let has_areas = curves.iter().any(|curve| curve.style == CurveStyle::Area);
        let ends = ends.chain(has_areas.then_some(0.0));
        let (left, right) = extremes(points().map(|point| point.x))?;
        let (bottom, top) = extremes(ends.filter(|end| self.y.can_show(*end)))?;
        let bottom = self.floor(curves).map_or(bottom, |floor| bottom.max(floor.min(top)));
        Some((Layout::new(&self.x, left, right), Layout::new(&self.y, bottom, top)))
    }

    /// Lower end of a logarithmic axis of lines: the first value above zero of a curve that grows, which is the precision of an error.
    /// Rounding and changes of sign give values below it, which would stretch the axis. A curve that does not grow is shown as a whole.
    pub(crate) fn floor(&self, curves: &[Curve]) -> Option<f64> {
        let is_line = |curve: &Curve| curve.style == CurveStyle::Line;
        if self.y.scale != Scale::Logarithmic || !curves.iter().all(is_line) {
            return None;
        }
        let floor = |curve: &Curve| {
            let mut above = curve.points.iter().map(|point| point.y).filter(|y| *y > 0.0);
            let first = above.next()?;
            let (least, greatest) = extremes(above)?;
            Some(if greatest > GROWTH * first { first } else { least.min(first) })
        };
        extremes(curves.iter().filter_map(floor)).map(|(least, _)| least)
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

/// Number of letters of tick labels for which there is space at least, so that charts below each other have equal margins.
const LEAST_LETTERS: usize = 5;

/// Space for the caption and the tick labels left of the axis.
fn left_labels(y: &Layout) -> i32 {
    46 + TICK_TEXT / 2 * (y.longest_text().max(LEAST_LETTERS) as i32 + 1)
}

/// Size of the letters of a title: smaller if it is long, so that it fits the width.
fn title_size(title: &str, width: i32) -> i32 {
    let needed = text_width(title, TITLE_TEXT).max(1);
    (TITLE_TEXT * (width - RIGHT_MARGIN) / needed).clamp(TITLE_TEXT / 2, TITLE_TEXT)
}

fn draw_plot(
    area: &Canvas<'_>,
    x: &Layout,
    y: &Layout,
    curves: &[Curve],
    right_margin: i32,
) -> Result<(), DrawingError> {
    let mut chart = ChartBuilder::on(area)
        .margin_top(fine(TOP_MARGIN))
        .margin_right(fine(right_margin))
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
    // Below a raised lower end of a logarithmic axis, curves run along the frame.
    let place = |point: &Point| (x.position(point.x), y.position(point.y).max(y.low));
    let mut below: Vec<(f64, f64)> = Vec::new();
    for curve in curves {
        let color = curve_color(curve.color);
        let positions: Vec<(f64, f64)> = curve.points.iter().map(place).collect();
        match curve.style {
            CurveStyle::Area => {
                if below.is_empty() {
                    below = positions.iter().map(|(x, _)| (*x, y.position(0.0))).collect();
                }
                let outline = positions.iter().chain(below.iter().rev()).copied();
                let area = Polygon::new(outline.collect::<Vec<_>>(), area_style(color));
                chart.draw_series([area]).map_err(failure)?;
                below = positions;
            }
            CurveStyle::Line | CurveStyle::Fit => {
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
                    let [dash, gap] = dashes(curve.color).map(fine);
                    let dashes = DashedLineSeries::new(part, dash, gap, stroke(color, 3));
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
