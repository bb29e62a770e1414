//! How a collapse is noticed: collisions of one disc between which no time passes.

use super::clock::Clock;
use crate::model::SimulationFault;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A pair collision counts as rapid when one of its discs collided less than this share of the time ago that a disc of
/// the root mean square speed takes for a diameter.
const RAPID: f64 = 1e-10;

/// So many rapid collisions in a row of one disc are a collapse. Elastic discs that are free to move hardly have two;
/// in a collapse the relative speeds fall by a constant factor each, so that they still are numbers after so many.
const COLLAPSE: u32 = 100;

/// Rapid collisions in a row of each disc that has had any.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Rapid {
    /// Collisions of a disc less than this apart are rapid.
    time: f64,
    in_a_row: BTreeMap<u32, u32>,
}

impl Rapid {
    /// Of discs of this diameter and mean square speed.
    pub(super) fn new(diameter: f64, mean_square_speed: f64) -> Self {
        let mut rapid = Self { time: 0.0, in_a_row: BTreeMap::new() };
        rapid.set_scale(diameter, mean_square_speed);
        rapid
    }

    /// Follows a system that cools.
    pub(super) fn set_scale(&mut self, diameter: f64, mean_square_speed: f64) {
        let time = RAPID * diameter / mean_square_speed.sqrt();
        self.time = if time < f64::MAX { time } else { f64::MAX };
    }

    /// Notes a collision of two discs whose last ones were `ages` ago; `now` is for the message.
    ///
    /// # Errors
    /// A collapse.
    #[inline(always)]
    pub(super) fn note(
        &mut self,
        pair: [u32; 2],
        ages: [f64; 2],
        now: Clock,
    ) -> Result<(), SimulationFault> {
        if self.in_a_row.is_empty() && ages[0] >= self.time && ages[1] >= self.time {
            return Ok(());
        }
        self.count(pair, ages, now.time())
    }

    #[inline(never)]
    fn count(&mut self, pair: [u32; 2], ages: [f64; 2], now: f64) -> Result<(), SimulationFault> {
        for (disc, age) in pair.into_iter().zip(ages) {
            if age >= self.time {
                self.in_a_row.remove(&disc);
                continue;
            }
            let count = self.in_a_row.entry(disc).or_insert(0);
            *count += 1;
            if *count >= COLLAPSE {
                return Err(SimulationFault(format!(
                    "inelastic collapse at time {now}: disc {disc} collided {COLLAPSE} times in a row while time stood still; \
                     a restitution nearer to 1, a contact_time or cutoff_velocity, a shorter run, or a start that is not \
                     jammed avoids it"
                )));
            }
        }
        Ok(())
    }
}
