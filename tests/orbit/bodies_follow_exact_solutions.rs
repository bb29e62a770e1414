//! Law: bodies with a_i = sum over j of G m_j (r_j - r_i) / |r_j - r_i|^3 conserve energy, momentum and angular
//! momentum, and follow these known solutions:
//! - Lagrange's triangle of equal masses rotates rigidly with omega^2 = 3 G m / side^3;
//! - figure eight: three equal masses follow one closed curve, a third of the period apart;
//! - two bodies: their separation follows the Kepler motion around the sum of their masses.
//!
//! Source: Lagrange (1772); inserted into the equation of motion, the two attractions on a corner add up to 3 G m /
//! side^3 times its displacement from the center. Chenciner and Montgomery, Ann. Math. 152 (2000) 881, with the initial
//! state and period of C. Simo, 8 digits.
//! Setup: G m = 1 AU^3/day^2 and lengths of the order of 1 AU, so that times are of the order of a day.
//! Tolerance: stated at each test.
//! Control: an initial velocity changed in its third digit, and explicit Euler, are rejected.

// Closed forms may use std's functions; an invalid configuration fails its test.
#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use crate::run::{body, distance, exercise};
use kinetoscope_manifest::model::{OrbitBody, OrbitConfig, OrbitIntegrator};
use kinetoscope_physics::constants::GM_SUN_AU3_PER_DAY2 as GM;
use kinetoscope_physics::model::{Extent, Model, Progress, Target};
use kinetoscope_physics::orbit::kepler::Kepler;
use kinetoscope_physics::orbit::motion::State;
use kinetoscope_physics::orbit::{BARYCENTRIC_START, Orbit};
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::{OrbitConserved, OrbitEnergy};
use kinetoscope_recording::frame::Frame;

fn run(bodies: Vec<OrbitBody>, integrator: OrbitIntegrator, step: f64, duration: f64) -> Orbit {
    let config = OrbitConfig { bodies: Some(bodies), ..exercise(integrator, step, duration) };
    let mut orbit = Orbit::prepare(&config, Seed { seed: 0, replicate: 0 }, false).unwrap();
    let Extent::Steps { total, .. } = orbit.extent() else { panic!("an orbit run has steps") };
    assert_eq!(orbit.advance(Target::Count(total), u64::MAX), Ok(Progress::Reached));
    orbit
}

/// Positions, energy and conserved quantities of the current frame.
fn observe(orbit: &Orbit) -> (Vec<[f64; 3]>, OrbitEnergy, OrbitConserved) {
    let mut frame = Frame::new();
    orbit.observe(&mut frame);
    let rows = frame.state().as_chunks::<6>().0;
    let positions = rows.iter().map(|row| [row[0], row[1], row[2]]).collect();
    (positions, frame.get().unwrap(), frame.get().unwrap())
}

/// Corner of the triangle at distance 1 from the center, rotated by `angle`.
fn corner(index: usize, angle: f64) -> [f64; 3] {
    let angle = angle + std::f64::consts::TAU / 3.0 * index as f64;
    [angle.cos(), angle.sin(), 0.0]
}

/// omega^2 = 3 G m / side^3, side = sqrt(3).
fn triangle_rate() -> f64 {
    (3.0 / 27.0_f64.sqrt()).sqrt()
}

/// Largest distance of a corner from its exact position after 10 days, 1.2 revolutions.
fn triangle_error(integrator: OrbitIntegrator, step: f64, speed: f64) -> f64 {
    let quarter = std::f64::consts::FRAC_PI_2;
    let bodies = [0, 1, 2].map(|index| {
        let velocity = corner(index, quarter).map(|part| part * speed);
        body(1.0, corner(index, 0.0), velocity)
    });
    let (positions, ..) = observe(&run(bodies.to_vec(), integrator, step, 10.0));
    let angle = 10.0 * triangle_rate();
    (0..3).map(|index| distance(positions[index], corner(index, angle))).fold(0.0, f64::max)
}

/// Tolerance: 1e-11 AU; the triangle is unstable, and rounding errors grow by exp(0.7 omega t) = 200 in this time.
/// Orders within 10 %.
#[test]
fn lagrange_triangle_rotates_rigidly() {
    let rate = triangle_rate();
    let error = triangle_error(OrbitIntegrator::Dop853, 0.1, rate);
    println!("triangle, adaptive: {error:e} AU");
    assert!(error < 1e-11, "{error:e}");
    for (integrator, order) in [
        (OrbitIntegrator::SemiImplicitEuler, 1.0),
        (OrbitIntegrator::VelocityVerlet, 2.0),
        (OrbitIntegrator::Rk4, 4.0),
        (OrbitIntegrator::Yoshida4, 4.0),
    ] {
        let [coarse, fine] = [0.02, 0.01].map(|step| triangle_error(integrator, step, rate));
        let measured = (coarse / fine).log2();
        println!("triangle, {integrator:?}: {fine:e} AU, order {measured}");
        assert!((measured / order - 1.0).abs() < 0.1, "{integrator:?}: {measured}");
    }
    let control = triangle_error(OrbitIntegrator::Dop853, 0.1, 1.001 * rate);
    assert!(control > 1e-3, "{control:e}");
}

/// Position and velocity of the initial state of C. Simo, and the period, days.
const EIGHT: [[f64; 2]; 2] = [[0.970_004_36, -0.243_087_53], [-0.932_407_37, -0.864_731_46]];
const EIGHT_PERIOD: f64 = 6.325_913_98;

