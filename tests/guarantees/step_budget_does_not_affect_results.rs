//! Promise: how work is cut does not change a bit. A model that is given 1 step or event at a time, 7, or all at once
//! shows the same states, messages, contacts and log at every frame.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::small_experiments::{MANIFESTS, Taking, run_of, trajectory};

#[test]
fn budgets_of_one_of_seven_and_without_limit_give_the_same_frames() {
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
