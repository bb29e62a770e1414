//! Curves of a chart.

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
    /// An area from the previous one, or from 0, up to the points. All areas of a chart have the same abscissas.
    Area,
    /// A line through the points, for a fit of data: it differs from theory of the same color by its dashes, also in print and with any color vision.
    Fit,
}

impl CurveStyle {
    /// The style in one word, as in the page and in the JSON of `plot`.
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::Line => "line",
            Self::Theory => "theory",
            Self::Data => "data",
            Self::Area => "area",
            Self::Fit => "fit",
        }
    }

    /// Whether such a curve is drawn for comparison with others.
    pub(crate) const fn is_comparison(self) -> bool {
        matches!(self, Self::Theory | Self::Fit)
    }
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

/// Areas on top of each other: each column holds the amounts of one area at these abscissas. A column with a negative amount is
/// shifted as a whole so that it has none. Returns the areas and the sum of the shifts.
pub(crate) fn stacked(abscissas: &[f64], columns: &[(&str, usize, Vec<f64>)]) -> (Vec<Curve>, f64) {
    let stride = abscissas.len().div_ceil(MAX_POINTS / 2).max(1);
    let last = abscissas.len().saturating_sub(1);
    let is_kept = |index: &usize| index.is_multiple_of(stride) || *index == last;
    let kept: Vec<usize> = (0..abscissas.len()).filter(is_kept).collect();
    let (mut tops, mut shifts) = (vec![0.0; abscissas.len()], 0.0);
    let mut areas = Vec::new();
    for (name, color, amounts) in columns {
        let shift = -amounts.iter().copied().fold(0.0, f64::min);
        shifts += shift;
        for (top, amount) in tops.iter_mut().zip(amounts) {
            *top += amount + shift;
        }
        let points = kept.iter().map(|&index| Point::bare(abscissas[index], tops[index])).collect();
        areas.push(Curve {
            name: (*name).to_owned(),
            style: CurveStyle::Area,
            color: *color,
            points,
        });
    }
    (areas, shifts)
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