fn eight(speed: f64) -> Vec<OrbitBody> {
    let [[x, y], [u, v]] = EIGHT;
    let (u, v) = (u * speed, v * speed);
    vec![
        body(1.0, [x, y, 0.0], [-u / 2.0, -v / 2.0, 0.0]),
        body(1.0, [-x, -y, 0.0], [-u / 2.0, -v / 2.0, 0.0]),
        body(1.0, [0.0; 3], [u, v, 0.0]),
    ]
}

/// Largest distance of a body from the nearest initial position after a third of a period, when each body has reached
/// the next position along the curve.
fn figure_eight_error(speed: f64) -> f64 {
    let third = EIGHT_PERIOD / 3.0;
    let (positions, ..) = observe(&run(eight(speed), OrbitIntegrator::Dop853, third / 4.0, third));
    let [[x, y], _] = EIGHT;
    let initial = [[x, y, 0.0], [-x, -y, 0.0], [0.0; 3]];
    let nearest = |position: [f64; 3]| {
        initial.iter().map(|start| distance(*start, position)).fold(f64::INFINITY, f64::min)
    };
    positions.iter().map(|position| nearest(*position)).fold(0.0, f64::max)
}

/// Tolerance: 1e-6 AU, because the initial state and the period have eight digits. The angular momentum of the figure
/// eight is zero.
#[test]
fn figure_eight_is_followed_by_all_three_bodies() {
    let error = figure_eight_error(1.0);
    println!("figure eight: {error:e} AU");
    assert!(error < 1e-6, "{error:e}");
    // Control.
    assert!(figure_eight_error(1.001) > 1e-4);

    let long = 20.0 * EIGHT_PERIOD;
    let (_, energy, conserved) =
        observe(&run(eight(1.0), OrbitIntegrator::VelocityVerlet, EIGHT_PERIOD / 1000.0, long));
    println!("figure eight, 20 periods of Verlet: {energy:?} {conserved:?}");
    // The forces of a pair are exactly opposite; the remainder is the rounding of 20000 steps.
    assert!(conserved.specific_angular_momentum_change_ppm < 1e-7);
    assert!(conserved.specific_momentum_au_per_day < 1e-13);
    assert!(conserved.center_of_mass_au < 1e-12);
    // Verlet's error is of the order (step / time scale)^2 and does not grow.
    assert!(energy.drift_ppm.abs() < 10.0);
    let (_, control, _) =
        observe(&run(eight(1.0), OrbitIntegrator::ExplicitEuler, EIGHT_PERIOD / 1000.0, long));
    assert!(control.drift_ppm > 1e3, "control: explicit Euler: {}", control.drift_ppm);
}

/// Masses of 3/4 and 1/4 of the Sun with the separation and relative velocity of the orbit exercise, whose separation
/// must follow the exercise.
/// Tolerance: 1e-11 AU after a year, for the tolerance of about 50 steps and its growth.
#[test]
fn two_bodies_follow_the_kepler_motion_of_their_total_mass() {
    let State { position, velocity } = BARYCENTRIC_START;
    let bodies = vec![body(0.75 * GM, [0.0; 3], [0.0; 3]), body(0.25 * GM, position, velocity)];
    let orbit = run(bodies, OrbitIntegrator::Dop853, 0.25, 365.25);
    let (positions, energy, conserved) = observe(&orbit);
    let separation: [f64; 3] = std::array::from_fn(|axis| positions[1][axis] - positions[0][axis]);
    let exact = Kepler::from_start(BARYCENTRIC_START).at(365.25).state.position;
    let error = distance(separation, exact);
    println!("two bodies after a year: {error:e} AU, energy {} ppm", energy.drift_ppm);
    assert!(error < 1e-11, "{error:e}");
    // The energy of the relative motion times m1 m2 / M^2.
    let relative = -0.000_148_822_178_837_004_19 * 0.75 * 0.25;
    assert!((energy.specific_total_energy_au2_per_day2 / relative - 1.0).abs() < 1e-11);
    assert!(conserved.center_of_mass_au < 1e-13);
}

#[test]
fn coincident_bodies_are_rejected_and_a_collapse_is_a_fault() {
    let prepare = |bodies| {
        let config =
            OrbitConfig { bodies: Some(bodies), ..exercise(OrbitIntegrator::Dop853, 0.01, 10.0) };
        Orbit::prepare(&config, Seed { seed: 0, replicate: 0 }, false)
    };
    let here = [1.0, 0.0, 0.0];
    for bodies in [
        vec![body(1.0, here, [0.0, 0.1, 0.0]), body(1.0, here, [0.0; 3])],
        vec![body(1.0, [0.0; 3], [0.0; 3]), body(1.0, here, [0.0; 3])],
    ] {
        let error = prepare(bodies).unwrap_err();
        assert!(error.0.what.contains("no motion to follow"), "{error}");
    }
    // Three bodies that fall toward each other: their paths end in a point after a finite time.
    let falling =
        |index: usize| body(1.0, corner(index, 0.0), corner(index, 0.0).map(|part| -0.01 * part));
    let mut orbit = prepare([0, 1, 2].map(falling).to_vec()).unwrap();
    let fault = orbit.advance(Target::Count(1000), u64::MAX).unwrap_err();
    assert!(fault.recorded().contains("too close to each other"), "{fault}");
    let mut in_parts = prepare([0, 1, 2].map(falling).to_vec()).unwrap();
    while in_parts.advance(Target::Count(1000), 7) == Ok(Progress::Working) {}
    assert_eq!(in_parts, orbit, "the final state depends on the step budget");
}
