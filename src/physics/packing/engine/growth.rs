//! Compression: discs that grow while they move.

use super::Engine;
use crate::packing::domain::Growth;

impl Engine {
    /// Lets discs grow from now on, from a share of their full radius. The engine was made with the radius of each disc.
    pub(in crate::packing) fn grow(&mut self, scale: f64, rate: f64) {
        let now = self.state.clock.local();
        self.state.growth = Some(Growth { scale: scale - rate * now, rate });
        self.predict_all();
    }

    /// The share of the full radius now.
    pub(in crate::packing) fn scale(&self) -> f64 {
        self.state.growth.map_or(1.0, |growth| growth.scale_at(self.state.clock.local()))
    }

    /// Multiplies all velocities: growing discs heat each other. No disc is moved.
    pub(in crate::packing) fn scale_velocities(&mut self, factor: f64) {
        let now = self.state.clock.local();
        for disc in &mut self.state.discs {
            disc.position = disc.position_at(now);
            disc.time = now;
            disc.velocity = disc.velocity.map(|component| factor * component);
        }
        self.predict_all();
    }

    /// Finds all events anew.
    fn predict_all(&mut self) {
        for disc in 0..self.state.discs.len() as u32 {
            self.predict::<false>(disc);
        }
        self.shift_clock_origin();
    }
}
