//! The legend of a chart: labels at the ends of the curves where there is room, or rows above the axes.

use super::axis::Layout;
use super::canvas::{
    Canvas, DrawingError, curve_color, dashes, failure, fine, stroke, text_style, text_width,
};
use super::curve::{Curve, CurveStyle};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// Space right of the plotted area of a chart without labels at the ends of its curves.
pub(super) const RIGHT_MARGIN: i32 = 32;
pub(super) const LEGEND_ROW_HEIGHT: i32 = 22;
const LEGEND_LEFT: i32 = 92;
const LEGEND_TEXT: i32 = 16;
const LEGEND_SAMPLE: i32 = 30;
const LEGEND_GAP: i32 = 22;

/// Letters of a label at the end of a curve.
const LABEL_TEXT: i32 = 14;
/// Length of the line from the end of a curve to its label, and the gaps around the sample.
const LEADER: i32 = 10;
const LABEL_SAMPLE: i32 = 14;
const LABEL_GAP: i32 = 6;
/// Distance of two labels.
const LABEL_HEIGHT: i32 = 18;
/// Maximum width of the labels over that of the chart.
const MAX_LABELS_OVER_WIDTH: f64 = 0.42;
/// Number of entries from which labels at the ends are easier to read than a legend.
const FEWEST_LABELS: usize = 3;

/// The beginning of the name of a line that shows how steep a power law is, which its entry states.
pub(crate) const SLOPE: &str = "slope ";

/// An entry of the legend: a curve, and the first theory or fit that shares the entry.
#[derive(Clone, Copy)]
pub(super) struct Entry<'a> {
    pub(super) curve: &'a Curve,
    comparison: Option<&'a Curve>,
}

impl Entry<'_> {
    /// Its text: the name of the curve, with the slope of its line.
    fn label(&self) -> String {
        let line = self.comparison.and_then(|line| line.name.split_once(": "));
        match line.filter(|(_, of)| of.starts_with(SLOPE)) {
            Some((_, slope)) => format!("{}, {slope}", self.curve.name),
            None => self.curve.name.clone(),
        }
    }
}

/// One entry per named curve. The first theory or fit that is named after its curve, such as `RK4: theory` after `RK4`, shares the entry of that curve.
/// The parts of an interrupted curve after the first have no name.
pub(super) fn entries(curves: &[Curve]) -> Vec<Entry<'_>> {
    let mut entries: Vec<Entry<'_>> = Vec::new();
    for curve in curves.iter().filter(|curve| !curve.name.is_empty()) {
        let measured = entries.iter_mut().find(|entry| is_compared_with(curve, entry));
        match measured {
            Some(entry) => {
                entry.comparison.get_or_insert(curve);
            }
            None => entries.push(Entry { curve, comparison: None }),
        }
    }
    entries
}

/// Whether a curve is the theory or the fit of an entry's curve and is named after it, and no other style shares the entry.
fn is_compared_with(comparison: &Curve, entry: &Entry<'_>) -> bool {
    let of_curve = comparison.name.strip_prefix(&entry.curve.name);
    comparison.style.is_comparison()
        && comparison.color == entry.curve.color
        && entry.comparison.is_none_or(|line| line.style == comparison.style)
        && of_curve.is_some_and(|rest| rest.starts_with(": "))
}

