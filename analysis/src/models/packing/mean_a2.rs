//! Mean of a2 over a run, exact between frames.

use crate::statistics::{Blocking, Entries, Estimate};
use kinetoscope_recording::reader::StateTable;

/// Velocity moments after an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct VelocityMoments {
    /// Pair and wall collisions since the start.
    pub(crate) events: f64,
    /// Simulated time.
    pub(crate) time: f64,
    /// `<v^2>`/2 = kT/m.
    pub(crate) temperature: f64,
    /// `<v^4>` / (2 `<v^2>^2`) - 1.
    pub(crate) a2: f64,
}

/// What a value of a2 is weighted with.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum A2Weights {
    /// Its duration.
    #[default]
    Durations,
    /// Its number of events: the time scale of cooling discs grows without bound.
    Events,
}

/// Sums of a2 that the model takes at every collision.
#[derive(Clone, Copy, Debug)]
pub(super) struct A2Sums {
    pub(super) events: f64,
    pub(super) time: f64,
    /// Time integral.
    pub(super) integral: f64,
    /// Sum over events.
    pub(super) sum: f64,
}

/// Mean of a2, by recorded collisions or else by the sums that the model takes at every collision.
#[derive(Clone, Debug, Default)]
pub(super) struct MeanA2 {
    weights: A2Weights,
    /// Number of events after which values count.
    settled_after: f64,
    last_collision: Option<VelocityMoments>,
    by_collisions: Blocking,
    by_model: Blocking,
    last_sums: Option<A2Sums>,
}

impl MeanA2 {
    /// Creates a mean without values.
    pub(super) fn new(weights: A2Weights, settled_after: f64) -> Self {
        let by_collisions = Blocking::of(Entries::Collisions);
        let by_model = Blocking::of(Entries::Intervals);
        Self { weights, settled_after, by_collisions, by_model, ..Self::default() }
    }

    /// Adds a recorded collision; a2 is constant from one collision to the next.
    pub(super) fn add_collision(&mut self, moments: VelocityMoments) {
        let before = self.last_collision.replace(moments);
        if let Some(before) = before.filter(|before| before.events >= self.settled_after) {
            let weight = match self.weights {
                A2Weights::Durations => moments.time - before.time,
                A2Weights::Events => moments.events - before.events,
            };
            self.by_collisions.add_weighted(before.a2, weight);
        }
    }

    /// Adds the sums of a frame.
    pub(super) fn add_sums(&mut self, now: A2Sums) {
        if now.events < self.settled_after {
            return;
        }
        let Some(before) = self.last_sums.replace(now) else { return };
        let (amount, length) = match self.weights {
            A2Weights::Durations => (now.integral - before.integral, now.time - before.time),
            A2Weights::Events => (now.sum - before.sum, now.events - before.events),
        };
        self.by_model.add_amount(amount, length);
    }

    fn series(&self) -> &Blocking {
        if self.by_collisions.entries() > 0 { &self.by_collisions } else { &self.by_model }
    }

    /// The mean with its error by blocking.
    pub(super) fn estimate(&self) -> Option<Estimate> {
        self.series().estimate()
    }

    /// The mean with its error for a correlation in units of the weights.
    pub(super) fn estimate_with_correlation(&self, correlation: f64) -> Option<Estimate> {
        self.series().estimate_with_correlation(correlation)
    }
}

/// Temperature, `<v^2>/2`, and a2 of a state; `None` without velocities.
pub(super) fn moments_of(state: &StateTable) -> Option<(f64, f64)> {
    let (vx, vy, count) = (state.index("vx")?, state.index("vy")?, state.rows() as f64);
    let (mut squares, mut fourths) = (0.0, 0.0);
    for row in state.iter() {
        let square = row[vx] * row[vx] + row[vy] * row[vy];
        squares += square;
        fourths += square * square;
    }
    let mean_square = squares / count;
    let a2 = fourths / count / (2.0 * mean_square * mean_square) - 1.0;
    (count > 0.0).then_some((mean_square / 2.0, a2))
}
