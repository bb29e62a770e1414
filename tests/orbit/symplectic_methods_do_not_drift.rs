//! Law: a symplectic method conserves the angular momentum to rounding and keeps its energy error bounded at any time,
//! because it follows the exact motion of a slightly different energy. Explicit Euler does neither. Symmetric methods
//! are reversible in time.
//!
//! Source: Hairer, Lubich and Wanner, Geometric Numerical Integration, chapters VI and IX. Kicks are parallel to r and
//! drifts to v, so r x v does not change. To first order, the semi-implicit method conserves E - (h/2) v . a, so the
//! error of E is (h/2) GM (r . v) / r^3. Largest energy errors: an f64 program with the same operations, checked
//! against 40-digit arithmetic.
//! Setup: the initial state of the orbit exercise, h = 0.25 days, 100 years (146100 steps).
//! Tolerance: stated at each test.
//! Control: explicit Euler and, for the angular momentum, the classical Runge-Kutta method are rejected.

// Closed forms may use std's functions; reference values keep all their digits.
#![allow(clippy::disallowed_methods, clippy::excessive_precision)]

use crate::run::{distance, exercise, finished, given, observe};
use kinetoscope_manifest::model::{OrbitConfig, OrbitIntegrator};
use kinetoscope_physics::orbit::BARYCENTRIC_START;
use kinetoscope_physics::orbit::integrators::{
    EXPLICIT_EULER, RUNGE_KUTTA_4, SEMI_IMPLICIT_EULER, VELOCITY_VERLET, YOSHIDA_4,
};
use kinetoscope_physics::orbit::motion::{FixedSun, State, angular_momentum, energy, length};
use kinetoscope_physics::orbit::single_step::{IntegrationState, Method};

/// Largest |dE/E| of the first and of the second half, and largest |dL/L|.
struct MaxErrors {
    energy: [f64; 2],
    momentum: f64,
}

/// Errors over 100 years with steps of 0.25 days and plain sums.
fn max_errors(method: &impl Method) -> MaxErrors {
    max_errors_with_sums::<false>(method)
}

/// Errors over 100 years with steps of 0.25 days.
fn max_errors_with_sums<const COMPENSATED: bool>(method: &impl Method) -> MaxErrors {
    let state = BARYCENTRIC_START;
    let [energy_start, momentum_start] = [energy(state), length(angular_momentum(state))];
    let mut errors = MaxErrors { energy: [0.0; 2], momentum: 0.0 };
    let zeros = State { position: [0.0; 3], velocity: [0.0; 3] };
    let mut integration = IntegrationState::<_, COMPENSATED>::new(&FixedSun, state, zeros);
    for step in 0..146_100 {
        method.step(&mut integration, 0.25);
        let state = integration.phase;
        let half = &mut errors.energy[usize::from(step >= 73_050)];
        *half = half.max((energy(state) / energy_start - 1.0).abs());
        let drift = (length(angular_momentum(state)) / momentum_start - 1.0).abs();
        errors.momentum = errors.momentum.max(drift);
    }
    errors
}

/// Tolerance: the printed digits of the largest error, plus 3e-14 of rounding for Yoshida's and the Runge-Kutta method.
/// An error is bounded if the second fifty years exceed the first by at most 1 % plus that rounding.
#[test]
fn energy_errors_are_bounded_and_equal_the_reference() {
    let methods = [
        (max_errors(&SEMI_IMPLICIT_EULER), 6.163_681e-5),
        (max_errors(&VELOCITY_VERLET), 2.481_238e-7),
        (max_errors(&YOSHIDA_4), 9.650e-12),
    ];
    for (errors, expected) in methods {
        let [first, second] = errors.energy;
        let max = first.max(second);
        println!("{max:e}, second half {second:e}, momentum {:e}", errors.momentum);
        assert!((max - expected).abs() < 1e-6 * expected + 3e-14, "{max:e}");
        assert!(second < 1.01 * first + 3e-14, "{first:e} {second:e}");
    }
    let control = max_errors(&EXPLICIT_EULER).energy;
    assert!(control[1] > 1.1 * control[0], "control: explicit Euler drifts: {control:?}");
    let runge_kutta = max_errors(&RUNGE_KUTTA_4).energy;
    assert!((runge_kutta[1] - 2.750e-11).abs() < 3e-14, "{runge_kutta:?}");
    assert!(runge_kutta[1] > 1.9 * runge_kutta[0], "control: Runge-Kutta drifts: {runge_kutta:?}");
}

