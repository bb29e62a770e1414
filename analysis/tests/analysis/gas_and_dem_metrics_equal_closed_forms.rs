//! Law: the metrics of a recording equal the numbers put into it.
//!
//! Setup: frames made from closed forms, so that each metric is known. Tolerance: rounding unless stated otherwise.
//! Control: an energy balance that contradicts the state is found.
#![allow(clippy::disallowed_methods, missing_docs, reason = "closed forms need std's maths")]

use crate::synthetic::{Folder, Frames, analyze, frames_of};
use kinetoscope_manifest::RunManifest;
use kinetoscope_manifest::model::{ModelConfig, SpeedScale};
use kinetoscope_recording::channels::{
    DemContactStatistics, DemEnergy, DemTemperature, GasCollisions, GasEnergyBalance,
    GasInvariants, GasPressure, GasTemperature,
};
use std::f64::consts::PI;

const GAS_SWEEP: &str = r#"
name = "gas"
seed = 1
replicates = 3
[model.gas]
particles = 2
duration_s = 2.0
[record]
frames = 1
channels = ["state", "pressure", "energy", "collisions"]
[sweep]
"model.gas.temperature_k" = [100.0, 200.0, 400.0]
[[checks]]
metric = "particles_outside"
maximum = 1
"#;

/// Two particles with speeds u and 3u, and the pressure c T + d, where c and d depend on the replicate.
fn gas_frames(run: &RunManifest) -> Frames {
    let ModelConfig::Gas(config) = &*run.model else { panic!("expected the gas model") };
    let SpeedScale::Temperature(temperature) = config.speed_scale else {
        panic!("expected a temperature")
    };
    let temperature = temperature.get();
    let replicate = f64::from(run.replicate);
    let pressure = (2.0 + replicate) * temperature + 10.0 * replicate;
    let speed = temperature.sqrt();
    frames_of(0..2, |index, frame| {
        let time = 2.0 * f64::from(index);
        // d = 0 and d = 0.6 of the radius: chords of 2 and 1.6.
        frame.push_state(&[0.0, 0.0, speed, 0.0]);
        frame.push_state(&[0.6, 0.0, 0.0, 3.0 * speed]);
        frame.push(&GasPressure {
            measured_since_start_n_per_m: pressure * time / 2.0,
            mean_speed_formula_n_per_m: 3.0 * temperature,
            mean_square_formula_n_per_m: 4.0 * temperature,
            ideal_gas_n_per_m: 4.0 * temperature,
            ..GasPressure::default()
        });
        frame.push(&GasInvariants {
            kinetic_j: 5.0 * (1.0 + 1e-3 * time),
            max_speed_change_relative: 1e-12 * (2.0 - time),
            particles_outside: 1 - index as u64,
            ..GasInvariants::default()
        });
        frame
            .push(&GasCollisions { wall_collisions: 7 * index as u64, ..GasCollisions::default() });
        time
    })
}

#[test]
fn gas_slopes_are_means_over_replicates() {
    let metrics = Folder::write(GAS_SWEEP, gas_frames).metrics();
    // Slopes 2, 3, 4: mean 3, standard error 1/sqrt(3). Intercepts 0, 10, 20.
    metrics.assert_near("pressure_vs_temperature.measured.slope", 3.0, 1e-12);
    let error = metrics.error("pressure_vs_temperature.measured.slope").unwrap();
    assert!((error - 1.0 / 3.0_f64.sqrt()).abs() < 1e-12);
    metrics.assert_near("pressure_vs_temperature.measured.intercept", 10.0, 1e-12);
    let error = metrics.error("pressure_vs_temperature.measured.intercept").unwrap();
    assert!((error - 10.0 / 3.0_f64.sqrt()).abs() < 1e-11);
    // N k_B / A with the exact SI constant, N = 2, r = 1 m.
    let theory = metrics.theory("pressure_vs_temperature.measured.slope").unwrap();
    assert!((theory / (2.0 * 1.380_649e-23 / PI) - 1.0).abs() < 1e-12);
    // <v> = 2 sqrt(T) exactly.
    metrics.assert_near("mean_speed_vs_temperature.exponent", 0.5, 1e-13);
    metrics.assert_near("pressure_vs_temperature.mean_speed_formula.slope", 3.0, 1e-12);
}

