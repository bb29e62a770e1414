//! Guarantee: every rule of `[model.orbit]` is enforced, and the message states the allowed values and the position.
//!
//! Setup: each rule is violated once.

// A test may panic.
#![allow(clippy::unwrap_used)]

use crate::verdicts::{accepted, errors, rejected};

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
            "keep the keys of one of the two",
        ),
        (
            "semi_major_axis_au = 1, eccentricity = 0, mean_anomaly_rad = 1e300",
            "the same angle without multiples of 2 pi is ",
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
    rejected(
        "[model.orbit]\nduration_days = 1e-300 # <-",
        "increase the duration to at least 0.25",
    );
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

#[test]
fn vectors_and_elements_cannot_be_mixed() {
    let start = |keys: &str| format!("[model.orbit]\nstart = {{ {keys} }} # <-");
    let (position, velocity) = ("position_au = [1, 0, 0]", "velocity_au_per_day = [0, 1, 0]");
    let elements = "semi_major_axis_au = 1, eccentricity = 0.1";
    for keys in [
        format!("{position}, {velocity}, eccentricity = 0.1"),
        format!("{velocity}, {elements}"),
        format!("{position}, {velocity}, {elements}, inclination_rad = 0"),
        format!("{position}, eccentricity = 0.1"),
    ] {
        rejected(&start(&keys), "cannot be used together");
    }
    let body = "{ gm_au3_per_day2 = 1, position_au = [1, 0, 0], mean_anomaly_rad = 1 }";
    rejected(&format!("[model.orbit]\nbodies = [{body}] # <-"), "`mean_anomaly_rad` cannot be");
}

#[test]
fn sizes_at_which_the_motion_overflows_are_rejected_with_the_nearest_value() {
    let start = |text: &str| format!("[model.orbit]\nstart = {{ {text} }} # <-");
    let elements = |axis: &str| start(&format!("semi_major_axis_au = {axis}, eccentricity = 0.5"));
    rejected(&elements("1e-300"), "`model.orbit.start.semi_major_axis_au` is 1e-300, at which");
    rejected(&elements("1e-300"), "the nearest value is 1e-50");
    rejected(&elements("1e300"), "the nearest value is 1e50");
    accepted(&elements("1e50"));
    let vectors = |position: &str, velocity: &str| {
        start(&format!(
            "position_au = [{position}, 0, 0], velocity_au_per_day = [0, {velocity}, 0]"
        ))
    };
    rejected(&vectors("1e160", "0.01"), "the length of `model.orbit.start.position_au` is 1e160");
    rejected(
        &vectors("1", "1e160"),
        "the length of `model.orbit.start.velocity_au_per_day` is 1e160",
    );
    rejected(&vectors("1e-160", "1"), "must be at least 1e-50 AU away");
    accepted(&vectors("1e50", "1e-50"));
    let both = "[model.orbit]\nstart = { semi_major_axis_au = 1e300, eccentricity = 2, mean_anomaly_rad = 1e3 }";
    let errors = errors(both);
    assert_eq!(errors.len(), 3, "all at once: {errors}");
}

#[test]
fn a_start_on_a_line_through_the_sun_is_rejected_with_the_speed_of_a_circle() {
    let start = |velocity: &str| {
        format!(
            "[model.orbit]\nstart = {{ position_au = [1, 0, 0], velocity_au_per_day = [{velocity}] }} # <-"
        )
    };
    // sqrt(2.959122082322128e-4 / 1)
    rejected(&start("0, 0, 0"), "0.01720 AU/day on a circle");
    rejected(&start("-0.01, 0, 0"), "needs a component perpendicular to `position_au`");
    accepted(&start("0.01, 1e-10, 0"));
}

#[test]
fn bodies_without_a_motion_are_rejected_at_their_lines() {
    const SUN: &str =
        "{ gm_au3_per_day2 = 3e-4, position_au = [0, 0, 0], velocity_au_per_day = [0, 0, 0] },";
    let bodies = |others: &str| format!("[model.orbit]\nbodies = [\n{SUN}\n{others}\n]");
    let planet = |gm: &str, anomaly: &str| {
        format!(
            "{{ gm_au3_per_day2 = {gm}, semi_major_axis_au = 1, eccentricity = 0, mean_anomaly_rad = {anomaly} }},"
        )
    };
    let at_the_sun = SUN.replace("3e-4", "0").replace("day = [0,", "day = [1,");
    rejected(
        &bodies(&format!("{at_the_sun} # <-")),
        "bodies 0 and 1 of `model.orbit.bodies` are at the same",
    );
    let [one, other] = [planet("0", "1"), planet("1e-9", "1")];
    rejected(&bodies(&format!("{one}\n{other} # <-")), "change `mean_anomaly_rad` of one of them");
    accepted(&bodies(&format!("{one}\n{one}")));
    accepted(&bodies(&format!("{one}\n{}", planet("1e-9", "2"))));
    let resting = SUN.replace("u = [0,", "u = [1,");
    rejected(
        &bodies(&resting).replace("bodies = [", "bodies = [ # <-"),
        "none moves relative to the others",
    );
    rejected(&bodies(&format!("{} # <-", planet("1e60", "1"))), "must be 0 or in [1e-50, 1e50]");
}

#[test]
fn misspelled_elements_are_compared_with_elements() {
    let errors = |start: &str| errors(&format!("[model.orbit]\nstart = {{ {start} }}")).to_string();
    let similar = errors("semi_major_axis = 1, excentricity = 0.5");
    for meant in ["did you mean `semi_major_axis_au`?", "did you mean `eccentricity`?"] {
        assert!(similar.contains(meant), "{similar}");
    }
    let unlike = errors("a = 1, e = 0.5");
    assert!(unlike.contains("known keys: semi_major_axis_au, eccentricity"), "{unlike}");
    assert!(unlike.contains("position_au, velocity_au_per_day"), "{unlike}");
}

/// Control: before, an unreadable key of a body hid every rule for its other keys.
#[test]
fn all_errors_of_one_body_are_reported_at_once() {
    const SUN: &str =
        "{ gm_au3_per_day2 = 3e-4, position_au = [0, 0, 0], velocity_au_per_day = [0, 0, 0] }";
    for (body, parts) in [
        (
            "gm_au3_per_day2 = -1, semi_major_axis_au = 1, eccentricity = 2, inclination_rad = 4",
            &[
                "bodies[1].gm_au3_per_day2` is -1",
                "nearest value is 0.999999",
                "nearest value is 3.14",
            ] as &[&str],
        ),
        (
            "gm_au3_per_day2 = 1e60, semi_major_axis_au = \"far\", eccentricity = 2",
            &[
                "the nearest value is 1e50",
                "semi_major_axis_au` is a string",
                "nearest value is 0.999999",
            ],
        ),
        (
            "gm_au3_per_day2 = 1e60, eccentricity = 2",
            &["nearest value is 1e50", "needs `semi_major_axis_au`", "nearest value is 0.999999"],
        ),
        (
            "gm_au3_per_day2 = 1e60, position_au = [1, 0, 0], eccentricity = 0.1",
            &["the nearest value is 1e50", "keep the keys of one of the two"],
        ),
        (
            "gm_au3_per_day2 = 1e60, position_au = [1, 0], velocity_au_per_day = [1e60, 0, 0]",
            &["the nearest value is 1e50", "must be an array of 3 numbers", "must be at most 1e50"],
        ),
    ] {
        let errors = errors(&format!("[model.orbit]\nbodies = [{SUN}, {{ {body} }}]"));
        let text = errors.to_string();
        for part in parts {
            assert!(text.contains(part), "{part}\n{text}");
        }
        assert_eq!(errors.len(), parts.len(), "{text}");
    }
    let first = "{ gm_au3_per_day2 = -1, semi_major_axis_au = 1, eccentricity = 0 }";
    let errors = errors(&format!("[model.orbit]\nbodies = [{first}, {SUN}]"));
    let text = errors.to_string();
    assert!(text.contains("give the first body by `position_au`"), "{text}");
    assert_eq!(errors.len(), 2, "{text}");
}

/// Control: before, a second error called the bodies coinciding, though a first body with elements has no position.
#[test]
fn first_body_with_the_elements_of_the_second_is_one_error() {
    let body = "{ gm_au3_per_day2 = 3e-4, semi_major_axis_au = 1, eccentricity = 0 }";
    rejected(
        &format!("[model.orbit]\nbodies = [{body}, {body}] # <-"),
        "the first body of `model.orbit.bodies` has elements",
    );
}
