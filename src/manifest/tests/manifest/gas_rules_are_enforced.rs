//! Guarantee: every rule of `[model.gas]` is enforced, and the message states the allowed values and the position.
//!
//! Setup: each rule is violated once.

// A test may panic.
#![allow(clippy::unwrap_used)]

use crate::verdicts::{accepted, errors, rejected};
use kinetoscope_manifest::model::{ModelConfig, SpeedScale};

#[test]
fn gas_speeds_and_steps_must_be_consistent() {
    for distribution in ["speed_distribution = \"maxwell\"", ""] {
        let manifest = format!("[model.gas]\n{distribution}\nmax_speed_m_per_s = 3 # <-");
        rejected(&manifest, "cannot be used with Maxwell's distribution");
        rejected(&manifest, "set speed_distribution to \"uniform\" or \"equal\"");
    }
    rejected(
        "[model.gas]\ntime_step_s = 1e-5 # <-",
        "`time_step_s` cannot be used with exact propagation",
    );
    rejected(
        "[model.gas]\npropagation = \"as-printed\" # <-",
        "propagation \"as-printed\" needs a time step",
    );
    rejected(
        "[model.gas]\npropagation = \"time-stepped\"\ntime_step_s = 1.0 # <-",
        "shorter than one time step",
    );
}

#[test]
fn gas_sizes_are_rejected_with_the_nearest_value_all_at_once() {
    for (keys, remedy) in [
        ("mass_kg = 1e-60", "the nearest value is 1e-50"),
        ("mass_kg = 1e60", "the nearest value is 1e50"),
        ("radius_m = 1e60", "the nearest value is 1e50"),
        ("duration_s = 1e60", "the nearest value is 1e50"),
        ("gravity_m_per_s2 = 1e-60", "the nearest value is 1e-50"),
        ("gravity_m_per_s2 = 1e60", "the nearest value is 1e50"),
        ("speeds_m_per_s = [1.0, 1e200]", "the nearest value is 1e50"),
        ("speed_distribution = \"uniform\"\nmax_speed_m_per_s = 1e60", "the nearest value is 1e50"),
        ("temperature_k = 1e300", "the nearest value is 3.6"),
        ("center_m = [3e9, 4e9]", "the nearest value is [6"),
        (
            "propagation = \"time-stepped\"\ntime_step_s = 1e-30",
            "the nearest time step that works is 1.11",
        ),
    ] {
        rejected(&format!("[model.gas]\n{keys} # <-"), remedy);
    }
    let text = "[model.gas]\nmass_kg = 1e-60\nradius_m = 1e-60\ncenter_m = [1e80, 0.0]\n\
        temperature_schedule = [[0.2, 300.0]]";
    let errors = errors(text);
    assert_eq!(errors.len(), 4, "all at once: {errors}");
    accepted("[model.gas]\nmass_kg = 1e-50\nradius_m = 1e50\nduration_s = 1e20");
}

#[test]
fn gas_temperatures_are_set_before_the_end() {
    let schedule = |pairs: &str| format!("[model.gas]\ntemperature_schedule = {pairs}");
    rejected(
        &format!("{} # <-", schedule("[[0.01, 200.0], [0.2, 300.0]]")),
        "sets a temperature at 0.2 s, but the run ends at 0.1 s",
    );
    accepted(&schedule("[[0.01, 200.0], [0.1, 300.0]]"));
}

