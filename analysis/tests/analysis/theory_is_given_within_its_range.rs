//! Guarantee: a theoretical value is compared only within the range that its law states, and belongs to the materials, the noise and
//! the density of the run.
//!
//! Setup: frames made by hand, whose measured values do not matter here.
//! Control: the same frames within the range.
#![allow(missing_docs, reason = "tests")]

use crate::gas_and_dem_metrics_equal_closed_forms::{DROP, drop_frames};
use crate::orbit_exercise::START;
use crate::synthetic::{Folder, Frames, Metrics};
use kinetoscope_manifest::RunManifest;
use kinetoscope_recording::channels::{
    DemEnergy, GasPressure, GasSpeeds, PackingCollisions, PackingPressure, PackingTemperature,
};
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::recorder::Clock;

/// Whether the theoretical value of a metric is in the range of its law; `None` without one.
fn is_in_range(metrics: &Metrics, name: &str) -> Option<bool> {
    metrics.first(name)["theory"]["in_range"].as_bool()
}

const OF_CONTACTS: [&str; 2] = ["restitution.measured", "contact_duration.measured"];

#[test]
fn coarse_time_step_is_out_of_range_of_the_contact_laws() {
    let with_steps = |steps: &str| {
        let keys =
            format!("steps_per_wall_contact = {steps}\non_unstable_time_step = \"warn\"\n[record]");
        Folder::write(&DROP.replace("[record]", &keys), drop_frames).metrics()
    };
    for name in OF_CONTACTS {
        assert_eq!(is_in_range(&with_steps("2"), name), Some(false), "{name}");
        assert_eq!(is_in_range(&with_steps("10"), name), Some(true), "control");
    }
}

/// Guarantee: a metric outside the range of its law names the condition that fails, with the value and the limit.
/// Setup: two steps per contact without damping, so that Δt over the duration is 1/2. Control: with ten steps, no condition is named.
#[test]
fn reason_names_the_condition_that_fails_and_its_value() {
    let reason = |steps: &str| {
        let keys =
            format!("steps_per_wall_contact = {steps}\non_unstable_time_step = \"warn\"\n[record]");
        let elastic = DROP.replace("restitution = 0.8", "restitution = 1.0");
        let metrics = Folder::write(&elastic.replace("[record]", &keys), drop_frames).metrics();
        metrics.first("contact_duration.measured")["reason"].as_str().unwrap_or_default().to_owned()
    };
    let stated = "the run is outside the range of its law: Δt over the duration of a contact is 0.5, above 0.1 (range: a time step of";
    assert!(reason("2").contains(stated), "{}", reason("2"));
    assert!(!reason("10").contains("outside the range"), "{}", reason("10"));
}

#[test]
fn restitution_is_compared_with_that_of_the_materials() {
    let with = |keys: &str| {
        Folder::write(&DROP.replace("[record]", &format!("{keys}\n[record]")), drop_frames)
            .metrics()
    };
    let wall = with("contact_pairs = [{ between = [\"disc\", \"wall\"], restitution = 0.4 }]");
    assert_eq!(wall.theory("restitution.measured"), Some(0.4));
    let ambiguous = with("materials = [{ name = \"a\" }, { name = \"b\", restitution = 0.1 }]");
    for name in OF_CONTACTS {
        assert_eq!(ambiguous.theory(name), None, "{name}");
    }
    assert_eq!(with("").theory("restitution.measured"), Some(0.8), "control");
}

fn packing_frames(_: &RunManifest) -> Frames {
    (0..5_u32)
        .map(|index| {
            let mut frame = Frame::new();
            let count = u64::from(index) * 1000;
            frame.push(&PackingTemperature { temperature: 1.0, ..PackingTemperature::default() });
            frame.push(&PackingCollisions {
                pair_collisions: count,
                wall_collisions: count,
                ..PackingCollisions::default()
            });
            frame.push(&PackingPressure {
                collision_virial_sum: f64::from(index),
                kinetic_energy_time_integral: f64::from(index),
                ..PackingPressure::default()
            });
            (Clock { count, time: f64::from(index) }, frame)
        })
        .collect()
}

