//! Law: the position error after a fixed time is proportional to the order-th power of the step, where the phase error is small, the
//! error is well above rounding, and the order no longer changes from step to step. Other runs are named and not used.
//!
//! Source: Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.3; Yoshida, Phys. Lett. A 150 (1990) 262.
//! Setup: the start of the orbit exercise over ten years with steps from 1 day to 1/24 day, by integrators written here.
//! Tolerance: 0.02.
//! Control: explicit Euler and RK4 over ten years have no order; a line through all errors gives 0.2 and 4.3.
#![allow(clippy::disallowed_methods, reason = "closed forms need std's maths")]

use crate::orbit_exercise::{START, step};
use crate::synthetic::{Folder, Frames, analyze, flat};
use kinetoscope_manifest::RunManifest;
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_recording::channels::OrbitElements;
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::recorder::Clock;

/// Period, days.
const PERIOD: f64 = 362.073_107_968_315_9;

/// First and last frame, with the whole turns of the phase error.
fn frames(run: &RunManifest) -> Frames {
    let ModelConfig::Orbit(config) = &*run.model else { panic!("expected the orbit model") };
    let h = config.time_step_days.get();
    let steps = (config.duration_days.get() / h + 1e-9).floor() as u64;
    let (mut state, mut angle) = (START, 0.0);
    let mut frames = Vec::new();
    for count in 0..=steps {
        let time = count as f64 * h;
        if count == 0 || count == steps {
            let mut frame = Frame::new();
            frame.push_state(&state);
            let phase_error_rad = angle - std::f64::consts::TAU * time / PERIOD;
            frame.push(&OrbitElements {
                phase_error_rad,
                min_radius_au: 1.0,
                ..OrbitElements::default()
            });
            frames.push((Clock { count, time }, frame));
        }
        let before = state;
        step(config.integrator, &mut state, h);
        let across = before[0] * state[1] - before[1] * state[0];
        angle += across.atan2(before[0] * state[0] + before[1] * state[1]);
    }
    frames
}

fn sweep(integrators: &[&str], days: f64) -> Folder {
    let mut manifest = format!(
        "name = \"order\"\n[model.orbit]\nstart = \"barycentric\"\nduration_days = {days}\n[record]\nframes = 1\n[sweep]\n\
         \"model.orbit.time_step_days\" = [1.0, 0.5, 0.25, 0.125, 0.08333333333333333, 0.041666666666666664]\n"
    );
    for integrator in integrators {
        manifest += &format!(
            "[[sweep.variants]]\nname = \"{integrator}\"\n\"model.orbit.integrator\" = \"{integrator}\"\n"
        );
    }
    Folder::write(&manifest, frames)
}

#[test]
fn orders_over_ten_years_are_exact_or_absent() {
    let folder = sweep(&["explicit-euler", "velocity-verlet", "rk4", "yoshida4"], 3652.0);
    let output = analyze(&[folder.name()]).exited_with(0);
    let metrics = folder.written();
    let orders = metrics.all("convergence.order");
    for order in &orders {
        println!("{} {}", order["sweep"]["coordinates"], order["value"]);
    }
    for (order, (variant, expected)) in
        orders.iter().zip([("velocity-verlet", 2.0), ("yoshida4", 4.0)])
    {
        assert_eq!(order["sweep"]["coordinates"]["variant"]["value"], variant);
        assert!((order["value"].as_f64().unwrap() - expected).abs() < 0.02, "{order}");
    }
    assert_eq!(orders.len(), 2, "{}", output.text);
    let text = flat(&output.text);
    assert!(text.contains("runs are in the asymptotic range"), "{text}");
    assert!(text.contains("time_step_days = 1 (phase error"), "{text}");
    assert!(text.contains("the order still changes"), "{text}");
}

/// Over a tenth of a revolution, all phase errors are small, and the next term of each error is below 1 %.
#[test]
fn orders_over_a_tenth_of_a_revolution_are_one_two_and_four() {
    let folder = sweep(&["explicit-euler", "velocity-verlet", "rk4", "yoshida4"], 36.0);
    let metrics = folder.metrics();
    let orders = metrics.all("convergence.order");
    for order in &orders {
        println!("{} {}", order["sweep"]["coordinates"], order["value"]);
    }
    assert_eq!(orders.len(), 4);
    for (order, expected) in orders.iter().zip([1.0, 2.0, 4.0, 4.0]) {
        assert!((order["value"].as_f64().unwrap() - expected).abs() < 0.02, "{order}");
    }
}
