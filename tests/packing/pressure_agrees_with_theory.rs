//! Law: the compressibility factor of hard discs agrees with the equation of state of Kolafa and Rottner (Mol. Phys. 104 (2006) 3435) in a
//! periodic box, and with its correction for walls at n = 50, within three combined errors.
//!
//! Setup: runs in memory, analyzed as a user analyzes them; the whole set of 12 packing fractions is ignored by default (half a minute).
//! Tolerance: 3 times the root of the squares of the run's standard error and the law's accuracy.
//! Control: Henderson's equation, and the law without walls, are rejected.

#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use kinetoscope::{Experiment, run};
use kinetoscope_analysis::analyze;

struct Compared {
    value: f64,
    theory: f64,
    /// The combined error.
    error: f64,
}

impl Compared {
    /// Deviation in combined errors.
    fn deviation(&self) -> f64 {
        (self.value - self.theory) / self.error
    }
}

/// Z of a run of discs of radius 1 in a square.
fn compared(
    seed: u32,
    discs: u32,
    fraction: f64,
    events_per_disc: u32,
    boundary: &str,
) -> Compared {
    let side = (f64::from(discs) * std::f64::consts::PI / fraction).sqrt();
    let placement = if fraction > 0.45 { "placement = \"compressed\"" } else { "" };
    let momentum = if boundary == "periodic" { "remove_mean_velocity = true" } else { "" };
    let manifest = format!(
        "seed = {seed}\n[model.packing]\ndiscs = {discs}\nradius = 1.0\nwidth = {side}\nheight = {side}\nboundary = \"{boundary}\"\n\
         {placement}\n{momentum}\nevents_per_disc = {events_per_disc}\n[record]\nframes = 640\n\
         channels = [\"temperature\", \"collisions\", \"pressure\"]\n"
    );
    let experiment: Experiment = manifest.parse().unwrap();
    let analysis = analyze(&run(&experiment.runs[0]).unwrap()).unwrap();
    let found = analysis.measurement("compressibility_factor").unwrap();
    let theory = found.theory.unwrap();
    assert!(theory.in_range(), "{fraction}");
    let (value, expected) = (found.estimate.value, theory.value);
    let error = found.estimate.standard_error.unwrap().hypot(theory.accuracy);
    println!("{boundary} {discs} {fraction}: {value} {expected} +- {error}");
    Compared { value, theory: expected, error }
}

#[test]
fn pressure_in_a_periodic_box_agrees_with_theory() {
    for fraction in [0.1, 0.3, 0.5, 0.6] {
        let compared = compared(19, 128, fraction, 800, "periodic");
        assert!(compared.deviation().abs() < 3.0, "{fraction}: {}", compared.deviation());
    }
}

#[test]
fn pressure_between_walls_agrees_with_theory() {
    for fraction in [0.1, 0.3, 0.5] {
        let found = compared(19, 50, fraction, 2000, "walls");
        assert!(found.deviation().abs() < 3.0, "{fraction}: {}", found.deviation());
        if fraction != 0.3 {
            continue;
        }
        // Control: the theory of a periodic box.
        let periodic = compared(19, 50, fraction, 100, "periodic");
        let without_walls = Compared { theory: periodic.theory, ..found };
        assert!(without_walls.deviation().abs() > 3.0, "{fraction}");
    }
}

#[test]
#[ignore = "half a minute on two cores; the short tests contain some of its values"]
fn pressure_agrees_with_theory_at_twelve_packing_fractions() {
    let mut henderson_is_rejected = false;
    for fraction in [0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.69] {
        let found = compared(77, 1024, fraction, 4000, "periodic");
        assert!(found.deviation().abs() < 3.0, "{fraction}: {}", found.deviation());
        let free = 1.0 - fraction;
        let theory = (1.0 + fraction * fraction / 8.0) / (free * free);
        let henderson = Compared { theory, ..found };
        henderson_is_rejected |= henderson.deviation().abs() > 5.0;
        if fraction <= 0.5 {
            let walls = compared(77, 50, fraction, 20_000, "walls");
            assert!(walls.deviation().abs() < 3.0, "walls, {fraction}: {}", walls.deviation());
        }
    }
    assert!(henderson_is_rejected, "control");
}
