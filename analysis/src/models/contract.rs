//! What the analysis of a model consists of: its metrics, an observer of its frames, its plots, and its fits over a sweep.
//!
//! Observers turn frames into numbers in bounded memory and do not depend on plots; a model's `figures.rs` reads its observer.

use crate::metric::{Definition, Measurements};
use crate::models::figures::Figures;
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_recording::drawing::Shape;
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::RecordedFrame;
use serde::Serialize;

/// Reads the frames of one run in order and derives its metrics.
pub(crate) trait Observer {
    /// Takes in the next frame.
    ///
    /// # Errors
    /// A message that cannot be decoded.
    fn observe(&mut self, frame: RecordedFrame) -> Result<(), ReadError>;

    /// Adds the run's metrics, without those whose channels were not recorded.
    fn measure(&self, found: &mut Measurements);
}

/// An observer whose run can be plotted.
pub(crate) trait PlottedObserver: Observer {
    /// The run's plots.
    fn figures(&self) -> Figures;
}

/// The analysis of one model.
pub(crate) struct ModelAnalysis {
    /// The model's name in the manifest.
    pub(crate) name: &'static str,
    /// The model's heading in the metrics reference.
    pub(crate) title: &'static str,
    /// The metrics of a run.
    pub(crate) metrics: &'static [&'static Definition],
    /// Counts of what a correct run never has: a run with one above 0 fails, unless a check states that it is expected.
    pub(crate) never: &'static [&'static Definition],
    /// Metrics that have no standard error in a single run, because other starts give other values.
    pub(crate) needs_replicates: &'static [&'static Definition],
    /// Metrics that follow from the states of all frames, not only from scalars and from the first and the last state.
    pub(crate) needs_all_states: &'static [&'static Definition],
    /// The metrics of a sweep, which [`Self::fits`] derive.
    pub(crate) sweep_metrics: &'static [&'static Definition],
    /// Fits along an axis of a sweep.
    pub(crate) fits: &'static [Fit],
    /// Metrics that are plotted against swept numbers.
    pub(crate) ordinates: &'static [Ordinate],
    /// Pairs of metrics that are plotted against each other.
    pub(crate) trade_offs: &'static [TradeOff],
    /// The charts of a run that a plot may name.
    pub(crate) figures: &'static [NamedChart],
}

/// What answers where neither a check nor a plot states what is asked: it depends on what a manifest sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MainResults {
    /// The metrics, the most telling one first; those that every run has are used.
    pub(crate) metrics: &'static [&'static str],
    /// The charts, likewise; for several runs those that the runs share.
    pub(crate) charts: &'static [&'static str],
}

impl MainResults {
    pub(crate) const fn new(
        metrics: &'static [&'static str],
        charts: &'static [&'static str],
    ) -> Self {
        Self { metrics, charts }
    }
}

/// A chart of a run that a plot may name. Whether a run has it depends on its manifest and its channels.
#[derive(Clone, Copy)]
pub(crate) struct NamedChart {
    /// Its file name without the extension.
    pub(crate) stem: &'static str,
    /// The metrics that it shows over time, or as numbers of its curves.
    pub(crate) metrics: &'static [&'static str],
    /// Whether it shows the states of all frames.
    pub(crate) needs_all_states: bool,
}

impl NamedChart {
    /// A chart of scalars, or of the first and the last state.
    pub(crate) const fn new(stem: &'static str, metrics: &'static [&'static str]) -> Self {
        Self { stem, metrics, needs_all_states: false }
    }

    /// A chart of the states of all frames.
    pub(crate) const fn of_all_states(
        stem: &'static str,
        metrics: &'static [&'static str],
    ) -> Self {
        Self { stem, metrics, needs_all_states: true }
    }
}

/// What the density by height is compared with: the heights of the lowest and the highest border, in the model's length unit, and for each layer of equal
/// height the fraction of the area and, by the law, that of the particles.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct HeightLayers {
    pub(crate) range: [f64; 2],
    pub(crate) areas: Vec<f64>,
    pub(crate) law: Vec<f64>,
}

