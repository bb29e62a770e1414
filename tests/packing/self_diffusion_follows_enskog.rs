//! Law: elastic discs diffuse with D = 1.027 sqrt(T/pi) / (2 n d χ) + T / (8 pi n (D + viscosity)) ln(t / 2.5 t_0) - T t / N,
//! measured by the velocity autocorrelation (D = 1/2 integral of <v(0) . v(t)>) and by the mean square displacement (D = d<|r|^2>/dt / 4).
//!
//! Source: Enskog's theory (Chapman and Cowling, The Mathematical Theory of Non-uniform Gases), with the sum of four Sonine
//! polynomials by `benches/peers/disc_diffusion_sonine.py`; χ by Kolafa and Rottner, Mol. Phys. 104 (2006) 3435. Tail of the
//! velocity autocorrelation by Ernst, Hauge and van Leeuwen, Phys. Rev. Lett. 25 (1970) 1254, with Enskog's viscosity by Gass, J. Chem. Phys. 54 (1971) 1898; its onset at 2.5 mean free times t_0 was fitted to runs
//! with other seeds and 250 discs. Fixed momentum takes T/N off the velocity autocorrelation.
//! Setup: 600 discs in a periodic box at three packing fractions, about 90 windows of ten mean free times, five frames per mean free
//! time.
//! Tolerance: 5 %, and a standard error of at most 3 %.
//! Control: the theory for another χ (1 in place of the contact value) at the largest fraction is rejected, as are inelastic discs.

#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use kinetoscope::{Experiment, run};
use kinetoscope_analysis::{RunAnalysis, analyze};
use std::f64::consts::PI;

const DISCS: f64 = 600.0;
const METRICS: [&str; 2] = ["self_diffusion.from_velocities", "self_diffusion.from_displacements"];

/// Contact value of Henderson's equation of state, Mol. Phys. 30 (1975) 971, within 0.1 % at these fractions.
fn contact_value(fraction: f64) -> f64 {
    (1.0 - 7.0 * fraction / 16.0) / ((1.0 - fraction) * (1.0 - fraction))
}

/// Enskog's D of discs with radius 1 and T = 1, for a contact value.
fn enskog(fraction: f64, contact: f64) -> f64 {
    1.027 / PI.sqrt() / (2.0 * (fraction / PI) * 2.0 * contact)
}

/// D after a time in mean free times, with the mean of ln(t / 2.5).
fn corrected(fraction: f64, contact: f64, [time, logarithm]: [f64; 2]) -> f64 {
    let (d, n, x) = (enskog(fraction, contact), fraction / PI, 2.0 * fraction * contact);
    let viscosity = 1.022 / PI.sqrt() / (4.0 * n) * (1.0 + x + 0.8729 * x * x) / contact;
    d + logarithm / (8.0 * PI * n * (d + viscosity)) - d / 1.027 * time / DISCS
}

/// At the end of the window of ten mean free times; and from five to ten, where the mean of ln t is 2 ln 10 - ln 5 - 1.
const END: [f64; 2] = [10.0, 1.386];
const SECOND_HALF: [f64; 2] = [7.5, 1.080];

fn analyzed(fraction: f64, windows: f64, keys: &str) -> RunAnalysis {
    let side = (DISCS * PI / fraction).sqrt();
    let free_time = enskog(fraction, contact_value(fraction)) / 1.027;
    let (duration, every) = (10.0 * windows * free_time, 0.2 * free_time);
    let manifest = format!(
        "seed = 8\n[model.packing]\ndiscs = {DISCS}\nradius = 1.0\nwidth = {side}\nheight = {side}\nboundary = \"periodic\"\n\
         remove_mean_velocity = true\nduration = {duration}\n{keys}[record]\nevery_time = {every}\n"
    );
    let experiment: Experiment = manifest.parse().unwrap();
    analyze(&run(&experiment.runs[0]).unwrap()).unwrap()
}

/// Ratios of both values to Enskog's at T of the run, with their relative errors.
fn over_theory(analysis: &RunAnalysis, fraction: f64, contact: f64) -> [(f64, Option<f64>); 2] {
    let speed = analysis.measurement("temperature.initial").unwrap().estimate.value.sqrt();
    [0, 1].map(|index| {
        let theory = speed * corrected(fraction, contact, [END, SECOND_HALF][index]);
        let found = analysis.measurement(METRICS[index]).unwrap();
        let expected = found.theory.as_ref().map(|expected| expected.value / theory);
        assert!(expected.is_none_or(|ratio| (ratio - 1.0).abs() < 0.01 || contact == 1.0));
        let found = found.estimate;
        (found.value / theory, found.standard_error.map(|error| error / theory))
    })
}

#[test]
fn diffusion_is_within_five_percent_of_enskog_at_three_packing_fractions() {
    for fraction in [0.05, 0.1, 0.2] {
        let analysis = analyzed(fraction, 90.0, "");
        for (ratio, error) in over_theory(&analysis, fraction, contact_value(fraction)) {
            println!("packing fraction {fraction}: D over theory {ratio:.4}, error {error:?}");
            assert!((ratio - 1.0).abs() < 0.05, "{fraction}: {ratio}");
            assert!(error.unwrap() < 0.03);
        }
        if fraction == 0.2 {
            for (ratio, _) in over_theory(&analysis, fraction, 1.0) {
                assert!((ratio - 1.0).abs() > 0.05, "control: without the contact value: {ratio}");
            }
        }
    }
}

#[test]
fn control_inelastic_discs_do_not_follow_enskog() {
    let analysis = analyzed(0.1, 10.0, "restitution = 0.9\n");
    for (ratio, error) in over_theory(&analysis, 0.1, contact_value(0.1)) {
        println!("restitution 0.9: D over theory at the initial temperature {ratio:.4}");
        assert!((ratio - 1.0).abs() > 0.05, "{ratio}");
        assert_eq!(error, None, "a cooling gas has no stationary D");
    }
    assert!(analysis.measurement(METRICS[0]).unwrap().theory.is_none());
}

/// Frames of one mean free time, walls, and a drift give a reason in place of a value.
#[test]
fn coarse_frames_give_a_reason() {
    let manifest = "seed = 8\n[model.packing]\nboundary = \"periodic\"\nremove_mean_velocity = true\nduration = 400\n[record]\nevery_time = 4\n";
    for (manifest, reason) in [
        (manifest.to_owned(), "a quarter of a mean free time"),
        (manifest.replace("velocity = true", "velocity = false"), "total momentum of zero"),
        (manifest.replace("boundary = \"periodic\"", ""), "periodic box"),
    ] {
        let experiment: Experiment = manifest.parse().unwrap();
        let analysis = analyze(&run(&experiment.runs[0]).unwrap()).unwrap();
        assert!(analysis.measurement(METRICS[1]).is_none());
        let found = analysis.measurements.iter().find(|found| found.name() == METRICS[1]).unwrap();
        assert!(found.reason.as_ref().unwrap().contains(reason), "{:?}", found.reason);
    }
}
