//! Metrics of dense elastic discs in a periodic box: pressure at freezing, long-range order, and pairs at contact.

use super::equilibrium;
use super::laws as law;
use super::metrics as metric;
use super::observe::PackingRun;
use super::structure::{MIN_LIQUID_FRACTION, SHELL_DIAMETERS};
use crate::metric::theory::ExpectedValue;
use crate::metric::{Law, Measurements, Quantity};
use crate::models::hard_discs::{DiscSizes, STATE_EQUATION_ACCURACY};
use crate::statistics::Estimate;
use std::f64::consts::PI;

/// Packing fraction up to which the compressibility of the fluid is compared.
const MAX_FLUID_FRACTION: f64 = 0.68;
/// Wave number times diameter up to which the expansion in it is used.
const MAX_WAVE_NUMBER: f64 = 0.5;

impl PackingRun {
    /// The sizes of discs as dense as a liquid, of one size, in a periodic box without obstacles. Dilute discs have little order to measure.
    fn liquid(&self) -> Option<DiscSizes> {
        let radius = self.equal_radius().filter(|_| self.keeps_momentum())?;
        let sizes = DiscSizes::equal(self.packing_fraction()?, radius);
        (sizes.packing_fraction >= MIN_LIQUID_FRACTION).then_some(sizes)
    }

    /// The law of the compressibility factor: a simulation of the same discs, where there is one.
    pub(super) fn law_of_compressibility(&self) -> Law {
        let simulated =
            self.liquid().and_then(|sizes| equilibrium::simulated_pressure(&self.config, sizes));
        match simulated {
            Some(_) => law::COMPRESSIBILITY_AT_FREEZING,
            None => self.law_of_sizes(law::COMPRESSIBILITY, law::COMPRESSIBILITY_OF_SIZES),
        }
    }

    /// The pressure P d^2/(m T), from Z - 1 of this run and by theory. T is that of n - 1 discs, because the sum of the velocities is zero.
    pub(super) fn measure_reduced_pressure(
        &self,
        excess: Option<Estimate>,
        found: &mut Measurements,
    ) {
        let (Some(sizes), Some(excess)) = (self.liquid(), excess) else { return };
        let factor = 4.0 * sizes.packing_fraction / PI;
        let free = (self.discs() - 1.0) / self.discs();
        let theory = self.equilibrium().map(|of| {
            let theory = of.compressibility();
            ExpectedValue {
                value: factor * (1.0 + free * (theory.value - 1.0)),
                accuracy: theory.accuracy.map(|accuracy| factor * free * accuracy),
                violation: theory.violation,
            }
        });
        let is_simulated = self.law_of_compressibility() == law::COMPRESSIBILITY_AT_FREEZING;
        let law = if is_simulated { law::PRESSURE_AT_FREEZING } else { law::PRESSURE_OF_FLUID };
        let value = excess.times(factor * free).plus(factor);
        found.compare_with(metric::PRESSURE_REDUCED, value, law, theory);
    }

    /// Order beyond the nearest neighbors, and g(r) at contact.
    pub(super) fn measure_liquid(&self, found: &mut Measurements) {
        let Some(sizes) = self.liquid() else { return };
        let structure = self.sampled_structure();
        found.add(metric::HEXATIC_EXPONENT, structure.long_range.hexatic_exponent());
        let waves = structure.long_range.longest_waves();
        let theory = self.is_elastic().then(|| self.compressibility_of_waves(sizes));
        found.compare(metric::LONGEST_WAVES, waves, theory);
        let theory = self.equilibrium().filter(|_| self.is_elastic()).map(|of| {
            let value = (of.compressibility_factor - 1.0) / (2.0 * sizes.packing_fraction);
            let decay = SHELL_DIAMETERS * (of.compressibility_factor - 1.0);
            let theory = of.proportional(value);
            // The third derivative is at most that of an exponential function that decays over the mean gap between discs.
            let of_extrapolation = 0.25 * value * decay * decay * decay;
            let accuracy = theory.accuracy.map(|accuracy| accuracy + of_extrapolation);
            ExpectedValue { accuracy, ..theory }
        });
        found.compare(metric::CONTACT_VALUE_FROM_PAIRS, structure.contact_value(), theory);
    }

    /// S(Q) of the longest waves, from the compressibility of the fluid. To the second order in Q, S grows by at most (1 - S)(Q d)^2/8, its
    /// value for a direct correlation function that is constant within a diameter; half of it is added.
    pub(crate) fn compressibility_of_waves(&self, sizes: DiscSizes) -> ExpectedValue {
        let limit = 1.0 / sizes.pressure_curve().slope;
        let square = self.structure.long_range.squared_wave_number();
        let half = limit * (1.0 - limit) * square / 16.0;
        let relative = STATE_EQUATION_ACCURACY + 3.0 / self.discs();
        let violation = (self.drift())
            .or_else(|| {
                Quantity::PackingFraction.at_most(sizes.packing_fraction, MAX_FLUID_FRACTION)
            })
            .or_else(|| Quantity::WaveNumber.at_most(square.sqrt(), MAX_WAVE_NUMBER));
        ExpectedValue { value: limit + half, accuracy: Some(half + relative * limit), violation }
    }

    /// S(Q) at Q = 0 by theory, if in its range.
    pub(crate) fn expected_longest_waves(&self) -> Option<f64> {
        let theory = self.compressibility_of_waves(self.liquid().filter(|_| self.is_elastic())?);
        theory.violation.is_none().then_some(theory.value)
    }
}
