//! Exact propagation: every frame is computed from the start in closed form, whatever frames came before.

use super::motion::{Chords, Particle};
use super::wall::{WallLedger, WallTally};
use serde::{Deserialize, Serialize};

/// Where the closed form stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct ExactClock {
    pub(super) duration_s: f64,
    pub(super) time_s: f64,
    /// Hits of each particle since the start.
    hits: Vec<u64>,
}

impl ExactClock {
    pub(super) fn new(duration_s: f64, particles: usize) -> Self {
        Self { duration_s, time_s: 0.0, hits: vec![0; particles] }
    }

    /// Moves the particles to a time and books their hits: those since the start by the closed form, those since the last
    /// frame by its difference.
    pub(super) fn jump_to(
        &mut self,
        time_s: f64,
        start: &[Particle],
        radius_m: f64,
        particles: &mut [Particle],
        wall: &mut WallLedger,
    ) {
        let window_s = time_s - self.time_s;
        wall.total = WallTally::default();
        for ((particle, hits_before), &first) in particles.iter_mut().zip(&mut self.hits).zip(start)
        {
            let chords = Chords::of(first, radius_m);
            let flight = chords.flight(time_s);
            let fresh = flight.hits.saturating_sub(*hits_before);
            wall.total.add(flight.hits, flight.impulse_per_mass);
            wall.window.add(fresh, chords.impulse_per_mass(fresh, window_s));
            *hits_before = flight.hits;
            *particle = flight.particle;
        }
        self.time_s = time_s;
    }
}