#[test]
fn gas_metrics_of_points_and_runs_are_exact() {
    let metrics = Folder::write(GAS_SWEEP, gas_frames).metrics();
    let points = metrics.all("pressure.measured");
    // 3 means over replicates, then 9 runs.
    assert_eq!(points.len(), 12);
    assert_eq!(points[0]["sweep"]["coordinates"]["temperature_k"]["value"], 100);
    assert_eq!(points[0]["sweep"]["coordinates"]["temperature_k"]["unit"], "K");
    assert_eq!(points[0]["sweep"]["replicates"], 3);
    metrics.assert_near("pressure.measured", (200.0 + 310.0 + 420.0) / 3.0, 1e-13);
    // <v^2> = (1 + 9)/2 T.
    let square = 5.0 * 100.0;
    let theory = 2.0 * 1e-26 * square / (2.0 * PI);
    assert!((metrics.theory("pressure.measured").unwrap() / theory - 1.0).abs() < 1e-12);
    let run = points[3];
    assert_eq!(run["run"]["replicate"], 0);
    let expected = 1.0 / (square.sqrt() * 2.0 * 2.0) * theory;
    assert!((run["standard_error"].as_f64().unwrap() / expected - 1.0).abs() < 1e-12);
    metrics.assert_near("mean_speed", 20.0, 1e-14);
    metrics.assert_near("rms_speed", square.sqrt(), 1e-14);
    metrics.assert_near("mean_velocity", 10.0_f64.hypot(30.0) / 2.0, 1e-14);
    metrics.assert_near("temperature.mean_square", 1e-26 * square / (2.0 * 1.380_649e-23), 1e-12);
    metrics.assert_near("temperature.mean_speed", 1e-26 * 400.0 / (2.0 * 1.380_649e-23), 1e-12);
    metrics.assert_near("wall_collision_rate", 3.5, 1e-14);
    let theory = metrics.theory("wall_collision_rate").unwrap();
    assert!((theory / (2.0 * 2.0 * 20.0 / PI) - 1.0).abs() < 1e-13);
    metrics.assert_near("energy.drift_relative", 2e-3, 1e-12);
    metrics.assert_near("max_speed_change_relative", 2e-12, 1e-15);
    metrics.assert_near("particles_outside", 1.0, 0.0);
}

/// Law: in gravity, kinetic energy becomes potential energy, so its change is no drift of the energy; the pressure depends on the height,
/// so that there is none of an ideal gas. Control: without gravity, both have values.
#[test]
fn kinetic_energy_is_not_the_energy_and_the_pressure_not_uniform_in_gravity() {
    let manifest = GAS_SWEEP.replace("[model.gas]", "[model.gas]\ngravity_m_per_s2 = 9.81");
    let metrics = Folder::write(&manifest, gas_frames).metrics();
    assert_eq!(metrics.all("energy.drift_relative").len(), 0);
    assert_ne!(metrics.all("particles_outside").len(), 0);
    let pressure = metrics.first("pressure.ideal_gas");
    let reason = "in gravity, the pressure depends on the height";
    assert!(pressure["value"].is_null() && pressure["reason"] == reason, "{pressure}");
    let control = Folder::write(GAS_SWEEP, gas_frames).metrics();
    assert_ne!(control.all("energy.drift_relative").len(), 0);
    assert!(control.value("pressure.ideal_gas") > 0.0);
}

