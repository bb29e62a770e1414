//! Guarantee: values that cannot be integrated are rejected before the first step with c = eta dt/m_eff and with values that are accepted.
//! With on_unstable_time_step = "warn", they run and end in a fault.
//!
//! Source: the values of the DEM exercise, m = 1e-3 kg, k = 5e4 N/m, eta = 1.5e3 N s/m, N_t = 10, 20, 50, give c = 133,
//! 67, 27 by hand. Beds of discs with e = 0.5 blow up at N_t = 4 and are stable at 20. A disc of r = 1e-4 m (the radius
//! in the exercise's text) that falls through the box of 0.04 m overlaps by 0.9 to 1.2 r at k = 5e4 N/m.
//! Setup: single configurations; every value that a rejection suggests is set in the configuration and prepared again.
//! Tolerance: 1 % for the largest stable time step, which neglects the spring; otherwise the printed digits.
//! Control: a time step 10 % above the suggested one is rejected; N_t = 20 is accepted without warnings.

use crate::scene::{
    SEED, damping, equal, frame, given, per_contact, positive, prepared, restitution, spring,
};
use kinetoscope_manifest::model::{DemConfig, DemDashpot, StepLength, TimeStep, UnstableTimeStep};
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::{Model, Target};
use kinetoscope_recording::frame::Level;

fn exercise(steps_per_wall_contact: f64) -> DemConfig {
    DemConfig {
        dissipation: damping(1.5e3),
        time_step: per_contact(steps_per_wall_contact),
        ..DemConfig::default()
    }
}

/// Message of the rejection, or `None` if the configuration is accepted.
fn rejection(config: &DemConfig) -> Option<String> {
    Dem::prepare(config, SEED, false).err().map(|error| error.0.to_string())
}

/// Returns the configuration with a suggested `key = value` applied.
fn with_suggestion(config: &DemConfig, key: &str, value: f64) -> DemConfig {
    let mut changed = config.clone();
    match key {
        "time_step_s" => changed.time_step = TimeStep::Length(StepLength::Fixed(positive(value))),
        "steps_per_wall_contact" => changed.time_step = per_contact(value),
        "damping_n_s_per_m" => changed.dissipation = damping(value),
        "restitution" => changed.dissipation = restitution(value),
        "stiffness_n_per_m" => changed.elasticity = spring(value),
        "radius_m" => changed.radius_m = equal(value),
        other => panic!("no such key: {other}"),
    }
    changed
}

/// Parses all `key = value` between "each alone: " and the next period.
fn suggestions(text: &str) -> Vec<(String, f64)> {
    let Some((_, list)) = text.split_once("each alone: ") else { return Vec::new() };
    let list = list.split(". ").next().unwrap_or(list);
    list.split("; ")
        .map(|line| {
            let (key, value) = line.split_once(" = ").expect("key = value");
            (key.to_owned(), value.parse().expect("a number"))
        })
        .collect()
}

/// Asserts that every suggestion is accepted; returns their keys.
fn accepted_keys(config: &DemConfig) -> Vec<String> {
    let text = rejection(config).expect("rejected");
    println!("{text}");
    let suggestions = suggestions(&text);
    for (key, value) in &suggestions {
        let again = rejection(&with_suggestion(config, key, *value));
        assert_eq!(again, None, "the suggestion {key} = {value} is rejected");
    }
    suggestions.into_iter().map(|(key, _)| key).collect()
}

#[test]
fn exercise_damping_is_rejected_with_valid_suggestions() {
    for (steps, c) in [(10.0, "c = eta dt/m_eff = 133 "), (20.0, "= 67 "), (50.0, "= 27 ")] {
        let config = exercise(steps);
        let text = rejection(&config).expect("rejected");
        assert!(text.contains(c), "{text}");
        let keys = accepted_keys(&config);
        for key in [
            "time_step_s",
            "steps_per_wall_contact",
            "damping_n_s_per_m",
            "restitution",
            "stiffness_n_per_m",
        ] {
            assert!(keys.iter().any(|found| found == key), "no {key} in: {text}");
        }
    }
}

#[test]
fn suggested_time_step_is_the_largest_stable_one() {
    let config = exercise(20.0);
    let text = rejection(&config).expect("rejected");
    let (_, step) = suggestions(&text).into_iter().next().expect("the first is a time step");
    // Control.
    assert!(rejection(&with_suggestion(&config, "time_step_s", 1.1 * step)).is_some());
    // 12 eta dt/m < 4, where the contribution of the spring is negligible: dt < m/(3 eta).
    assert!((step / (1e-3 / 4.5e3) - 1.0).abs() < 0.01, "{step:e}");
}

