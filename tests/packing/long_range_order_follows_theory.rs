//! Law: the longest density waves of a fluid follow its compressibility, S(Q) = kT dn/dP for Q → 0; the density of neighbors at contact follows
//! its pressure, χ = (Z - 1)/(2 φ); hexagonal order decays fast in the liquid and slower than r^(-1/4) in the crystal.
//!
//! Source: Ornstein and Zernike; Kolafa and Rottner, Mol. Phys. 104 (2006) 3435; the bound 1/4 by Halperin and Nelson, Phys. Rev. Lett. 41 (1978) 121.
//! Setup: elastic discs in a periodic box, frames several mean free times apart.
//! Tolerance: 4 combined errors.
//! Control: the values of a packing fraction larger by 0.06 are rejected.

#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use kinetoscope::{Experiment, run};
use kinetoscope_analysis::{RunAnalysis, analyze};
use std::f64::consts::PI;

fn analyzed(
    discs: u32,
    fraction: f64,
    placement: &str,
    events_per_disc: u32,
    frames: u32,
) -> RunAnalysis {
    let side = (f64::from(discs) * PI / fraction).sqrt();
    let manifest = format!(
        "seed = 5\n[model.packing]\ndiscs = {discs}\nradius = 1.0\nwidth = {side}\nheight = {side}\nboundary = \"periodic\"\n\
         placement = \"{placement}\"\nevents_per_disc = {events_per_disc}\n[record]\nframes = {frames}\n\
         channels = [\"state\", \"temperature\", \"collisions\", \"pressure\"]\n"
    );
    let experiment: Experiment = manifest.parse().unwrap();
    analyze(&run(&experiment.runs[0]).unwrap()).unwrap()
}

/// Value, combined error and theory of a metric.
fn compared(analysis: &RunAnalysis, metric: &str) -> [f64; 3] {
    let found = analysis.measurement(metric).unwrap();
    let theory = found.theory.unwrap();
    assert!(theory.in_range(), "{metric}");
    let error = found.estimate.standard_error.unwrap().hypot(theory.accuracy);
    println!("{metric}: {} +- {error}, theory {}", found.estimate.value, theory.value);
    [found.estimate.value, error, theory.value]
}

#[test]
fn longest_waves_follow_the_compressibility() {
    // S(0) at a packing fraction, from the derivative of Henderson's equation of state (1 + f^2/8)/(1 - f)^2.
    let henderson = |f: f64| {
        let pressure = |f: f64| f * (1.0 + f * f / 8.0) / ((1.0 - f) * (1.0 - f));
        2e-4 / (pressure(f + 1e-4) - pressure(f - 1e-4))
    };
    for fraction in [0.3, 0.5] {
        let [value, error, theory] = compared(
            &analyzed(200, fraction, "compressed", 4000, 2000),
            "structure_factor.longest_waves",
        );
        assert!((theory / henderson(fraction) - 1.0).abs() < 0.02, "{fraction}: {theory}");
        assert!((value - theory).abs() < 4.0 * error && error < 0.05 * theory, "{fraction}");
        let denser = henderson(fraction + 0.06);
        assert!((value - denser).abs() > 4.0 * error, "control: {value} {denser} {error}");
    }
}

#[test]
fn density_at_contact_follows_the_pressure() {
    for fraction in [0.3, 0.5, 0.65] {
        let analysis = analyzed(256, fraction, "compressed", 3000, 1600);
        let [value, error, theory] = compared(&analysis, "contact_value.from_pairs");
        assert!((value - theory).abs() < 4.0 * error && error < 0.03 * theory, "{fraction}");
        // Control: the mean over 0.1 diameters, which is not extrapolated.
        let mean = analysis.measurement("pair_correlation.near_contact").unwrap().estimate.value;
        assert!((mean - theory).abs() > 4.0 * error || fraction < 0.4, "control: {mean}");
    }
}

#[test]
fn hexagonal_order_decays_in_the_liquid_and_stays_in_the_crystal() {
    let exponent = |fraction: f64, placement: &str| {
        let analysis = analyzed(480, fraction, placement, 600, 1024);
        let found = analysis.measurement("psi6.correlation_exponent").unwrap().estimate;
        println!("{fraction}: {} +- {:?}", found.value, found.standard_error);
        found.value
    };
    assert!(exponent(0.78, "lattice") < 0.25, "crystal");
    assert!(exponent(0.66, "compressed") > 0.6, "liquid");
}
