//! Guarantee: period, third law, distances, phase and drift of a run are the same for 20, 200 and 2000 frames, because the model
//! tracks the passes of the start and the apsides at every step.
//!
//! Source: period of the start of the orbit exercise, 362.0731079683158659 d, in 50-digit arithmetic; that of the heliocentric
//! start, 364.8983 d. Phase error of explicit Euler after ten years, -15.1885041463336 rad, in 40-digit arithmetic.
//! Setup: whole runs, recorded and analyzed in memory, with each integrator.
//! Tolerance: 1e-9 between numbers of frames; the error of the method for periods, stated at each assertion.
//! Control: a period from the frames, by linear interpolation, depends on their number by more than 5 d.

#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use kinetoscope::{Experiment, Recording, run};
use kinetoscope_analysis::{Measurement, RunAnalysis, analyze};

const METRICS: [&str; 8] = [
    "period.measured",
    "third_law.ratio",
    "radius.min",
    "radius.max",
    "phase_error.final",
    "position_error.final",
    "energy.drift_relative",
    "energy.drift_per_revolution",
];

/// A run of the start of the orbit exercise.
fn recorded(settings: &str, days: f64, frames: u32) -> Recording {
    let manifest =
        format!("[model.orbit]\n{settings}\nduration_days = {days}\n[record]\nframes = {frames}\n");
    let experiment: Experiment = manifest.parse().unwrap();
    run(&experiment.runs[0]).unwrap()
}

fn value(analysis: &RunAnalysis, metric: &str) -> f64 {
    analysis.measurement(metric).unwrap().estimate.value
}

/// Period from the frames: the mean time between passes of the direction of the start, interpolated linearly.
fn period_from_frames(recording: &Recording) -> f64 {
    let (mut start, mut before) = ([0.0; 3], None::<(f64, f64)>);
    let (mut passes, mut last) = (0.0, 0.0);
    for (index, frame) in recording.frames().unwrap().enumerate() {
        let frame = frame.unwrap();
        let state = frame.state().unwrap();
        let position = ["x", "y", "z"].map(|name| state.value(0, name).unwrap());
        if index == 0 {
            start = position;
            continue;
        }
        let ahead = start[0] * position[1] - start[1] * position[0];
        let along = start[0] * position[0] + start[1] * position[1];
        let time = frame.clock.time;
        if let Some((time_before, ahead_before)) = before
            && ahead_before < 0.0
            && ahead >= 0.0
            && along > 0.0
        {
            passes += 1.0;
            last = time_before + (time - time_before) * ahead_before / (ahead_before - ahead);
        }
        before = Some((time, ahead));
    }
    last / passes
}

#[test]
fn metrics_are_equal_at_three_frame_rates() {
    for integrator in [
        "explicit-euler",
        "semi-implicit-euler",
        "velocity-verlet",
        "rk4",
        "yoshida4",
        "dop853",
        "kepler",
    ] {
        let settings = format!(
            "start = \"barycentric\"\nintegrator = \"{integrator}\"\ntime_step_days = 0.25"
        );
        let [coarse, medium, fine] =
            [20, 200, 2000].map(|frames| analyze(&recorded(&settings, 1500.0, frames)).unwrap());
        for metric in METRICS {
            let expected = value(&fine, metric);
            for other in [&coarse, &medium] {
                let found = value(other, metric);
                assert!(
                    (found - expected).abs() <= 1e-9 * expected.abs().max(1.0),
                    "{integrator}: {metric} is {found} and {expected}"
                );
            }
        }
        let period = value(&coarse, "period.measured");
        println!(
            "{integrator}: period {period} d, third law {}",
            value(&coarse, "third_law.ratio")
        );
        // Error of the period per revolution: the phase error over the angular velocity.
        let allowed = match integrator {
            "explicit-euler" => continue,
            "semi-implicit-euler" => 0.05,
            "velocity-verlet" => 3e-3,
            "yoshida4" => 1e-6,
            _ => 1e-7,
        };
        assert!((period - 362.073_107_968_315_9).abs() < allowed, "{integrator}: {period}");
        let ratio = value(&coarse, "third_law.ratio");
        assert!((ratio - 1.0).abs() < allowed / 50.0, "{integrator}: {ratio}");
    }
}

#[test]
fn control_period_from_frames_depends_on_their_number() {
    let settings = "start = \"barycentric\"\nintegrator = \"kepler\"";
    let [coarse, fine] =
        [20, 2000].map(|frames| period_from_frames(&recorded(settings, 1500.0, frames)));
    assert!((fine - 362.073).abs() < 1e-3, "{fine}");
    assert!((coarse - 362.073).abs() > 0.1, "{coarse}");
}

#[test]
fn phase_error_of_euler_is_unwrapped_with_few_frames() {
    let settings =
        "start = \"barycentric\"\nintegrator = \"explicit-euler\"\ntime_step_days = 0.25";
    let analysis = analyze(&recorded(settings, 3652.5, 20)).unwrap();
    let phase = value(&analysis, "phase_error.final");
    assert!((phase + 15.188_504_146_333_6).abs() < 1e-9, "{phase}");
}

#[test]
fn default_start_has_the_period_of_its_osculating_orbit() {
    let analysis = analyze(&recorded("integrator = \"rk4\"", 800.0, 20)).unwrap();
    let period = analysis.measurement("period.measured").unwrap();
    let theory = period.theory.unwrap().value;
    assert!((theory - 364.8983).abs() < 1e-4, "{theory}");
    assert!((period.estimate.value - theory).abs() < 1e-6, "{}", period.estimate.value);
}

#[test]
fn period_of_a_run_without_a_revolution_is_explained() {
    let analysis = analyze(&recorded("", 300.0, 20)).unwrap();
    assert!(analysis.measurement("period.measured").is_none());
    let named = |found: &&Measurement| found.name() == "period.measured";
    let period = analysis.measurements.iter().find(named).unwrap();
    assert!(period.reason.as_ref().unwrap().contains("before the first revolution"));
}
