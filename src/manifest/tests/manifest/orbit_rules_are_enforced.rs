//! Guarantee: every rule of `[model.orbit]` is enforced, and the message states the allowed values and the position.
//!
//! Setup: each rule is violated once.

use crate::verdicts::{accepted, rejected};

#[test]
fn elements_that_describe_no_ellipse_are_rejected_with_the_nearest_value() {
    let start = |text: &str| format!("[model.orbit]\nstart = {{ {text} }} # <-");
    for (elements, remedy) in [
        ("semi_major_axis_au = 1, eccentricity = 1.2", "the nearest value is 0.999999"),
        ("semi_major_axis_au = 1, eccentricity = 1", "the nearest value is 0.999999"),
        ("semi_major_axis_au = 1, eccentricity = -0.1", "the nearest value is 0.0"),
        ("semi_major_axis_au = -2.5, eccentricity = 0.1", "must be > 0, such as 2.5"),
        ("semi_major_axis_au = 0, eccentricity = 0.1", "must be > 0, such as 1.0"),
        (
            "semi_major_axis_au = 1, eccentricity = 0, inclination_rad = 4",
            "the nearest value is 3.141592653589793",
        ),
        ("semi_major_axis_au = 1, eccentricity = 0, inclination_rad = -1", "nearest value is 0.0"),
        (
            "semi_major_axis_au = 1, eccentricity = 0, true_anomaly_rad = 1, mean_anomaly_rad = 1",
            "keep one of them",
        ),
        (
            "position_au = [1, 0, 0], velocity_au_per_day = [0, 0.017, 0], eccentricity = 0.1",
            "keep the vectors or the elements",
        ),
        (
            "semi_major_axis_au = 1, eccentricity = 0, mean_anomaly_rad = 1e300",
            "subtract multiples of 2 pi",
        ),
        ("semi_major_axis_au = 1", "needs `eccentricity`"),
    ] {
        rejected(&start(elements), remedy);
    }
    let sun =
        "{ gm_au3_per_day2 = 3e-4, position_au = [0, 0, 0], velocity_au_per_day = [0, 0, 0] }";
    let planet = "{ gm_au3_per_day2 = 0, semi_major_axis_au = 1, eccentricity = 0.1 }";
    let bodies =
        |first: &str, second: &str| format!("[model.orbit]\nbodies = [{first}, {second}] # <-");
    accepted(&bodies(sun, planet));
    rejected(&bodies(planet, sun), "give the first body by `position_au`");
    rejected(&bodies(sun, &planet.replace("0.1", "1.5")), "the nearest value is 0.99999");
    for step in ["1e-5", "1", "365"] {
        accepted(&format!(
            "[model.orbit]\nintegrator = \"explicit-euler\"\ntime_step_days = {step}"
        ));
    }
}

#[test]
fn orbits_must_start_outside_the_sun() {
    rejected(
        "[model.orbit]\nstart = { position_au = [0, 0, -0.0], velocity_au_per_day = [1, 0, 0] } # <-",
        "must not be [0, 0, 0]",
    );
    rejected(
        "[model.orbit]\nstart = { position_au = [1, 0], velocity_au_per_day = [1, 0, 0] } # <-",
        "must be an array of 3 numbers",
    );
    rejected(
        "[model.orbit]\nstart = \"geocentric\" # <-",
        "\"barycentric\", \"heliocentric\" or { position_au",
    );
    rejected("[model.orbit]\nduration_days = 0.1 # <-", "shorter than one time step");
    rejected("[model.orbit]\ntime_step_days = 0 # <-", "must be a number > 0");
    rejected("[model.orbit]\ntime_step_days = -0.25 # <-", "must be a number > 0");
    rejected("[model.orbit]\nduration_days = 0 # <-", "must be a number > 0");
    rejected("[model.orbit]\ntolerance = 1e-16 # <-", "must be a number in [1e-15, 0.01]");
}

#[test]
fn several_bodies_must_include_a_mass() {
    const SUN: &str =
        "{ gm_au3_per_day2 = 1, position_au = [0, 0, 0], velocity_au_per_day = [0, 0, 0] }";
    const EARTH: &str =
        "{ gm_au3_per_day2 = 0, position_au = [1, 0, 0], velocity_au_per_day = [0, 1, 0] }";
    let orbit = |rest: &str| format!("[model.orbit]\n{rest}");
    accepted(&orbit(&format!("bodies = [{SUN}, {EARTH}]")));
    rejected(&orbit(&format!("bodies = [{SUN}] # <-")), "needs at least two bodies");
    rejected(&orbit(&format!("bodies = [{EARTH}, {EARTH}] # <-")), "one of them with mass");
    rejected(
        &orbit(&format!("bodies = [{SUN}, {EARTH}]\nintegrator = \"kepler\" # <-")),
        "moves one body about the Sun",
    );
    rejected(
        &orbit(&format!("bodies = [{SUN}, {EARTH}]\nstart = \"heliocentric\" # <-")),
        "keep one of them",
    );
    let massless = SUN.replace("= 1,", "= -1,");
    rejected(&orbit(&format!("bodies = [{EARTH}, {massless}] # <-")), "must be a number >= 0");
    rejected(&orbit("bodies = [1] # <-"), "a table { gm_au3_per_day2");
}
