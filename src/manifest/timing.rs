//! `timing.json`: how long the runs of an experiment took on a machine. `kinetoscope benchmark` writes it, reports show it, and no
//! metric reads it.

use crate::sweep::Coordinate;
use kinetoscope_console::text::json;
use serde::{Deserialize, Serialize};

/// The times of an experiment's runs: only the engine, one run at a time, without recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimingTable {
    /// Version of the file's layout.
    pub schema: u32,
    /// Name of the experiment.
    pub experiment: String,
    /// Processor, system and version of the program.
    pub machine: String,
    /// One entry per point of the sweep.
    pub points: Vec<TimingPoint>,
    /// For a sweep that has a key with two values.
    pub comparison: Option<TimingComparison>,
}

/// The replicates of a point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimingPoint {
    /// Its point in the sweep.
    pub coordinates: Vec<Coordinate>,
    /// Runs that counted.
    pub runs: usize,
    /// Median of their times, s.
    pub median_s: f64,
    /// Mean, s.
    pub mean_s: f64,
    /// Standard deviation, s; 0 for one run.
    pub standard_deviation_s: f64,
    /// Interquartile range, s.
    pub quartile_distance_s: f64,
    /// Steps or events of all runs divided by their time, 1/s.
    pub steps_or_events_per_s: f64,
    /// Published mean time of such runs, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub published_s: Option<f64>,
}

impl TimingPoint {
    /// Who published the times, and how they were measured.
    pub const PUBLISHED_BY: &str =
        "the packing exercise, Python 3.11 on a 1.4 GHz Intel Core i5, means of 100 runs";
}

/// Ratios of the times at one value of a key to those at another, replicate by replicate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimingComparison {
    /// The value in the numerator.
    pub of: String,
    /// The value in the denominator.
    pub over: String,
    /// One entry per point of the other keys.
    pub ratios: Vec<TimingRatio>,
    /// The ratio over all points.
    pub all: TimingRatio,
}

/// A ratio of times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimingRatio {
    /// The other keys' values.
    pub coordinates: Vec<Coordinate>,
    /// Median.
    pub median: f64,
    /// Geometric mean.
    pub mean: f64,
    /// Standard error of the mean.
    pub standard_error: f64,
}

impl TimingTable {
    /// Name of the file, next to the recordings.
    pub const FILE: &str = "timing.json";
    /// The version of its layout.
    pub const SCHEMA: u32 = 1;

    /// The text of the file. A terminal may show it.
    ///
    /// # Errors
    /// The serializer's own; none is known.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self).map(|text| json(&text))
    }

    /// Reads the file's text.
    ///
    /// # Errors
    /// A text that this version does not write.
    pub fn from_json(text: &str) -> serde_json::Result<Self> {
        serde_json::from_str(text)
    }
}