/// Guarantee: the temperature at the start, by the definition of the manifest, and the radius are those of the recording, and the theory is the temperature
/// of the manifest. Control: a recording with other values than its manifest has these, and not those of the manifest or of the last frame.
#[test]
fn temperature_at_the_start_and_radius_of_a_gas_are_those_recorded() {
    let manifest = |definition: &str| {
        format!(
            "name = \"gas\"\n[model.gas]\nparticles = 5\ntemperature_k = 300.0\ntemperature_definition = \"{definition}\"\nduration_s = 1.0\n[record]\nframes = 1\nchannels = [\"temperature\", \"energy_balance\"]\n"
        )
    };
    let metrics = |definition: &str, start: f64, radius_m: f64| {
        let frames = move |_: &RunManifest| {
            frames_of(0..2, |index, frame| {
                frame.push(&GasTemperature {
                    mean_square_temperature_k: start + 50.0 * f64::from(index),
                    mean_speed_temperature_k: start - 20.0,
                    ..GasTemperature::default()
                });
                frame.push(&GasEnergyBalance { radius_m, ..GasEnergyBalance::default() });
                f64::from(index)
            })
        };
        Folder::write(&manifest(definition), frames).metrics()
    };
    let as_given = metrics("mean-square", 300.0, 1.0);
    as_given.assert_near("temperature.start", 300.0, 0.0);
    as_given.assert_near("container_radius", 1.0, 0.0);
    metrics("mean-speed", 320.0, 1.0).assert_near("temperature.start", 300.0, 0.0);
    let control = metrics("mean-square", 375.0, 1.1);
    control.assert_near("temperature.start", 375.0, 0.0);
    control.assert_near("container_radius", 1.1, 0.0);
    assert_eq!(control.theory("temperature.start"), Some(300.0));
}

/// Law: the granular temperature at the start of N discs with drawn velocities is std^2 (N - 1)/N on average, and scatters by that over
/// sqrt(N - 1). Source: chi-square distribution. Control: the value is that of the first frame, and the theory does not follow it.
#[test]
fn granular_temperature_at_the_start_is_compared_with_that_of_drawn_velocities() {
    let manifest = "name = \"dem\"\n[model.dem]\ndiscs = 10\nvelocity_std_m_per_s = 0.5\nduration_s = 1.0\n[record]\nframes = 1\nchannels = [\"temperature\"]\n";
    for start in [0.2, 0.3] {
        let frames = move |_: &RunManifest| {
            frames_of(0..2, |index, frame| {
                frame.push(&DemTemperature {
                    granular_temperature_m2_per_s2: start - 0.1 * f64::from(index),
                    ..DemTemperature::default()
                });
                f64::from(index)
            })
        };
        let metrics = Folder::write(manifest, frames).metrics();
        metrics.assert_near("granular_temperature.start", start, 0.0);
        metrics.assert_near("granular_temperature", start - 0.1, 1e-15);
        let theory = metrics.theory("granular_temperature.start").unwrap();
        assert!((theory - 0.225).abs() < 1e-15, "{theory}");
        let error = metrics.error("granular_temperature.start").unwrap();
        assert!((error - 0.075).abs() < 1e-15, "{error}");
    }
}

