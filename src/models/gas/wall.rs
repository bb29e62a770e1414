//! What the wall felt: hits and normal impulse, since the start and since the last frame.

use super::motion::Flight;
use crate::sum::CompensatedSum;
use serde::{Deserialize, Serialize};

/// Hits of the wall and their normal impulse over the mass of a particle, m/s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct WallTally {
    pub(super) hits: u64,
    pub(super) impulse_per_mass: CompensatedSum,
}

impl WallTally {
    /// Adds hits and their impulse.
    pub(super) fn add(&mut self, hits: u64, impulse_per_mass: f64) {
        self.hits = self.hits.saturating_add(hits);
        self.impulse_per_mass.add(impulse_per_mass);
    }
}

/// The wall's two tallies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct WallLedger {
    /// Since the start.
    pub(super) total: WallTally,
    /// Since the last frame.
    pub(super) window: WallTally,
    /// Time of the last frame, s.
    pub(super) window_opened_s: f64,
}

impl WallLedger {
    /// Starts "since the last frame" again from zero.
    pub(super) fn open_window(&mut self, time_s: f64) {
        self.window = WallTally::default();
        self.window_opened_s = time_s;
    }

    /// Books what one particle did in one step.
    pub(super) fn book(&mut self, flight: &Flight) {
        if flight.hits > 0 || flight.impulse_per_mass > 0.0 {
            self.total.add(flight.hits, flight.impulse_per_mass);
            self.window.add(flight.hits, flight.impulse_per_mass);
        }
    }
}
