//! Guarantee: a moving wall is drawn at its position in every frame; walls at rest are drawn once, in the first message
//! of the recording.
//!
//! Setup: a gate that rises at 0.1 m/s from 0.02 s to 0.05 s, y = u (t - 0.02 s); frames at 0.04 s and at the end.
//! Tolerance: 1e-15 m, the rounding of one product.
//! Control: a gate at rest is in no frame.

use crate::scene::{frame, run_to_time};
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_manifest::parse;
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::Model;
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::scenery::Wall;

fn run(motion: &str) -> Dem {
    let manifest = format!(
        "[model.dem]\ndiscs = 1\nwidth_m = 0.02\nheight_m = 0.04\nduration_s = 0.06\nplacement_region_m = [[0, 0], [0.01, 0.04]]\n\
         walls = [{{ from_m = [0.012, 0.0], to_m = [0.012, 0.02]{motion} }}]\n"
    );
    let experiment = parse(&manifest, "gate.toml", &[]).unwrap_or_else(|errors| panic!("{errors}"));
    let ModelConfig::Dem(config) = &experiment.runs[0].manifest.model else {
        panic!("not a DEM run")
    };
    let seed = Seed { seed: 1, replicate: 0 };
    Dem::prepare(config, seed, false).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn moving_gate_is_drawn_at_its_position() {
    let mut model = run(", velocity_m_per_s = [0.0, 0.1], moves_s = [0.02, 0.05]");
    for (time, rise) in [(0.0, 0.0), (0.04, 0.002), (0.06, 0.003)] {
        run_to_time(&mut model, time);
        let frame = frame(&model);
        let [Wall::Rectangle { .. }, Wall::Segment { from, to }] = frame.walls() else {
            panic!("at {time} s: {:?}", frame.walls())
        };
        // Frames are recorded at whole steps.
        let expected = if rise > 0.0 && time < 0.05 { 0.1 * (model.time() - 0.02) } else { rise };
        assert!((from[1] - expected).abs() < 1e-15, "at {time} s: {}", from[1]);
        assert!((to[1] - from[1] - 0.02).abs() < 1e-15);
    }
}

#[test]
fn control_wall_at_rest_is_in_no_frame() {
    assert_eq!(frame(&run("")).walls(), []);
}
