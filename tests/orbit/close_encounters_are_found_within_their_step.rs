//! Law: the least separation of two bodies is where their relative velocity is perpendicular to their separation. On a straight line, it
//! is the impact parameter; on a hyperbola, the perihelion distance q = L^2/(GM (1 + e)).
//!
//! Source: Murray and Dermott, Solar System Dynamics, sections 2.2 and 2.3.
//! Setup: fly-bys that begin and end within one or two steps, seven bodies on crossing orbits, and steps too long for an encounter.
//! Tolerance: stated at each test.
//! Control: the separations at the ends of the steps alone are rejected.

// Closed forms may use std's functions; an invalid configuration fails its test.
#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use crate::run::{advance, body, distance, exercise, finished, prepare};
use kinetoscope_manifest::model::{OrbitBody, OrbitConfig, OrbitIntegrator};
use kinetoscope_physics::constants::GM_SUN_AU3_PER_DAY2 as GM;
use kinetoscope_physics::model::{Model, Progress, Target};
use kinetoscope_physics::orbit::Orbit;
use kinetoscope_recording::channels::OrbitClosestApproach;
use kinetoscope_recording::frame::{Frame, Level};

const FIXED_STEPS: [OrbitIntegrator; 5] = [
    OrbitIntegrator::ExplicitEuler,
    OrbitIntegrator::SemiImplicitEuler,
    OrbitIntegrator::VelocityVerlet,
    OrbitIntegrator::Rk4,
    OrbitIntegrator::Yoshida4,
];

fn config(
    bodies: &[OrbitBody],
    integrator: OrbitIntegrator,
    step: f64,
    duration: f64,
) -> OrbitConfig {
    OrbitConfig { bodies: Some(bodies.to_vec()), ..exercise(integrator, step, duration) }
}

fn frame(orbit: &Orbit) -> Frame {
    let mut frame = Frame::new();
    orbit.observe(&mut frame);
    frame
}

fn closest(orbit: &Orbit) -> OrbitClosestApproach {
    frame(orbit).get().unwrap()
}

fn positions(orbit: &Orbit) -> Vec<[f64; 3]> {
    frame(orbit).state().as_chunks::<6>().0.iter().map(|row| [row[0], row[1], row[2]]).collect()
}

fn warnings(orbit: &Orbit) -> Vec<String> {
    let frame = frame(orbit);
    let warnings = frame.log_lines().iter().filter(|line| line.level == Level::Warning);
    warnings.map(|line| line.text.clone()).collect()
}

/// Tolerance: 1e-12, the rounding of sums. The steps are up to ten impact parameters long.
#[test]
fn straight_fly_by_has_its_impact_parameter() {
    let (impact, speed) = (0.1, 1.0);
    for integrator in FIXED_STEPS.into_iter().chain([OrbitIntegrator::Dop853]) {
        for (start, step) in [(-3.3, 1.0), (-3.3, 0.07), (-0.04, 1.0), (-7.95, 0.5)] {
            let bodies = [
                body(1e-40, [0.0; 3], [0.0; 3]),
                body(0.0, [start, 0.0, impact], [speed, 0.0, 0.0]),
            ];
            let found = closest(&finished(&config(&bodies, integrator, step, 20.0)));
            let at = format!("{integrator:?}, start {start}, step {step}: {found:?}");
            assert!((found.separation_au - impact).abs() < 1e-12, "{at}");
            assert!((found.time_d + start / speed).abs() < 1e-12 * 20.0, "{at}");
            assert!((found.relative_speed_au_per_day - speed).abs() < 1e-12, "{at}");
            assert_eq!([found.first_body, found.second_body], [0, 1], "{at}");
        }
    }
}

/// A body that recedes from the start, and one that still approaches at the end.
#[test]
fn start_and_end_count() {
    let at = |x: f64| body(0.0, [x, 0.0, 0.5], [1.0, 0.0, 0.0]);
    for (start, expected) in [(2.0, 2.0), (-9.0, 4.0)] {
        let bodies = [body(1e-40, [0.0; 3], [0.0; 3]), at(start)];
        let config = config(&bodies, OrbitIntegrator::VelocityVerlet, 0.3, 5.1);
        let found = closest(&finished(&config)).separation_au;
        let end = if start < 0.0 { start + 5.1_f64 } else { start };
        assert!((found - end.hypot(0.5)).abs() < 1e-12, "{found} {expected}");
    }
}