/// Size and shape of a model's particles and of their container, in the model's length unit.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Extent {
    /// Radius of particles without a radius in the state; 0 for points.
    pub(crate) radius: f64,
    /// Lower left and upper right corner of the container; `None` without walls.
    pub(crate) bounds: Option<[[f64; 2]; 2]>,
    /// The container and the walls at rest, drawn where no walls were recorded.
    pub(crate) walls: Vec<Shape>,
    /// Whether a replay draws the path of each particle.
    pub(crate) has_trails: bool,
    /// Whether particles that leave through a side enter through the opposite one.
    pub(crate) is_periodic: bool,
    /// How discs fly between the collisions of `/events`, if the model can record them.
    pub(crate) flight: Option<Flight>,
}

/// The flight of a disc between collisions.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Flight {
    /// Impulse over change of velocity; discs have these in turn.
    pub(crate) masses: Vec<f64>,
    /// Acceleration downward.
    pub(crate) gravity: f64,
}

/// A fit of a metric along an axis of a sweep.
#[derive(Clone, Copy)]
pub(crate) struct Fit {
    /// The swept key.
    pub(crate) along: &'static str,
    /// The metric that is the abscissa; `None` for the swept key itself.
    pub(crate) over: Option<&'static str>,
    /// The metric that is the ordinate.
    pub(crate) of: &'static str,
    /// The fitted function.
    pub(crate) shape: FitShape,
    /// The metrics that the function's parameters are.
    pub(crate) parameters: &'static [&'static Definition],
    /// The theoretical value of the first parameter.
    pub(crate) theory: fn(&ModelConfig) -> Option<f64>,
    /// Given if the fit is an order of convergence: all runs must end at the same time, the theory must know an order, and only
    /// runs in this range are used.
    pub(crate) asymptotic_range: Option<AsymptoticRange>,
}

/// Where an error is proportional to a power of the step.
#[derive(Clone, Copy)]
pub(crate) struct AsymptoticRange {
    /// The metric that is the phase error, rad; it must be small.
    pub(crate) phase_error: &'static str,
    /// Rounding error of the fitted metric, from the configuration and the end time; the metric must be much larger.
    pub(crate) rounding: fn(&ModelConfig, f64) -> f64,
}

impl Fit {
    /// A fit over the swept key itself, without a theoretical value.
    pub(crate) const fn new(
        along: &'static str,
        of: &'static str,
        shape: FitShape,
        parameters: &'static [&'static Definition],
    ) -> Self {
        let theory = |_: &ModelConfig| None;
        Self { along, over: None, of, shape, parameters, theory, asymptotic_range: None }
    }
}

/// A fitted function, with its parameters in order.
#[derive(Clone, Copy)]
pub(crate) enum FitShape {
    /// A line, with slope and intercept.
    Line,
    /// A power law, with its exponent.
    PowerLaw,
    /// A saturating exponential y = s (1 - exp(-x/s)), with s and the root mean square relative deviation from the fit.
    Saturation,
}

/// A metric that is plotted against swept numbers.
#[derive(Clone, Copy)]
pub(crate) struct Ordinate {
    /// The metric's name.
    pub(crate) metric: &'static str,
    /// The quantity, as axis label and title.
    pub(crate) title: &'static str,
    /// Whether both axes are logarithmic whatever the range.
    pub(crate) is_power_law: bool,
    /// A second metric in the same chart, with its name there.
    pub(crate) companion: Option<(&'static str, &'static str)>,
    /// The order of an error in a swept key, drawn as a line through the point of the smallest key.
    pub(crate) order: Option<OrderInKey>,
}

impl Ordinate {
    /// A metric on axes that follow its range.
    pub(crate) const fn new(metric: &'static str, title: &'static str) -> Self {
        Self { metric, title, is_power_law: false, companion: None, order: None }
    }
}

/// The order of an error in a swept key.
#[derive(Clone, Copy)]
pub(crate) struct OrderInKey {
    /// The key.
    pub(crate) key: &'static str,
    /// The order; `None` for a model or method without one.
    pub(crate) order: fn(&ModelConfig) -> Option<f64>,
}

/// A chart of one metric against another, with one curve per group of runs that differ only in some keys.
#[derive(Clone, Copy)]
pub(crate) struct TradeOff {
    /// The chart's file name without its extension.
    pub(crate) stem: &'static str,
    /// The chart's title.
    pub(crate) title: &'static str,
    /// The metric on the horizontal axis, with label and unit.
    pub(crate) x: (&'static str, &'static str, &'static str),
    /// The metric on the vertical axis, with label and unit.
    pub(crate) y: (&'static str, &'static str, &'static str),
    /// The keys whose values share a curve.
    pub(crate) keys: &'static [&'static str],
}
