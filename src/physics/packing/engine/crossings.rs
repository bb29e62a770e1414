//! Cell crossings: a disc moves to the next cell, and its motion does not change.

use super::state::Engine;
use crate::cell_grid::Side;
use crate::packing::contact::MovingDisc;
use crate::packing::motion;

impl Engine {
    /// Moves a disc to the adjacent cell. Its record keeps the time of its last collision; only the corner to which the
    /// position refers changes.
    #[inline(always)]
    pub(super) fn cross_cell<const WIDTH: usize>(&mut self, disc: u32, side: Side) {
        let count = self.state.discs.len();
        let now = self.state.clock.local();
        let grid = &self.cells.grid;
        let record = &mut self.state.discs[disc as usize];
        let from = record.cell;
        let to = grid.neighbor(from, side);
        let offset = grid.offset_from_neighbor(side);
        let velocity = record.velocity;
        let position = [record.position[0] + offset[0], record.position[1] + offset[1]];
        let age = now - record.time;
        record.position = position;
        record.cell = to;
        let position = motion::free_flight(position, velocity, age);
        let moving = MovingDisc { id: disc, cell: to, position, velocity, now };
        let prediction = self.predict_next_event::<WIDTH>(moving);
        // The lists are changed after the scan, which skips the disc itself, so it does not wait for these stores.
        self.cells.remove(disc, from);
        self.cells.insert(disc, to, count);
        self.set_prediction(disc, prediction);
        self.schedule(disc);
    }
}
