//! Temperatures that are set during the run: step (d) of the gas exercise at chosen times.

use kinetoscope_manifest::model::GasConfig;
use serde::{Deserialize, Serialize};

/// Temperatures that are still to be set.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct TemperatureSchedule {
    /// Pairs of time, s, and temperature, K, in increasing order of time.
    settings: Vec<[f64; 2]>,
    /// Index of the next pair.
    next: usize,
}

impl TemperatureSchedule {
    /// The schedule of the manifest.
    pub(super) fn new(config: &GasConfig) -> Self {
        let settings = config.temperature_schedule.iter();
        let settings = settings.map(|setting| setting.map(|number| number.get())).collect();
        Self { settings, next: 0 }
    }

    /// Whether this is the schedule of a manifest, in part completed.
    pub(super) fn is_valid_for(&self, config: &GasConfig) -> bool {
        self.settings == Self::new(config).settings && self.next <= self.settings.len()
    }

    /// Time and temperature of the next setting, if it is not later than the given time.
    pub(super) fn due(&self, time_s: f64) -> Option<[f64; 2]> {
        self.settings.get(self.next).copied().filter(|setting| setting[0] <= time_s)
    }

    /// Advances to the next setting.
    pub(super) fn complete(&mut self) {
        self.next += 1;
    }
}
