//! Free flights of discs between two collisions with other discs, by the collisions of `/events`: times, and lengths of paths.
//!
//! A collision with a wall ends no flight: it turns the velocity and keeps the speed, so the length of the broken path is the speed times the time.

use super::laws as law;
use crate::statistics::{Blocking, Entries, Estimate};
use kinetoscope_recording::channels::PackingEvents;
use kinetoscope_recording::reader::StateTable;

/// Width of the bins of a distribution, and their number, in means by theory.
const BIN: f64 = 0.1;
const BINS: usize = 60;

/// A disc since its last collision.
#[derive(Clone, Copy, Debug)]
struct Disc {
    velocity: [f64; 2],
    /// Time of its last collision with another disc.
    since: Option<f64>,
    /// Time up to which its path counts.
    counted_to: f64,
}

/// Times and lengths of the flights that end after the discs have settled.
#[derive(Clone, Debug)]
pub(super) struct FreeFlights {
    discs: Vec<Disc>,
    is_settled: bool,
    /// Path of all discs over their collisions with others, with an entry per frame. Its mean is not that of complete flights: in a short run,
    /// long flights are rarely complete.
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
        time: f64,
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
                let now = events.time[event];
                let [vx, vy] = disc.velocity;
                let speed = libm::hypot(vx, vy);
                length += speed * (now - std::mem::replace(&mut disc.counted_to, now));
                disc.velocity = [vx + sign * impulse[0], vy + sign * impulse[1]];
                if is_wall {
                    continue;
                }
                ended += 1;
                if let Some(since) = disc.since.replace(now).filter(|_| self.is_settled) {
                    self.flights += 1;
                    self.count([now - since, (now - since) * speed], units);
                }
            }
        }
        for disc in &mut self.discs {
            let speed = libm::hypot(disc.velocity[0], disc.velocity[1]);
            length += speed * (time - std::mem::replace(&mut disc.counted_to, time));
        }
        if self.is_settled {
            self.path.add_amount(length, ended as f64);
        }
        self.is_settled |= is_settled;
        if let Some(state) = state {
            self.take_velocities(time, state);
        }
    }

    fn take_velocities(&mut self, time: f64, state: &StateTable) {
        let places = ["vx", "vy"].map(|name| state.index(name));
        let [Some(vx), Some(vy)] = places else { return };
        self.discs.resize(state.rows(), Disc { velocity: [0.0; 2], since: None, counted_to: time });
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
    pub(super) fn distribution(&self, which: usize) -> Vec<[f64; 4]> {
        let all = self.flights as f64 * BIN;
        let longer = |bin: usize| law::longer_flights(bin as f64 * BIN, which == 1);
        let row = |(bin, count): (usize, &u64)| {
            let count = *count as f64;
            let theory = (longer(bin) - longer(bin + 1)) / BIN;
            [(bin as f64 + 0.5) * BIN, count / all, count.sqrt() / all, theory]
        };
        self.counts[which].iter().enumerate().map(row).collect()
    }

    /// The mean length.
    pub(super) fn path(&self) -> Option<Estimate> {
        self.path.estimate()
    }

    /// Flights of a disc whose beginning and end were recorded.
    pub(super) fn per_disc(&self) -> f64 {
        self.flights as f64 / self.discs.len() as f64
    }
}
