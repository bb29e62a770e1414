//! What the analysis of a model consists of: its metrics, an observer of its frames, its plots, and its fits over a sweep.
//!
//! Observers turn frames into numbers in bounded memory and do not depend on plots; a model's `figures.rs` reads its observer.

use crate::metric::{Definition, Measurement};
use crate::models::figures::Figures;
use crate::models::snapshots::Snapshots;
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::RecordedFrame;

/// Reads the frames of one run in order and derives its metrics.
pub trait Observer {
    /// Takes in the next frame.
    ///
    /// # Errors
    /// A message that cannot be decoded.
    fn observe(&mut self, frame: RecordedFrame) -> Result<(), ReadError>;

    /// The run's metrics, without those whose channels were not recorded.
    fn measurements(&self) -> Vec<Measurement>;
}

/// An observer whose run can be plotted.
pub trait PlottedObserver: Observer {
    /// The run's plots.
    fn figures(&self) -> Figures;
}

/// The analysis of one model.
pub struct ModelAnalysis {
    /// The model's name in the manifest.
    pub name: &'static str,
    /// The model's heading in the metrics reference.
    pub title: &'static str,
    /// The metrics of a run.
    pub metrics: &'static [&'static Definition],
    /// The metrics of a sweep, which [`Self::fits`] derive.
    pub sweep_metrics: &'static [&'static Definition],
    /// Fits along an axis of a sweep.
    pub fits: &'static [Fit],
    /// Metrics that are plotted against swept numbers.
    pub ordinates: &'static [Ordinate],
    /// Pairs of metrics that are plotted against each other.
    pub trade_offs: &'static [TradeOff],
    /// Creates the observer of a run; `None` for the configuration of another model.
    pub observer: fn(&ModelConfig, Snapshots) -> Option<Box<dyn PlottedObserver>>,
    /// Size of the particles and of their container; `None` for the configuration of another model.
    pub extent: fn(&ModelConfig) -> Option<Extent>,
}

/// Size of a model's particles and of their container, in the model's length unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extent {
    /// Radius of particles without a radius in the state; 0 for points.
    pub radius: f64,
    /// Lower left and upper right corner of the container; `None` without walls.
    pub bounds: Option<[[f64; 2]; 2]>,
}

/// A fit of a metric along an axis of a sweep.
#[derive(Clone, Copy)]
pub struct Fit {
    /// The swept key.
    pub along: &'static str,
    /// The metric that is the abscissa; `None` for the swept key itself.
    pub over: Option<&'static str>,
    /// The metric that is the ordinate.
    pub of: &'static str,
    /// The fitted function.
    pub shape: FitShape,
    /// The theoretical value of the slope, exponent or scale.
    pub theory: fn(&ModelConfig) -> Option<f64>,
    /// Whether the fit is an order of convergence: all runs must end at the same time, and the theory must know an order.
    pub is_convergence_order: bool,
}

impl Fit {
    /// A fit over the swept key itself, without a theoretical value.
    #[must_use]
    pub const fn new(along: &'static str, of: &'static str, shape: FitShape) -> Self {
        Self { along, over: None, of, shape, theory: |_| None, is_convergence_order: false }
    }
}

/// A fitted function and the metrics that its parameters are.
#[derive(Clone, Copy)]
pub enum FitShape {
    /// A line.
    Line {
        /// Its slope.
        slope: &'static Definition,
        /// Its intercept.
        intercept: &'static Definition,
    },
    /// A power law with this exponent.
    PowerLaw(&'static Definition),
    /// A saturating exponential y = s (1 - exp(-x/s)).
    Saturation {
        /// The scale s.
        scale: &'static Definition,
        /// The root mean square relative deviation from the fit.
        misfit: &'static Definition,
    },
}

/// A metric that is plotted against swept numbers.
#[derive(Clone, Copy)]
pub struct Ordinate {
    /// The metric's name.
    pub metric: &'static str,
    /// The quantity, as axis label and title.
    pub title: &'static str,
    /// Whether both axes are logarithmic whatever the range.
    pub is_power_law: bool,
    /// A second metric in the same chart, with its name there.
    pub companion: Option<(&'static str, &'static str)>,
    /// The order of an error in a swept key, drawn as a line through the point of the smallest key.
    pub order: Option<OrderInKey>,
}

impl Ordinate {
    /// A metric on axes that follow its range.
    #[must_use]
    pub const fn new(metric: &'static str, title: &'static str) -> Self {
        Self { metric, title, is_power_law: false, companion: None, order: None }
    }
}

/// The order of an error in a swept key.
#[derive(Clone, Copy)]
pub struct OrderInKey {
    /// The key.
    pub key: &'static str,
    /// The order; `None` for a model or method without one.
    pub order: fn(&ModelConfig) -> Option<f64>,
}

/// A chart of one metric against another, with one curve per group of runs that differ only in some keys.
#[derive(Clone, Copy)]
pub struct TradeOff {
    /// The chart's file name without its extension.
    pub stem: &'static str,
    /// The chart's title.
    pub title: &'static str,
    /// The metric on the horizontal axis, with label and unit.
    pub x: (&'static str, &'static str, &'static str),
    /// The metric on the vertical axis, with label and unit.
    pub y: (&'static str, &'static str, &'static str),
    /// The keys whose values share a curve.
    pub keys: &'static [&'static str],
}
