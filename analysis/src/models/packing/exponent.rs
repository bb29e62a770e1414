//! The largest Lyapunov exponent of hard discs, against Sinai's billiard and Krylov's estimate.

use super::laws as law;
use super::metrics as metric;
use super::observe::PackingRun;
use crate::metric::theory::ExpectedValue;
use crate::metric::{Law, Measurements, NEEDS_ALL_STATES, Quantity};
use crate::models::lyapunov::{Growth, SETTLED_AFTER};
use crate::statistics::{MissingError, NO_CHAOS};
use kinetoscope_manifest::model::RunLength;
use kinetoscope_recording::channels::PackingEvents;
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::{RecordedFrame, StateTable};
use std::f64::consts::PI;

/// Largest diameter over the side of the box up to which the exponent of two discs is compared, and the coefficient of its accuracy.
const MAX_SINAI_RATIO: f64 = 0.1;
const SINAI_ACCURACY: f64 = 1.5;
/// Packing fraction up to which discs are dilute.
const MAX_DILUTE_FRACTION: f64 = 0.002;
/// The term after ln(l/d), which no theory gives: -1.1 at both packing fractions of `dilute_discs_follow_the_longest_chain_of_collisions`.
const CHAIN_ACCURACY: f64 = 1.5;

/// Discs that dissipate energy have no constant growth.
const NEEDS_ELASTIC: &str = "needs elastic discs";

impl PackingRun {
    /// Adds the collisions of a frame, if they are recorded.
    pub(super) fn add_recorded_collisions(
        &mut self,
        frame: &RecordedFrame,
        state: Option<&StateTable>,
    ) -> Result<(), ReadError> {
        let Some(events) = frame.get::<PackingEvents>()? else { return Ok(()) };
        // The map of a collision holds for straight flights, whose speed is constant.
        if self.config.gravity.get() > 0.0 {
            return Ok(());
        }
        let (time, done) = (frame.clock.time, frame.clock.step_or_event_count as f64);
        let is_settled = match self.config.length {
            RunLength::EventsPerDisc(events) => {
                done >= SETTLED_AFTER * f64::from(events.get()) * self.discs()
            }
            RunLength::Duration(duration) => time >= SETTLED_AFTER * duration.get(),
        };
        self.tangent.add_frame(time, state, &events, is_settled);
        self.add_to_free_flights([time, done], state, &events);
        Ok(())
    }

    pub(super) fn measure_lyapunov(&self, found: &mut Measurements) {
        if !self.tangent.is_recorded() {
            return;
        }
        if self.lacks_states {
            let all = [metric::LYAPUNOV, metric::DIVERGENCE_TIME, metric::DIVERGENCE_COLLISIONS];
            return all.into_iter().for_each(|metric| found.explain(metric, NEEDS_ALL_STATES));
        }
        let exponent = self.tangent.growth.exponent().map(|exponent| match self.is_elastic() {
            true => self.with_scatter_of_starts(exponent),
            false => exponent.without_error(MissingError::Drifting),
        });
        match self.tangent.growth_by_collisions.exponent() {
            _ if !self.is_elastic() => found.explain(metric::DIVERGENCE_COLLISIONS, NEEDS_ELASTIC),
            Some(exponent) => {
                Growth::measure_divergence(exponent, metric::DIVERGENCE_COLLISIONS, found);
            }
            None => found.explain(metric::DIVERGENCE_COLLISIONS, NO_CHAOS),
        }
        let theory = self.expected_exponent();
        Growth::measure(exponent, [metric::LYAPUNOV, metric::DIVERGENCE_TIME], theory, found);
    }

    /// Mean free path of dilute discs, 1/(2 sqrt(2) n d).
    fn mean_free_path(&self) -> Option<f64> {
        let diameter = 2.0 * self.equal_radius()?;
        let area = self.config.width.get() * self.config.height.get();
        Some(area / (2.0 * std::f64::consts::SQRT_2 * self.discs() * diameter))
    }

    /// The exponent of elastic discs of one size in a periodic box, by Sinai's billiard for two, and for dilute ones by the collisions of
    /// the longest chain.
    fn expected_exponent(&self) -> Option<(Law, ExpectedValue)> {
        let radius = self.equal_radius().filter(|_| self.is_elastic() && !self.has_walls())?;
        let (width, height) = (self.config.width.get(), self.config.height.get());
        let (centers, of_obstacle) = self.config.obstacles();
        let diameter = if centers.is_empty() { 2.0 * radius } else { of_obstacle + radius };
        if self.discs() + centers.len() as f64 == 2.0 {
            let speed = self.tangent.relative_speed().filter(|_| width == height)?;
            let ratio = diameter / width;
            let collisions = speed * 2.0 * diameter / (width * width - PI * diameter * diameter);
            let violation =
                self.drift().or_else(|| Quantity::DiameterOverSide.at_most(ratio, MAX_SINAI_RATIO));
            let value = collisions * law::sinai_growth_per_collision(ratio);
            let accuracy = Some(collisions * SINAI_ACCURACY * ratio);
            return Some((law::SINAI, ExpectedValue { value, accuracy, violation }));
        }
        let logarithm = libm::log(self.mean_free_path()? / diameter);
        let value = self.tangent.chain_rate()? * logarithm;
        let violation = self.outside_fluid().or_else(|| {
            Quantity::PackingFraction.at_most(self.packing_fraction()?, MAX_DILUTE_FRACTION)
        });
        let accuracy = Some(CHAIN_ACCURACY * value / logarithm);
        (logarithm > 1.0).then_some((law::CHAINS, ExpectedValue { value, accuracy, violation }))
    }
}
