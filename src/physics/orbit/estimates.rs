//! What is known of a run before its first step: how much explicit Euler will gain, how far the path will reach.

use super::elements::Elements;
use super::integrators::Integrator;
use super::kepler::Kepler;
use super::motion::length;
use crate::constants::GM_SUN_AU3_PER_DAY2;

/// What the drawing leaves free around the path, as a factor.
const MARGIN: f64 = 1.1;

/// Largest distance from the Sun to be drawn, AU: the aphelion, or the farther end of an open path; for explicit Euler of
/// the orbit as it has grown at the end.
pub(super) fn reach(
    exact: &Kepler,
    integrator: Integrator,
    step_days: f64,
    duration_days: f64,
) -> f64 {
    let elements = Elements::of(exact.start());
    let farthest = match elements.bound {
        Some(_) if integrator == Integrator::ExplicitEuler => {
            let grown = grown_semi_major_axis(&elements, step_days, duration_days);
            grown * (1.0 + elements.eccentricity)
        }
        Some(bound) => bound.aphelion,
        None => {
            let first = length(exact.start().position);
            let last = length(exact.at(duration_days).state.position);
            if first > last { first } else { last }
        }
    };
    MARGIN * farthest
}

/// Explicit Euler's semi-major axis after a time t, AU: a^3 = a0^3 + 6 h GM t (1 + e^2/2) (1 - e^2)^(-5/2), from the
/// energy that its local error adds, averaged over a revolution of fixed eccentricity.
fn grown_semi_major_axis(elements: &Elements, step_days: f64, duration_days: f64) -> f64 {
    let a = elements.semi_major_axis;
    let gain = 6.0 * step_days * GM_SUN_AU3_PER_DAY2 * duration_days * energy_gain_factor(elements);
    libm::cbrt(a * a * a + gain)
}

/// What explicit Euler adds to the energy in one revolution over its size, to first order in the step h:
/// 8 pi^2 (h / P) (1 + e^2/2) (1 - e^2)^(-5/2).
pub(super) fn euler_energy_gain_per_revolution(
    elements: &Elements,
    period_days: f64,
    step_days: f64,
) -> f64 {
    use std::f64::consts::TAU;
    2.0 * TAU * TAU * step_days / period_days * energy_gain_factor(elements)
}

/// (1 + e^2/2) (1 - e^2)^(-5/2): how much more an eccentric orbit gains than a circle of the same axis.
fn energy_gain_factor(elements: &Elements) -> f64 {
    let square = elements.eccentricity * elements.eccentricity;
    let rest = 1.0 - square;
    (1.0 + 0.5 * square) / (rest * rest * rest.sqrt())
}
