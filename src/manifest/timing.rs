//! `timing.json`: how long the runs of an experiment took on a machine. `kinetoscope benchmark` writes it, reports show it, and no
//! metric reads it.

use crate::sweep::Coordinate;
use serde::{Deserialize, Serialize};

/// All that was timed of an experiment: the engine alone, one run at a time, nothing recorded.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimingTable {
    /// Version of the file's layout.
    pub schema: u32,
    /// Name of the experiment.
    pub experiment: String,
    /// Processor, system and version of the program.
    pub machine: String,
    /// An entry a point of the sweep.
    pub points: Vec<TimingPoint>,
    /// Of a sweep that has a key of two values.
    pub comparison: Option<TimingComparison>,
}

/// The replicates of a point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimingPoint {
    /// Where it lies in the sweep.
    pub coordinates: Vec<Coordinate>,
    /// Runs that counted.
    pub runs: usize,
    /// Median of their times, s.
    pub median_s: f64,
    /// Mean, s.
    pub mean_s: f64,
    /// Standard deviation, s; 0 of one run.
    pub standard_deviation_s: f64,
    /// Distance of the quartiles, s.
    pub quartile_distance_s: f64,
    /// Steps or events of all runs over their time, 1/s.
    pub steps_or_events_per_s: f64,
}

/// Times at one value of a key over those at another, replicate by replicate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimingComparison {
    /// The value whose times are above the line.
    pub of: String,
    /// The value whose times are below it.
    pub over: String,
    /// An entry a point of the other keys.
    pub ratios: Vec<TimingRatio>,
    /// Of all points together.
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
    /// Name of the file, beside the recordings.
    pub const FILE: &str = "timing.json";
    /// The version of its layout.
    pub const SCHEMA: u32 = 1;

    /// The text of the file.
    ///
    /// # Errors
    /// None that is known; the serializer's own.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }

    /// Reads the file's text.
    ///
    /// # Errors
    /// What is not as this version writes it.
    pub fn from_json(text: &str) -> serde_json::Result<Self> {
        serde_json::from_str(text)
    }
}
