//! Law: stiff elastic discs diverge as hard discs do: their Lyapunov exponent by a twin is that of hard discs by the exact motion of
//! a difference, at the same packing fraction and in units of sqrt(T)/r.
//!
//! Source: Dellago, Posch and Hoover, Phys. Rev. E 53 (1996) 1485, for hard discs, whose metric is compared with an independent program in
//! `tests/packing/lyapunov_exponent_agrees_with_twins.rs`. The methods share no code.
//! Setup: 16 discs at a packing fraction of 0.1 in a periodic box; overlaps of 1 % of a radius, contacts of 0.6 % of a free time.
//! Tolerance: three standard errors of both together, at most 15 %.
//! Control: at a packing fraction of 0.03, the exponent is another one. A run without the channel has the same states.

#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use kinetoscope::{Experiment, run};
use kinetoscope_analysis::{RunAnalysis, analyze};
use kinetoscope_recording::reader::Recording;
use std::f64::consts::PI;

const DISCS: f64 = 16.0;

fn recorded(fraction: f64, duration: f64, channels: &str) -> Recording {
    let side = 1e-3 * (DISCS * PI / fraction).sqrt();
    let manifest = format!(
        "seed = 3\n[model.dem]\ndiscs = {DISCS}\nradius_m = 1e-3\nmass_kg = 1e-3\nwidth_m = {side}\nheight_m = {side}\nperiodic = \"both\"\n\
         gravity_m_per_s2 = [0.0, 0.0]\nstiffness_n_per_m = 1e5\nrestitution = 1.0\nvelocity_std_m_per_s = 0.1\nduration_s = {duration}\n\
         [record]\nframes = 100\nchannels = [\"state\", \"temperature\"{channels}]\n"
    );
    let experiment: Experiment = manifest.parse().unwrap();
    run(&experiment.runs[0]).unwrap()
}

/// The exponent in units of sqrt(T)/r, and its standard error.
fn exponent(analysis: &RunAnalysis, temperature: &str, radius: f64) -> [f64; 2] {
    let speed = analysis.measurement(temperature).unwrap().estimate.value.sqrt();
    let found = analysis.measurement("lyapunov.exponent").unwrap().estimate;
    let error = found.conditional_standard_error.or(found.standard_error).unwrap();
    [found.value, error].map(|value| value * radius / speed)
}

#[test]
fn exponent_of_stiff_discs_is_that_of_hard_discs() {
    let side = (DISCS * PI / 0.1).sqrt();
    let manifest = format!(
        "[model.packing]\ndiscs = {DISCS}\nwidth = {side}\nheight = {side}\nboundary = \"periodic\"\nevents_per_disc = 4000\n\
         remove_mean_velocity = true\n[record]\nframes = 100\nchannels = [\"state\", \"temperature\", \"events\"]\n"
    );
    let experiment: Experiment = manifest.parse().unwrap();
    let hard = analyze(&run(&experiment.runs[0]).unwrap()).unwrap();
    let [expected, of_expected] = exponent(&hard, "temperature.initial", 1.0);
    for (fraction, is_same) in [(0.1, true), (0.03, false)] {
        let analysis = analyze(&recorded(fraction, 20.0, ", \"divergence\"")).unwrap();
        let [found, error] = exponent(&analysis, "granular_temperature.start", 1e-3);
        let errors = (error * error + of_expected * of_expected).sqrt();
        println!(
            "{fraction}: {found:.4} ± {error:.4}, hard discs {expected:.4} ± {of_expected:.4}"
        );
        assert_eq!((found - expected).abs() < 3.0 * errors, is_same, "{fraction}");
        assert!(errors < 0.05 * expected, "{errors}");
    }
}

/// Guarantee: a twin changes no bit of the run.
#[test]
fn a_twin_changes_no_bit_of_the_run() {
    let [with, without] = [", \"divergence\"", ""].map(|channels| recorded(0.1, 0.2, channels));
    let mut frames = 0;
    for (one, other) in with.frames().unwrap().zip(without.frames().unwrap()) {
        let (one, other) = (one.unwrap(), other.unwrap());
        assert_eq!(one.state(), other.state());
        frames += 1;
    }
    assert_eq!(frames, 101);
}
