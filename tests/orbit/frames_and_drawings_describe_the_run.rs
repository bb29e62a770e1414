//! Guarantee: frames, log and drawings describe the run; frames change no revolution count; invalid configurations are rejected, and
//! numerical overflow is reported as a fault.
//!
//! Setup: every method, several hundred steps.
//! Tolerance: none; states are compared bit by bit.

// The largest value found in a test is not recorded.
#![allow(clippy::disallowed_methods)]

use crate::run::{advance, exercise, finished, given, observe, prepare};
use kinetoscope_manifest::model::{OrbitConfig, OrbitIntegrator, OrbitStart};
use kinetoscope_physics::model::{Extent, Model, Progress, Target};
use kinetoscope_physics::orbit::Orbit;
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::frame::{Frame, Level};
use kinetoscope_recording::scenery::{DrawnRadius, GuideMeaning, Wall};

const ALL: [OrbitIntegrator; 7] = [
    OrbitIntegrator::ExplicitEuler,
    OrbitIntegrator::SemiImplicitEuler,
    OrbitIntegrator::VelocityVerlet,
    OrbitIntegrator::Rk4,
    OrbitIntegrator::Yoshida4,
    OrbitIntegrator::Dop853,
    OrbitIntegrator::Kepler,
];

#[test]
fn observation_changes_no_bit_and_no_revolution_count() {
    for integrator in ALL {
        let config = exercise(integrator, 0.9, 3000.0);
        let unobserved = observe(&finished(&config));
        let mut observed = prepare(&config);
        for count in 1..=3333 {
            advance(&mut observed, count);
            let now = observe(&observed);
            // The angle is continuous: an exact revolution takes 402 steps, one of explicit Euler takes more and more.
            let exact = now.orbit.revolutions - now.orbit.phase_error_rad / std::f64::consts::TAU;
            assert!((exact - observed.time() / 362.073_107_968_315_9).abs() < 0.01);
        }
        let end = observe(&observed);
        assert_eq!(end.state, unobserved.state);
        assert_eq!(end.orbit, unobserved.orbit);
        assert!(end.orbit.revolutions > 4.0, "{}", end.orbit.revolutions);
    }
}

#[test]
fn steps_and_times_are_counted() {
    // 0.1 * 3 exceeds 0.3 in f64, but the run has three steps.
    let run = prepare(&exercise(OrbitIntegrator::ExplicitEuler, 0.1, 0.3));
    assert_eq!(run.extent(), Extent::Steps { total: 3, step: 0.1 });
    let mut run = prepare(&exercise(OrbitIntegrator::Kepler, 0.1, 10.0));
    assert_eq!(run.advance(Target::Time(0.7), u64::MAX), Ok(Progress::Reached));
    assert_eq!((run.count(), run.time()), (7, 7.0 * 0.1));
}

#[test]
fn initial_states_on_a_line_through_the_sun_are_rejected() {
    let cases = [
        (given([0.0; 3], [0.0, 0.01, 0.0]), "away from the Sun"),
        (given([1e-200, 0.0, 0.0], [0.0, 0.01, 0.0]), "away from the Sun"),
        (given([1e200, 0.0, 0.0], [0.0, 0.01, 0.0]), "away from the Sun"),
        (given([1.0, 0.0, 0.0], [0.0, 1e300, 0.0]), "overflows"),
        (given([1.0, 2.0, 0.5], [0.0; 3]), "straight line through the Sun"),
        (given([0.1, 0.2, 0.3], [-0.01, -0.02, -0.03]), "straight line through the Sun"),
    ];
    for (start, text) in cases {
        let config = OrbitConfig { start, ..Default::default() };
        let error = Orbit::prepare(&config, Seed { seed: 1, replicate: 0 }, false).unwrap_err();
        assert!(error.0.to_string().contains(text), "{error}");
    }
    let config = exercise(OrbitIntegrator::ExplicitEuler, 0.5, 0.25);
    let error = Orbit::prepare(&config, Seed { seed: 1, replicate: 0 }, false).unwrap_err();
    assert!(error.0.what.contains("longer than the run"), "{error}");
}

/// Setup: a pass of the Sun at a distance at which the first kick overflows.
#[test]
fn numerical_overflow_is_a_fault_at_a_fixed_step() {
    let config = OrbitConfig {
        start: given([1e-100, 0.0, 0.0], [0.0, 1e47, 0.0]),
        ..exercise(OrbitIntegrator::ExplicitEuler, 1e120, 1e125)
    };
    let mut at_once = prepare(&config);
    let fault = at_once.advance(Target::Count(100), u64::MAX).unwrap_err();
    assert!(fault.recorded().contains("time_step_days"), "{fault}");
    let mut in_parts = prepare(&config);
    while in_parts.advance(Target::Count(100), 1) == Ok(Progress::Working) {}
    assert_eq!(in_parts, at_once);
    assert!(observe(&at_once).state.is_finite(), "the last finite state must remain observable");
    assert_eq!(at_once.advance(Target::Count(100), 5), Err(fault));
}

