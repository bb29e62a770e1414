//! Events on the path around the Sun that are tracked at every step: turns, completed revolutions and apsides.
//!
//! The time of an event is found by repeating its step with the same method and a shorter length, so its error is that of the method
//! and not that of the frame interval. Nothing here changes the trajectory.

use super::elements::Elements;
use super::kepler::{Kepler, KeplerPoint};
use super::motion::{FixedSun, Force, Phase, dot, length};
use super::orbital_plane::OrbitalPlane;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Events since the start.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct PathRecord {
    /// Whole turns of the angle around the Sun: crossings of the half plane opposite the start.
    pub(super) turns: i64,
    /// Completed revolutions: passes of the direction of the start.
    pub(super) revolutions: i64,
    /// End of the last completed revolution, days.
    pub(super) last_revolution_end: Option<f64>,
    /// Minimum and maximum distance of the apsides passed, AU.
    pub(super) apsides: Option<[f64; 2]>,
}

/// Quantities whose change of sign is an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Signs {
    /// Whether the body is in the half plane ahead of the direction of the start.
    is_first_half: bool,
    /// Whether the distance from the Sun increases.
    is_receding: bool,
}

/// One step of an integration.
pub(super) struct StepPath<'a, V> {
    pub(super) from: &'a Phase<V>,
    pub(super) to: &'a Phase<V>,
    /// Time at its start, days.
    pub(super) start: f64,
    /// Days.
    pub(super) length: f64,
    /// State after the given part of the length, days.
    pub(super) part: &'a dyn Fn(f64) -> Phase<V>,
}

/// Finds the events of a path, step by step.
pub(super) trait PathTracker<F: Force> {
    /// The events found.
    type Record: Clone + Default;
    /// Quantities at a state whose change is an event.
    type Signs;

    /// Signs at a state.
    fn signs(&self, phase: &Phase<F::Vector>) -> Self::Signs;

    /// Time from a state within which no event changes the record, days, if positions are those of continuous paths.
    fn quiet_time(&self, _: &Phase<F::Vector>, _: &Self::Record) -> f64 {
        0.0
    }

    /// Whether an event may be in the step to a state with these separations, given the signs before it, which become those after it.
    fn has_event(
        &self,
        phase: &Phase<F::Vector>,
        separations: &F::Separations,
        signs: &mut Self::Signs,
        record: &Self::Record,
    ) -> bool;

    /// Adds the events of a step.
    fn add_step(&self, step: &StepPath<'_, F::Vector>, record: &mut Self::Record);

    /// Completes a step of the given length, with or without events. It may replace the separations.
    fn complete_step(&self, _: &mut F::Separations, _length: f64, _: &mut Self::Record) {}
}

/// Maximum r . v h / r^2 at which an apsis is not searched within a step: the distance changes by less than its rounding error.
const CIRCULAR: f64 = 1e-15;

impl PathTracker<FixedSun> for OrbitalPlane {
    type Record = PathRecord;
    type Signs = Signs;

    #[inline]
    fn signs(&self, phase: &Phase<[f64; 3]>) -> Signs {
        Signs {
            is_first_half: self.is_first_half(phase.position),
            is_receding: radial_motion(phase) >= 0.0,
        }
    }

    #[inline]
    fn has_event(
        &self,
        phase: &Phase<[f64; 3]>,
        (): &(),
        signs: &mut Signs,
        _: &PathRecord,
    ) -> bool {
        let next = self.signs(phase);
        if next == *signs {
            return false;
        }
        *signs = next;
        true
    }

