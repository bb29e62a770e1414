//! Law: bodies that attract each other, a_i = sum over j of G m_j (r_j - r_i) / |r_j - r_i|^3, keep energy, momentum and angular
//! momentum, and there are motions of three bodies whose course is known:
//! - Lagrange's triangle of equal masses: it turns as a whole with omega^2 = 3 G m / side^3;
//! - the figure eight: three equal masses follow each other on one closed curve, a third of the period apart;
//! - two bodies: their distance moves as one light body about a Sun with the mass of both.
//!
//! Source: Lagrange 1772 (the triangle; put into the equation: the two pulls on a corner add up to 3 G m / side^3 times its way
//! to the center); Chenciner and Montgomery, Ann. Math. 152, 881 (2000), with the start and period that C. Simo found, 8 digits.
//! Setup: G m = 1 AU^3/day^2 and lengths of an AU, so that times are of the order of a day.
//! Tolerance: at each test.
//! Control: a start changed in its third digit, and explicit Euler, are rejected by the same judges.

// Closed forms may use std's functions; a start that can't be built fails its test.
#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use crate::run::{apart, document};
use kinetoscope_manifest::model::{OrbitBody, OrbitConfig, OrbitIntegrator};
use kinetoscope_manifest::quantity::{Finite, NonNegative};
use kinetoscope_physics::constants::GM_SUN_AU3_PER_DAY2 as GM;
use kinetoscope_physics::model::{Extent, Model, Progress, Target};
use kinetoscope_physics::orbit::kepler::Kepler;
use kinetoscope_physics::orbit::motion::State;
use kinetoscope_physics::orbit::{BARYCENTRIC_START, Orbit};
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::{OrbitConserved, OrbitEnergy};
use kinetoscope_recording::frame::Frame;

fn body(gm: f64, position: [f64; 3], velocity: [f64; 3]) -> OrbitBody {
    OrbitBody {
        gm_au3_per_day2: NonNegative::new(gm).unwrap(),
        position_au: position.map(|component| Finite::new(component).unwrap()),
        velocity_au_per_day: velocity.map(|component| Finite::new(component).unwrap()),
    }
}

fn run(bodies: Vec<OrbitBody>, integrator: OrbitIntegrator, step: f64, duration: f64) -> Orbit {
    let config = OrbitConfig { bodies: Some(bodies), ..document(integrator, step, duration) };
    let mut orbit = Orbit::prepare(&config, Seed { seed: 0, replicate: 0 }, false).unwrap();
    let Extent::Steps { total, .. } = orbit.extent() else { panic!("an orbit has fixed steps") };
    assert_eq!(orbit.advance(Target::Count(total), u64::MAX), Ok(Progress::Reached));
    orbit
}

fn seen(orbit: &Orbit) -> (Vec<[f64; 3]>, OrbitEnergy, OrbitConserved) {
    let mut frame = Frame::new();
    orbit.observe(&mut frame);
    let rows = frame.state().as_chunks::<6>().0;
    let positions = rows.iter().map(|row| [row[0], row[1], row[2]]).collect();
    (positions, frame.get().unwrap(), frame.get().unwrap())
}

/// A corner of the triangle with corners a unit from the center, an angle after the start.
fn corner(which: usize, angle: f64) -> [f64; 3] {
    let angle = angle + std::f64::consts::TAU / 3.0 * which as f64;
    [angle.cos(), angle.sin(), 0.0]
}

/// omega^2 = 3 G m / side^3, side = sqrt(3).
fn triangle_rate() -> f64 {
    (3.0 / 27.0_f64.sqrt()).sqrt()
}

/// Largest distance of a corner from where it should be after 10 days, 1.2 turns.
fn triangle_miss(integrator: OrbitIntegrator, step: f64, speed: f64) -> f64 {
    let quarter = std::f64::consts::FRAC_PI_2;
    let bodies = [0, 1, 2].map(|which| {
        let across = corner(which, quarter).map(|part| part * speed);
        body(1.0, corner(which, 0.0), across)
    });
    let (positions, ..) = seen(&run(bodies.to_vec(), integrator, step, 10.0));
    let angle = 10.0 * triangle_rate();
    (0..3).map(|which| apart(positions[which], corner(which, angle))).fold(0.0, f64::max)
}

/// Tolerance: the triangle is unstable, roundings grow by exp(0.7 omega t) = 200 in this time.
#[test]
fn lagranges_triangle_turns_as_a_whole() {
    let rate = triangle_rate();
    let miss = triangle_miss(OrbitIntegrator::Dop853, 0.1, rate);
    println!("triangle, adaptive: {miss:e} AU");
    assert!(miss < 1e-11, "{miss:e}");
    for (integrator, order) in [
        (OrbitIntegrator::SemiImplicitEuler, 1.0),
        (OrbitIntegrator::VelocityVerlet, 2.0),
        (OrbitIntegrator::Rk4, 4.0),
        (OrbitIntegrator::Yoshida4, 4.0),
    ] {
        let [coarse, fine] = [0.02, 0.01].map(|step| triangle_miss(integrator, step, rate));
        let measured = (coarse / fine).log2();
        println!("triangle, {integrator:?}: {fine:e} AU, order {measured}");
        assert!((measured / order - 1.0).abs() < 0.1, "{integrator:?}: {measured}");
    }
    let control = triangle_miss(OrbitIntegrator::Dop853, 0.1, 1.001 * rate);
    assert!(control > 1e-3, "{control:e}");
}

