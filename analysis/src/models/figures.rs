//! Which plots a run has: one file a model.

use crate::models::snapshots::NamedSnapshot;
use crate::plot::{Axis, Chart, Curve, CurveStyle, Picture, Plot, Point, short_number, thinned};
use serde::{Deserialize, Serialize};

/// The plots of one run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Drawn for each run on its own.
    pub plots: Vec<Plot>,
    /// Curves that are drawn for several runs side by side.
    pub comparisons: Vec<SharedCurve>,
}

/// A run's curve in a chart that it shares with other runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SharedCurve {
    /// The chart's file name without its ending.
    pub stem: String,
    /// What is shown.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The run's curve.
    pub points: Vec<Point>,
}

/// Points of a curve beyond these would not show.
pub(crate) const MOST_POINTS: usize = 1500;

/// A curve without errors, thinned to what shows.
pub(crate) fn curve(
    name: impl Into<String>,
    style: CurveStyle,
    color: usize,
    points: impl IntoIterator<Item = (f64, f64)>,
) -> Curve {
    let points = points.into_iter().map(|(x, y)| Point::bare(x, y)).collect();
    Curve { name: name.into(), style, color, points: thinned(points, MOST_POINTS) }
}

/// A chart with unequal axes.
pub(crate) fn chart(stem: &str, title: &str, x: Axis, y: Axis, curves: Vec<Curve>) -> Plot {
    let (stem, title) = (stem.to_owned(), title.to_owned());
    Plot::Chart(Chart { stem, title, x, y, equal_aspect: false, curves })
}

/// The pictures of a run: title of each from what it shows and when, caption from its count and its time.
pub(crate) fn pictures(
    placed: Vec<NamedSnapshot>,
    what: &str,
    caption: impl Fn(&str, &str) -> String,
    sheet: &Picture,
) -> Vec<Plot> {
    placed
        .into_iter()
        .map(|NamedSnapshot { stem, words, snapshot }| {
            let count = count_text(snapshot.particles, snapshot.bodies.len());
            Plot::Picture(Picture {
                stem: format!("state_at_{stem}"),
                title: format!("{what} {words}"),
                caption: caption(&count, &short_number(snapshot.time)),
                bodies: snapshot.bodies,
                ..sheet.clone()
            })
        })
        .collect()
}

/// "N = 1000" with a word on what is not drawn.
fn count_text(particles: usize, drawn: usize) -> String {
    if drawn < particles {
        format!("N = {particles} (the first {drawn} drawn)")
    } else {
        format!("N = {particles}")
    }
}
