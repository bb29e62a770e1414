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

#[test]
fn obstacles_are_inside_of_the_box_and_starts_avoid_them() {
    let of = |positions: &str, radius: &str, keys: &str| {
        format!(
            "[model.packing]\n{keys}obstacles = {{ positions = [{positions}], radius = {radius} }} # <-"
        )
    };
    accepted(&of("[-20.0, 0.0], [-18.0, 0.0]", "2.0", "gravity = 0.1\n"));
    // One disc in a periodic box collides with obstacles.
    accepted(&of("[0.0, 0.0]", "2.0", "discs = 1\nboundary = \"periodic\"\n"));
    rejected(&of("[0.0, 0.0], [20.5, 1.0]", "2.0", ""), "must have |x| <= 20.0 and |y| <= 20.0");
    rejected(&of("[0.0, 0.0], [1.0, 0.0]", "17.0", ""), "use fewer or smaller obstacles");
    rejected(&of("[0.0, 0.0]", "0.0", ""), "must be");
    let shaken = "gravity = 0.1\nfloor_stroke = 1.0\nfloor_period = 2.0\n";
    accepted(&of("[0.0, 0.0]", "2.0", shaken));
    rejected(&of("[0.0, -15.5]", "2.0", shaken), "raise the obstacles");
    rejected(&of("", "1.0", ""), "add one, or remove `obstacles`");
    rejected(&of(&"[0.0, 0.0], ".repeat(1001), "0.01", ""), "must be at most 1000");
    for placement in ["lattice", "compressed"] {
        let keys = format!("placement = \"{placement}\"\n");
        rejected(&of("[0.0, 0.0]", "1.0", &keys), "set placement to \"random\"");
    }
}

#[test]
fn gravity_needs_walls_and_floors_need_gravity() {
    let falling = "[model.packing]\ngravity = 0.1\n";
    accepted(falling);
    accepted(&format!("{falling}floor_temperature = 2.0"));
    accepted(&format!("{falling}floor_stroke = 1.0\nfloor_period = 2.0"));
    rejected(
        "[model.packing]\ngravity = 0.1\nboundary = \"periodic\" # <-",
        "remove `gravity`, or set boundary to \"walls\"",
    );
    rejected("[model.packing]\ngravity = 1e11 # <-", "must be at most 25000000000.0");
    rejected(
        "[model.packing]\nfloor_temperature = 1.0 # <-",
        "`floor_temperature` needs `gravity`",
    );
    rejected(
        &format!("{falling}wall_noise_variance_rad2 = 0.1\nfloor_temperature = 1.0 # <-"),
        "`floor_temperature` cannot be used with wall noise",
    );
    rejected(&format!("{falling}floor_stroke = 1.0 # <-"), "add the other one");
    rejected(
        &format!("{falling}floor_temperature = 1.0\nfloor_period = 2.0\nfloor_stroke = 1.0 # <-"),
        "a shaken floor has no temperature",
    );
    rejected(
        &format!("{falling}floor_period = 2.0\nfloor_stroke = 20.0 # <-"),
        "`floor_stroke` is 20.0, too small or too large",
    );
    rejected(
        &format!("{falling}floor_stroke = 1e-6\nfloor_period = 1e-4 # <-"),
        "must be at least 1e-3",
    );
    rejected(
        "[model.packing]\ngravity = 1e-9\nfloor_period = 1.0\nfloor_stroke = 1.0 # <-",
        "must be at least 1e-6",
    );
    // 4 S/P is above 1000 sqrt(2 + 2 g h).
    rejected(
        &format!("{falling}floor_stroke = 1.0\nfloor_period = 1e-3 # <-"),
        "the nearest period that works is 1.264",
    );
    accepted(&format!("{falling}floor_stroke = 1.0\nfloor_period = 1.3e-3"));
    rejected(
        "[model.packing]\n[record]\nchannels = [\"energy\"] # <-",
        "the discs do not fall, so that their energy is kinetic",
    );
    accepted(&format!("{falling}[record]\nchannels = [\"energy\"]"));
}
