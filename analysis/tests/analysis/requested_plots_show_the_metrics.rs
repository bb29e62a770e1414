//! Guarantee: the plots that a manifest requests come first in the report and in the list of the written files, with gaps where
//! a run has no value, and a plot that cannot be drawn is noted.

use crate::synthetic::{Folder, Frames, analyze, flat, two_frames};
use kinetoscope_recording::channels::GasPressure;
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::recorder::Clock;
use std::fs;

const SWEEP: &str =
    "[model.gas]\nparticles = 1\n[sweep]\nmodel.gas.temperature_k = [100, 200, 300, 400]\n";

/// The given pressures in one run, a value per frame.
fn pressures(values: &[f64]) -> Frames {
    let frame = |(index, value): (u32, &f64)| {
        let mut frame = Frame::new();
        frame.push_state(&[0.0, 0.0, 1.0, 0.0]);
        frame.push(&GasPressure {
            measured_n_per_m: *value,
            measured_since_start_n_per_m: *value,
            ..GasPressure::default()
        });
        (Clock { count: u64::from(index), time: f64::from(index) }, frame)
    };
    (0..).zip(values).map(frame).collect()
}

#[test]
fn requested_plots_come_first() {
    let plots = "[[plots]]\ny = \"/pressure.measured_n_per_m\"\ntitle = \"First <of> all\"\n\
        [[plots]]\ny = \"pressure.measured\"\nlog = [\"x\"]\n";
    let folder = Folder::write(&format!("{SWEEP}{plots}"), |run| {
        let kinetoscope_manifest::model::ModelConfig::Gas(gas) = &*run.model else { panic!() };
        let value = f64::from(run.replicate) + format!("{gas:?}").len() as f64;
        two_frames(&GasPressure {
            measured_since_start_n_per_m: value,
            measured_n_per_m: value,
            ..GasPressure::default()
        })
    });
    analyze(&[folder.name()]).exited_with(0);
    let html = folder.page();
    let labels: Vec<&str> = html.split("<svg role=\"img\" aria-label=\"").skip(1).collect();
    assert!(labels[0].starts_with("First &lt;of&gt; all\""), "{}", &labels[0][..80]);
    assert!(labels[1].starts_with("Pressure against temperature\""), "{}", &labels[1][..80]);
    for name in ["pressure_measured_n_per_m_vs_time.svg", "pressure_vs_temperature.svg"] {
        assert!(folder.path().join(name).exists(), "{name}");
    }
    // The automatic plot of the same quantities is not drawn as well.
    assert!(!folder.path().join("pressure_vs_temperature_2.svg").exists());
    // Unchanged recordings are not read again, and give the same page.
    assert_eq!(analyze(&[folder.name()]).code, 0);
    assert_eq!(folder.page(), html);
}

/// Setup: NaN in the middle of a series and at its end. Control: without NaN, the line is one.
#[test]
fn value_that_is_not_a_number_is_a_gap() {
    let plots = "[model.gas]\nparticles = 1\n[[plots]]\ny = \"/pressure.measured_n_per_m\"\n";
    let lines = |values: &[f64]| {
        let folder = Folder::write(plots, |_| pressures(values));
        analyze(&[folder.name()]).exited_with(0);
        let path = folder.path().join("pressure_measured_n_per_m_vs_time.svg");
        let svg = fs::read_to_string(path).unwrap();
        let curves =
            svg.lines().filter(|line| line.contains("<polyline") && line.contains("#6C1DC1"));
        curves.count()
    };
    assert_eq!(lines(&[f64::NAN, 1.0, 2.0, f64::NAN, 3.0, 4.0, f64::INFINITY]), 2);
    assert_eq!(lines(&[1.0, 2.0, 3.0, 4.0]), 1);
}

/// Guarantee: the plot of a single run states in its title that there are replicates, so that it does not pass for their mean. Control: a run
/// without replicates has the requested title.
#[test]
fn plot_of_one_replicate_states_their_number() {
    let plots = "[[plots]]\ny = \"/pressure.measured_n_per_m\"\ntitle = \"Pressure\"\n";
    for (replicates, title) in [(1, "Pressure"), (3, "Pressure (one of 3 replicates)")] {
        let manifest = format!("replicates = {replicates}\n[model.gas]\nparticles = 1\n{plots}");
        let folder = Folder::write(&manifest, |_| pressures(&[1.0, 2.0]));
        analyze(&[folder.name()]).exited_with(0);
        let label = format!("aria-label=\"{title}\"");
        assert!(folder.page().contains(&label), "{label}");
    }
}

#[test]
fn plot_that_cannot_be_drawn_is_noted() {
    let plots = "[[plots]]\ny = \"effusion_rate\"\n[[plots]]\ny = \"/collisions.wall_collisions\"\n\
        [[plots]]\ny = \"/pressure.no_field\"\n";
    let pressure = GasPressure { measured_since_start_n_per_m: 1.0, ..GasPressure::default() };
    let folder = Folder::write(&format!("{SWEEP}{plots}"), |_| two_frames(&pressure));
    let output = analyze(&[folder.name()]).exited_with(0);
    let text = flat(&output.text);
    for name in ["effusion_rate", "/collisions.wall_collisions", "/pressure.no_field"] {
        assert!(text.contains(&format!("the plot of `{name}` was not drawn: no")), "{text}");
    }
}

/// Setup: a chart of the model is requested, and the answer is composed from a check of another metric.
#[test]
fn requested_chart_is_in_front_of_the_plot_of_the_answer() {
    let rest = "[[plots]]\nfigure = \"pressure_over_time\"\ntitle = \"Asked for\"\n\
        [[checks]]\nmetric = \"pressure.measured\"\nminimum = 0.0\n";
    let folder = Folder::write(&format!("{SWEEP}{rest}"), |run| {
        let kinetoscope_manifest::model::ModelConfig::Gas(gas) = &*run.model else { panic!() };
        let kinetoscope_manifest::model::SpeedScale::Temperature(kelvin) = gas.speed_scale else {
            panic!()
        };
        let value = kelvin.get();
        pressures(&[f64::NAN, 1.1 * value, 0.9 * value, value])
    });
    analyze(&[folder.name()]).exited_with(0);
    let html = folder.page();
    let labels: Vec<&str> = html.split("<svg role=\"img\" aria-label=\"").skip(1).collect();
    assert!(labels[0].starts_with("Asked for"), "{}", &labels[0][..80]);
    assert!(labels[1].starts_with("Pressure against temperature\""), "{}", &labels[1][..80]);
}

/// Guarantee: below a requested fit stands why the model's own is missing, and why the requested one is. Setup: pressures of 0, which have no power law.
#[test]
fn requested_fit_states_why_a_fit_is_missing() {
    let manifest = "[model.gas]\nparticles = 1\n[sweep]\nmodel.gas.radius_m = [1, 2]\n\
        [[plots]]\ny = \"pressure.measured\"\nfit = \"power\"\nlog = []\n";
    let folder = Folder::write(manifest, |_| two_frames(&GasPressure::default()));
    analyze(&[folder.name()]).exited_with(0);
    let html = folder.page();
    assert!(
        html.contains("the numbers give no exponent of the pressure in the radius, because"),
        "of the model"
    );
    assert!(html.contains("no power law is fitted"), "requested");
}