fn packing(keys: &str) -> Metrics {
    let manifest = format!(
        "name = \"packing\"\n[model.packing]\n{keys}\n[record]\nframes = 4\nchannels = [\"temperature\", \"collisions\", \"pressure\"]\n"
    );
    Folder::write(&manifest, packing_frames).metrics()
}

const OF_PACKINGS: [&str; 3] =
    ["wall_collision_rate_per_disc", "pair_collision_rate_per_disc", "compressibility_factor"];

#[test]
fn strong_wall_noise_is_out_of_range_of_equilibrium() {
    for name in OF_PACKINGS {
        let at = |noise: &str| {
            is_in_range(&packing(&format!("wall_noise_variance_rad2 = {noise}")), name)
        };
        assert_eq!(at("0.1"), Some(false), "{name}");
        assert_eq!(at("0.0031415926535897933"), Some(true), "control, the exercise's noise");
    }
}

/// Fewer than 128 cooling discs do not show whether they flow or cluster. Therefore, their rates are not compared with
/// the theory of uniform discs.
#[test]
fn cooling_discs_that_may_cluster_are_out_of_range_of_equilibrium() {
    for name in OF_PACKINGS {
        assert_eq!(is_in_range(&packing("restitution = 0.9"), name), Some(false), "{name}");
        assert_eq!(is_in_range(&packing("restitution = 1.0"), name), Some(true), "control");
    }
}

#[test]
fn discs_denser_than_a_fluid_have_no_theory() {
    let square = |side: &str| {
        packing(&format!("discs = 50\nwidth = {side}\nheight = {side}\nplacement = \"lattice\""))
    };
    for name in OF_PACKINGS {
        assert_eq!(square("15.5").theory(name), None, "{name}");
        assert!(square("40.0").theory(name).is_some(), "control");
    }
}

const FLOOR: &str = r#"
name = "floor"
[model.dem]
discs = 20
mass_kg = 1e-3
radius_m = 5e-4
width_m = 0.02
height_m = 0.02
stiffness_n_per_m = 5e4
[record]
frames = 1
channels = ["state", "energy"]
"#;

#[test]
fn discs_in_the_air_have_no_surface() {
    let with_elastic = |elastic_j: f64| {
        let frames = move |_: &RunManifest| {
            let mut frame = Frame::new();
            for disc in 0..20 {
                let column = f64::from(disc);
                let height = 1e-3 + 2e-3 * (5.0 - (column / 2.0 - 5.0).abs());
                frame.push_state(&[5e-4 + 1e-3 * column, height, 0.0, 0.0]);
            }
            frame.push(&DemEnergy { elastic_j, gravitational_j: 1.0, ..DemEnergy::default() });
            vec![(Clock { count: 0, time: 0.0 }, frame)]
        };
        Folder::write(FLOOR, frames).metrics()
    };
    assert!(with_elastic(0.0).all("bed.surface_angle").is_empty());
    // Control: each disc carries itself, (m g)^2/2k.
    let weight = 1e-3 * 9.81;
    let carried = 20.0 * weight * weight / 1e5;
    assert!(with_elastic(carried).value("bed.surface_angle") > 0.0);
}

/// Frames of a planet at 1 AU that moves at these speeds, AU/d.
fn orbit(speeds: [f64; 2]) -> Metrics {
    let manifest = "name = \"orbit\"\n[model.orbit]\nintegrator = \"velocity-verlet\"\n";
    let frames = move |_: &RunManifest| {
        let at = |(time, speed): (f64, f64)| {
            let mut frame = Frame::new();
            frame.push_state(&[1.0, 0.0, 0.0, 0.0, speed, 0.0]);
            (Clock { count: time as u64, time }, frame)
        };
        [(0.0, speeds[0]), (1.0, speeds[1])].map(at).into()
    };
    Folder::write(manifest, frames).metrics()
}