/// Simo's start; the period is 6.32591398 days.
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

/// Largest distance of a body from the place where the one before it started, a third of a period later.
fn eight_miss(speed: f64) -> f64 {
    let third = EIGHT_PERIOD / 3.0;
    let (positions, ..) = seen(&run(eight(speed), OrbitIntegrator::Dop853, third / 4.0, third));
    let [[x, y], _] = EIGHT;
    let places = [[x, y, 0.0], [-x, -y, 0.0], [0.0; 3]];
    // Each body takes the place of the next one along the curve; which that is follows from the first.
    let nearest = |position: [f64; 3]| {
        places.iter().map(|place| apart(*place, position)).fold(f64::INFINITY, f64::min)
    };
    positions.iter().map(|position| nearest(*position)).fold(0.0, f64::max)
}

/// Tolerance: 1e-6, since the start and the period have eight digits. The eight has no angular momentum.
#[test]
fn the_figure_eight_is_followed_by_all_three() {
    let miss = eight_miss(1.0);
    println!("figure eight: {miss:e} AU");
    assert!(miss < 1e-6, "{miss:e}");
    assert!(eight_miss(1.001) > 1e-4);

    let long = 20.0 * EIGHT_PERIOD;
    let (_, energy, kept) =
        seen(&run(eight(1.0), OrbitIntegrator::VelocityVerlet, EIGHT_PERIOD / 1000.0, long));
    println!("figure eight, 20 periods of Verlet: {energy:?} {kept:?}");
    // Forces of a pair are opposite to the bit; what is left is the rounding of 20000 steps.
    assert!(
        kept.specific_angular_momentum_change_ppm < 1e-7
            && kept.specific_momentum_au_per_day < 1e-13
    );
    assert!(kept.center_of_mass_au < 1e-12);
    // Verlet's error is of the order (step / time scale)^2 and does not grow.
    assert!(energy.drift_ppm.abs() < 10.0);
    let (_, control, _) =
        seen(&run(eight(1.0), OrbitIntegrator::ExplicitEuler, EIGHT_PERIOD / 1000.0, long));
    assert!(control.drift_ppm > 1e3, "explicit Euler gains energy: {}", control.drift_ppm);
}

/// A Sun of 3/4 and an Earth of 1/4 of the mass, as far apart and as fast as the orbit exercise's: their distance is the orbit exercise's.
/// Tolerance: 1e-11 AU after a year, the tolerance of some 50 steps and their growth.
#[test]
fn two_bodies_move_about_each_other_as_one_about_the_sun() {
    let State { position, velocity } = BARYCENTRIC_START;
    let bodies = vec![body(0.75 * GM, [0.0; 3], [0.0; 3]), body(0.25 * GM, position, velocity)];
    let orbit = run(bodies, OrbitIntegrator::Dop853, 0.25, 365.25);
    let (positions, energy, kept) = seen(&orbit);
    let apart_now: [f64; 3] = std::array::from_fn(|axis| positions[1][axis] - positions[0][axis]);
    let exact = Kepler::from_start(BARYCENTRIC_START).at(365.25).state.position;
    let miss = apart(apart_now, exact);
    println!("two bodies after a year: {miss:e} AU, energy {} ppm", energy.drift_ppm);
    assert!(miss < 1e-11, "{miss:e}");
    // The energy of the relative motion times m1 m2 / M^2.
    let relative = -0.000_148_822_178_837_004_19 * 0.75 * 0.25;
    assert!((energy.specific_total_energy_au2_per_day2 / relative - 1.0).abs() < 1e-11);
    assert!(kept.center_of_mass_au < 1e-13);
}

#[test]
fn bodies_that_have_no_motion_are_refused_and_collisions_end_in_words() {
    let prepare = |bodies| {
        let config =
            OrbitConfig { bodies: Some(bodies), ..document(OrbitIntegrator::Dop853, 0.01, 10.0) };
        Orbit::prepare(&config, Seed { seed: 0, replicate: 0 }, false)
    };
    let here = [1.0, 0.0, 0.0];
    for bodies in [
        vec![body(1.0, here, [0.0, 0.1, 0.0]), body(1.0, here, [0.0; 3])],
        vec![body(1.0, [0.0; 3], [0.0; 3]), body(1.0, here, [0.0; 3])],
    ] {
        let refusal = prepare(bodies).unwrap_err();
        assert!(refusal.0.contains("no motion to follow"), "{refusal}");
    }
    // Three that fall together: their paths end at a point, in finite time.
    let falling =
        |which: usize| body(1.0, corner(which, 0.0), corner(which, 0.0).map(|part| -0.01 * part));
    let mut orbit = prepare([0, 1, 2].map(falling).to_vec()).unwrap();
    let fault = orbit.advance(Target::Count(1000), u64::MAX).unwrap_err();
    assert!(fault.0.contains("too close to each other"), "{fault}");
    let mut parts = prepare([0, 1, 2].map(falling).to_vec()).unwrap();
    while parts.advance(Target::Count(1000), 7) == Ok(Progress::Working) {}
    assert_eq!(parts, orbit, "the end does not depend on how work is cut");
}