/// Arranges the entries in rows that fit the canvas, each with its position from the left.
pub(super) fn rows<'a>(entries: &[Entry<'a>], width: i32) -> Vec<Vec<(i32, Entry<'a>)>> {
    let mut rows: Vec<Vec<(i32, Entry<'a>)>> = Vec::new();
    let mut left = i32::MAX;
    for entry in entries {
        let needed = LEGEND_SAMPLE + 8 + text_width(&entry.label(), LEGEND_TEXT) + LEGEND_GAP;
        if left.saturating_add(needed) > width - RIGHT_MARGIN {
            rows.push(Vec::new());
            left = LEGEND_LEFT;
        }
        if let Some(row) = rows.last_mut() {
            row.push((left, *entry));
        }
        left += needed;
    }
    rows
}

/// Draws a row of the legend.
pub(super) fn draw_row(
    sheet: &Canvas<'_>,
    top: i32,
    row: &[(i32, Entry<'_>)],
) -> Result<(), DrawingError> {
    let middle = top + LEGEND_ROW_HEIGHT / 2;
    for (left, entry) in row {
        draw_sample(sheet, *entry, [*left, left + LEGEND_SAMPLE], middle)?;
        let style = text_style(LEGEND_TEXT, HPos::Left, VPos::Center);
        let at = (fine(left + LEGEND_SAMPLE + 8), fine(middle));
        sheet.draw(&Text::new(entry.label(), at, style)).map_err(failure)?;
    }
    Ok(())
}

/// Labels at the ends of the curves, right of the plotted area.
pub(super) struct EndLabels<'a> {
    /// Each entry with the height of the end of its curve and that of its label, px below the top of the plotted area.
    labels: Vec<(Entry<'a>, i32, i32)>,
    /// Width of the margin that holds them, px.
    pub(super) width: i32,
}

impl<'a> EndLabels<'a> {
    /// The labels of a chart of this width and height of the plotted area; `None` for few entries, or where there is no room.
    pub(super) fn new(
        entries: &[Entry<'a>],
        y: &Layout,
        [width, height]: [i32; 2],
    ) -> Option<Self> {
        // Letters of common fonts are up to 9/16 as wide as they are high, on average.
        let widths = entries.iter().map(|entry| 9 * text_width(&entry.label(), LABEL_TEXT) / 8);
        let needed = LEADER + LABEL_SAMPLE + 2 * LABEL_GAP + widths.max()?;
        let has_room = f64::from(needed) <= MAX_LABELS_OVER_WIDTH * f64::from(width)
            && entries.len() as i32 * LABEL_HEIGHT <= height;
        if entries.len() < FEWEST_LABELS || !has_room {
            return None;
        }
        let down = |value: f64| {
            let fraction = ((y.high - y.position(value)) / (y.high - y.low)).clamp(0.0, 1.0);
            libm::round(fraction * f64::from(height)) as i32
        };
        let mut below = None;
        let mut labels: Vec<(Entry<'a>, i32, i32)> = Vec::new();
        for entry in entries {
            let end = down(end_of(entry.curve)?);
            let mut middle = end;
            if entry.curve.style == CurveStyle::Area {
                // An area is labeled in the middle of its end.
                middle = i32::midpoint(end, below.unwrap_or(down(0.0)));
                below = Some(end);
            }
            labels.push((*entry, middle, middle));
        }
        labels.sort_by_key(|(_, end, _)| *end);
        let mut least = LABEL_HEIGHT / 2;
        for (_, _, at) in &mut labels {
            *at = (*at).max(least);
            least = *at + LABEL_HEIGHT;
        }
        let mut most = height - LABEL_HEIGHT / 2;
        for (_, _, at) in labels.iter_mut().rev() {
            *at = (*at).min(most);
            most = *at - LABEL_HEIGHT;
        }
        Some(Self { labels, width: needed })
    }

    /// Draws the labels right of a plotted area with this right edge and top.
    pub(super) fn draw(
        &self,
        sheet: &Canvas<'_>,
        right: i32,
        top: i32,
    ) -> Result<(), DrawingError> {
        for (entry, end, at) in &self.labels {
            let color = curve_color(entry.curve.color);
            let leader = [(right, top + end), (right + LEADER, top + at)];
            let leader = leader.map(|(across, down)| (fine(across), fine(down)));
            sheet.draw(&PathElement::new(leader, stroke(color, 1))).map_err(failure)?;
            let left = right + LEADER + LABEL_GAP / 2;
            draw_sample(sheet, *entry, [left, left + LABEL_SAMPLE], top + at)?;
            let style = text_style(LABEL_TEXT, HPos::Left, VPos::Center);
            let place = (fine(left + LABEL_SAMPLE + LABEL_GAP), fine(top + at));
            sheet.draw(&Text::new(entry.label(), place, style)).map_err(failure)?;
        }
        Ok(())
    }
}

/// The value of a curve at its right end.
fn end_of(curve: &Curve) -> Option<f64> {
    let last = curve.points.iter().max_by(|one, other| one.x.total_cmp(&other.x));
    last.map(|point| point.y)
}

/// Draws the sample of a curve between two abscissas.
fn draw_sample(
    sheet: &Canvas<'_>,
    entry: Entry<'_>,
    [left, right]: [i32; 2],
    middle: i32,
) -> Result<(), DrawingError> {
    let color = curve_color(entry.curve.color);
    let ends = [(fine(left), fine(middle)), (fine(right), fine(middle))];
    let draw_dashes = || {
        let [dash, gap] = dashes(entry.curve.color).map(fine);
        let starts = (ends[0].0..ends[1].0).step_by((dash + gap).unsigned_abs() as usize);
        starts
            .map(|start| {
                let end = (start + dash).min(ends[1].0);
                PathElement::new([(start, ends[0].1), (end, ends[0].1)], stroke(color, 3))
            })
            .try_for_each(|dash| sheet.draw(&dash))
    };
    match entry.comparison.map(|line| line.style) {
        Some(CurveStyle::Fit) => sheet.draw(&PathElement::new(ends, stroke(color, 3))),
        Some(_) => draw_dashes(),
        None => Ok(()),
    }
    .map_err(failure)?;
    match entry.curve.style {
        CurveStyle::Line | CurveStyle::Fit => sheet.draw(&PathElement::new(ends, stroke(color, 4))),
        CurveStyle::Theory => draw_dashes(),
        CurveStyle::Data => {
            let center = (fine(i32::midpoint(left, right)), fine(middle));
            sheet.draw(&Circle::new(center, fine(4), color.filled()))
        }
        CurveStyle::Area => {
            let corners = [(fine(left), fine(middle - 6)), (fine(right), fine(middle + 6))];
            sheet.draw(&Rectangle::new(corners, area_style(color)))
        }
    }
    .map_err(failure)
}

/// The filling of an area, through which the grid is visible.
pub(super) fn area_style(color: RGBColor) -> ShapeStyle {
    color.mix(0.75).filled()
}
