//! Guarantee: another seed of the same physics does not fail where chance decides which values a run has, and a single run that passes states
//! what it cannot show.
//!
//! Setup: scenes of `changed_physics.rs`, single runs and eight replicates. Control: a changed container or disc is found.

use crate::baselines_find_changed_physics::{Baseline, Finding, comparison_in};
use crate::changed_physics::{CHANCE_SCENES, Change, HIDDEN, SCENES, Scene};

fn chance_scene(name: &str) -> &'static Scene {
    CHANCE_SCENES.iter().find(|scene| scene.name == name).unwrap()
}

/// No seed of a scene fails, and its fourth change, of a radius, does.
fn assert_no_seed_fails(name: &str, replicates: u32) {
    let baseline = Baseline::new(chance_scene(name), replicates);
    for seed in 2..14 {
        let (finding, text) = baseline.compare(seed, None);
        assert_ne!(finding, Finding::Different, "{name} x {replicates}, seed {seed}: {text}");
    }
    let (finding, text) = baseline.compare(2, Some(&baseline.scene.changes[3]));
    assert_eq!(finding, Finding::Different, "control, {name} x {replicates}: {text}");
}

/// The manifest does not set the pressure of what remains behind an orifice, also if nothing has left. A rate of escape of zero has no error.
#[test]
fn particles_that_leave_by_chance_are_no_difference() {
    assert_no_seed_fails("gas_few_leave", 1);
    assert_no_seed_fails("gas_few_leave", 8);
}

/// The start decides which particles the reflection as printed loses.
#[test]
fn particles_that_are_lost_by_chance_are_no_difference() {
    assert_no_seed_fails("gas_few_as_printed", 1);
    assert_no_seed_fails("gas_few_as_printed", 8);
}

/// The accuracy of the law of cooling contains one standard deviation of what few collisions dissipate.
#[test]
fn losses_of_few_collisions_are_no_difference() {
    assert_no_seed_fails("packing_few_losses", 1);
}

/// The fastest disc decides whether displacements are known.
#[test]
fn displacements_that_are_unknown_by_chance_are_no_difference() {
    assert_no_seed_fails("packing_far_between_frames", 1);
}

/// Six discs keep their angular momentum, and hardly collide.
#[test]
fn rates_of_few_discs_are_no_difference() {
    assert_no_seed_fails("gas_few_discs", 1);
}

/// A change that no metric of single runs shows is named, and so are the metrics that are not compared. Control: without the change, it is not.
#[test]
fn single_runs_state_what_they_do_not_show() {
    for (scene, hidden) in &HIDDEN {
        let named = format!("no compared metric shows the change of {}: ", hidden.key);
        let baseline = Baseline::new(scene, 1);
        for (change, is_named) in [(Some(hidden), true), (None, false)] {
            let called = baseline.called(2, change);
            assert_eq!(called.code, Some(0), "{}: {}", scene.name, called.out);
            let lines = comparison_in(&called.out)["sensitivity"].to_string();
            assert!(lines.contains("not compared in single runs: "), "{}: {lines}", scene.name);
            assert_eq!(lines.contains(&named), is_named, "{}: {lines}", scene.name);
            let junit = std::fs::read_to_string(baseline.bench.path("junit.xml")).unwrap();
            assert!(junit.contains("not compared in single runs"), "{}: {junit}", scene.name);
        }
    }
}

/// The same of runs without random numbers: no metric depends on the direction of an ellipse. Control: the time step.
#[test]
fn orbits_state_the_change_that_they_do_not_show() {
    let scene = SCENES.iter().find(|scene| scene.name == "orbit_circle").unwrap();
    let turned =
        "{ semi_major_axis_au = 1.0, eccentricity = 0.02, argument_of_perihelion_rad = 2.0 }";
    let turned = Change { what: "turned", key: "model.orbit.start", value: turned };
    let called = Baseline::new(scene, 1).called(1, Some(&turned));
    assert_eq!(called.code, Some(0), "{}", called.out);
    let lines = comparison_in(&called.out)["sensitivity"].to_string();
    assert!(
        lines.contains("no compared metric shows the change of model.orbit.start: "),
        "{lines}"
    );
    let slower =
        scene.changes.iter().find(|change| change.key.ends_with("time_step_days")).unwrap();
    assert_eq!(Baseline::new(scene, 1).called(1, Some(slower)).code, Some(3));
}

/// Points keep their energy, so that their root mean square speed equals its law before and now. Law: ⟨v²⟩ = 2 k T / m in a plane, so that twice the mass gives
/// another speed, which is no agreement. Control: another seed.
#[test]
fn value_of_a_law_that_the_manifest_changes_fails() {
    let scene = SCENES.iter().find(|scene| scene.name == "gas_points").unwrap();
    let heavier = scene.changes.iter().find(|change| change.key.ends_with("mass_kg")).unwrap();
    let baseline = Baseline::new(scene, 1);
    let (finding, text) = baseline.compare(2, Some(heavier));
    assert_eq!(finding, Finding::Different, "{text}");
    assert!(text.contains("\"rms_speed\": \"its exact law"), "{text}");
    let (finding, text) = baseline.compare(2, None);
    assert_eq!(finding, Finding::Equal, "control: {text}");
}
