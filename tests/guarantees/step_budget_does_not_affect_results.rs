//! Guarantee: the step budget does not affect results.
//!
//! Setup: each small experiment is advanced by 1 step or event at a time, by 7, and without a limit. States, messages, contacts and
//! log must be bitwise identical at every frame.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::small_experiments::{MANIFESTS, Taking, run_of, trajectory};

#[test]
fn frames_do_not_depend_on_the_step_budget() {
    for (name, manifest) in MANIFESTS {
        let run = run_of(name, manifest);
        let whole = trajectory(&run, Taking::PLAIN);
        assert!(whole.len() >= 19, "{name}: {} frames", whole.len());
        for budget in [1, 7] {
            let cut = trajectory(&run, Taking { budget, ..Taking::PLAIN });
            assert!(whole == cut, "{name}: a budget of {budget} changes a frame");
        }
    }
}