#[test]
fn exercise_damping_ends_in_a_fault_with_stability_warn() {
    for (steps, tail) in [(10.0, false), (20.0, true)] {
        let config = DemConfig {
            on_unstable_time_step: UnstableTimeStep::Warn,
            limit_damping: tail,
            ..exercise(steps)
        };
        let mut model = prepared(&config);
        let start = frame(&model);
        let has_warning = |text: &str| text.contains("The time step is unstable");
        assert!(
            start
                .log_lines()
                .iter()
                .any(|line| line.level == Level::Warning && has_warning(&line.text))
        );
        let fault = model.advance(Target::Count(u64::MAX), u64::MAX).expect_err("a blow-up");
        let fault = fault.recorded();
        println!("{fault}");
        for word in ["step ", "t = ", "disc ", "c = eta dt/m_eff", "steps_per_wall_contact"] {
            assert!(fault.contains(word), "{fault}");
        }
        assert!(frame(&model).state().iter().all(|value| value.is_finite()));
    }
}

#[test]
fn four_steps_per_contact_are_rejected_and_twenty_accepted() {
    let config = |steps: f64| DemConfig { time_step: per_contact(steps), ..DemConfig::default() };
    assert!(rejection(&config(4.0)).is_some_and(|text| text.contains("for a bed")));
    assert_eq!(
        accepted_keys(&config(4.0)),
        ["time_step_s", "steps_per_wall_contact", "damping_n_s_per_m", "restitution"]
    );
    assert_eq!(rejection(&config(20.0)), None);
    let fixed = DemConfig {
        time_step: TimeStep::Length(StepLength::Fixed(positive(1e-4))),
        ..DemConfig::default()
    };
    assert!(accepted_keys(&fixed).iter().any(|key| key == "stiffness_n_per_m"));
    assert!(prepared_warnings(&config(8.0)).iter().any(|text| text.contains("chatter")));
    assert_eq!(prepared_warnings(&config(20.0)), Vec::<String>::new());
}

fn prepared_warnings(config: &DemConfig) -> Vec<String> {
    frame(&prepared(config))
        .log_lines()
        .iter()
        .filter(|line| line.level == Level::Warning)
        .map(|line| line.text.clone())
        .collect()
}

#[test]
fn strong_but_stable_dashpot_causes_a_warning() {
    // c = eta dt/m_eff = 9 * 2.2214e-5 / 5e-4 = 0.40.
    let config = DemConfig { dissipation: damping(9.0), ..DemConfig::default() };
    assert!(prepared_warnings(&config)[0].contains("c = eta dt/m_eff = 0.40"));
}

#[test]
fn exercise_radius_is_rejected_and_accepted_with_stiffer_contacts() {
    let small = |stiffness: f64| DemConfig {
        radius_m: equal(1e-4),
        elasticity: spring(stiffness),
        ..DemConfig::default()
    };
    for (dissipation, overlap) in [(restitution(0.5), "0.93"), (damping(0.0), "1.25")] {
        let text = rejection(&DemConfig { dissipation, ..small(5e4) }).expect("rejected");
        assert!(text.contains(&format!("by about {overlap} of its radius")), "{text}");
    }
    let keys = accepted_keys(&small(5e4));
    assert!(["stiffness_n_per_m", "radius_m"].iter().all(|key| keys.iter().any(|k| k == key)));
    assert_eq!(rejection(&small(5e6)), None);
}

/// Confirms the rejection: at k = 5e4 N/m the disc passes through the wall, at 5e6 N/m it does not.
#[test]
fn exercise_radius_passes_through_the_wall() {
    let dropped = |stiffness: f64| {
        let config = DemConfig {
            radius_m: equal(1e-4),
            elasticity: spring(stiffness),
            dissipation: restitution(0.9),
            on_unstable_time_step: UnstableTimeStep::Warn,
            ..DemConfig::default()
        };
        let mut model = prepared(&given(config, &[([0.02, 0.0399], [0.0, 0.0])]));
        // The disc reaches the floor after 0.0903 s.
        let end = (0.1 / crate::scene::time_step(&model)) as u64;
        model.advance(Target::Count(end), u64::MAX)
    };
    let fault = dropped(5e4).expect_err("the disc passes through the floor");
    assert!(fault.recorded().contains("stiffness_n_per_m"), "{fault}");
    assert!(dropped(5e6).is_ok());
}

#[test]
fn implicit_dashpot_accepts_any_damping() {
    let config = DemConfig { dashpot: DemDashpot::Implicit, ..exercise(20.0) };
    assert_eq!(rejection(&config), None);
}

#[test]
fn duration_below_one_step_is_rejected() {
    let config = DemConfig { duration_s: positive(1e-9), ..DemConfig::default() };
    assert!(rejection(&config).is_some_and(|text| text.contains("at least one time step")));
}
