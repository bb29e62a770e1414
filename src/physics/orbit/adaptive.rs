//! Adaptive steps of the Dormand–Prince method of order 8, each as long as its estimated error allows.
//!
//! The length of a step depends only on the step before it, not on the times of the frames or on the division of the work. Between two
//! steps, the bodies are at the end of one shorter step from the earlier one. The step control uses sums in a fixed order and no power
//! function, so its results are bitwise identical on every machine.

use super::dormand_prince::{DORMAND_PRINCE_8, ERROR_OF_ORDER_3, ERROR_OF_ORDER_5};
use super::motion::{Force, Phase};
use super::single_step::{IntegrationState, weighted};
use serde::{Deserialize, Serialize};

/// End of the last whole step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct AdaptiveStep<V, R> {
    /// Time since the start, days.
    pub(super) time: f64,
    /// Length of the next step to try, days.
    pub(super) next_length: f64,
    pub(super) phase: Phase<V>,
    pub(super) compensation: Phase<V>,
    /// Events of the path up to this time.
    pub(super) path: R,
}

/// Result of an attempted step.
pub(super) struct Attempt {
    /// Factor for the length of the next step.
    pub(super) length_factor: f64,
    /// Whether the error was within the tolerance, so that the step was taken.
    pub(super) is_accepted: bool,
}

/// Factor by which a step is shorter than the estimate of the longest step within the tolerance.
const SAFETY: f64 = 0.9;
/// Maximum ratio of a step to the step before it (DOP853, FAC2).
const MAX_LENGTH_FACTOR: f64 = 6.0;
/// Minimum ratio of a step to the step before it (DOP853, FAC1).
const MIN_LENGTH_FACTOR: f64 = 0.333;

/// Factor for the length of a step whose error is not finite.
const OVERFLOW_LENGTH_FACTOR: f64 = 0.1;

/// Takes a step of length h if its error is within the tolerance.
pub(super) fn try_step<F: Force, const COMPENSATED: bool>(
    state: &mut IntegrationState<'_, F, COMPENSATED>,
    h: f64,
    tolerance: f64,
) -> Attempt {
    let slopes = DORMAND_PRINCE_8.slopes(state, h);
    let error = h.abs() * relative_error(&state.phase, &slopes) / tolerance;
    if !error.is_finite() {
        return Attempt { length_factor: OVERFLOW_LENGTH_FACTOR, is_accepted: false };
    }
    let is_accepted = error <= 1.0;
    if is_accepted {
        DORMAND_PRINCE_8.finish(state, &slopes, h);
    }
    // The error is proportional to h^8; three square roots are an eighth root that is bitwise identical on every machine.
    let factor = SAFETY / error.sqrt().sqrt().sqrt();
    let factor = if factor > MAX_LENGTH_FACTOR { MAX_LENGTH_FACTOR } else { factor };
    let length_factor = if factor < MIN_LENGTH_FACTOR { MIN_LENGTH_FACTOR } else { factor };
    Attempt { length_factor, is_accepted }
}

/// Estimated error of a step over h, of r relative to |r| and of v relative to |v|: e5^2 / sqrt(e5^2 + e3^2 / 100), where e5 and e3
/// are the differences from the methods of orders 5 and 3 (Hairer, Norsett, Wanner, equation II.10.17).
fn relative_error<V: AsRef<[f64]>>(phase: &Phase<V>, slopes: &[Phase<V>; 12]) -> f64 {
    let part = |weights: &[f64; 12], of: fn(&Phase<V>) -> &[f64]| {
        let (mut error, mut size) = (0.0, 0.0);
        for (axis, component) in of(phase).iter().enumerate() {
            let difference = weighted(weights, |slope| of(&slopes[slope])[axis]);
            error += difference * difference;
            size += component * component;
        }
        error / size
    };
    let both = |weights| {
        part(weights, |phase| phase.position.as_ref())
            + part(weights, |phase| phase.velocity.as_ref())
    };
    let (fifth, third) = (both(&ERROR_OF_ORDER_5), both(&ERROR_OF_ORDER_3));
    if fifth == 0.0 { 0.0 } else { fifth / (fifth + 0.01 * third).sqrt() }
}