/// Guarantee: points of a sweep that have the same seed and replicates are reported as correlated, in the folded notes and with `--all`:
/// neither in a plot nor in a brief text, because it concerns all sweeps alike. Control: a single point is not.
#[test]
fn points_that_share_random_streams_are_reported_as_correlated() {
    const REMARK: &str = "the points use the same random numbers: their errors may have a common part, which cancels in differences between points";
    let read = |folder: &Folder, file: &str| {
        assert_eq!(analyze(&[folder.name()]).code, 0);
        std::fs::read_to_string(folder.path().join(file)).unwrap()
    };
    let sweep = Folder::write(GAS_SWEEP, gas_frames);
    assert!(read(&sweep, "report.html").contains(&format!("<li>{REMARK}</li>")));
    assert!(!read(&sweep, "pressure_vs_temperature.svg").contains(&REMARK[..30]));
    let words = |arguments: &[&str]| {
        analyze(arguments).text.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    assert!(words(&[sweep.name(), "--all"]).contains(REMARK));
    let brief = words(&[sweep.name()]);
    assert!(!brief.contains(&REMARK[..30]) && brief.contains("and 1 note as well"), "{brief}");
    let point = GAS_SWEEP.replace("[100.0, 200.0, 400.0]", "[100.0]");
    let point = Folder::write(&point, gas_frames);
    assert!(!read(&point, "report.html").contains(REMARK), "control");
}

#[test]
fn gas_pressure_falls_with_the_square_of_the_radius() {
    let manifest = GAS_SWEEP
        .replace(
            r#""model.gas.temperature_k" = [100.0, 200.0, 400.0]"#,
            r#""model.gas.radius_m" = [0.5, 1.0, 4.0]
"model.gas.mass_kg" = [1e-26, 2e-26]"#,
        )
        .replace("[record]", "temperature_k = 100.0\n[record]");
    let folder = Folder::write(&manifest, |run| {
        let ModelConfig::Gas(config) = &*run.model else { panic!("expected the gas model") };
        let mut frames = gas_frames(run);
        // The exponent is -2 for the light gas and -2.5 for the heavy one.
        let heavy = config.mass_kg.get() > 1.5e-26;
        for (clock, frame) in &mut frames {
            frame.clear();
            let measured = config.radius_m.get().powf(if heavy { -2.5 } else { -2.0 });
            frame.push_state(&[0.0, 0.0, 1.0, 0.0]);
            frame.push(&GasPressure {
                measured_since_start_n_per_m: measured * clock.time,
                ..GasPressure::default()
            });
            frame.push(&GasInvariants::default());
            frame.push(&GasCollisions::default());
        }
        frames
    });
    let metrics = folder.metrics();
    let exponents = metrics.all("pressure_vs_radius.measured.exponent");
    assert_eq!(exponents.len(), 2);
    for (exponent, (mass, expected)) in exponents.iter().zip([(1e-26, -2.0), (2e-26, -2.5)]) {
        assert_eq!(exponent["sweep"]["coordinates"]["mass_kg"]["value"], mass);
        assert_eq!(exponent["sweep"]["along"], "radius_m");
        assert!((exponent["value"].as_f64().unwrap() - expected).abs() < 1e-12);
        assert_eq!(exponent["theory"]["value"], -2.0);
    }
}

pub(crate) const DROP: &str = r#"
name = "drop"
[model.dem]
discs = 1
width_m = 0.01
height_m = 0.3
mass_kg = 1e-3
radius_m = 5e-4
restitution = 0.8
stiffness_n_per_m = 5e4
placement = { positions_m = [[0.005, 0.1005]], velocities_m_per_s = [[0, 0]] }
duration_s = 0.6
[record]
frames = 300
channels = ["state", "energy", "contact_statistics", "temperature"]
"#;

/// An instantaneous rebound with e = 0.8 after a fall of 0.1 m.
pub(crate) fn drop_frames(_: &RunManifest) -> Frames {
    const GRAVITY: f64 = 9.81;
    let energy_at = |flight: i32| 1e-3 * GRAVITY * 0.1 * 0.64_f64.powi(flight);
    let fall = (0.2_f64 / GRAVITY).sqrt();
    frames_of(0..=300, |index, frame| {
        let time = 0.6 * f64::from(index) / 300.0;
        let (mut flight, mut start) = (0, -fall);
        let speed_after = |flight: i32| (2.0 * GRAVITY * 0.1).sqrt() * 0.8_f64.powi(flight);
        while time > start + 2.0 * speed_after(flight) / GRAVITY {
            start += 2.0 * speed_after(flight) / GRAVITY;
            flight += 1;
        }
        let since = time - start;
        let gap = speed_after(flight) * since - GRAVITY * since * since / 2.0;
        let velocity = speed_after(flight) - GRAVITY * since;
        let kinetic = 1e-3 * velocity * velocity / 2.0;
        frame.push_state(&[0.005, 5e-4 + gap, 0.0, velocity]);
        frame.push(&DemEnergy {
            kinetic_j: kinetic,
            gravitational_j: 1e-3 * GRAVITY * (gap + 5e-4),
            dissipated_j: energy_at(0) - energy_at(flight) + 1e-6 * time,
            ..DemEnergy::default()
        });
        frame.push(&DemContactStatistics {
            max_overlap_over_radius: if flight == 1 { 0.2 } else { 0.1 },
            coordination_number: 0.5,
            ..DemContactStatistics::default()
        });
        frame.push(&DemTemperature {
            granular_temperature_m2_per_s2: time,
            ..DemTemperature::default()
        });
        time
    })
}

#[test]
fn dem_drop_has_the_given_restitution_and_energy_balance() {
    let metrics = Folder::write(DROP, drop_frames).metrics();
    metrics.assert_near("restitution.measured", 0.8, 1e-9);
    assert_eq!(metrics.theory("restitution.measured"), Some(0.8));
    let start = 1e-3 * 9.81 * 0.1005;
    // Planted error: the dissipated energy grows by 1e-6 J per second too fast.
    metrics.assert_near("energy.residual_relative", 0.6e-6 / start, 1e-8);
    metrics.assert_near("energy.max_residual_relative", 0.6e-6 / start, 1e-8);
    let dissipated = metrics.value("energy.dissipated") - 0.6e-6;
    metrics.assert_near("energy.total_change_relative", -dissipated / start, 1e-10);
    metrics.assert_near("energy.kinetic_disagreement_relative", 0.0, 1e-12);
    metrics.assert_near("max_overlap_over_radius", 0.2, 0.0);
    metrics.assert_near("coordination_number", 0.5, 0.0);
    metrics.assert_near("granular_temperature", 0.6, 0.0);
    metrics.assert_near("packing_fraction", PI * 25e-8 / 3e-3, 1e-12);
}

/// Control: an energy balance that contradicts the state is found.
#[test]
fn control_contradicting_energy_balance_is_found() {
    let folder = Folder::write(DROP, |run| {
        let mut frames = drop_frames(run);
        for (_, frame) in &mut frames {
            let state = [frame.state()[0], frame.state()[1], 1.0, frame.state()[3]];
            let (energy, contacts) =
                (frame.get::<DemEnergy>().unwrap(), frame.get::<DemContactStatistics>());
            let temperature = frame.get::<DemTemperature>().unwrap();
            frame.clear();
            frame.push_state(&state);
            frame.push(&energy);
            frame.push(&contacts.unwrap());
            frame.push(&temperature);
        }
        frames
    });
    let expected = 0.5e-3 / (1e-3 * 9.81 * 0.1005);
    folder.metrics().assert_near("energy.kinetic_disagreement_relative", expected, 1e-9);
}

/// Law: N (1 - exp(-t/tau)) particles leave a well mixed gas within t, with 1/tau = <v> w/(pi A) (Knudsen's flux n <v>/pi in two dimensions).
///
/// Guarantee: the answer and the plot compare with this law. Setup: t/tau = 10/pi^2. Control: at the constant rate of the start, all would
/// have left.
#[test]
fn gas_that_empties_is_compared_with_the_law_of_its_plot() {
    let manifest = "[model.gas]\nparticles = 1000\norifice_width_m = 0.5\nduration_s = 10\n[record]\nframes = 1\n";
    let left: f64 = 1000.0 * (1.0 - (-10.0 / PI / PI).exp());
    let folder = Folder::write(manifest, |_| {
        frames_of(0..2, |index, frame| {
            frame.push_state(&[0.0, 0.0, 2.0, 0.0]);
            let temperature = GasTemperature::default();
            frame.push(&GasTemperature { mean_speed_m_per_s: 2.0, ..temperature });
            let particles_escaped = 637 * index as u64;
            frame.push(&GasEnergyBalance { particles_escaped, ..GasEnergyBalance::default() });
            10.0 * f64::from(index)
        })
    });
    let theory = folder.metrics().theory("effusion_rate").unwrap();
    assert!((theory - left / 10.0).abs() < 1e-9, "{theory}");
    let page = folder.page().replace(['\u{a0}', '\n'], " ");
    let answer = "63.7 ± 2.5 per second</strong>, which agrees with the 63.7 per second of kinetic theory within its standard error.";
    assert!(page.contains(answer), "the answer");
    let (_, curve) = page.split_once("\"kinetic theory, N (1 − exp(−t/τ))").unwrap();
    let curve = curve.split('}').next().unwrap();
    assert!(curve.contains(&left.to_string()[..6]), "{curve}");
}
