//! Steps of Dormand and Prince's method of order 8, each as long as its estimated error allows.
//!
//! A step is chosen by the one before it and by nothing else: neither by when frames are taken nor by how work is cut. Between
//! two of these nodes the bodies are where one shorter step from the earlier node takes them. The method is written here since
//! the control of its steps must have the same bits everywhere: sums in a fixed order, and no power function.

use super::dormand_prince::{DORMAND_PRINCE_8, ERROR_OF_ORDER_3, ERROR_OF_ORDER_5};
use super::motion::{Force, Phase};
use super::single_step::{Walker, weighted};
use serde::{Deserialize, Serialize};

/// The end of the last whole step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Node<V> {
    /// Since the start, days.
    pub(super) time: f64,
    /// Length to try next, days.
    pub(super) trial: f64,
    pub(super) phase: Phase<V>,
    pub(super) lost: Phase<V>,
    /// Whole turns up to here.
    pub(super) turns: i64,
}

/// What the next step's length is multiplied with when the estimate says that a longer or shorter one would just do.
const SAFETY: f64 = 0.9;
/// Most that a step is longer than the one before.
const LONGEST: f64 = 6.0;
/// Least of the same (Hairer, Norsett, Wanner: DOP853, FAC1 and FAC2).
const SHORTEST: f64 = 0.333;

/// Takes a step of length h if its error is within the tolerance; says by what to multiply h next, and whether it was taken.
/// `None`: no number came out.
pub(super) fn try_step<F: Force, const COMPENSATED: bool>(
    walker: &mut Walker<'_, F, COMPENSATED>,
    h: f64,
    tolerance: f64,
) -> Option<(f64, bool)> {
    let slopes = DORMAND_PRINCE_8.slopes(walker, h);
    let error = h.abs() * relative_error(&walker.phase, &slopes) / tolerance;
    if !error.is_finite() {
        return None;
    }
    let taken = error <= 1.0;
    if taken {
        DORMAND_PRINCE_8.finish(walker, &slopes, h);
    }
    // The error goes with the eighth power of h; three square roots are an eighth root, with the same bits everywhere.
    let factor = SAFETY / error.sqrt().sqrt().sqrt();
    let factor = if factor > LONGEST { LONGEST } else { factor };
    Some((if factor < SHORTEST { SHORTEST } else { factor }, taken))
}

/// Estimated error of a step over h, of r relative to |r| and of v relative to |v|: e5^2 / sqrt(e5^2 + e3^2 / 100) with the
/// differences to the methods of order 5 and 3 (Hairer, Norsett, Wanner, equation II.10.17).
fn relative_error<V: AsRef<[f64]>>(phase: &Phase<V>, slopes: &[Phase<V>; 12]) -> f64 {
    let part = |weights: &[f64; 12], of: fn(&Phase<V>) -> &[f64]| {
        let (mut error, mut size) = (0.0, 0.0);
        for (axis, here) in of(phase).iter().enumerate() {
            let difference = weighted(weights, |slope| of(&slopes[slope])[axis]);
            error += difference * difference;
            size += here * here;
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
