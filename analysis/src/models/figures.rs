//! Plots of a run, and what the models' plots share.

use crate::models::snapshots::Snapshots;
use crate::number_text::short_number;
use crate::plot::{Axis, DRAWS, Picture, Plot, PlotContent, Point, Scale, thinned};
use kinetoscope_recording::plot_list::is_plot_name;
use serde::{Deserialize, Serialize};

/// The plots of one run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Figures {
    /// Plots of this run only.
    pub(crate) plots: Vec<Plot>,
    /// Curves that are drawn in one chart for several runs.
    pub(crate) comparisons: Vec<SharedCurve>,
}

impl Figures {
    /// Keeps the plots whose file names satisfy a condition.
    pub(crate) fn retain(&mut self, keeps: impl Fn(&str) -> bool) {
        self.plots.retain(|plot| keeps(&plot.stem));
        self.comparisons.retain(|curve| keeps(&curve.stem));
    }

    /// Whether all plots have names of files in their folder. A cache may claim others.
    pub(crate) fn have_plain_names(&self) -> bool {
        let stems = self.plots.iter().map(|plot| &plot.stem);
        let mut stems = stems.chain(self.comparisons.iter().map(|curve| &curve.stem));
        stems.all(|stem| is_plot_name(&format!("{stem}.svg")))
    }
}

/// A run's curve in a chart that it shares with other runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SharedCurve {
    /// The chart's file name without its extension.
    pub(crate) stem: String,
    /// The chart's title.
    pub(crate) title: String,
    /// The horizontal and the vertical axis.
    pub(crate) axes: [Axis; 2],
    /// The run's curve.
    pub(crate) points: Vec<Point>,
}

impl SharedCurve {
    pub(crate) fn new(
        stem: &str,
        title: &str,
        axes: [Axis; 2],
        points: impl Iterator<Item = (f64, f64)>,
    ) -> Self {
        let points = thinned(points.map(|(x, y)| Point::bare(x, y)).collect());
        Self { stem: stem.to_owned(), title: title.to_owned(), axes, points }
    }
}

/// Ratio of the last to the first frame interval above which a linear time axis would hide the first frames.
const LOGARITHMIC_RATIO: f64 = 10.0;

/// The scale of a time axis: logarithmic if the frame interval grows, as for frames that are even in the logarithm of time.
pub(crate) fn time_scale_of(times: impl Iterator<Item = f64>) -> Scale {
    let times: Vec<f64> = times.filter(|time| *time > 0.0).collect();
    let gaps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    match (gaps.first(), gaps.last()) {
        (Some(first), Some(last)) if *last > LOGARITHMIC_RATIO * first => Scale::Logarithmic,
        _ => Scale::Linear,
    }
}

/// A time axis of this scale for these times.
pub(crate) fn time_axis(times: impl Iterator<Item = f64>, unit: &str) -> Axis {
    Axis { scale: time_scale_of(times), ..Axis::linear("time", unit) }
}

/// Pictures of the snapshots of a run and of their velocities if those are drawn; `caption` takes the number of particles and the time as text, and `size` is that of
/// the container.
pub(crate) fn pictures<'a>(
    snapshots: &'a Snapshots,
    particles: &'a str,
    caption: impl Fn(&str, &str) -> String + 'a,
    size: &'a str,
) -> impl Iterator<Item = Plot> + 'a {
    let named = DRAWS.then(|| snapshots.named());
    named.into_iter().flatten().flat_map(move |(stem, when, snapshot)| {
        let count = match (snapshot.particles, snapshot.drawing.discs.len()) {
            (all, drawn) if drawn < all => format!("N = {all} ({drawn} drawn)"),
            (all, _) => format!("N = {all}"),
        };
        let caption = caption(&count, &short_number(snapshot.time));
        let plot = |name: &str, title: &str, drawing| Plot {
            stem: format!("{name}_at_{stem}"),
            title: format!("{title} {when}"),
            content: PlotContent::Picture(Picture {
                caption: caption.clone(),
                size: size.to_owned(),
                drawing,
            }),
        };
        let velocities = snapshot.velocities.map(|field| plot("velocity", "Velocities", field));
        [Some(plot("state", particles, snapshot.drawing)), velocities].into_iter().flatten()
    })
}

/// Formats the size of a box.
pub(crate) fn box_text(sides: [f64; 2], unit: &str) -> String {
    let [width, height] = sides.map(|side| format!("{} {unit}", short_number(side)));
    format!("box of {} × {}", width.trim_end(), height.trim_end())
}
