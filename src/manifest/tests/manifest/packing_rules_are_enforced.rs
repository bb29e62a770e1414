//! Guarantee: every rule of `[model.packing]` is enforced, and the message states the allowed values and the position.
//!
//! Setup: each rule is violated once.

use crate::verdicts::{accepted, rejected};
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_manifest::parse;

#[test]
fn packing_limits_equal_those_of_the_exercise() {
    rejected(
        "[model.packing]\nradius = 20.0 # <-",
        "the radius must be below half of the shorter side, 20.0",
    );
    // n pi r^2 / (lx ly) = 0.5 lies between 254 and 255 discs of radius 1 in 40 x 40: 800/pi = 254.6.
    accepted("[model.packing]\ndiscs = 254");
    rejected("[model.packing]\ndiscs = 255 # <-", "n pi r^2 / (lx ly) is 0.501");
    accepted("[model.packing]\ndiscs = 255\nplacement = \"lattice\"");
    rejected(
        "[model.packing]\nboundary = \"periodic\"\ndiscs = 1 # <-",
        "two discs or more, or `duration` in place of `events_per_disc`",
    );
    accepted("[model.packing]\ndiscs = 1\nboundary = \"periodic\"\nduration = 3");
    rejected("[model.packing]\nradius = nope # <-", "this is not TOML");
}

/// Control: before, the advice was "at most 0 discs of this radius".
#[test]
fn dense_random_placement_is_rejected_with_values_that_work() {
    let one = |radius: &str| {
        format!("[model.packing]\ndiscs = 1\nwidth = 10\nheight = 10\nradius = {radius} # <-")
    };
    // sqrt(0.5 10 10/pi) = 3.9894
    rejected(&one("4.9"), "^^^ a radius of at most 3.987, or a larger box");
    accepted(&one("3.987"));
    let many = |radius: &str| format!("[model.packing]\ndiscs = 400\nradius = {radius} # <-");
    // sqrt(0.5 40 40/(400 pi)) = 0.79788
    rejected(&many("1.0"), "at most 254 discs of this radius, a radius of at most 0.7975,");
    accepted(&many("0.7975"));
}

/// In a periodic box, nothing ends a drift: the mean velocity is removed unless the manifest says otherwise. Between walls, and of given
/// velocities, it is not. What is recorded states it, so that it is read again with the same value.
#[test]
fn discs_of_a_periodic_box_do_not_drift_by_default() {
    let given = "placement = { positions = [[-5, 0], [5, 0]], velocities = [[1, 0], [1, 0]] }";
    for (keys, removed) in [
        ("", false),
        ("boundary = \"periodic\"", true),
        ("boundary = \"periodic\"\nremove_mean_velocity = false", false),
        ("boundary = \"walls\"\nremove_mean_velocity = true", true),
        (&format!("boundary = \"periodic\"\n{given}"), false),
    ] {
        let run = parse(&format!("[model.packing]\n{keys}\n"), "packing.toml", &[]).unwrap().runs;
        let ModelConfig::Packing(config) = &*run[0].manifest.model else { panic!("{keys}") };
        assert_eq!(config.remove_mean_velocity, removed, "{keys}");
        let recorded = run[0].manifest.canonical();
        assert!(recorded.contains(&format!("remove_mean_velocity = {removed}\n")), "{recorded}");
    }
}
