//! What a model's table provides beyond its keys.

use crate::keys::{HasKeys, Reader};
use crate::quantity::Positive;
use std::num::NonZeroU32;

/// The table `[model.<NAME>]` of one model.
pub(crate) trait Model: HasKeys + Default {
    /// The keys of `[record]` that give an interval between frames, other than `frames` and `frames_per_decade`. If the
    /// table has errors, it is not `sound`, and the keys are those that any table of the model allows.
    fn intervals(&self, sound: bool) -> &'static [&'static str];

    /// Maximum number of particles in a frame, those included that enter during the run.
    fn particles(&self) -> u64;

    /// Whether a run draws random numbers. Runs that draw none are the same for every seed.
    fn draws_random_numbers(&self) -> bool {
        true
    }

    /// Simulated time at the end, in the model's unit; `None` if the run ends after a number of events.
    fn duration(&self) -> Option<f64>;

    /// Number of species, which the particles have in turn.
    fn species(&self) -> usize {
        1
    }

    /// The same physics with so many particles at the same density; `None` if the start depends on more than that.
    fn with_particles(&self, particles: NonZeroU32) -> Option<Self> {
        let _ = particles;
        None
    }

    /// Reports the broken rules between the keys.
    fn check(&mut self, table: &mut Reader<'_>);
}

/// Minimum width of a box with fewer particles, in diameters of the largest disc, so that discs at its walls are few.
pub(super) const MIN_WIDTH_DIAMETERS: f64 = 20.0;

/// Maximum number of steps: integers up to 2^53 are exact.
pub const MAX_STEPS: f64 = 9_007_199_254_740_992.0;

/// Reports a run that ends before its first step, or that has more steps than can be counted.
pub(super) fn check_steps(
    duration: Positive,
    step: Option<Positive>,
    table: &mut Reader<'_>,
    keys: &[&str],
) {
    let Some(step) = step else { return };
    check_first_step(duration, step, table, keys);
    let (duration, step) = (duration.get(), step.get());
    let steps = duration / step;
    if steps > MAX_STEPS {
        let title =
            format!("the run has {steps:e} time steps of {step:e}, more than can be counted");
        let nearest = duration / MAX_STEPS;
        table.refuse(keys, title, format!("the nearest time step that works is {nearest:e}"));
    }
}

/// Reports a run that ends before its first step.
pub(super) fn check_first_step(
    duration: Positive,
    step: Positive,
    table: &mut Reader<'_>,
    keys: &[&str],
) {
    let (duration, step) = (duration.get(), step.get());
    // The number of steps is floor(duration / step + 1e-9).
    if duration / step + 1e-9 < 1.0 {
        let title = "the run is shorter than one time step";
        let label = "the time step must be <= the duration";
        table.refuse(
            keys,
            title,
            format!("{label}: reduce it, or increase the duration to at least {step:?}"),
        );
    }
}
