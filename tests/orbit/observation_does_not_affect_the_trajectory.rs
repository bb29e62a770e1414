//! Promise: neither the budget in which work is done, nor who looks when, nor a stop and a resume changes a bit of an orbit;
//! and what can't be run is refused or faulted in words.
//!
//! Setup: every method, some hundred steps, states compared bit by bit.

// A largest value in a test is no part of any recording.
#![allow(clippy::disallowed_methods)]

use crate::run::{advance, document, finished, given, look, prepare};
use kinetoscope_manifest::model::{OrbitConfig, OrbitIntegrator, OrbitStart};
use kinetoscope_physics::model::{Extent, Model, Progress, Target};
use kinetoscope_physics::orbit::Orbit;
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::frame::{Frame, Level};
use kinetoscope_recording::scenery::{DrawnRadius, Wall};

const ALL: [OrbitIntegrator; 7] = [
    OrbitIntegrator::ExplicitEuler,
    OrbitIntegrator::SemiImplicitEuler,
    OrbitIntegrator::VelocityVerlet,
    OrbitIntegrator::Rk4,
    OrbitIntegrator::Yoshida4,
    OrbitIntegrator::DormandPrince8,
    OrbitIntegrator::Kepler,
];

#[test]
fn the_budget_is_invisible() {
    for integrator in ALL {
        let config = document(integrator, 0.9, 1000.0);
        let whole = finished(&config);
        for budget in [1, 7] {
            let mut cut = prepare(&config);
            let target = Target::Count(whole.count());
            while cut.advance(target, budget) == Ok(Progress::Working) {}
            assert_eq!(cut, whole, "{integrator:?}, budget {budget}");
        }
    }
}

#[test]
fn looking_is_passive_and_counts_revolutions_alike() {
    for integrator in ALL {
        let config = document(integrator, 0.9, 3000.0);
        let unseen = look(&finished(&config));
        let mut watched = prepare(&config);
        for count in 1..=3333 {
            advance(&mut watched, count);
            let seen = look(&watched);
            // The angle never jumps: an exact revolution takes 402 steps, explicit Euler's ever more.
            let exact = seen.orbit.revolutions - seen.orbit.phase_error_rad / std::f64::consts::TAU;
            assert!((exact - watched.time() / 362.073_107_968_315_9).abs() < 0.01);
        }
        let seen = look(&watched);
        assert_eq!(seen.state, unseen.state);
        assert_eq!(seen.orbit, unseen.orbit);
        assert!(seen.orbit.revolutions > 4.0, "{}", seen.orbit.revolutions);
    }
}

#[test]
fn a_saved_run_goes_on_to_the_same_bits() {
    for integrator in ALL {
        let config = document(integrator, 0.3, 900.0);
        let mut saved = prepare(&config);
        advance(&mut saved, 1234);
        let mut resumed: Orbit =
            serde_json::from_value(serde_json::to_value(&saved).unwrap()).unwrap();
        assert_eq!(resumed, saved);
        advance(&mut resumed, 3000);
        assert_eq!(resumed, finished(&config));
    }
}

#[test]
fn steps_and_times_are_counted() {
    // 0.1 * 3 is above 0.3 in f64, and still three steps.
    let run = prepare(&document(OrbitIntegrator::ExplicitEuler, 0.1, 0.3));
    assert_eq!(run.extent(), Extent::Steps { total: 3, step: 0.1 });
    let mut run = prepare(&document(OrbitIntegrator::Kepler, 0.1, 10.0));
    assert_eq!(run.advance(Target::Time(0.7), u64::MAX), Ok(Progress::Reached));
    assert_eq!((run.count(), run.time()), (7, 7.0 * 0.1));
}

#[test]
fn starts_that_lead_through_the_sun_are_refused_in_words() {
    let cases = [
        (given([0.0; 3], [0.0, 0.01, 0.0]), "away from the Sun"),
        (given([1e-200, 0.0, 0.0], [0.0, 0.01, 0.0]), "away from the Sun"),
        (given([1e200, 0.0, 0.0], [0.0, 0.01, 0.0]), "away from the Sun"),
        (given([1.0, 0.0, 0.0], [0.0, 1e300, 0.0]), "overflows"),
        (given([1.0, 2.0, 0.5], [0.0; 3]), "straight line through the Sun"),
        (given([0.1, 0.2, 0.3], [-0.01, -0.02, -0.03]), "straight line through the Sun"),
    ];
    for (start, words) in cases {
        let config = OrbitConfig { start, ..Default::default() };
        let refusal = Orbit::prepare(&config, Seed { seed: 1, replicate: 0 }, false).unwrap_err();
        assert!(refusal.0.contains(words), "{refusal}");
    }
    let config = document(OrbitIntegrator::ExplicitEuler, 0.5, 0.25);
    let refusal = Orbit::prepare(&config, Seed { seed: 1, replicate: 0 }, false).unwrap_err();
    assert!(refusal.0.contains("no step"), "{refusal}");
}

