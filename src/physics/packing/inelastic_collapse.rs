//! Detection of inelastic collapse: many collisions of one disc between which almost no time passes.

use super::clock::Clock;
use crate::model::SimulationFault;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A collision is rapid if the previous one of a disc was less than this fraction of a crossing time ago, in which a disc of
/// the root mean square speed moves by one diameter.
const RAPID_FRACTION: f64 = 1e-10;

/// Number of consecutive rapid collisions of one disc that is a collapse. Elastic discs that are free to move rarely have
/// two. In a collapse, the relative speeds decrease by a constant factor per collision, so they are still normal numbers
/// after this many.
const COLLAPSE_COUNT: u32 = 100;

/// Counts the consecutive rapid collisions of each disc.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct CollapseDetector {
    /// Collisions of a disc less than this time apart are rapid.
    rapid_interval: f64,
    /// Consecutive rapid collisions of each disc that has had any.
    counts: BTreeMap<u32, u32>,
}

impl CollapseDetector {
    /// A detector for discs of this diameter and mean square speed.
    pub(super) fn new(diameter: f64, mean_square_speed: f64) -> Self {
        let mut detector = Self { rapid_interval: 0.0, counts: BTreeMap::new() };
        detector.set_scale(diameter, mean_square_speed);
        detector
    }

    /// Whether no count has reached the limit.
    pub(super) fn is_valid(&self) -> bool {
        self.rapid_interval >= 0.0 && self.counts.values().all(|count| *count < COLLAPSE_COUNT)
    }

    /// Adapts the interval to the present speeds of a system that cools.
    pub(super) fn set_scale(&mut self, diameter: f64, mean_square_speed: f64) {
        let interval = RAPID_FRACTION * diameter / mean_square_speed.sqrt();
        self.rapid_interval = if interval < f64::MAX { interval } else { f64::MAX };
    }

    /// Records a collision of two discs, or of one with the floor, given the times since the previous collision of each. `now` is for the message.
    ///
    /// # Errors
    /// Inelastic collapse.
    #[inline(always)]
    pub(super) fn record<const DISCS: usize>(
        &mut self,
        discs: [u32; DISCS],
        times_since_previous: [f64; DISCS],
        now: Clock,
    ) -> Result<(), SimulationFault> {
        if self.counts.is_empty()
            && times_since_previous.iter().all(|time| *time >= self.rapid_interval)
        {
            return Ok(());
        }
        self.count(&discs, &times_since_previous, now.time())
    }

    #[inline(never)]
    fn count(&mut self, discs: &[u32], times: &[f64], now: f64) -> Result<(), SimulationFault> {
        for (&disc, &time) in discs.iter().zip(times) {
            if time >= self.rapid_interval {
                self.counts.remove(&disc);
                continue;
            }
            let count = self.counts.entry(disc).or_insert(0);
            *count += 1;
            if *count >= COLLAPSE_COUNT {
                return Err(SimulationFault::new(
                    format!(
                        "inelastic collapse at time {now:?}: disc {disc} collided {COLLAPSE_COUNT} times in a row while almost no \
                         time passed"
                    ),
                    "use a restitution closer to 1, a contact_time or cutoff_velocity, a shorter run, or a start that is not \
                     jammed",
                ));
            }
        }
        Ok(())
    }
}
