//! Guarantee: a moving wall is drawn at its position in every frame; walls at rest are drawn once, in the first message
//! of the recording.
//!
//! Setup: a gate that rises at 0.1 m/s from 0.02 s to 0.05 s, y = u (t - 0.02 s); frames at 0.04 s and at the end.
//! Tolerance: 1e-15 m, the rounding of one product.
//! Control: a gate at rest is in no frame.

use crate::scene::{drum, finite, frame, prepared, run_to_time, scenes};
use kinetoscope_manifest::model::{DemConfig, ModelConfig};
use kinetoscope_manifest::parse;
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::Model;
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::scenery::Wall;
use std::f64::consts::PI;

fn run(motion: &str) -> Dem {
    let manifest = format!(
        "[model.dem]\ndiscs = 1\nwidth_m = 0.02\nheight_m = 0.04\nduration_s = 0.06\nplacement_region_m = [[0, 0], [0.01, 0.04]]\n\
         walls = [{{ from_m = [0.012, 0.0], to_m = [0.012, 0.02]{motion} }}]\n"
    );
    let experiment = parse(&manifest, "gate.toml", &[]).unwrap_or_else(|errors| panic!("{errors}"));
    let ModelConfig::Dem(config) = &*experiment.runs[0].manifest.model else {
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

/// After a quarter of a turn, the mark of a drum that started on the right is at the top. Control: a drum at rest has no mark and
/// is in no frame.
#[test]
fn rotating_drum_has_a_mark_that_turns_with_it() {
    let turning = |spin: f64| DemConfig {
        walls: vec![drum([0.02, 0.02], 0.02, spin)],
        placement_region_m: Some([finite([0.01, 0.01]), finite([0.03, 0.03])]),
        ..DemConfig::default()
    };
    let mut model = prepared(&turning(10.0));
    run_to_time(&mut model, 0.05 * PI);
    let frame_at_quarter = frame(&model);
    let [.., Wall::Segment { from, to }] = frame_at_quarter.walls() else {
        panic!("{:?}", frame_at_quarter.walls())
    };
    // Frames are taken at whole steps.
    let angle = 10.0 * model.time();
    for (end, part) in [(from, 0.94), (to, 1.06)] {
        assert!((end[0] - (0.02 + 0.02 * part * libm::cos(angle))).abs() < 1e-15, "{end:?}");
        assert!((end[1] - (0.02 + 0.02 * part * libm::sin(angle))).abs() < 1e-15, "{end:?}");
    }
    assert!(to[1] > 0.0411);
    let at_rest = prepared(&turning(0.0));
    assert_eq!(frame(&at_rest).walls(), []);
    assert!(!at_rest.scenery().walls.iter().any(|wall| matches!(wall, Wall::Segment { .. })));
}

/// A hopper has curves of discharged discs and their energy, a run with insertion those of inserted discs, and a closed box none.
#[test]
fn curves_of_discs_that_leave_or_enter_are_shown_only_where_they_do() {
    let unused = |name: &str| {
        let scene = scenes().into_iter().find(|scene| scene.0 == name).expect("a scene");
        prepared(&scene.1).scenery().unused_fields
    };
    let [removed, entered] = ["/wall_forces.discs_removed", "/wall_forces.discs_entered"];
    let (hopper, insertion) =
        (unused("hopper"), unused("insertion onto two materials behind a gate"));
    assert!(!hopper.contains(&removed) && hopper.contains(&entered));
    assert!(insertion.contains(&removed) && !insertion.contains(&entered));
    assert!(unused("bed").contains(&removed) && unused("bed").contains(&entered));
    assert!(hopper.contains(&"/energy_percent.wall_work_percent"));
    assert!(!unused("drum").contains(&"/energy_percent.wall_work_percent"));
}
