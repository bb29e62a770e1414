//! The largest Lyapunov exponent: the rate at which a small difference of two runs grows.

use crate::metric::theory::ExpectedValue;
use crate::metric::{Definition, Law, Measurements};
use crate::statistics::{Blocking, Estimate, NO_CHAOS};
use kinetoscope_recording::channels::Divergence;
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::RecordedFrame;

/// Part of a run after which growth counts: until then, the difference turns into the direction that grows fastest.
pub(crate) const SETTLED_AFTER: f64 = 0.25;

const NO_ERROR: &str = "the error of the exponent is unknown, so that it may be compatible with 0";

/// Growth of a difference over the settled part of a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Growth {
    rate: Blocking,
    duration: f64,
    /// Time and logarithm of the last frame.
    last: Option<(f64, f64)>,
}

impl Growth {
    /// Adds the logarithm of the factor by which the difference has grown over a duration.
    pub(crate) fn add(&mut self, logarithm: f64, duration: f64) {
        self.rate.add_amount(logarithm, duration);
        self.duration += duration;
    }

    /// Adds the logarithm of the growth since the start of a run of this duration, if a frame has it.
    pub(crate) fn add_frame(
        &mut self,
        frame: &RecordedFrame,
        duration: f64,
    ) -> Result<(), ReadError> {
        let Some(Divergence { logarithm }) = frame.get::<Divergence>()? else { return Ok(()) };
        let time = frame.clock.time;
        if let Some((before, earlier)) =
            self.last.filter(|(time, _)| *time >= SETTLED_AFTER * duration)
        {
            self.add(logarithm - earlier, time - before);
        }
        self.last = Some((time, logarithm));
        Ok(())
    }

    /// The exponent with its error by blocks. A difference that grows in proportion to time, as that of a regular motion, has grown by
    /// 1/[`SETTLED_AFTER`] meanwhile; the logarithm of it is a further error.
    pub(crate) fn exponent(&self) -> Option<Estimate> {
        let found = self.rate.estimate_with_correlation(0.0)?;
        Some(found.with_further_error(libm::log(1.0 / SETTLED_AFTER) / self.duration))
    }

    /// Adds the exponent, and the time after which two runs that differ by a rounding error are unrelated.
    pub(crate) fn measure(
        exponent: Option<Estimate>,
        [of_exponent, of_time]: [&'static Definition; 2],
        theory: Option<(Law, ExpectedValue)>,
        found: &mut Measurements,
    ) {
        let Some(exponent) = exponent else { return };
        let (law, theory) = theory.unzip();
        found.compare_with(of_exponent, exponent, law, theory);
        Self::measure_divergence(exponent, of_time, found);
    }

    /// Adds what a rounding error takes to grow to 1: a time, or collisions if the exponent is that per collision.
    pub(crate) fn measure_divergence(
        exponent: Estimate,
        definition: &'static Definition,
        found: &mut Measurements,
    ) {
        let error = exponent.conditional_standard_error.or(exponent.standard_error);
        let Some(error) = error else { return found.explain(definition, NO_ERROR) };
        if exponent.value > 2.0 * error {
            found.add(definition, exponent.inverse().times(-libm::log(f64::EPSILON / 2.0)));
        } else {
            found.explain(definition, NO_CHAOS);
        }
    }
}