#[test]
fn orbits_that_leave_the_sun_are_compared_or_explained() {
    let ejected = orbit([0.002, 0.04]);
    assert_eq!(ejected.theory("energy.drift_relative"), Some(0.0));
    assert!(ejected.value("energy.drift_relative") > 1.0);
    let hyperbolic = orbit([0.04, 0.04]);
    let position = hyperbolic.first("position_error.final");
    assert!(position["reason"].as_str().is_some_and(|reason| reason.contains("not an ellipse")));
    assert_eq!(hyperbolic.theory("energy.drift_relative"), Some(0.0));
    assert!(ejected.value("position_error.final").is_finite(), "control");
}

/// The mean speed of a single particle is its root mean square speed.
#[test]
fn mean_speed_of_one_particle_is_its_speed() {
    let of = |particles: u32| {
        let manifest = format!(
            "name = \"gas\"\n[model.gas]\nparticles = {particles}\ntemperature_k = 300.0\n"
        );
        let frames = |_: &RunManifest| crate::synthetic::two_frames(&GasPressure::default());
        let metrics = Folder::write(&manifest, frames).metrics();
        metrics.theory("mean_speed").unwrap() / metrics.theory("rms_speed").unwrap()
    };
    assert!((of(1) - 1.0).abs() < 1e-12);
    assert!(of(100_000) < 0.9, "control: many particles");
}

/// Two thousand particles, half of them with the second speed, m/s, behind a partition that was removed 0.1 s ago.
fn expanded(slow: f64) -> Metrics {
    let manifest = "name = \"gas\"\n[model.gas]\nparticles = 2000\npartition_x_m = 0.0\npartition_opens_s = 0.01\nduration_s = 0.11\n[record]\nframes = 1\n";
    let frames = move |_: &RunManifest| {
        let at = |(time, side): (f64, f64)| {
            let mut frame = Frame::new();
            for particle in 0..2000 {
                let speed = if particle % 2 == 0 { 1300.0 } else { slow };
                let sign = if particle % 4 < 2 { -1.0 } else { side };
                frame.push_state(&[sign * 0.5, 0.0, speed, 0.0]);
            }
            (Clock { count: time as u64, time }, frame)
        };
        [(0.0, -1.0), (0.11, 1.0)].map(at).into()
    };
    Folder::write(manifest, frames).metrics()
}

/// Source: particles at 20 m/s cross a container of 2 m once in 0.1 s. Control: particles at 1300 m/s.
#[test]
fn entropy_is_not_compared_while_slow_particles_have_not_moved() {
    assert_eq!(is_in_range(&expanded(20.0), "box_entropy.change"), Some(false));
    assert_eq!(is_in_range(&expanded(1300.0), "box_entropy.change"), Some(true), "control");
}

/// All speeds of a gas at 300 K lie in the first of 30 bins up to 40 km/s: Maxwell's density at the middle of that bin is almost zero.
#[test]
fn maxwells_speeds_are_compared_by_the_integral_of_a_bin() {
    let of = |width: f64| {
        let manifest = "name = \"gas\"\n[model.gas]\nparticles = 2000\ngravity_m_per_s2 = 4e8\nposition_distribution = \"barometric\"\n[record]\nframes = 1\n";
        // <v^2> = 2 k_B T/m with the manifest's defaults.
        let square = 2.0 * 1.380_649e-23 * 300.0 / 1e-26;
        let frames = move |_: &RunManifest| {
            let middles: Vec<f64> = (0..30).map(|bin| (f64::from(bin) + 0.5) * width).collect();
            let below = |speed: f64| 1.0 - libm::exp(-speed * speed / square);
            let fraction = |middle: &f64| below(middle + width / 2.0) - below(middle - width / 2.0);
            let maxwell = |v: &f64| 2.0 * v / square * libm::exp(-v * v / square);
            let speeds = GasSpeeds {
                density: middles.iter().map(|speed| fraction(speed) / width).collect(),
                initial_distribution: middles.iter().map(maxwell).collect(),
                speed_m_per_s: middles,
                speed_over_rms: vec![0.0; 30],
                density_times_rms: vec![0.0; 30],
                initial_distribution_times_rms: vec![0.0; 30],
                maxwell_times_rms: vec![0.0; 30],
                maxwell: vec![0.0; 30],
            };
            let at = |time: f64| {
                let mut frame = Frame::new();
                frame.push(&speeds);
                (Clock { count: time as u64, time }, frame)
            };
            [0.0, 1.0].map(at).into()
        };
        Folder::write(manifest, frames).metrics()
    };
    for width in [76.0, 700.0] {
        let metrics = of(width);
        let name = "speed_histogram.chi_square_per_bin";
        assert!(metrics.value(name) < 1e-6, "{width}: {}", metrics.value(name));
    }
}