#[test]
fn first_frame_logs_the_configuration_and_later_frames_log_nothing() {
    let lines = |orbit: &Orbit| {
        let mut frame = Frame::new();
        orbit.observe(&mut frame);
        frame.log_lines().to_vec()
    };
    let mut run = prepare(&exercise(OrbitIntegrator::ExplicitEuler, 0.25, 365.25));
    let text: Vec<String> = lines(&run).into_iter().map(|line| line.text).collect();
    let log = text.join("\n");
    for expected in [
        "explicit-euler",
        "0.25 d",
        "1461 steps",
        "barycenter",
        "362.073 d",
        "0.99418 AU",
        "heliocentric",
        "5.4",
    ] {
        assert!(log.contains(expected), "no {expected:?} in {log}");
    }
    advance(&mut run, 1);
    assert!(lines(&run).is_empty());

    let heliocentric = OrbitConfig {
        start: OrbitStart::Heliocentric,
        ..exercise(OrbitIntegrator::Kepler, 2.0, 400.0)
    };
    let log = lines(&prepare(&heliocentric));
    assert!(log.iter().any(|line| line.text.contains("period 364.898 d")));
    assert!(
        log.iter().any(|line| line.level == Level::Warning && line.text.contains("less than 1 d"))
    );
}

/// The path stays inside the camera's view and covers more than half of it.
#[test]
fn view_contains_the_path() {
    let open = given([3.0, 1.0, 0.5], [-0.02, -0.001, 0.002]);
    let runs = [
        exercise(OrbitIntegrator::ExplicitEuler, 0.25, 365.25),
        exercise(OrbitIntegrator::ExplicitEuler, 0.9, 20.0 * 365.25),
        exercise(OrbitIntegrator::ExplicitEuler, 0.25, 36_525.0),
        exercise(OrbitIntegrator::VelocityVerlet, 0.25, 3652.5),
        OrbitConfig { start: open, ..exercise(OrbitIntegrator::Rk4, 0.25, 1000.0) },
    ];
    for config in runs {
        let mut run = prepare(&config);
        let scenery = run.scenery();
        let [low, high] = scenery.view;
        let Extent::Steps { total, .. } = run.extent() else { panic!("an orbit run has steps") };
        let mut max = 0.0_f64;
        for frame in 0..=400 {
            advance(&mut run, total * frame / 400);
            let [x, y, _] = observe(&run).state.position;
            assert!(x > low[0] && x < high[0] && y > low[1] && y < high[1], "{x} {y} {config:?}");
            max = max.max(x.abs()).max(y.abs());
        }
        assert!(max > 0.5 * high[0], "{max} of {}", high[0]);
        assert_eq!(scenery.drawn_radius, DrawnRadius::Fixed(0.02 * (high[1] - low[1])));
        assert_eq!(scenery.walls[0], Wall::Body { center: [0.0, 0.0], radius: 0.05 });
    }
}

/// The ellipse of the exact orbit contains every exact position: with center c and half diameters A, B, the solution of
/// x = c + A cos E + B sin E has cos^2 + sin^2 = 1, up to 1e-12 of rounding. The start is marked; an open path has no ellipse.
/// Control: the positions of explicit Euler leave the ellipse.
#[test]
fn exact_orbit_and_start_are_drawn() {
    let distance = |config: &OrbitConfig| {
        let mut run = prepare(config);
        let walls = run.scenery().walls;
        let [x, y, _] = observe(&run).state.position;
        assert!(walls.iter().any(|wall| {
            matches!(wall, Wall::Guide { center, meaning: GuideMeaning::Mark, .. } if *center == [x, y])
        }));
        let (center, [a, b]) = walls.iter().find_map(|wall| match wall {
            Wall::Guide { center, axes, meaning: GuideMeaning::ExactSolution } => {
                Some((*center, *axes))
            }
            _ => None,
        })?;
        let Extent::Steps { total, .. } = run.extent() else { panic!("an orbit run has steps") };
        let mut largest = 0.0_f64;
        for frame in 0..=20 {
            advance(&mut run, total * frame / 20);
            let [x, y, _] = observe(&run).state.position;
            let [x, y] = [x - center[0], y - center[1]];
            let area = a[0] * b[1] - a[1] * b[0];
            let (cosine, sine) = ((x * b[1] - y * b[0]) / area, (a[0] * y - a[1] * x) / area);
            largest = largest.max((cosine * cosine + sine * sine - 1.0).abs());
        }
        Some(largest)
    };
    let exact = exercise(OrbitIntegrator::Kepler, 0.25, 365.25);
    assert!(distance(&exact).unwrap() < 1e-12);
    let tilted =
        OrbitConfig { start: given([0.7, -0.4, 0.3], [0.005, 0.012, 0.004]), ..exact.clone() };
    assert!(distance(&tilted).unwrap() < 1e-12);
    assert!(distance(&exercise(OrbitIntegrator::ExplicitEuler, 0.25, 365.25)).unwrap() > 1e-2);
    let open = OrbitConfig { start: given([3.0, 1.0, 0.5], [-0.02, -0.001, 0.002]), ..exact };
    assert_eq!(distance(&open), None);
}
