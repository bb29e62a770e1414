//! Estimates before the first step: energy gain of explicit Euler, and maximum distance from the Sun.

use super::elements::Elements;
use super::kepler::Kepler;
use super::motion::length;
use super::trajectory::Discretization;
use crate::constants::GM_SUN_AU3_PER_DAY2;
use kinetoscope_manifest::model::OrbitIntegrator;

/// Half width of the view over the maximum distance from the Sun.
const MARGIN: f64 = 1.1;

/// Half width of the view, AU. The maximum distance from the Sun is the aphelion (for explicit Euler, that of the grown orbit at the end
/// of the run) or the more distant end of an open path.
pub(super) fn view_half_width(
    exact: &Kepler,
    discretization: &Discretization,
    duration_days: f64,
) -> f64 {
    let elements = Elements::of(exact.start());
    let farthest = match elements.bound {
        Some(_) if discretization.integrator == OrbitIntegrator::ExplicitEuler => {
            let grown = grown_semi_major_axis(&elements, discretization.step, duration_days);
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

/// Semi-major axis of explicit Euler after time t, AU: a^3 = a0^3 + 6 h GM t (1 + e^2/2) (1 - e^2)^(-5/2). It follows from the energy
/// added by the local error, averaged over a revolution of constant eccentricity.
pub(super) fn grown_semi_major_axis(
    elements: &Elements,
    step_days: f64,
    duration_days: f64,
) -> f64 {
    let a = elements.semi_major_axis;
    let gain = 6.0 * step_days * GM_SUN_AU3_PER_DAY2 * duration_days * energy_gain_factor(elements);
    libm::cbrt(a * a * a + gain)
}

/// Relative energy gain per revolution of explicit Euler to first order in the step h: 8 pi^2 (h / P) (1 + e^2/2) (1 - e^2)^(-5/2).
pub(super) fn euler_energy_gain_per_revolution(
    elements: &Elements,
    period_days: f64,
    step_days: f64,
) -> f64 {
    use std::f64::consts::TAU;
    2.0 * TAU * TAU * step_days / period_days * energy_gain_factor(elements)
}

/// Ratio of the energy gain to that of a circle with the same semi-major axis: (1 + e^2/2) (1 - e^2)^(-5/2).
fn energy_gain_factor(elements: &Elements) -> f64 {
    let square = elements.eccentricity * elements.eccentricity;
    let rest = 1.0 - square;
    (1.0 + 0.5 * square) / (rest * rest * rest.sqrt())
}
