//! Law: the method of order 8 with steps of its own keeps each step's error below its tolerance: the position errs by about
//! that much times the number of revolutions, however eccentric the orbit; with fixed steps its order is 8.
//!
//! Source: E. Hairer, S. P. Norsett, G. Wanner: Solving Ordinary Differential Equations I, section II.5. The conditions on the
//! coefficients: the sums of weights times powers of the stages' times are 1/q up to q = 8, and a stage's row sums to its time.
//! Setup: the orbit document's start; an orbit of eccentricity 0.9 from its perihelion; against the exact Kepler motion.
//! Tolerance: at each test.
//! Control: coefficients changed in their last digits, and a loose tolerance, are rejected by the same judges.

// Closed forms may use std's functions; a start that can't be built fails its test.
#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use crate::run::{apart, document, finished, given, look};
use kinetoscope_manifest::model::{OrbitConfig, OrbitIntegrator, OrbitSummation};
use kinetoscope_manifest::quantity::StepTolerance;
use kinetoscope_physics::constants::GM_SUN_AU3_PER_DAY2 as GM;
use kinetoscope_physics::orbit::DOCUMENT_START;
use kinetoscope_physics::orbit::dormand_prince::{
    DORMAND_PRINCE_8, ERROR_OF_ORDER_3, ERROR_OF_ORDER_5,
};
use kinetoscope_physics::orbit::kepler::Kepler;
use kinetoscope_physics::orbit::step::stepped;

/// Largest |sum of weights times c^(q-1) - 1/q| for q to 8, c a stage's time (the sum of its row).
fn largest_defect(weights: &[f64; 12]) -> f64 {
    let times = DORMAND_PRINCE_8.stages.map(|row| row.iter().sum::<f64>());
    let defects = (1..=8).map(|q: i32| {
        let sum: f64 = weights.iter().zip(times).map(|(w, c)| w * c.powi(q - 1)).sum();
        (sum - 1.0 / f64::from(q)).abs()
    });
    defects.fold(0.0, f64::max)
}

/// Tolerance: roundings of numbers up to 8 with weights of alternating sign.
#[test]
fn the_weights_integrate_powers_exactly() {
    let defect = largest_defect(&DORMAND_PRINCE_8.weights);
    assert!(defect < 1e-14, "{defect:e}");
    let mut wrong = DORMAND_PRINCE_8.weights;
    wrong[7] += 1e-12;
    assert!(largest_defect(&wrong) > 1e-13);
    // Both differences vanish for a constant slope.
    for error in [ERROR_OF_ORDER_5, ERROR_OF_ORDER_3] {
        assert!(error.iter().sum::<f64>().abs() < 1e-14);
    }
}

/// Steps of 20 to 10 days over 200: the error falls from 1e-9 to 1e-12 AU. Tolerance: 0.5 of 8, the next term at such steps.
#[test]
fn with_fixed_steps_the_order_is_8() {
    let exact = Kepler::from_start(DOCUMENT_START).at(200.0).state.position;
    let error = |steps: u32| {
        let h = 200.0 / f64::from(steps);
        let end = (0..steps).fold(DOCUMENT_START, |state, _| stepped(&DORMAND_PRINCE_8, state, h));
        apart(end.position, exact)
    };
    let [coarse, fine] = [error(8), error(16)];
    let order = (coarse / fine).log2();
    println!("{coarse:e} {fine:e} order {order}");
    assert!((order - 8.0).abs() < 0.5, "{order}");
}

fn century(summation: OrbitSummation, tolerance: f64) -> (f64, f64, u64) {
    let config = OrbitConfig {
        summation,
        tolerance: StepTolerance::new(tolerance).unwrap(),
        ..document(OrbitIntegrator::DormandPrince8, 0.25, 36_525.0)
    };
    let end = look(&finished(&config));
    (end.orbit.position_error_au, end.energy.drift_ppm / 1e6, end.orbit.force_evaluations)
}

/// Tolerance: 1e-10 AU at 1e-13: errors of a step go into the energy, whose error lets the phase run away with the square of
/// the time: 1e-13 times 12 steps a revolution times 100^2 would be 1e-8 if all had one sign.
#[test]
fn a_century_is_followed_to_ten_digits() {
    for summation in [OrbitSummation::Plain, OrbitSummation::Compensated] {
        let (position, energy, evaluations) = century(summation, 1e-13);
        println!("{summation:?}: {position:e} AU, energy {energy:e}, {evaluations} evaluations");
        assert!(position < 1e-10, "{position:e}");
        assert!(energy.abs() < 1e-12, "{energy:e}");
    }
    assert!(century(OrbitSummation::Plain, 1e-6).0 > 1e-6, "a loose tolerance is seen");
}

/// Ten revolutions at e = 0.9, where speeds differ by 19: steps shorten and lengthen by themselves.
#[test]
fn an_eccentric_orbit_takes_short_steps_at_the_perihelion() {
    let speed = (GM * 1.9 / 0.1).sqrt();
    let period = std::f64::consts::TAU / GM.sqrt();
    let config = OrbitConfig {
        start: given([0.1, 0.0, 0.0], [0.0, speed, 0.0]),
        ..document(OrbitIntegrator::DormandPrince8, 0.5, 10.0 * period)
    };
    let end = look(&finished(&config));
    let (error, evaluations) = (end.orbit.position_error_au, end.orbit.force_evaluations);
    println!("{error:e} AU, {evaluations} evaluations");
    assert!(error < 1e-9, "{error:e}");
    let verlet = OrbitConfig { integrator: OrbitIntegrator::VelocityVerlet, ..config };
    let end = look(&finished(&verlet));
    assert!(end.orbit.position_error_au > 1e-2, "equal steps of half a day are too long there");
}