/// A fall past the Sun so near that the first kick there overflows.
#[test]
fn a_step_to_no_number_is_a_fault_at_a_count_of_its_own() {
    let config = OrbitConfig {
        start: given([1e-100, 0.0, 0.0], [0.0, 1e47, 0.0]),
        ..document(OrbitIntegrator::ExplicitEuler, 1e120, 1e125)
    };
    let mut at_once = prepare(&config);
    let fault = at_once.advance(Target::Count(100), u64::MAX).unwrap_err();
    assert!(fault.0.contains("time_step_days"), "{fault}");
    let mut in_parts = prepare(&config);
    while in_parts.advance(Target::Count(100), 1) == Ok(Progress::Working) {}
    assert_eq!(in_parts, at_once);
    assert!(look(&at_once).state.is_finite(), "the last state that was one may still be looked at");
    assert_eq!(at_once.advance(Target::Count(100), 5), Err(fault));
}

#[test]
fn frame_0_says_what_is_run_and_later_frames_are_silent() {
    let lines = |orbit: &Orbit| {
        let mut frame = Frame::new();
        orbit.observe(&mut frame);
        frame.log_lines().to_vec()
    };
    let mut run = prepare(&OrbitConfig::default());
    let text: Vec<String> = lines(&run).into_iter().map(|line| line.text).collect();
    let text = text.join("\n");
    for words in [
        "explicit-euler",
        "0.25 d",
        "1461 steps",
        "barycenter",
        "362.073 d",
        "0.99418 AU",
        "heliocentric",
        "5.4",
    ] {
        assert!(text.contains(words), "{words} in {text}");
    }
    advance(&mut run, 1);
    assert!(lines(&run).is_empty());

    let heliocentric = OrbitConfig {
        start: OrbitStart::Heliocentric,
        ..document(OrbitIntegrator::Kepler, 2.0, 400.0)
    };
    let log = lines(&prepare(&heliocentric));
    assert!(log.iter().any(|line| line.text.contains("period 364.898 d")));
    assert!(
        log.iter().any(|line| line.level == Level::Warning && line.text.contains("less than 1 d"))
    );
}

/// The path stays inside what the camera shows, and fills more than half of it.
#[test]
fn the_view_holds_the_path() {
    let open = given([3.0, 1.0, 0.5], [-0.02, -0.001, 0.002]);
    let runs = [
        document(OrbitIntegrator::ExplicitEuler, 0.25, 365.25),
        document(OrbitIntegrator::ExplicitEuler, 0.9, 20.0 * 365.25),
        document(OrbitIntegrator::ExplicitEuler, 0.25, 36_525.0),
        document(OrbitIntegrator::VelocityVerlet, 0.25, 3652.5),
        OrbitConfig { start: open, ..document(OrbitIntegrator::Rk4, 0.25, 1000.0) },
    ];
    for config in runs {
        let mut run = prepare(&config);
        let scenery = run.scenery();
        let [low, high] = scenery.view;
        let Extent::Steps { total, .. } = run.extent() else { panic!("an orbit has fixed steps") };
        let mut farthest = 0.0_f64;
        for frame in 0..=400 {
            advance(&mut run, total * frame / 400);
            let [x, y, _] = look(&run).state.position;
            assert!(x > low[0] && x < high[0] && y > low[1] && y < high[1], "{x} {y} {config:?}");
            farthest = farthest.max(x.abs()).max(y.abs());
        }
        assert!(farthest > 0.5 * high[0], "{farthest} of {}", high[0]);
        assert_eq!(scenery.drawn_radius, DrawnRadius::Fixed(0.02 * (high[1] - low[1])));
        assert_eq!(scenery.walls, [Wall::Body { center: [0.0, 0.0], radius: 0.05 }]);
    }
}