/// Tolerance: 1e-9 for the adaptive method; order 2 within 15 % for velocity Verlet.
#[test]
fn hyperbola_has_its_perihelion() {
    let (impact, speed, far) = (1.0, 0.02, -10.0_f64);
    let momentum = impact * speed;
    let energy = speed * speed / 2.0 - GM / far.hypot(impact);
    let eccentricity = (1.0 + 2.0 * energy * momentum * momentum / (GM * GM)).sqrt();
    let perihelion = momentum * momentum / (GM * (1.0 + eccentricity));
    let bodies = [body(GM, [0.0; 3], [0.0; 3]), body(0.0, [far, impact, 0.0], [speed, 0.0, 0.0])];
    let error = |integrator, step| {
        closest(&finished(&config(&bodies, integrator, step, 900.0))).separation_au - perihelion
    };
    let adaptive = error(OrbitIntegrator::Dop853, 45.0);
    assert!(adaptive.abs() < 1e-9, "{adaptive:e}");
    let [coarse, fine] = [4.0, 2.0].map(|step| error(OrbitIntegrator::VelocityVerlet, step));
    let order = (coarse / fine).log2();
    assert!((order / 2.0 - 1.0).abs() < 0.15, "order {order}, {coarse:e} {fine:e}");
}

/// Seven bodies on crossing orbits around the first.
fn crossing() -> Vec<OrbitBody> {
    let mut bodies = vec![body(GM, [0.0; 3], [0.0; 3])];
    for number in 1..7_u32 {
        let (distance, angle) = (0.9 + 0.05 * f64::from(number), 2.4 * f64::from(number));
        let speed = (GM / distance).sqrt() * (0.9 + 0.04 * f64::from(number % 4));
        let (sine, cosine) = angle.sin_cos();
        let mass = if number < 5 { 1e-9 * f64::from(number) } else { 0.0 };
        let tilt = 0.01 * f64::from(number % 3);
        bodies.push(body(
            mass,
            [distance * cosine, distance * sine, tilt],
            [-speed * sine, speed * cosine, 0.0],
        ));
    }
    bodies
}

/// The closest approach equals that of a run whose separations are computed at every one of 400 times as many points, within the
/// curvature between them. The separations at the ends of the steps, the control, miss it by more than that.
#[test]
fn closest_approach_is_the_least_of_all_separations() {
    let (step, parts, steps) = (3.0, 400_u32, 900_u64);
    let least = |orbit: &Orbit| {
        let bodies = positions(orbit);
        let mut least = f64::INFINITY;
        for (one, other) in (1..7).flat_map(|one| (one + 1..7).map(move |other| (one, other))) {
            if one < 5 || other < 5 {
                least = least.min(distance(bodies[one], bodies[other]));
            }
        }
        least
    };
    let duration = step * steps as f64;
    let mut fine =
        prepare(&config(&crossing(), OrbitIntegrator::Dop853, step / f64::from(parts), duration));
    let (mut dense, mut at_steps) = (least(&fine), least(&fine));
    for count in 1..=steps * u64::from(parts) {
        advance(&mut fine, count);
        let now = least(&fine);
        dense = dense.min(now);
        if count % u64::from(parts) == 0 {
            at_steps = at_steps.min(now);
        }
    }
    let found = closest(&finished(&config(&crossing(), OrbitIntegrator::Dop853, step, duration)));
    println!("{found:?}, dense {dense}, at steps {at_steps}");
    // Between two points, the separation is lower by at most v^2 t^2 / (8 d), with v t = 0.03 AU/d times 0.0075 d.
    let tolerance = (0.03_f64 * step / f64::from(parts)).powi(2) / (8.0 * dense) + 1e-9;
    assert!(found.separation_au <= dense + 1e-9, "{} {dense}", found.separation_au);
    assert!(found.separation_au >= dense - tolerance, "{} {dense}", found.separation_au);
    assert!(at_steps > dense + 10.0 * tolerance, "control: {at_steps} {dense}");
}

/// Five bodies that are far from each other most of the time. Their closest approaches become closer and closer.
fn far_apart() -> Vec<OrbitBody> {
    let mut bodies = vec![body(GM, [0.0; 3], [0.0; 3])];
    for (distance, mass, speed) in
        [(1.0, 1e-6, 1.05), (1.9, 1e-3, 0.97), (5.2, 1e-3, 1.1), (9.5, 3e-4, 0.9)]
    {
        let circular = (GM / distance).sqrt();
        bodies.push(body(mass * GM, [distance, 0.0, 0.02], [0.0, speed * circular, 0.0]));
    }
    bodies
}