#[test]
fn gas_gravity_and_partition_must_be_consistent() {
    for own in ["gravity_m_per_s2 = 9.81", "partition_x_m = 0"] {
        let name = own.split(' ').next().unwrap();
        for (key, value) in [
            ("propagation", "\"time-stepped\""),
            ("wall_speed_m_per_s", "1"),
            ("disc_radius_m", "0.001"),
            ("temperature_schedule", "[[0.01, 200.0]]"),
        ] {
            let more = if key == "propagation" { "time_step_s = 1e-6\n" } else { "" };
            rejected(
                &format!("[model.gas]\n{more}{own}\n{key} = {value} # <-"),
                &format!("`{name}` cannot be used with this `{key}`"),
            );
        }
    }
    for (outside, nearest) in [("3.5", "2.999"), ("0.5", "1.001")] {
        let manifest =
            format!("[model.gas]\ncenter_m = [2.0, 0.0]\npartition_x_m = {outside} # <-");
        rejected(&manifest, &format!("the nearest value that works is {nearest}"));
    }
    rejected(
        "[model.gas]\npartition_x_m = 0\npartition_opens_s = 0.1 # <-",
        "the partition would be removed at 0.1 s, but the run ends at 0.1 s",
    );
    rejected(
        "[model.gas]\npartition_opens_s = 0.1 # <-",
        "`partition_opens_s` needs `partition_x_m`",
    );
    rejected(
        "[model.gas]\npartition_side = \"left\" # <-",
        "`partition_side` needs `partition_x_m`",
    );
    rejected(
        "[model.gas]\npartition_x_m = 0\npartition_side = \"by-mass\" # <-",
        "partition_side \"by-mass\" needs `additional_masses_kg`",
    );
    let barometric = "[model.gas]\nposition_distribution = \"barometric\"";
    rejected(&format!("{barometric} # <-"), "a barometric start needs gravity");
    rejected(
        &format!("{barometric}\ngravity_m_per_s2 = 1\nspeed_distribution = \"uniform\" # <-"),
        "a barometric start needs Maxwell's speeds",
    );
    rejected(
        &format!("{barometric}\ngravity_m_per_s2 = 1e12 # <-"),
        "the nearest value that works is 4.14",
    );
    for bad in ["inf", "nan", "-9.81"] {
        rejected(&format!("[model.gas]\ngravity_m_per_s2 = {bad} # <-"), "must be a number >= 0");
    }
    accepted(&format!("{barometric}\ngravity_m_per_s2 = 1e5"));
    accepted(
        "[model.gas]\nadditional_masses_kg = [1e-26]\npartition_x_m = 0\npartition_side = \"by-mass\"",
    );
}

#[test]
fn gas_discs_and_listed_speeds_must_be_consistent() {
    for (key, value) in [
        ("propagation", "\"time-stepped\""),
        ("wall_speed_m_per_s", "1"),
        ("wall_temperature_k", "300"),
        ("orifice_width_m", "0.1"),
        ("position_distribution", "\"uniform-in-radius\""),
    ] {
        let more = if key == "propagation" { "time_step_s = 1e-6\n" } else { "" };
        rejected(
            &format!("[model.gas]\n{more}disc_radius_m = 0.001\n{key} = {value} # <-"),
            &format!("`disc_radius_m` cannot be used with this `{key}`"),
        );
    }
    rejected(
        "[model.gas]\nparticles = 10\ndisc_radius_m = 0.3 # <-",
        "would cover 0.900 of the container",
    );
    rejected("[model.gas]\nspeeds_m_per_s = [] # <-", "`speeds_m_per_s` is empty");
    rejected("[model.gas]\nspeeds_m_per_s = [-1] # <-", "must be a number >= 0");
    rejected(
        "[model.gas]\nspeeds_m_per_s = [1]\nmax_speed_m_per_s = 1 # <-",
        "`speeds_m_per_s` and `max_speed_m_per_s` cannot be used together",
    );
    let ModelConfig::Gas(gas) = accepted("[model.gas]\nspeeds_m_per_s = [1, 2]") else {
        panic!("expected the gas model")
    };
    assert_eq!(gas.speed_scale, SpeedScale::Given);
}

