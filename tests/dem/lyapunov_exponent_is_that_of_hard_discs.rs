//! Law: stiff elastic discs diverge as hard discs do: their Lyapunov exponent by a twin is that of hard discs by the exact motion of
//! a difference, at the same packing fraction and in units of sqrt(T)/r.
//!
//! Source: Dellago, Posch and Hoover, Phys. Rev. E 53 (1996) 1485, for hard discs, whose metric is compared with an independent program in
//! `tests/packing/lyapunov_exponent_agrees_with_twins.rs`. The methods share no code.
//! Setup: 16 discs at a packing fraction of 0.1 in a periodic box; overlaps of 2 % of a radius, contacts of 1 % of a free time.
//! Tolerance: three standard errors of both together, at most 15 %.
//! Control: with 20 steps per contact of stiffer discs, the exponent is larger by a quarter: the velocity after a contact depends on the part of a
//! step in which it begins, and a step is far shorter than the time in which a disc flies its diameter.

#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use kinetoscope::{Experiment, run};
use kinetoscope_analysis::{RunAnalysis, analyze};
use kinetoscope_physics::model::{Model, Progress, Target};
use kinetoscope_physics::random::Seed;
use kinetoscope_physics::{prepare_with_twin, restore_with_twin};
use kinetoscope_recording::channels::Divergence;
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::reader::Recording;
use std::f64::consts::PI;

const DISCS: f64 = 16.0;

fn recorded([steps, stiffness]: [f64; 2], duration: f64, channels: &str) -> Recording {
    let side = 1e-3 * (DISCS * PI / 0.1).sqrt();
    let manifest = format!(
        "seed = 3\n[model.dem]\ndiscs = {DISCS}\nradius_m = 1e-3\nmass_kg = 1e-3\nwidth_m = {side}\nheight_m = {side}\nperiodic = \"both\"\n\
         gravity_m_per_s2 = [0.0, 0.0]\nstiffness_n_per_m = {stiffness}\nsteps_per_wall_contact = {steps}\nrestitution = 1.0\nvelocity_std_m_per_s = 0.1\nduration_s = {duration}\n\
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
    for (steps, is_same) in [([160.0, 2.5e4], true), ([20.0, 1e5], false)] {
        let analysis = analyze(&recorded(steps, 8.0, ", \"divergence\"")).unwrap();
        let [found, error] = exponent(&analysis, "granular_temperature.start", 1e-3);
        let errors = (error * error + of_expected * of_expected).sqrt();
        println!("{steps:?}: {found:.4} ± {error:.4}, hard discs {expected:.4} ± {of_expected:.4}");
        assert_eq!((found - expected).abs() < 3.0 * errors, is_same, "{steps:?}");
        assert!(errors < 0.05 * expected, "{errors}");
    }
}

/// Guarantee: a twin changes no bit of the run.
#[test]
fn a_twin_changes_no_bit_of_the_run() {
    let [with, without] =
        [", \"divergence\"", ""].map(|channels| recorded([20.0, 1e5], 0.2, channels));
    let mut frames = 0;
    for (one, other) in with.frames().unwrap().zip(without.frames().unwrap()) {
        let (one, other) = (one.unwrap(), other.unwrap());
        assert_eq!(one.state(), other.state());
        frames += 1;
    }
    assert_eq!(frames, 101);
}

/// Guarantee: a run with a twin that is restored from a checkpoint, and one whose work is divided otherwise, give the same growth, bit for bit.
#[test]
fn twins_resume_with_the_same_bits() {
    let dem = "[model.dem]\ndiscs = 16\nperiodic = \"both\"\nwidth_m = 0.02\nheight_m = 0.02\ngravity_m_per_s2 = [0.0, 0.0]\nrestitution = 1.0\nfriction = 0.3\nvelocity_std_m_per_s = 0.1\n";
    let orbit = "[model.orbit]\nintegrator = \"dop853\"\ntime_step_days = 0.01\nduration_days = 10.0\nbodies = [{ gm_au3_per_day2 = 1.0, position_au = [0.5, 0.0, 0.0], velocity_au_per_day = [0.0, 0.8, 0.0] }, { gm_au3_per_day2 = 1.0, position_au = [-0.5, 0.0, 0.0], velocity_au_per_day = [0.0, -0.8, 0.0] }]\n";
    for (text, end) in [(dem, 5000), (orbit, 900)] {
        let experiment: Experiment = text.parse().unwrap();
        let config = &experiment.runs[0].manifest.model;
        let start = || prepare_with_twin(config, Seed { seed: 1, replicate: 0 }, false, &|_| true);
        let growth = |model: &dyn Model| {
            let mut frame = Frame::new();
            model.observe(&mut frame);
            frame.get::<Divergence>().unwrap().logarithm.to_bits()
        };
        let advance = |model: &mut dyn Model, at_most: u64, to: u64| {
            while model.advance(Target::Count(to), at_most).unwrap() == Progress::Working {}
        };
        let mut whole = start().unwrap();
        advance(&mut *whole, u64::MAX, end);
        let mut parts = start().unwrap();
        advance(&mut *parts, 7, end / 3);
        let mut bytes = Vec::new();
        parts.encode_into(&mut bytes).unwrap();
        let mut restored = restore_with_twin(config, &bytes).unwrap();
        advance(&mut *restored, 100, end);
        assert_eq!(growth(&*restored), growth(&*whole));
        assert_ne!(growth(&*parts), growth(&*whole));
    }
}
