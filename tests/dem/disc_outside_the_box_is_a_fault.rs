//! Guarantee: a disc whose center leaves the box ends the run in that step, with its position.
//!
//! Setup: a disc that flies into a corner of walls so soft that they cannot stop it, whatever the direction; m v^2/2 is 4000 times k r^2/2.
//! Control: walls that stop it, of 10^6 times the stiffness.

use crate::scene::{given, positive, prepared, spring};
use kinetoscope_manifest::model::{DemConfig, UnstableTimeStep};
use kinetoscope_physics::model::{Model, Target};

/// What ends a run of a disc with this velocity between walls of this stiffness.
fn fault(stiffness: f64, velocity: [f64; 2]) -> Option<String> {
    let config = DemConfig {
        width_m: positive(0.01),
        height_m: positive(0.01),
        elasticity: spring(stiffness),
        on_unstable_time_step: UnstableTimeStep::Warn,
        ..DemConfig::default()
    };
    let mut model = prepared(&given(config, &[([0.005, 0.005], velocity)]));
    let step = crate::scene::time_step(&model);
    let steps = (0.02 / step) as u64;
    model.advance(Target::Count(steps), u64::MAX).err().map(|fault| fault.to_string())
}

#[test]
fn disc_that_leaves_the_box_is_a_fault() {
    for velocity in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]] {
        let fault_text = fault(1.0, velocity).unwrap_or_else(|| panic!("{velocity:?}: no fault"));
        assert!(fault_text.contains("left the box"), "{fault_text}");
        assert_eq!(fault(1e6, velocity), None, "control");
    }
}
