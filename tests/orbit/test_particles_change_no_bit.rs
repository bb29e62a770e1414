//! Law: a body without mass feels the others and attracts none, so the others move as if it were absent.
//!
//! Source: a_i = sum over j of G m_j (r_j - r_i) / |r_j - r_i|^3 with m_j = 0.
//! Setup: the Sun and a planet with a tenth of its mass for ten years, alone and with three test particles, two of them at the same
//! position. A test particle on the planet's ellipse around the Sun alone follows the exact solution.
//! Tolerance: none, all bits are equal. For the adaptive method, whose steps keep the tolerance for the test particles as well,
//! 1e-9 AU: its tolerance of 1e-13 per step, in a few hundred steps, and the growth of the phase error.
//! Control: with 1e-15 of the Sun's mass, a test particle changes bits.

// An invalid configuration fails its test.
#![allow(clippy::unwrap_used)]

use crate::run::{distance, exercise, finished, prepare};
use kinetoscope_manifest::model::{OrbitBody, OrbitConfig, OrbitIntegrator, OrbitSummation};
use kinetoscope_physics::constants::GM_SUN_AU3_PER_DAY2 as GM;
use kinetoscope_physics::model::Model;
use kinetoscope_physics::orbit::kepler::Kepler;
use kinetoscope_physics::orbit::motion::State;
use kinetoscope_recording::channels::OrbitEnergy;
use kinetoscope_recording::frame::Frame;

const YEARS: f64 = 3652.5;

fn body(mass: f64, position: [f64; 3], velocity: [f64; 3]) -> OrbitBody {
    crate::run::body(mass * GM, position, velocity)
}

fn massive() -> Vec<OrbitBody> {
    vec![body(1.0, [0.0; 3], [0.0; 3]), body(0.1, [3.0, 0.0, 0.0], [0.0, 0.01, 0.0])]
}

fn with_particles(mass: f64) -> Vec<OrbitBody> {
    let mut bodies = massive();
    bodies.push(body(mass, [0.0, 1.0, 0.1], [-0.0172, 0.0, 0.0]));
    bodies.extend([0, 1].map(|_| body(0.0, [-1.5, 0.0, 0.0], [0.0, -0.014, 0.0])));
    bodies
}

fn rows(
    bodies: Vec<OrbitBody>,
    integrator: OrbitIntegrator,
    summation: OrbitSummation,
) -> Vec<[f64; 6]> {
    let config =
        OrbitConfig { bodies: Some(bodies), summation, ..exercise(integrator, 0.5, YEARS) };
    let mut frame = Frame::new();
    finished(&config).observe(&mut frame);
    frame.state().as_chunks::<6>().0.to_vec()
}

fn bits(rows: &[[f64; 6]]) -> Vec<[u64; 6]> {
    rows.iter().take(2).map(|row| row.map(f64::to_bits)).collect()
}

#[test]
fn massive_bodies_do_not_depend_on_test_particles() {
    for integrator in [
        OrbitIntegrator::ExplicitEuler,
        OrbitIntegrator::SemiImplicitEuler,
        OrbitIntegrator::VelocityVerlet,
        OrbitIntegrator::Rk4,
        OrbitIntegrator::Yoshida4,
    ] {
        for summation in [OrbitSummation::Plain, OrbitSummation::Compensated] {
            let alone = rows(massive(), integrator, summation);
            let accompanied = rows(with_particles(0.0), integrator, summation);
            assert_eq!(bits(&alone), bits(&accompanied), "{integrator:?}, {summation:?}");
            // Test particles do not attract each other, so equal starts give equal paths.
            assert_eq!(accompanied[3], accompanied[4]);
            let control = rows(with_particles(1e-15), integrator, summation);
            assert_ne!(bits(&alone), bits(&control), "control: {integrator:?}, {summation:?}");
        }
    }
}

#[test]
fn adaptive_steps_agree_within_the_tolerance() {
    let run = |bodies| rows(bodies, OrbitIntegrator::Dop853, OrbitSummation::Plain);
    let (alone, accompanied) = (run(massive()), run(with_particles(0.0)));
    let position = |row: &[f64; 6]| [row[0], row[1], row[2]];
    let apart = distance(position(&alone[1]), position(&accompanied[1]));
    println!("adaptive steps: {apart:e} AU");
    assert!(apart < 1e-9, "{apart:e}");
}

/// Tolerance: 1e-9 AU, as above.
#[test]
fn test_particle_around_one_mass_follows_the_exact_solution() {
    let (position, velocity) = ([0.0, 1.0, 0.1], [-0.0172, 0.0, 0.001]);
    let sun = body(1.0, [0.0; 3], [0.0; 3]);
    let particle = body(0.0, position, velocity);
    let rows = rows(vec![sun, particle], OrbitIntegrator::Dop853, OrbitSummation::Plain);
    let exact = Kepler::from_start(State { position, velocity }).at(YEARS).state.position;
    let error = distance([rows[1][0], rows[1][1], rows[1][2]], exact);
    println!("test particle after ten years: {error:e} AU");
    assert!(error < 1e-9, "{error:e}");
}

/// Around one mass, each test particle keeps v^2/2 - GM/r = -GM/(2a). Tolerance: rounding. Control: Euler's method does not.
#[test]
fn energy_around_one_mass_is_the_mean_of_the_test_particles() {
    let circle = |radius: f64| body(0.0, [radius, 0.0, 0.0], [0.0, (GM / radius).sqrt(), 0.0]);
    let bodies = vec![body(1.0, [0.0; 3], [0.0; 3]), circle(1.0), circle(2.0)];
    let expected = -0.5 * (GM / 2.0 + GM / 4.0);
    let energies = |integrator| {
        let config =
            OrbitConfig { bodies: Some(bodies.clone()), ..exercise(integrator, 0.5, YEARS) };
        [prepare(&config), finished(&config)].map(|orbit| {
            let mut frame = Frame::new();
            orbit.observe(&mut frame);
            let energy: OrbitEnergy = frame.get().unwrap();
            energy.specific_total_energy_au2_per_day2 / expected - 1.0
        })
    };
    let [start, end] = energies(OrbitIntegrator::Dop853);
    println!("relative to the mean of -GM/(2a): {start:e} at the start, {end:e} after ten years");
    assert!(start.abs() < 1e-15 && end.abs() < 1e-10, "{start:e}, {end:e}");
    let [_, control] = energies(OrbitIntegrator::ExplicitEuler);
    assert!(control.abs() > 0.1, "{control:e}");
}
