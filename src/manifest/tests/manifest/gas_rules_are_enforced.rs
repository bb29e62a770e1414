//! Guarantee: every rule of `[model.gas]` is enforced, and the message states the allowed values and the position.
//!
//! Setup: each rule is violated once.

// A test may panic.
#![allow(clippy::unwrap_used)]

use crate::verdicts::{accepted, rejected};
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
fn gas_gravity_and_partition_must_be_consistent() {
    for own in ["gravity_m_per_s2 = 9.81", "partition_x_m = 0"] {
        let name = own.split(' ').next().unwrap();
        for (key, value) in [
            ("propagation", "\"time-stepped\""),
            ("wall_speed_m_per_s", "1"),
            ("wall_temperature_k", "300"),
            ("orifice_width_m", "0.1"),
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
    rejected(
        "[model.gas]\ngravity_m_per_s2 = 1\npartition_x_m = 0 # <-",
        "`gravity_m_per_s2` and `partition_x_m` cannot be used together",
    );
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
        "the nearest `gravity_m_per_s2` that works is 4.14",
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
