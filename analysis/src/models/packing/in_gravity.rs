//! Sums over the states of discs in gravity: heights, layers, temperature; and the first and the last energy.

use crate::models::lyapunov::SETTLED_AFTER;
use crate::statistics::{Blocking, Sum};
use kinetoscope_manifest::model::{PackingConfig, RunLength};
use kinetoscope_recording::channels::PackingEnergy;
use kinetoscope_recording::reader::StateTable;

/// Number of layers of equal height.
pub(super) const LAYERS: usize = 20;

/// Why the mean of a2 is not measured in gravity.
pub(super) const BETWEEN_COLLISIONS: &str = "in gravity, velocities change between collisions, and their fourth moment is recorded at collisions only";

/// What the states and the energies of discs in gravity give.
#[derive(Clone, Debug, Default)]
pub(super) struct InGravity {
    /// Of the first frame and of the last one.
    pub(super) energy: Option<(PackingEnergy, PackingEnergy)>,
    /// Discs per layer, in all settled states.
    pub(super) layers: [f64; LAYERS],
    /// Number of settled states, and the sum of their temperatures.
    pub(super) states: f64,
    pub(super) temperatures: Sum,
    /// Mean height of the centers above their lowest position, per settled state.
    pub(super) heights: Blocking,
}

impl InGravity {
    /// Adds the energy of a frame, if it has one.
    pub(super) fn add_energy(&mut self, energy: Option<PackingEnergy>) {
        let Some(energy) = energy else { return };
        let first = self.energy.take().map_or_else(|| energy.clone(), |(first, _)| first);
        self.energy = Some((first, energy));
    }

    /// Adds a state, if it is settled.
    pub(super) fn add_state(&mut self, config: &PackingConfig, time: f64, state: &StateTable) {
        // Frames at collisions do not sample the time.
        let RunLength::Duration(duration) = config.length else { return };
        if config.gravity.get() == 0.0 || time < SETTLED_AFTER * duration.get() {
            return;
        }
        let columns = ["y", "vx", "vy"].map(|name| state.index(name));
        let [Some(y), Some(vx), Some(vy)] = columns else { return };
        let room = room(config);
        let (mut heights, mut squares, mut count) = (0.0, 0.0, 0.0);
        for row in state.iter() {
            let height = row[y] + 0.5 * room;
            let layer = (height / room * LAYERS as f64).clamp(0.0, LAYERS as f64 - 1.0);
            self.layers[layer as usize] += 1.0;
            heights += height;
            squares += row[vx] * row[vx] + row[vy] * row[vy];
            count += 1.0;
        }
        self.states += 1.0;
        self.heights.add(heights / count);
        self.temperatures.add(0.5 * squares / count);
    }
}

/// Distance between the lowest and the highest position of a center.
pub(super) fn room(config: &PackingConfig) -> f64 {
    config.height.get() - 2.0 * config.radius.get()
}
