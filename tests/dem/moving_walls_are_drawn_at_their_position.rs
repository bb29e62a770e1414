//! Promise: a wall that moves is drawn where it is in every frame; walls at rest are drawn once, with the start.
//!
//! Setup: a gate that rises with 0.1 m/s from 0.02 s to 0.05 s, x = u (t - 0.02 s), no longer than that; seen after 0.04 s
//! and at the end. Tolerance: rounding of one product. Control: the gate at rest is in no frame.

use crate::scene::{frame, run_to_time};
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_manifest::parse;
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::Model;
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::scenery::Wall;

fn run(motion: &str) -> Dem {
    let manifest = format!(
        "[model.dem]\ndiscs = 1\nwidth_m = 0.02\nheight_m = 0.04\nduration_s = 0.06\nregion_m = [[0, 0], [0.01, 0.04]]\n\
         walls = [{{ from_m = [0.012, 0.0], to_m = [0.012, 0.02]{motion} }}]\n"
    );
    let experiment = parse(&manifest, "gate.toml", &[]).unwrap_or_else(|errors| panic!("{errors}"));
    let ModelConfig::Dem(config) = &experiment.runs[0].manifest.model else {
        panic!("not a DEM run")
    };
    let seed = Seed { seed: 1, replicate: 0 };
    Dem::prepare(config, seed, false).unwrap_or_else(|refusal| panic!("{refusal}"))
}

#[test]
fn a_gate_is_drawn_where_it_is() {
    let mut model = run(", velocity_m_per_s = [0.0, 0.1], moves_s = [0.02, 0.05]");
    for (time, risen) in [(0.0, 0.0), (0.04, 0.002), (0.06, 0.003)] {
        run_to_time(&mut model, time);
        let shown = frame(&model);
        let [Wall::Rectangle { .. }, Wall::Segment { from, to }] = shown.walls() else {
            panic!("at {time} s: {:?}", shown.walls())
        };
        // A frame is at a whole step.
        let expected = if risen > 0.0 && time < 0.05 { 0.1 * (model.time() - 0.02) } else { risen };
        assert!((from[1] - expected).abs() < 1e-15, "at {time} s: {}", from[1]);
        assert!((to[1] - from[1] - 0.02).abs() < 1e-15);
    }
}

#[test]
fn control_a_wall_at_rest_is_in_no_frame() {
    assert_eq!(frame(&run("")).walls(), []);
}