/// Guarantee: gravity, a thermal wall, an opening and a partition can all be combined.
#[test]
fn gas_gravity_partition_and_walls_can_be_combined() {
    let keys = [
        "gravity_m_per_s2 = 9.81",
        "wall_temperature_k = 300",
        "orifice_width_m = 0.1",
        "partition_x_m = 0",
    ];
    for chosen in 0..1 << keys.len() {
        let chosen = keys.iter().enumerate().filter(|(key, _)| chosen >> key & 1 == 1);
        let lines: String = chosen.map(|(_, line)| format!("{line}\n")).collect();
        accepted(&format!("[model.gas]\n{lines}"));
    }
}

/// Control: before, one error hid the others, and none named its pair.
#[test]
fn all_errors_of_the_temperature_schedule_are_reported_at_their_pairs() {
    let text = "[model.gas]\ntemperature_schedule = [\n[0.05, 300],\n[0.02, -1],\n[0.3, 300],\n[0.04, 200],\n]\n";
    let errors = errors(text);
    let rendered = errors.to_string();
    for (line, part) in [
        (4, "`model.gas.temperature_schedule[1]` is -1"),
        (4, "`temperature_schedule[1]` is at 0.02 s, not after the 0.05 s of a pair before it"),
        (5, "`temperature_schedule[2]` sets a temperature at 0.3 s, but the run ends at 0.1 s"),
        (6, "`temperature_schedule[3]` is at 0.04 s, not after the 0.3 s of a pair before it"),
    ] {
        let (_, place) = rendered.split_once(part).unwrap_or_else(|| panic!("{part}\n{rendered}"));
        let place = place.split_once("--> m.toml:").unwrap().1;
        assert!(place.starts_with(&format!("{line}:")), "{part}\n{rendered}");
    }
    assert_eq!(errors.len(), 4, "{rendered}");
}

/// Control: before, the error was at the last of the keys in the text, such as `duration_s`, but the advice was for another.
#[test]
fn errors_of_gravity_and_partition_are_at_the_key_to_change() {
    for text in [
        "partition_x_m = 3 # <-\ncenter_m = [1e3, 0]\nradius_m = 2",
        "partition_x_m = 0\npartition_opens_s = 1 # <-\nduration_s = 0.2",
        "position_distribution = \"uniform-in-radius\" # <-\npartition_x_m = 0",
        "gravity_m_per_s2 = 1e20 # <-\nposition_distribution = \"barometric\"\ntemperature_k = 300",
        "center_m = [1e30, 0] # <-\nradius_m = 1",
    ] {
        rejected(&format!("[model.gas]\n{text}"), "");
    }
}

/// Law: the nearest values of the messages are accepted. Control: before, that of a partition was rejected for most centers.
#[test]
fn nearest_values_of_gravity_and_partition_work() {
    for center in ["0.3", "-0.7", "1.1", "123.456", "1e9"] {
        for x in ["-1e12", "1e12"] {
            let text =
                |x: &str| format!("[model.gas]\ncenter_m = [{center}, 0]\npartition_x_m = {x}");
            accepted(&text(&suggested(&text(x), "the nearest value that works is ")));
        }
    }
    for (mass, temperature) in [("1e-26", "300"), ("3.3e-27", "17.3"), ("7e-25", "1e-3")] {
        let text = |gravity: &str| {
            format!(
                "[model.gas]\nmass_kg = {mass}\ntemperature_k = {temperature}\nposition_distribution = \"barometric\"\ngravity_m_per_s2 = {gravity}"
            )
        };
        accepted(&text(&suggested(&text("1e30"), "the nearest value that works is ")));
    }
    let text = |opens: &str| format!("[model.gas]\npartition_x_m = 0\npartition_opens_s = {opens}");
    accepted(&text(&suggested(&text("3"), "must be below 0.1, such as ")));
}

/// The value that the error of a manifest suggests after these words.
fn suggested(text: &str, words: &str) -> String {
    let rendered = errors(text).to_string();
    let (_, value) = rendered.split_once(words).unwrap_or_else(|| panic!("{rendered}"));
    value.split([';', '\n']).next().unwrap().to_owned()
}
