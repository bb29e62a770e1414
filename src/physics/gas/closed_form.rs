//! Closed-form propagator: computes every frame from the start of the paths, independently of earlier frames.

use super::clock::Clock;
use super::closed_form_simd::Paths;
use super::propagator::Propagator;
use super::state::GasState;
use super::tallies::WallTally;
use crate::model::{SetupError, Target};
use crate::random::Seed;
use kinetoscope_manifest::model::{GasConfig, Propagation};
use serde::{Deserialize, Serialize};

/// Paths of all particles, and the time up to which they are followed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct ClosedForm {
    duration_s: f64,
    time_s: f64,
    /// Start of the present paths, s.
    started_s: f64,
    paths: Paths,
    /// Wall collisions before the present paths.
    before: WallTally,
}

impl Propagator for ClosedForm {
    fn prepare(
        config: &GasConfig,
        _seed: Seed,
        state: &GasState,
    ) -> Option<Result<Self, SetupError>> {
        (config.propagation == Propagation::Exact).then(|| {
            Ok(Self {
                duration_s: config.duration_s.get(),
                time_s: 0.0,
                started_s: 0.0,
                paths: Paths::start(state, 0.0),
                before: WallTally::default(),
            })
        })
    }

    fn clock(&self) -> Clock {
        Clock::Continuous { time_s: self.time_s, duration_s: self.duration_s }
    }

    /// Counts the wall collisions since the start of the paths by the closed form, and those since the last call by its difference.
    fn advance(&mut self, target: Target, _budget: &mut u64, state: &mut GasState) -> bool {
        let Target::Time(time_s) = target else { return true };
        let sums = self.paths.advance(time_s - self.started_s, &mut state.particles);
        state.wall.total = self.before;
        state.wall.total.add(sums.collisions, sums.impulse.value());
        state.wall.window.add(sums.new_collisions, sums.new_impulse.value());
        self.time_s = time_s;
        true
    }

    fn restart_paths(&mut self, state: &GasState) {
        self.paths = Paths::start(state, self.time_s);
        self.started_s = self.time_s;
        self.before = state.wall.total;
    }

    fn description(&self, _state: &GasState) -> String {
        "propagation: closed form, exact at any time".to_owned()
    }
}
