//! Law: halving the step divides the error by 2^p: p = 1 for both Euler methods, 2 for Verlet, 4 for Yoshida's and for
//! the classical Runge-Kutta method, and 5 for the energy of the latter after whole revolutions.
//!
//! Source: the definitions of the methods (Hairer, Lubich and Wanner, Geometric Numerical Integration, chapters I, II
//! and V). Positions after a year and reference values of the drift: 40-digit arithmetic and another f64 program.
//! Setup: the initial state of the orbit exercise. The error is the distance from the exact Kepler motion after 100
//! days, more than a quarter of a revolution, so that no return to the initial position hides it; p is the slope of a
//! least-squares line in logarithms over four steps.
//! Tolerance: 5 % of p, for the next term of the error's series at these steps; 0.001 for explicit Euler over a whole
//! revolution; 0.1 for the energy of Runge-Kutta.
//! Control: the errors of each method are rejected for the next order and the order below.

// Fits may use std's functions; reference values keep all their digits.
#![allow(clippy::disallowed_methods, clippy::excessive_precision)]

use crate::run::{JULIAN_YEAR, exercise, finished, observe};
use kinetoscope_manifest::model::OrbitIntegrator;

/// Period of the exercise's initial state, days (50-digit arithmetic).
const PERIOD: f64 = 362.073_107_968_315_865_9;

/// Slope of log(error) over log(step), by least squares.
fn order(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let logs: Vec<(f64, f64)> = points.iter().map(|(h, error)| (h.ln(), error.ln())).collect();
    let mean = |pick: fn(&(f64, f64)) -> f64| logs.iter().map(pick).sum::<f64>() / count;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let covariance: f64 = logs.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
    let variance: f64 = logs.iter().map(|point| (point.0 - x) * (point.0 - x)).sum();
    covariance / variance
}

/// Step and position error after a duration divided into each number of steps.
fn position_errors(integrator: OrbitIntegrator, duration: f64, steps: [f64; 4]) -> Vec<(f64, f64)> {
    steps
        .map(|count| {
            let step = duration / count;
            let end = observe(&finished(&exercise(integrator, step, duration)));
            (step, end.orbit.position_error_au)
        })
        .to_vec()
}

#[test]
fn position_errors_have_the_order_of_each_method() {
    let methods = [
        (OrbitIntegrator::ExplicitEuler, 1.0, [4000.0, 8000.0, 16_000.0, 32_000.0]),
        (OrbitIntegrator::SemiImplicitEuler, 1.0, [400.0, 800.0, 1600.0, 3200.0]),
        (OrbitIntegrator::VelocityVerlet, 2.0, [100.0, 200.0, 400.0, 800.0]),
        (OrbitIntegrator::Rk4, 4.0, [50.0, 100.0, 200.0, 400.0]),
        (OrbitIntegrator::Yoshida4, 4.0, [50.0, 100.0, 200.0, 400.0]),
    ];
    for (integrator, expected, steps) in methods {
        let measured = order(&position_errors(integrator, 100.0, steps));
        println!("{integrator:?}: {measured}");
        assert!((measured / expected - 1.0).abs() < 0.05, "{integrator:?}: {measured}");
        for wrong in [expected - 1.0, expected + 1.0] {
            assert!((measured / wrong - 1.0).abs() > 0.05, "{integrator:?}: {measured}");
        }
    }
}

#[test]
fn explicit_euler_approaches_order_one() {
    let steps = [8000.0, 16_000.0, 32_000.0, 64_000.0];
    let mut energies = Vec::new();
    let mut positions = Vec::new();
    for count in steps {
        let step = PERIOD / count;
        let end = observe(&finished(&exercise(OrbitIntegrator::ExplicitEuler, step, PERIOD)));
        energies.push((step, end.energy.drift_ppm));
        positions.push((step, end.orbit.position_error_au));
    }
    // The two smallest steps; 40-digit arithmetic gives 0.996 and 0.999.
    let (energy, position) = (order(&energies[2..]), order(&positions[2..]));
    println!("energy {energy}, position {position}");
    assert!((energy - 0.996).abs() < 0.001, "{energy}");
    assert!((position - 0.999).abs() < 0.001, "{position}");
}

/// Setup: ten whole revolutions, after which the oscillating part of the energy error has returned to its initial value.
#[test]
fn runge_kutta_energy_error_is_of_fifth_order() {
    let points = [600.0, 900.0, 1350.0, 2025.0].map(|count| {
        let step = 10.0 * PERIOD / count;
        let end = observe(&finished(&exercise(OrbitIntegrator::Rk4, step, 10.0 * PERIOD)));
        assert!(end.energy.drift_ppm < 0.0, "Runge-Kutta must lose energy");
        (step, -end.energy.drift_ppm)
    });
    let measured = order(&points);
    println!("energy of Runge-Kutta: {measured}");
    assert!((measured - 5.0).abs() < 0.1, "{measured}");
}

/// x, y in AU after 365.25 days with steps of 0.25 days, from another f64 program with the same order of operations,
/// checked there against 40-digit arithmetic.
/// Tolerance: none.
#[test]
fn positions_after_a_year_equal_those_of_another_program() {
    let references = [
        (OrbitIntegrator::SemiImplicitEuler, [-0.235_523_740_770_400_4, 0.952_392_415_498_212_9]),
        (OrbitIntegrator::VelocityVerlet, [-0.235_542_307_532_198_9, 0.952_513_484_426_992_7]),
        (OrbitIntegrator::Yoshida4, [-0.235_581_133_300_718_73, 0.952_503_897_276_424_3]),
        (OrbitIntegrator::Rk4, [-0.235_581_131_398_097_36, 0.952_503_897_751_523_7]),
    ];
    for (integrator, expected) in references {
        let [x, y, _] = observe(&finished(&exercise(integrator, 0.25, JULIAN_YEAR))).state.position;
        assert_eq!([x, y], expected, "{integrator:?}");
    }
}
