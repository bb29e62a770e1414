//! The mean free path of discs, and the distributions of free times and paths, against Enskog's theory.

use super::metrics as metric;
use super::observe::PackingRun;
use crate::metric::theory::ExpectedValue;
use crate::metric::{Measurements, NEEDS_ALL_STATES};
use crate::models::hard_discs::fixed_energy_speed;
use kinetoscope_recording::channels::PackingEvents;
use kinetoscope_recording::reader::StateTable;
use std::f64::consts::FRAC_PI_2;

/// Packing fraction up to which the distributions are compared. There, 2 % fewer flights are shorter than a tenth of the mean than of independent
/// discs, and 5 % fewer at 0.1: two discs that part do not collide again at once.
const MAX_INDEPENDENT_FRACTION: f64 = 0.01;
/// Flights of a disc from which on the distributions are compared.
const MIN_FLIGHTS_PER_DISC: f64 = 100.0;
const NO_COLLISIONS: &str = "needs collisions of two discs in two frames or more";
/// Why there are no free flights.
const NEEDS_ONE_RATE: &str = "needs elastic discs of one size";

impl PackingRun {
    /// Adds the collisions of a frame, if free flights are defined.
    pub(super) fn add_to_free_flights(
        &mut self,
        [time, events]: [f64; 2],
        state: Option<&StateTable>,
        collisions: &PackingEvents,
    ) {
        if self.is_elastic() && self.equal_radius().is_some() {
            let units = self.free_flight_theory().map(|means| means.map(|mean| mean.value));
            let is_settled = self.is_settled(events);
            self.free_flights
                .get_or_insert_default()
                .add_frame(time, state, collisions, units, is_settled);
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
        let Some(path) = flights.path() else {
            return found.explain(metric::MEAN_FREE_PATH, NO_COLLISIONS);
        };
        found.compare(metric::MEAN_FREE_PATH, Some(path), theory);
    }

    /// The distributions of time and length, as [`FreeFlights::distribution`], and whether that of independent discs applies.
    pub(super) fn free_flight_distributions(&self) -> Option<([Vec<[f64; 4]>; 2], bool)> {
        let flights = self.free_flights.as_ref().filter(|flights| flights.per_disc() > 0.0)?;
        let [time, _] = self.free_flight_theory()?;
        let is_dilute = self.packing_fraction()? <= MAX_INDEPENDENT_FRACTION;
        // Of fewer flights, those that are not complete are missed, which are long.
        let applies = is_dilute
            && flights.per_disc() > MIN_FLIGHTS_PER_DISC
            && time.violation.is_none()
            && !self.has_walls();
        Some(([0, 1].map(|which| flights.distribution(which)), applies))
    }
}
