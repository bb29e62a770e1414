//! What the wall felt: hits and normal impulse, since the start and since the last frame.

use super::motion::{Flight, Particle, dot};
use crate::sum::CompensatedSum;
use serde::{Deserialize, Serialize};

/// Hits of the wall and their normal impulse over the first mass, m/s.
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

    /// Books what all particles did since the last call.
    pub(super) fn book(&mut self, fresh: &WallTally) {
        for tally in [&mut self.total, &mut self.window] {
            tally.add(fresh.hits, fresh.impulse_per_mass.value());
        }
    }

    /// Reads both tallies off those of the particles, whose masses are these times the first one.
    pub(super) fn gather(&mut self, tallies: &[Tally], mass_ratios: &[f64]) {
        (self.total, self.window) = (WallTally::default(), WallTally::default());
        for (tally, ratio) in tallies.iter().zip(mass_ratios) {
            self.total.add(tally.hits, ratio * tally.impulse_per_mass);
            self.window.add(tally.window_hits, ratio * tally.window_impulse_per_mass);
        }
    }
}

/// What one particle did to the wall. Each has its own, so that no sum depends on how work is cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Tally {
    hits: u64,
    impulse_per_mass: f64,
    /// Since the last frame.
    window_hits: u64,
    window_impulse_per_mass: f64,
    /// v^2 when the path began, m^2/s^2.
    square: f64,
    /// p x v when the path began, m^2/s.
    angular_momentum_per_mass: f64,
}

impl Tally {
    /// The tally of nobody: a lane without a particle divides by one.
    pub(super) fn at_unit_speed() -> Self {
        Self { square: 1.0, ..Self::default() }
    }

    /// Notes what a path keeps.
    pub(super) fn begin(&mut self, particle: Particle) {
        self.square = dot(particle.velocity, particle.velocity);
        self.angular_momentum_per_mass = particle.angular_momentum_per_mass();
    }

    /// A particle after a hit, brought back to the speed and the angular momentum of its path: each mirror rounds, and over a
    /// million like hits that adds up to 4e-12. The velocity is stretched, then the place shifted across it, both by some last bits.
    #[inline(always)]
    pub(super) fn on_its_path(&self, particle: Particle) -> Particle {
        let Particle { position: [x, y], velocity } = particle;
        let lost = (self.square - dot(velocity, velocity)) / (2.0 * self.square);
        let [vx, vy] = velocity.map(|component| component + lost * component);
        let shift = ((x * vy - y * vx) - self.angular_momentum_per_mass) / self.square;
        Particle { position: [x - shift * vy, y + shift * vx], velocity: [vx, vy] }
    }

    /// Books what the particle did in one step.
    #[inline(always)]
    pub(super) fn book(&mut self, flight: &Flight) {
        self.hits += flight.hits;
        self.impulse_per_mass += flight.impulse_per_mass;
        self.window_hits += flight.hits;
        self.window_impulse_per_mass += flight.impulse_per_mass;
    }

    /// Starts "since the last frame" again from zero.
    pub(super) fn open_window(&mut self) {
        (self.window_hits, self.window_impulse_per_mass) = (0, 0.0);
    }
}
