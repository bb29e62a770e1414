//! Plots of a run, and what the models' plots share.

use crate::models::snapshots::{NamedSnapshot, Snapshots};
use crate::plot::{Axis, Chart, Curve, CurveStyle, Picture, Plot, Point, short_number, thinned};
use serde::{Deserialize, Serialize};

/// The plots of one run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Plots of this run only.
    pub plots: Vec<Plot>,
    /// Curves that are drawn in one chart for several runs.
    pub comparisons: Vec<SharedCurve>,
}

/// A run's curve in a chart that it shares with other runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SharedCurve {
    /// The chart's file name without its extension.
    pub stem: String,
    /// The chart's title.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The run's curve.
    pub points: Vec<Point>,
}

/// Maximum number of points of a curve; more would not be visible.
pub(crate) const MAX_POINTS: usize = 1500;

/// A curve without error bars, thinned to the visible points.
pub(crate) fn curve(
    name: impl Into<String>,
    style: CurveStyle,
    color: usize,
    points: impl IntoIterator<Item = (f64, f64)>,
) -> Curve {
    let points = points.into_iter().map(|(x, y)| Point::bare(x, y)).collect();
    Curve { name: name.into(), style, color, points: thinned(points, MAX_POINTS) }
}

/// A chart with unequal axes.
pub(crate) fn chart(stem: &str, title: &str, x: Axis, y: Axis, curves: Vec<Curve>) -> Plot {
    let (stem, title) = (stem.to_owned(), title.to_owned());
    Plot::Chart(Chart { stem, title, x, y, equal_aspect: false, curves })
}

/// Pictures of the snapshots of a run; `caption` takes the number of particles and the time as text, and `size` is that of
/// the container.
pub(crate) fn pictures(
    snapshots: &Snapshots,
    particles: &str,
    caption: impl Fn(&str, &str) -> String,
    size: &str,
) -> Vec<Plot> {
    let picture = |NamedSnapshot { stem, words, snapshot }: NamedSnapshot| {
        let count = count_text(snapshot.particles, snapshot.drawing.discs.len());
        Plot::Picture(Picture {
            stem: format!("state_at_{stem}"),
            title: format!("{particles} {words}"),
            caption: caption(&count, &short_number(snapshot.time)),
            size: size.to_owned(),
            drawing: snapshot.drawing,
        })
    };
    snapshots.named().into_iter().map(picture).collect()
}

/// Formats the size of a box.
pub(crate) fn box_text(sides: [f64; 2], unit: &str) -> String {
    let [width, height] = sides.map(|side| format!("{} {unit}", short_number(side)));
    format!("box of {} × {}", width.trim_end(), height.trim_end())
}

/// Formats the number of particles and, if fewer are drawn, their number.
fn count_text(particles: usize, drawn: usize) -> String {
    if drawn < particles {
        format!("N = {particles} ({drawn} drawn)")
    } else {
        format!("N = {particles}")
    }
}
