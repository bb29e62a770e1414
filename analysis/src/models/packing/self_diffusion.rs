//! The self-diffusion coefficient of a run, against Enskog's.

use super::diffusion_windows::{DiffusionWindows, WINDOW_MEAN_FREE_TIMES};
use super::displacement::MAX_PARTICLES;
use super::laws as law;
use super::metrics as metric;
use super::observe::PackingRun;
use crate::metric::theory::ExpectedValue;
use crate::metric::{Measurements, NEEDS_ALL_STATES, Quantity};
use crate::models::hard_discs::contact_value;
use crate::statistics::{Estimate, MissingError};
use kinetoscope_recording::reader::StateTable;

/// Packing fraction up to which Enskog's D is compared, and the accuracy of the comparison.
const MAX_FRACTION: f64 = 0.25;
const ACCURACY: f64 = 0.05;
/// Number of discs from which the correction for fixed momentum is small.
const MIN_DISCS: f64 = 200.0;

impl PackingRun {
    /// Adds a frame to the windows. Their length follows from the collision rate by theory at the temperature of the first frame.
    pub(super) fn add_to_self_diffusion(&mut self, time: f64, state: &StateTable) {
        let places = ["vx", "vy"].map(|name| state.index(name));
        let ([Some(vx), Some(vy)], true) = (places, self.diffuses()) else { return };
        let rows = (0..state.rows().min(MAX_PARTICLES)).map(|disc| state.row(disc));
        let velocities: Vec<[f64; 2]> = rows.map(|row| [row[vx], row[vy]]).collect();
        if self.self_diffusion.is_none() {
            let free_time = self.theory_rate().map(|rate| 1.0 / rate);
            self.self_diffusion = Some(DiffusionWindows::new(free_time));
        }
        if let Some(windows) = &mut self.self_diffusion {
            windows.add_frame(time, &self.displacement, &velocities);
        }
    }

    /// Whether D is defined: nothing bounds the displacements, and no common drift adds to them.
    fn diffuses(&self) -> bool {
        !self.has_walls() && !self.has_drift() && self.equal_radius().is_some()
    }

    /// Pair collisions per disc and unit of time by theory, at the temperature of the first frame.
    pub(super) fn theory_rate(&self) -> Option<f64> {
        let temperature = self.frames.first()?.temperature;
        let rate = self.equilibrium()?.pair_rate * temperature.sqrt();
        (rate > 0.0).then_some(rate)
    }

    pub(super) fn measure_self_diffusion(&self, found: &mut Measurements) {
        let definitions = [metric::DIFFUSION_GREEN_KUBO, metric::DIFFUSION_EINSTEIN];
        if !self.diffuses() {
            return definitions.iter().for_each(|definition| found.explain(definition, BOUNDED));
        }
        let Some(windows) = &self.self_diffusion else { return };
        if self.lacks_states {
            let explain = |definition| found.explain(definition, NEEDS_ALL_STATES);
            return definitions.into_iter().for_each(explain);
        }
        match windows.estimates() {
            Ok(estimates) => {
                let values = estimates.into_iter().zip(moments_of_window());
                for (definition, (estimate, moments)) in definitions.into_iter().zip(values) {
                    let theory = self.expected_diffusion(moments);
                    found.compare(definition, self.with_drifting(estimate), theory);
                }
            }
            Err(reason) => {
                definitions.iter().for_each(|definition| found.explain(definition, reason));
            }
        }
    }

    /// Cooling discs diffuse ever more slowly, so their D has neither a theory nor an error.
    fn with_drifting(&self, estimate: Estimate) -> Estimate {
        if self.is_elastic() { estimate } else { estimate.without_error(MissingError::Drifting) }
    }

    /// Theory after a time in mean free times, with the mean of ln(t / onset of the tail).
    fn expected_diffusion(&self, [time, logarithm]: [f64; 2]) -> Option<ExpectedValue> {
        let temperature = self.frames.first().filter(|_| self.is_elastic())?.temperature;
        let (packing_fraction, radius) = (self.packing_fraction()?, self.equal_radius()?);
        let discs = law::DiffusingDiscs {
            discs: self.discs(),
            packing_fraction,
            diameter: 2.0 * radius,
            contact_value: contact_value(packing_fraction),
            temperature,
            pair_rate: self.theory_rate()?,
        };
        let value = discs.self_diffusion(time, logarithm);
        let violation = (self.outside_fluid())
            .or_else(|| Quantity::Discs.at_least(self.discs(), MIN_DISCS))
            .or_else(|| Quantity::PackingFraction.at_most(packing_fraction, MAX_FRACTION));
        Some(ExpectedValue { value, accuracy: Some(ACCURACY * value), violation })
    }
}

/// Time and mean of ln(t / onset): at the end of a window, and averaged over its second half, in which the mean square displacement
/// grows. The mean of ln t from w/2 to w is ln w - 1 + ln 2.
fn moments_of_window() -> [[f64; 2]; 2] {
    let end = WINDOW_MEAN_FREE_TIMES;
    let logarithm = libm::log(end / law::TAIL_ONSET_MEAN_FREE_TIMES);
    [[end, logarithm], [0.75 * end, logarithm - 1.0 + std::f64::consts::LN_2]]
}

/// Why D is not defined.
const BOUNDED: &str = "needs discs of one size in a periodic box, with a total momentum of zero (remove_mean_velocity)";
