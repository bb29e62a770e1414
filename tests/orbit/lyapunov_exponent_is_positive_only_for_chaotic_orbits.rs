//! Law: two runs of bodies that attract each other separate exponentially where their motion is chaotic, and in proportion to time where it
//! is regular. The figure-eight orbit is stable (Simó, in: European Congress of Mathematics 2000, 101), so its exponent is 0, as that of two bodies is.
//!
//! Source: Benettin, Galgani and Strelcyn, Phys. Rev. A 14 (1976) 2338.
//! Setup: the figure-eight orbit for 400 periods, two bodies on an ellipse, and a test particle of the circular restricted problem that
//! starts halfway between the masses.
//! Tolerance: two standard errors for 0. Control: the chaotic orbit is four standard errors from 0.

#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use kinetoscope::{Experiment, run};
use kinetoscope_analysis::analyze;

/// The exponent, its standard error, and whether a time of divergence follows from it.
fn exponent(integrator: &str, duration: f64, bodies: &str) -> ([f64; 2], bool) {
    let manifest = format!(
        "[model.orbit]\nintegrator = \"{integrator}\"\ntime_step_days = 0.01\nduration_days = {duration}\nbodies = [{bodies}]\n\
         [record]\nframes = 1000\nchannels = [\"state\", \"divergence\"]\n"
    );
    let experiment: Experiment = manifest.parse().unwrap();
    let analysis = analyze(&run(&experiment.runs[0]).unwrap()).unwrap();
    let found = analysis.measurement("lyapunov.exponent").unwrap().estimate;
    let has_time = analysis.measurement("lyapunov.divergence_time").is_some();
    println!("{integrator}: {} ± {:?}", found.value, found.standard_error);
    ([found.value, found.standard_error.unwrap()], has_time)
}

fn body(mass: f64, [x, y]: [f64; 2], [vx, vy]: [f64; 2]) -> String {
    format!(
        "{{ gm_au3_per_day2 = {mass:?}, position_au = [{x:?}, {y:?}, 0.0], velocity_au_per_day = [{vx:?}, {vy:?}, 0.0] }},"
    )
}

#[test]
fn figure_eight_is_regular() {
    let bodies = [
        body(1.0, [0.970_004_36, -0.243_087_53], [0.466_203_685, 0.432_365_73]),
        body(1.0, [-0.970_004_36, 0.243_087_53], [0.466_203_685, 0.432_365_73]),
        body(1.0, [0.0, 0.0], [-0.932_407_37, -0.864_731_46]),
    ]
    .concat();
    for integrator in ["dop853", "yoshida4"] {
        let ([value, error], has_time) = exponent(integrator, 2530.0, &bodies);
        assert!(value.abs() < 2.0 * error && !has_time, "{integrator}: {value} ± {error}");
        assert!(error < 2e-3, "{error}");
    }
}

#[test]
fn two_bodies_are_regular() {
    let bodies = [body(1.0, [0.5, 0.0], [0.0, 0.8]), body(1.0, [-0.5, 0.0], [0.0, -0.8])].concat();
    let ([value, error], has_time) = exponent("dop853", 1000.0, &bodies);
    assert!(value.abs() < 2.0 * error && !has_time, "{value} ± {error}");
}

/// Two masses of 0.9 and 0.1 on a circle of radius 1 with the period 2 pi, and a test particle that nearly rotates with them.
#[test]
fn control_test_particle_between_two_masses_is_chaotic() {
    let bodies = [
        body(0.9, [-0.1, 0.0], [0.0, -0.1]),
        body(0.1, [0.9, 0.0], [0.0, 0.9]),
        body(0.0, [0.5, 0.0], [0.0, 0.55]),
    ]
    .concat();
    let ([value, error], has_time) = exponent("dop853", 2400.0, &bodies);
    assert!(value > 4.0 * error && has_time, "{value} ± {error}");
}

/// Guarantee: a planet around the fixed Sun has no twin; the manifest is rejected with what to change.
#[test]
fn divergence_needs_several_bodies() {
    let manifest = "[model.orbit]\n[record]\nchannels = [\"state\", \"divergence\"]\n";
    let errors = manifest.parse::<Experiment>().unwrap_err().to_string();
    assert!(errors.contains("no twin") && errors.contains("model.orbit.bodies"), "{errors}");
}
