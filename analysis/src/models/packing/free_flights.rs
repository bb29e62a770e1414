//! Free flights of discs between two collisions with other discs, by the collisions of `/events`: times, and lengths of paths.
//!
//! A collision with a wall ends no flight: it turns the velocity and keeps the speed, so the length of the broken path is the speed times the time.

use super::laws as law;
use super::metrics as metric;
use super::observe::PackingRun;
use crate::metric::theory::ExpectedValue;
use crate::metric::{Measurements, NEEDS_ALL_STATES};
use crate::models::hard_discs::fixed_energy_speed;
use crate::statistics::{Blocking, Entries};
use kinetoscope_recording::channels::PackingEvents;
use kinetoscope_recording::reader::StateTable;
use std::f64::consts::FRAC_PI_2;

/// Width of the bins of a distribution, and their number, in means by theory.
const BIN: f64 = 0.1;
const BINS: usize = 60;
/// Packing fraction up to which the distributions are compared. There, 2 % fewer flights are shorter than a tenth of the mean than of independent
/// discs, and 5 % fewer at 0.1: two discs that part do not collide again at once.
const MAX_INDEPENDENT_FRACTION: f64 = 0.01;
/// Why there are no free flights.
const NEEDS_ONE_RATE: &str = "needs elastic discs of one size";

/// A disc since its last collision.
#[derive(Clone, Copy, Debug)]
struct Disc {
    velocity: [f64; 2],
    /// Time of its last collision with another disc.
    since: Option<f64>,
}

/// Times and lengths of the flights that end after the discs have settled.
#[derive(Clone, Debug)]
pub(super) struct FreeFlights {
    discs: Vec<Disc>,
    is_settled: bool,
    /// Mean of the length, with an entry per frame.
    path: Blocking,
    /// Numbers of flights by time and by length, in means by theory.
    counts: [[u64; BINS]; 2],
    flights: u64,
}

impl Default for FreeFlights {
    fn default() -> Self {
        let path = Blocking::of(Entries::Intervals);
        Self { discs: Vec::new(), is_settled: false, path, counts: [[0; BINS]; 2], flights: 0 }
    }
}

impl FreeFlights {
    /// Adds a frame with the collisions since the one before. Flights count from here on if it `is_settled`. `units` are the means of time and
    /// length by theory.
    pub(super) fn add_frame(
        &mut self,
        state: Option<&StateTable>,
        events: &PackingEvents,
        units: Option<[f64; 2]>,
        is_settled: bool,
    ) {
        let (mut length, mut ended) = (0.0, 0_u64);
        for event in 0..events.event.len() {
            let ids = [events.first_id[event], events.second_id[event]];
            let impulse = [events.impulse_x[event], events.impulse_y[event]];
            let is_wall = ids[0] == ids[1];
            for (id, sign) in ids.into_iter().zip([1.0, -1.0]).take(2 - usize::from(is_wall)) {
                let Some(disc) = self.discs.get_mut(id as usize) else { continue };
                let [vx, vy] = disc.velocity;
                disc.velocity = [vx + sign * impulse[0], vy + sign * impulse[1]];
                if is_wall {
                    continue;
                }
                let now = events.time[event];
                if let Some(since) = disc.since.replace(now).filter(|_| self.is_settled) {
                    let flight = [now - since, (now - since) * libm::hypot(vx, vy)];
                    self.count(flight, units);
                    length += flight[1];
                    ended += 1;
                }
            }
        }
        if self.is_settled {
            self.flights += ended;
            self.path.add_amount(length, ended as f64);
        }
        self.is_settled |= is_settled;
        if let Some(state) = state {
            self.take_velocities(state);
        }
    }

    fn take_velocities(&mut self, state: &StateTable) {
        let places = ["vx", "vy"].map(|name| state.index(name));
        let [Some(vx), Some(vy)] = places else { return };
        self.discs.resize(state.rows(), Disc { velocity: [0.0; 2], since: None });
        for (disc, row) in self.discs.iter_mut().zip(state.iter()) {
            disc.velocity = [row[vx], row[vy]];
        }
    }

    fn count(&mut self, flight: [f64; 2], units: Option<[f64; 2]>) {
        let Some(units) = units else { return };
        for (counts, (value, unit)) in self.counts.iter_mut().zip(flight.into_iter().zip(units)) {
            if let Some(count) = counts.get_mut((value / unit / BIN) as usize) {
                *count += 1;
            }
        }
    }

    /// For each bin of the time or, as the second distribution, of the length in means by theory: its middle, the density of the flights with its
    /// error, and that of independent discs.
    fn distribution(&self, which: usize) -> Vec<[f64; 4]> {
        let all = self.flights as f64 * BIN;
        let longer = |bin: usize| law::longer_flights(bin as f64 * BIN, which == 1);
        let row = |(bin, count): (usize, &u64)| {
            let count = *count as f64;
            let theory = (longer(bin) - longer(bin + 1)) / BIN;
            [(bin as f64 + 0.5) * BIN, count / all, count.sqrt() / all, theory]
        };
        self.counts[which].iter().enumerate().map(row).collect()
    }
}

impl PackingRun {
    /// Adds the collisions of a frame, if free flights are defined.
    pub(super) fn add_to_free_flights(
        &mut self,
        events: f64,
        state: Option<&StateTable>,
        collisions: &PackingEvents,
    ) {
        if self.is_elastic() && self.equal_radius().is_some() {
            let units = self.free_flight_theory().map(|means| means.map(|mean| mean.value));
            let is_settled = self.is_settled(events);
            self.free_flights
                .get_or_insert_default()
                .add_frame(state, collisions, units, is_settled);
        }
    }

    /// Means of time and length: 1/ν, and the mean speed over ν.
    fn free_flight_theory(&self) -> Option<[ExpectedValue; 2]> {
        let time = 1.0 / self.theory_rate()?;
        // Between walls, the momentum is not fixed.
        let free = if self.has_walls() { self.discs() } else { self.discs() - 1.0 };
        let temperature = self.frames.first()?.temperature;
        let speed = (FRAC_PI_2 * temperature).sqrt() * fixed_energy_speed(free);
        let equilibrium = self.equilibrium()?;
        Some([time, speed * time].map(|mean| equilibrium.proportional(mean)))
    }

    pub(super) fn measure_free_flights(&self, found: &mut Measurements) {
        let Some(flights) = &self.free_flights else {
            if self.tangent.is_recorded() {
                found.explain(metric::MEAN_FREE_PATH, NEEDS_ONE_RATE);
            }
            return;
        };
        if self.lacks_states {
            return found.explain(metric::MEAN_FREE_PATH, NEEDS_ALL_STATES);
        }
        // It does not depend on the energy of the start.
        let theory = self.free_flight_theory().map(|[_, path]| path);
        found.compare(metric::MEAN_FREE_PATH, flights.path.estimate(), theory);
    }

    /// The distributions of time and length, as [`FreeFlights::distribution`], and whether that of independent discs applies.
    pub(super) fn free_flight_distributions(&self) -> Option<([Vec<[f64; 4]>; 2], bool)> {
        let flights = self.free_flights.as_ref().filter(|flights| flights.flights > 0)?;
        let [time, _] = self.free_flight_theory()?;
        let is_dilute = self.packing_fraction()? <= MAX_INDEPENDENT_FRACTION;
        let applies = is_dilute && time.violation.is_none() && !self.has_walls();
        Some(([0, 1].map(|which| flights.distribution(which)), applies))
    }
}
