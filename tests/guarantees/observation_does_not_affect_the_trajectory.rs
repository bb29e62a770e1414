//! Guarantee: observation does not affect the trajectory.
//!
//! Setup: each small experiment is observed at every frame, at a few frames and at the last frame only, with and without
//! per-collision series. The final states must be bitwise identical.
//! Control: a change of one bit is found.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::small_experiments::{MANIFESTS, Taking, bits, run_of, trajectory};

#[test]
fn final_state_does_not_depend_on_observation() {
    for (name, manifest) in MANIFESTS {
        let run = run_of(name, manifest);
        let often = trajectory(&run, Taking::PLAIN);
        let end = bits(often.last().unwrap());
        assert!(!end.is_empty(), "{name}: no state");
        for taking in [
            Taking { look_at_all: false, ..Taking::PLAIN },
            Taking { frames: Some(3), ..Taking::PLAIN },
            Taking { frames: Some(1), look_at_all: false, ..Taking::PLAIN },
            Taking { per_collision: true, ..Taking::PLAIN },
        ] {
            let seldom = trajectory(&run, taking);
            assert!(
                end == bits(seldom.last().unwrap()),
                "{name}: observation changes the final state"
            );
        }
    }
}

#[test]
fn control_a_change_of_one_bit_is_found() {
    let (name, manifest) = MANIFESTS[0];
    let run = run_of(name, manifest);
    let mut other = run.clone();
    other.seed += 1;
    let end = |run| bits(trajectory(run, Taking::PLAIN).last().unwrap());
    assert!(end(&run) != end(&other));
}