/// Separations are not compared while a lower bound excludes a closer approach. With a budget of fewer steps than such a span has, all
/// are. Tolerance: none; the states with their records are compared bit by bit.
#[test]
fn step_budget_and_frames_change_no_bit_of_the_closest_approach() {
    for integrator in FIXED_STEPS.into_iter().chain([OrbitIntegrator::Dop853]) {
        for config in [
            config(&crossing(), integrator, 2.9, 2000.0),
            config(&far_apart(), integrator, 0.37, 8000.0),
        ] {
            let reference = finished(&config);
            for budget in [1, 7, 64, 500] {
                let mut in_parts = prepare(&config);
                let target = Target::Count(reference.count());
                while in_parts.advance(target, budget) == Ok(Progress::Working) {
                    let _ = frame(&in_parts);
                }
                assert_eq!(closest(&in_parts), closest(&reference), "{integrator:?}, {budget}");
                assert_eq!(in_parts, reference, "{integrator:?}, budget {budget}");
            }
        }
    }
}

/// The Hill radius counts the mean distance from the central body, (r_1 + r_2)/2 ((m_1 + m_2)/(3 M))^(1/3) (Chambers, Mon. Not. R.
/// Astron. Soc. 304 (1999) 793); pairs with the central body are left out. Tolerance: 1e-12, the rounding of sums.
#[test]
fn closest_approach_is_compared_with_the_mutual_hill_radius() {
    let at = |mass: f64, x: f64| body(mass, [x, 0.0, 0.0], [0.0, 1.0 / x.sqrt(), 0.0]);
    // The inner body is faster: the separation grows from the start.
    let bodies = [body(1.0, [0.0; 3], [0.0; 3]), at(3e-6, 1.0), at(0.0, 1.02)];
    let found = closest(&finished(&config(&bodies, OrbitIntegrator::Dop853, 0.01, 0.1)));
    assert!((found.separation_au - 0.02).abs() < 1e-12, "{found:?}");
    let radius = f64::midpoint(1.0, 1.02) * 1e-6_f64.cbrt();
    assert!((found.separation_over_hill_radius * radius / 0.02 - 1.0).abs() < 1e-12, "{found:?}");
}

/// An encounter within the Hill radius and one that the steps do not follow are warned of at the end, and only there.
#[test]
fn close_encounters_are_warned_of() {
    let planet = body(1e-3 * GM, [5.2, 0.0, 0.0], [0.0, (GM / 5.2_f64).sqrt(), 0.0]);
    // Mutual Hill radius: 5.2 (1e-3 / 3)^(1/3) = 0.36 AU.
    let near = body(0.0, [5.5, 0.0, 0.0], [0.0, (GM / 5.5_f64).sqrt(), 0.0]);
    let far = body(0.0, [8.0, 0.0, 0.0], [0.0, (GM / 8.0_f64).sqrt(), 0.0]);
    let sun = body(GM, [0.0; 3], [0.0; 3]);
    let run = |other: &OrbitBody, step: f64| {
        let bodies = [sun.clone(), planet.clone(), other.clone()];
        config(&bodies, OrbitIntegrator::VelocityVerlet, step, 400.0)
    };
    let near_run = run(&near, 0.5);
    assert!(warnings(&prepare(&near_run)).is_empty());
    let found = warnings(&finished(&near_run));
    let is_warned = |line: &String| {
        line.contains("of their mutual Hill radius") && line.contains("bodies 1 and 2")
    };
    assert!(found.iter().any(is_warned), "{found:?}");
    assert!(warnings(&finished(&run(&far, 0.5))).is_empty());

    // A body that crosses the planet's path at a right angle, in steps of twice the least separation.
    let fast = body(0.0, [5.0, 0.1, 0.0], [0.2, (GM / 5.2_f64).sqrt(), 0.0]);
    let found = warnings(&finished(&run(&fast, 1.0)));
    assert!(found.iter().any(|line| line.contains("time step of 1 d is too long")), "{found:?}");
    let adaptive = OrbitConfig { integrator: OrbitIntegrator::Dop853, ..run(&fast, 1.0) };
    let found = warnings(&finished(&adaptive));
    assert!(!found.iter().any(|line| line.contains("too long")), "{found:?}");
}
