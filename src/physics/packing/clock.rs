//! The engine's time: a count of whole units and a small remainder.

use serde::{Deserialize, Serialize};

/// Time since the start as `whole_units * unit + local`. Event times are relative to the local origin, which is shifted
/// regularly, so that the resolution of time does not decrease with the length of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Clock {
    /// A power of two: shifting the origin by whole units is exact.
    unit: f64,
    /// Whole units between the start and the local origin: an integer.
    whole_units: f64,
    /// Time since the local origin.
    local: f64,
}

impl Clock {
    /// A clock at time 0. Its unit is the largest power of two that is not above the time in which a disc of the root mean
    /// square speed moves by `length`. If all speeds of a start are scaled by a power of two, all times are scaled exactly.
    /// Without motion, the unit is 1.
    pub(super) fn new(length: f64, mean_square_speed: f64) -> Self {
        let crossing_time = length / mean_square_speed.sqrt();
        Self {
            unit: if crossing_time.is_normal() { power_of_two_below(crossing_time) } else { 1.0 },
            whole_units: 0.0,
            local: 0.0,
        }
    }

    /// Whether the clock can be reached by advances and shifts from time 0.
    pub(super) fn is_valid(&self) -> bool {
        let is_power_of_two = self.unit.is_normal() && self.unit == power_of_two_below(self.unit);
        is_power_of_two
            && self.whole_units.is_finite()
            && self.whole_units >= 0.0
            && self.whole_units == self.whole_units.floor()
            && self.local.is_finite()
            && self.local >= 0.0
    }

    /// Time since the start.
    pub(super) fn time(&self) -> f64 {
        self.whole_units * self.unit + self.local
    }

    /// Time since the local origin.
    pub(super) fn local(&self) -> f64 {
        self.local
    }

    /// Converts a time since the start to a time since the local origin.
    pub(super) fn to_local(self, time: f64) -> f64 {
        time - self.whole_units * self.unit
    }

    /// Advances to a local time. An event that rounding placed before the present occurs now.
    pub(super) fn advance_to(&mut self, local: f64) {
        if local > self.local {
            self.local = local;
        }
    }

    /// Shifts the origin as close to the present as whole units allow. Returns the shift, which must be subtracted from all
    /// local times stored elsewhere.
    pub(super) fn shift_origin(&mut self) -> f64 {
        let units = (self.local / self.unit).floor();
        let shift = units * self.unit;
        self.whole_units += units;
        self.local -= shift;
        shift
    }
}

/// The largest power of two that is not above a positive normal number: the number with a zero mantissa.
fn power_of_two_below(number: f64) -> f64 {
    f64::from_bits(number.to_bits() & 0x7FF0_0000_0000_0000)
}
