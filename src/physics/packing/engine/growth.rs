//! Compression: the engine with discs that grow while they move.

use super::state::Engine;
use crate::packing::growth::Growth;

impl Engine {
    /// Starts the growth of the discs at a fraction of their full radii, which are those given at construction.
    pub(in crate::packing) fn grow(&mut self, scale: f64, rate: f64) {
        let now = self.state.clock.local();
        self.state.growth = Some(Growth { scale: scale - rate * now, rate });
        self.predict_all();
    }

    /// Present radius over full radius.
    pub(in crate::packing) fn scale(&self) -> f64 {
        self.state.growth.map_or(1.0, |growth| growth.scale_at(self.state.clock.local()))
    }

    /// Multiplies all velocities by a factor, because growing discs heat each other. No disc is moved.
    pub(in crate::packing) fn scale_velocities(&mut self, factor: f64) {
        let now = self.state.clock.local();
        for disc in &mut self.state.discs {
            disc.position = disc.at::<false>(now, 0.0).0;
            disc.time = now;
            disc.velocity = disc.velocity.map(|component| factor * component);
        }
        self.predict_all();
    }

    /// Predicts all events from scratch.
    fn predict_all(&mut self) {
        for disc in 0..self.state.discs.len() as u32 {
            self.predict::<1, false>(disc);
        }
        self.shift_clock_origin();
    }
}
