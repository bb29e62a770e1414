//! The engine's time: whole units that are counted, and a remainder that stays small.

use serde::{Deserialize, Serialize};

/// Time since the start as `whole_units * unit + local`. Events are timed on the local part, whose zero is moved now and
/// then, so that the grain of time does not grow with the length of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Clock {
    /// A power of two: moving the zero by whole units is exact.
    unit: f64,
    /// Whole units between the start and the local zero: an integer.
    whole_units: f64,
    /// Time since the local zero.
    local: f64,
}

impl Clock {
    /// A clock at 0. Its unit is the largest power of two that is not above the time in which a disc of the root mean
    /// square speed flies through `length`: it follows the speeds, so that all times of a start whose speeds are scaled
    /// by a power of two are scaled exactly. Without motion the unit is 1.
    pub(super) fn new(length: f64, mean_square_speed: f64) -> Self {
        let flight = length / mean_square_speed.sqrt();
        Self {
            unit: if flight.is_normal() { power_of_two_below(flight) } else { 1.0 },
            whole_units: 0.0,
            local: 0.0,
        }
    }

    /// Time since the start.
    pub(super) fn time(&self) -> f64 {
        self.whole_units * self.unit + self.local
    }

    /// Time since the local zero.
    pub(super) fn local(&self) -> f64 {
        self.local
    }

    /// A time since the start as time since the local zero.
    pub(super) fn to_local(self, time: f64) -> f64 {
        time - self.whole_units * self.unit
    }

    /// Goes on to a local time. An event that rounding put before the present happens now.
    pub(super) fn advance_to(&mut self, local: f64) {
        if local > self.local {
            self.local = local;
        }
    }

    /// Moves the zero as near to the present as whole units allow, and returns by how much: what stands on this clock
    /// elsewhere has to follow.
    pub(super) fn shift_origin(&mut self) -> f64 {
        let units = (self.local / self.unit).floor();
        let shift = units * self.unit;
        self.whole_units += units;
        self.local -= shift;
        shift
    }
}

/// The largest power of two that is not above a positive normal number: its mantissa cleared.
fn power_of_two_below(number: f64) -> f64 {
    f64::from_bits(number.to_bits() & 0x7FF0_0000_0000_0000)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Promise: moving the zero changes no time: exact, whatever the unit's size, and the local part ends below one unit.
    #[test]
    fn moving_the_zero_is_exact() {
        for (length, mean_square_speed) in [(2.0, 1.96), (0.013, 7e5), (3e4, 1e-9), (1.0, 0.0)] {
            let mut clock = Clock::new(length, mean_square_speed);
            let mut local = 0.0;
            for step in 1..1000 {
                local += clock.unit * 0.1 * f64::from(step % 97);
                clock.advance_to(local);
                let time = clock.time();
                let shift = clock.shift_origin();
                assert_eq!(local - shift, clock.local());
                assert_eq!(clock.time(), time);
                assert!(clock.local() < clock.unit);
                local = clock.local();
            }
        }
    }
}