    #[cold]
    fn add_step(&self, step: &StepPath<'_, [f64; 3]>, record: &mut PathRecord) {
        let (from, to) = (step.from, step.to);
        record.turns += self.turns_between(from.position, to.position);
        // The half plane opposite the start is crossed first, so rounding at the start is not a revolution.
        if self.passes_start(from.position, to.position) && record.turns == record.revolutions + 1 {
            record.revolutions = record.turns;
            let part = step.zero_of(|phase| self.transverse(phase.position));
            record.last_revolution_end = Some(step.start + part);
        }
        let (before, after) = (radial_motion(from), radial_motion(to));
        if (before >= 0.0) != (after >= 0.0) {
            let square = dot(to.position, to.position);
            let is_circular = (before - after).abs() * step.length <= CIRCULAR * square;
            let apsis = if is_circular {
                to.position
            } else {
                (step.part)(step.zero_of(radial_motion)).position
            };
            record.add_apsis(length(apsis));
        }
    }
}

/// r . v, AU^2/day: zero at an apsis.
#[inline]
fn radial_motion(phase: &Phase<[f64; 3]>) -> f64 {
    dot(phase.position, phase.velocity)
}

/// Maximum number of iterations; about 8 suffice.
const MAX_ITERATIONS: u32 = 100;

impl<V> StepPath<'_, V> {
    /// Part of the length after which a quantity that changes its sign in this step is zero, by the Illinois variant of the false
    /// position (Dowell and Jarratt, BIT 11 (1971) 168). A negative length searches before the state `from`.
    pub(super) fn zero_of(&self, quantity: impl Fn(&Phase<V>) -> f64) -> f64 {
        let (mut low, mut high) = (0.0, self.length);
        let (mut at_low, mut at_high) = (quantity(self.from), quantity(self.to));
        let sign = at_high >= 0.0;
        let mut last_side = None;
        let mut zero = high;
        for _ in 0..MAX_ITERATIONS {
            let next = low + (high - low) * (at_low / (at_low - at_high));
            let change = (next - zero).abs();
            zero = next;
            let value = quantity(&(self.part)(zero));
            let side = (value >= 0.0) == sign;
            if side {
                (high, at_high) = (zero, value);
                at_low *= if last_side == Some(side) { 0.5 } else { 1.0 };
            } else {
                (low, at_low) = (zero, value);
                at_high *= if last_side == Some(side) { 0.5 } else { 1.0 };
            }
            last_side = Some(side);
            // A value that is not a number ends the search as well.
            if !(change > f64::EPSILON * self.length.abs() && value.abs() > 0.0) {
                break;
            }
        }
        zero
    }
}

impl PathRecord {
    fn add_apsis(&mut self, radius: f64) {
        self.apsides = Some(extended(self.apsides, radius));
    }

    /// Events of the exact motion up to a time; `turns` are those of the angle in the orbital plane.
    pub(super) fn exact(kepler: &Kepler, point: &KeplerPoint, turns: i64, time: f64) -> Self {
        let start = Elements::of(kepler.start());
        let mut record = Self { turns, ..Self::default() };
        let Some(bound) = start.bound else {
            let [before, after] = [kepler.start(), point.state].map(|state| radial_motion(&state));
            if before < 0.0 && after >= 0.0 {
                record.add_apsis(start.perihelion);
            }
            return record;
        };
        let revolutions = point.turns - i64::from(point.angle < 0.0);
        if revolutions > 0 {
            record.revolutions = revolutions;
            record.last_revolution_end = Some(revolutions as f64 * bound.period);
        }
        // Mean anomaly in revolutions; whole numbers are perihelion passes.
        let anomaly = bound.mean_anomaly / TAU;
        for (offset, radius) in [(0.0, start.perihelion), (0.5, bound.aphelion)] {
            let before = (anomaly + offset).floor();
            if (anomaly + offset + time / bound.period).floor() > before {
                record.add_apsis(radius);
            }
        }
        record
    }

    /// Minimum and maximum distance from the Sun between two states, AU: those of the apsides and of the two states.
    pub(super) fn radii(&self, start: [f64; 3], now: [f64; 3]) -> [f64; 2] {
        extended(Some(extended(self.apsides, length(start))), length(now))
    }
}

fn extended(range: Option<[f64; 2]>, radius: f64) -> [f64; 2] {
    let [least, greatest] = range.unwrap_or([radius; 2]);
    [if radius < least { radius } else { least }, if radius > greatest { radius } else { greatest }]
}