/// Tolerance: 5e-14, the random walk of the roundings of 146100 steps, 1e-16 each; 2e-13 for Yoshida's method, whose
/// step has nine parts, some of them longer than the whole step.
#[test]
fn angular_momentum_is_conserved_to_rounding() {
    let drifts = [
        (max_errors(&SEMI_IMPLICIT_EULER).momentum, 5e-14),
        (max_errors(&VELOCITY_VERLET).momentum, 5e-14),
        (max_errors(&YOSHIDA_4).momentum, 2e-13),
    ];
    for (drift, tolerance) in drifts {
        println!("plain sums {drift:e}");
        assert!(drift < tolerance, "{drift:e}");
    }
    assert!(
        max_errors(&RUNGE_KUTTA_4).momentum > 5e-13,
        "control: Runge-Kutta does not conserve L"
    );
}

/// Tolerance: 3e-15, the rounding of one cross product, because compensated sums retain the rounding errors of 146100
/// additions.
/// Control: compensation does not make the Runge-Kutta method conserve L.
#[test]
fn compensated_sums_conserve_angular_momentum_to_one_rounding() {
    let drifts = [
        max_errors_with_sums::<true>(&SEMI_IMPLICIT_EULER).momentum,
        max_errors_with_sums::<true>(&VELOCITY_VERLET).momentum,
        max_errors_with_sums::<true>(&YOSHIDA_4).momentum,
    ];
    println!("compensated sums {drifts:?}");
    for drift in drifts {
        assert!(drift < 3e-15, "{drift:e}");
    }
    assert!(max_errors_with_sums::<true>(&RUNGE_KUTTA_4).momentum > 5e-13);
}

/// dE = (h/2) GM (r . v) / r^3 relative to the initial state, so |dE/E| is at most n h e (1 + sin E0) with n h e =
/// 5.72e-5 and E0 = 5.2 degrees, the eccentric anomaly of the initial state.
/// Tolerance: 2 %, for terms of order e.
#[test]
fn amplitude_of_the_semi_implicit_energy_error_is_n_h_e() {
    let n = std::f64::consts::TAU / 362.073_107_968_315_9;
    let e: f64 = 0.013_193_509_473_117_57;
    // M0 + e sin M0 with M0 = 5.130364713432 degrees.
    let anomaly = 5.130_364_713_432_f64.to_radians();
    let eccentric = anomaly + e * anomaly.sin();
    let expected = n * 0.25 * e * (1.0 + eccentric.sin());
    let [first, _] = max_errors(&SEMI_IMPLICIT_EULER).energy;
    assert!((first / expected - 1.0).abs() < 0.02, "{first:e} {expected:e}");
}

/// Distance from the initial position after ten years, reversal of the velocity, and ten more years.
fn reversal_error(integrator: OrbitIntegrator) -> f64 {
    let middle = observe(&finished(&exercise(integrator, 0.25, 3652.5))).state;
    let reversed = middle.velocity.map(|component| -component);
    let config = OrbitConfig {
        start: given(middle.position, reversed),
        ..exercise(integrator, 0.25, 3652.5)
    };
    distance(observe(&finished(&config)).state.position, BARYCENTRIC_START.position)
}

/// Tolerance: 1e-11 AU; rounding errors of 29220 steps grow linearly in the phase.
#[test]
fn symmetric_methods_are_reversible_in_time() {
    for integrator in [OrbitIntegrator::VelocityVerlet, OrbitIntegrator::Yoshida4] {
        let error = reversal_error(integrator);
        println!("{integrator:?} {error:e}");
        assert!(error < 1e-11, "{integrator:?}: {error:e}");
    }
    for control in [OrbitIntegrator::ExplicitEuler, OrbitIntegrator::SemiImplicitEuler] {
        assert!(reversal_error(control) > 1e-6, "control: {control:?}");
    }
}
