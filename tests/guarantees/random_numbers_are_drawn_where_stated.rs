//! Guarantee: a run that states that it draws no random numbers is the same for every seed.
//!
//! Setup: two seeds of runs of all models, analyzed in memory.
//! Control: runs that draw their start, their radii, their materials, their walls or the discs that enter.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use kinetoscope::{Experiment, run};

/// Whether a run states that it draws random numbers, and whether a metric differs between two seeds.
fn draws_and_differs(manifest: &str) -> (bool, bool) {
    let of_seed = |seed: u32| {
        let experiment: Experiment = format!("seed = {seed}\n{manifest}").parse().unwrap();
        let planned = &experiment.runs[0];
        let analysis = kinetoscope_analysis::analyze(&run(planned).unwrap()).unwrap();
        let value = |found: &kinetoscope_analysis::Measurement| found.estimate.value.to_bits();
        let values: Vec<u64> = analysis.measurements.iter().map(value).collect();
        (planned.manifest.model.draws_random_numbers(), values)
    };
    let ((draws, one), (_, other)) = (of_seed(1), of_seed(2));
    (draws, one != other)
}

const DISCS: &str =
    "positions_m = [[0.01, 0.01], [0.02, 0.011]], velocities_m_per_s = [[0.1, 0.0], [0.0, 0.0]]";

#[test]
fn runs_without_random_numbers_are_the_same_for_every_seed() {
    let dem = |keys: &str| format!("[model.dem]\nduration_s = 0.1\n{keys}\n");
    let packing = |keys: &str| {
        format!("[model.packing]\nevents_per_disc = 20\n{keys}\n[record]\nframes = 20\n")
    };
    let gas = |keys: &str| format!("[model.gas]\nduration_s = 0.01\n{keys}\n");
    let two = "placement = { positions = [[-5.0, 0.0], [5.0, 1.0]], velocities = [[1.0, 0.0], [-0.5, 0.2]] }";
    let one = "placement = { positions_m = [[0.1, 0.2]], velocities_m_per_s = [[300.0, 40.0]] }";
    let given = format!("placement = {{ {DISCS} }}");
    for manifest in [
        "[model.orbit]\n".to_owned(),
        dem(&given),
        dem("discs = 9\nplacement = \"lattice\""),
        packing(two),
        gas(one),
    ] {
        assert_eq!(draws_and_differs(&manifest), (false, false), "{manifest}");
    }
    for manifest in [
        dem("discs = 9"),
        dem("discs = 9\nplacement = \"lattice\"\nvelocity_std_m_per_s = 0.1"),
        dem(&format!("{given}\nradius_m = {{ min = 4e-4, max = 6e-4 }}")),
        dem(&format!(
            "{given}\ninsertion = {{ discs = 3, discs_per_s = 100.0, from_m = [0.01, 0.03], to_m = [0.03, 0.03], velocity_m_per_s = [0.0, -0.5] }}"
        )),
        packing("discs = 9"),
        packing("discs = 9\nplacement = \"lattice\""),
        packing(&format!("{two}\nwall_noise_variance_rad2 = 0.01")),
        gas("particles = 5"),
        gas(&format!("{one}\nwall_temperature_k = 300.0")),
    ] {
        assert_eq!(draws_and_differs(&manifest), (true, true), "control, {manifest}");
    }
}
