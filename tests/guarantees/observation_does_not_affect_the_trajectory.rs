//! Promise: looking does not disturb. The state at the end of a run has the same bits whether every frame was looked at,
//! a few, or the last alone, and whether per-collision series were collected.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::small_experiments::{MANIFESTS, Taking, bits, run_of, trajectory};

#[test]
fn the_end_is_the_same_however_often_somebody_looks() {
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
            assert!(end == bits(seldom.last().unwrap()), "{name}: looking changes the end");
        }
    }
}

#[test]
fn the_judge_sees_a_change_of_one_bit() {
    let (name, manifest) = MANIFESTS[0];
    let run = run_of(name, manifest);
    let mut other = run.clone();
    other.seed += 1;
    let end = |run| bits(trajectory(run, Taking::PLAIN).last().unwrap());
    assert!(end(&run) != end(&other));
}