/// Guarantee: no plot shows theory outside the range of its law. Setup: a requested plot, the plot of any metric, and the energy of explicit
/// Euler. Control: within the range, all three show it.
#[test]
fn plots_show_theory_within_its_range_only() {
    let manifest = |steps: &str, plots: &str| {
        let sweep = DROP.replace(
            "[record]",
            &format!(
                "steps_per_wall_contact = {steps}\non_unstable_time_step = \"warn\"\n[record]"
            ),
        ) + "[sweep]\n\"model.dem.mass_kg\" = [1e-3, 2e-3]\n";
        sweep + plots + "[[checks]]\nmetric = \"restitution.measured\"\nminimum = 0\n"
    };
    let requested = |steps: &str| {
        let plot = "[[plots]]\ny = \"restitution.measured\"\n";
        let folder = Folder::write(&manifest(steps, plot), drop_frames);
        let _ = folder.metrics();
        let page = folder.page();
        let svg = std::fs::read_to_string(folder.path().join("restitution_measured_vs_mass.svg"))
            .expect("a plot");
        let data = page.split("class=\"sweep\">").nth(1).expect("data of the sweep");
        let data = data.split("</script>").next().expect("its end");
        let data: serde_json::Value = serde_json::from_str(data).expect("JSON");
        let metrics = data["metrics"].as_array().expect("metrics");
        let metric = metrics.iter().find(|metric| metric["name"] == "Measured restitution");
        let in_sweep = !metric.expect("the metric")["t"].as_array().expect("a list").is_empty();
        [svg.contains("theory"), in_sweep]
    };
    // Without a requested plot, the result is the metric of the check.
    let result_states_the_range = |steps: &str| {
        let folder = Folder::write(&manifest(steps, ""), drop_frames);
        let _ = folder.metrics();
        let page = folder.page();
        let result = page.split("class=\"result\"").nth(1).expect("a result");
        let result = result.split("</p>").next().expect("its end");
        assert!(!result.contains("deviation out of range"), "{result}");
        result.contains(", outside the range of its law")
    };
    assert!(result_states_the_range("2") && !result_states_the_range("10"));
    assert_eq!(requested("2"), [false, false]);
    assert_eq!(requested("10"), [true, true], "control");
    let euler = |step: &str| {
        let manifest = format!(
            "name = \"euler\"\n[model.orbit]\nduration_days = 400.0\nintegrator = \"explicit-euler\"\ntime_step_days = {step}\n[record]\nframes = 2\nchannels = [\"state\"]\n"
        );
        let folder = Folder::write(&manifest, |_| {
            let frame = |index: u32| {
                let mut state = START;
                state[3] *= 1.0 + 1e-3 * f64::from(index);
                let mut frame = Frame::new();
                frame.push_state(&state);
                (Clock { count: index.into(), time: 200.0 * f64::from(index) }, frame)
            };
            (0..3).map(frame).collect()
        });
        let _ = folder.metrics();
        let svg = std::fs::read_to_string(folder.path().join("energy_drift.svg"));
        svg.expect("a plot").contains("first-order theory, 1")
    };
    assert!(!euler("5.0") && euler("0.25"));
}
