//! Law: the adaptive method of order 8 keeps the error of each step below its tolerance: the position error is of the
//! order of the tolerance times the number of revolutions, at any eccentricity. With fixed steps, its order is 8.
//!
//! Source: Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.5. Conditions on the
//! coefficients: the sum of the weights times c^(q-1) is 1/q for q = 1..8, where c is the sum of a stage's row.
//! Setup: the initial state of the orbit exercise; an orbit of eccentricity 0.9 from its perihelion; both compared with
//! the exact Kepler motion.
//! Tolerance: stated at each test.
//! Control: coefficients changed by 1e-12, a loose tolerance, and velocity Verlet are rejected.

// Closed forms may use std's functions; an invalid configuration fails its test.
#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use crate::run::{advance, distance, exercise, finished, given, observe, prepare};
use kinetoscope_manifest::model::{OrbitConfig, OrbitIntegrator, OrbitSummation};
use kinetoscope_manifest::quantity::StepTolerance;
use kinetoscope_physics::constants::GM_SUN_AU3_PER_DAY2 as GM;
use kinetoscope_physics::model::{Model, Progress, Target};
use kinetoscope_physics::orbit::BARYCENTRIC_START;
use kinetoscope_physics::orbit::dormand_prince::{
    DORMAND_PRINCE_8, ERROR_OF_ORDER_3, ERROR_OF_ORDER_5,
};
use kinetoscope_physics::orbit::kepler::Kepler;
use kinetoscope_physics::orbit::single_step::take_step;

/// Largest |sum of weights times c^(q-1) - 1/q| for q = 1..8, where c is the time of a stage (the sum of its row).
fn max_defect(weights: &[f64; 12]) -> f64 {
    let times = DORMAND_PRINCE_8.stages.map(|row| row.iter().sum::<f64>());
    let defects = (1..=8).map(|q: i32| {
        let sum: f64 = weights.iter().zip(times).map(|(w, c)| w * c.powi(q - 1)).sum();
        (sum - 1.0 / f64::from(q)).abs()
    });
    defects.fold(0.0, f64::max)
}

/// Tolerance: 1e-14, the rounding of numbers up to 8 with weights of alternating sign.
#[test]
fn weights_integrate_powers_exactly() {
    let defect = max_defect(&DORMAND_PRINCE_8.weights);
    assert!(defect < 1e-14, "{defect:e}");
    // Control.
    let mut changed = DORMAND_PRINCE_8.weights;
    changed[7] += 1e-12;
    assert!(max_defect(&changed) > 1e-13);
    // The error estimates vanish for a constant derivative.
    for error in [ERROR_OF_ORDER_5, ERROR_OF_ORDER_3] {
        assert!(error.iter().sum::<f64>().abs() < 1e-14);
    }
}

/// With steps of 25 and 12.5 days over 200 days, the error falls from 1e-9 to 1e-12 AU.
/// Tolerance: 0.5 of 8, for the next term of the error at these steps.
#[test]
fn order_is_8_with_fixed_steps() {
    let exact = Kepler::from_start(BARYCENTRIC_START).at(200.0).state.position;
    let error = |steps: u32| {
        let h = 200.0 / f64::from(steps);
        let end =
            (0..steps).fold(BARYCENTRIC_START, |state, _| take_step(&DORMAND_PRINCE_8, state, h));
        distance(end.position, exact)
    };
    let [coarse, fine] = [error(8), error(16)];
    let order = (coarse / fine).log2();
    println!("{coarse:e} {fine:e} order {order}");
    assert!((order - 8.0).abs() < 0.5, "{order}");
}

/// Position error (AU), relative energy drift and force evaluations after a century.
fn century(summation: OrbitSummation, tolerance: f64) -> (f64, f64, u64) {
    let config = OrbitConfig {
        summation,
        tolerance: StepTolerance::new(tolerance).unwrap(),
        ..exercise(OrbitIntegrator::Dop853, 0.25, 36_525.0)
    };
    let end = observe(&finished(&config));
    (end.orbit.position_error_au, end.energy.drift_ppm / 1e6, end.orbit.force_evaluations)
}

/// Tolerance: 1e-10 AU at a tolerance of 1e-13. Errors of a step change the energy, and an energy error changes the
/// phase as the square of the time: 1e-13 times 12 steps per revolution times 100^2 would be 1e-8 if all errors had the
/// same sign.
#[test]
fn position_is_accurate_to_ten_digits_after_a_century() {
    for summation in [OrbitSummation::Plain, OrbitSummation::Compensated] {
        let (position, energy, evaluations) = century(summation, 1e-13);
        println!("{summation:?}: {position:e} AU, energy {energy:e}, {evaluations} evaluations");
        assert!(position < 1e-10, "{position:e}");
        assert!(energy.abs() < 1e-12, "{energy:e}");
    }
    assert!(century(OrbitSummation::Plain, 1e-6).0 > 1e-6, "control: loose tolerance");
}

/// Ten revolutions at e = 0.9 in steps of the given length, days; `None` is one step.
fn eccentric(step: Option<f64>) -> OrbitConfig {
    let speed = (GM * 1.9 / 0.1).sqrt();
    let duration = 10.0 * std::f64::consts::TAU / GM.sqrt();
    OrbitConfig {
        start: given([0.1, 0.0, 0.0], [0.0, speed, 0.0]),
        ..exercise(OrbitIntegrator::Dop853, step.unwrap_or(duration), duration)
    }
}

/// Guarantee: a call attempts as many steps as its budget, so that a signal is served however long the steps of the manifest are. No
/// bit depends on the budget, and the state between two calls is that at its count.
/// Setup: steps of the manifest that are shorter and longer than those of the method. An attempt evaluates the force 12 times, the
/// number of stages.
#[test]
fn budget_limits_the_attempted_steps_of_a_call() {
    for step in [Some(0.5), Some(61.3), None] {
        let config = eccentric(step);
        let reference = finished(&config);
        for budget in [1, 7, 64] {
            let mut orbit = prepare(&config);
            let mut progress = Ok(Progress::Working);
            while progress == Ok(Progress::Working) {
                let before = observe(&orbit).orbit.force_evaluations;
                progress = orbit.advance(Target::Count(reference.count()), budget);
                let attempts = (observe(&orbit).orbit.force_evaluations - before) / 12;
                assert!(attempts <= budget, "{step:?}: {attempts} attempts, budget {budget}");
                if budget == 64 {
                    let mut at_count = prepare(&config);
                    advance(&mut at_count, orbit.count());
                    assert_eq!(orbit.state(), at_count.state(), "{step:?}, {}", orbit.count());
                }
            }
            assert_eq!(orbit, reference, "{step:?}, budget {budget}");
        }
    }
}

/// Ten revolutions at e = 0.9, where the speed varies by a factor of 19.
/// Tolerance: 1e-9 AU, measured with a margin; velocity Verlet with the same number of frames exceeds 1e-2 AU.
#[test]
fn eccentric_orbit_is_accurate_with_adaptive_steps() {
    let config = eccentric(Some(0.5));
    let end = observe(&finished(&config));
    let (error, evaluations) = (end.orbit.position_error_au, end.orbit.force_evaluations);
    println!("{error:e} AU, {evaluations} evaluations");
    assert!(error < 1e-9, "{error:e}");
    let verlet = OrbitConfig { integrator: OrbitIntegrator::VelocityVerlet, ..config };
    let end = observe(&finished(&verlet));
    assert!(end.orbit.position_error_au > 1e-2, "control: fixed steps of half a day are too long");
}
