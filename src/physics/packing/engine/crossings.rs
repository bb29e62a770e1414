//! Cell crossings: a disc moves to the next cell, and its motion does not change.

use super::state::Engine;
use crate::cell_grid::Side;
use crate::packing::contact::MovingDisc;
use crate::packing::motion;

/// Cell crossings without a collision after which none is expected: this number, or this multiple of the number that discs in
/// equilibrium need. Where discs cool, the number grows by (1 - e^2)/(2 n) per collision, so that up to this one, 20 discs with e = 0.9
/// cross 2e7 cells, which takes seconds.
const MAX_CROSSINGS: f64 = 1e5;
const MAX_CROSSINGS_OVER_EXPECTED: f64 = 1e3;

impl Engine {
    /// Number of cell crossings since the last collision, up to rounding, if no collision is expected any more: inelastic discs in a
    /// periodic box cool until all move in parallel. `None` otherwise.
    ///
    /// No velocity has changed since the last collision, so the number follows from the state: t sum over the discs of
    /// (|vx|/a + |vy|/b) with cells of a x b. In equilibrium, discs of diameter s cross 8 l/(pi a) cells between two collisions in
    /// the system, where l = A/(2 sqrt 2 N s) is the mean free path of a dilute gas.
    #[inline(never)]
    pub(in crate::packing) fn excessive_crossings(&self) -> Option<f64> {
        let [a, b] = self.cells.grid.cell_sides;
        let domain = &self.state.domain;
        let rate = |[vx, vy]: motion::Vector| vx.abs() / a + vy.abs() / b;
        let rate = self.velocities().fold(0.0, |sum, velocity| sum + rate(velocity));
        let crossings = self.time_since_last_collision() * rate;
        let area = domain.sides[0] * domain.sides[1];
        let free_path =
            area / (2.0 * std::f64::consts::SQRT_2 * self.count() as f64 * 2.0 * domain.max_radius);
        let narrower = if a < b { a } else { b };
        let expected = 8.0 * free_path / (std::f64::consts::PI * narrower);
        let rare = MAX_CROSSINGS_OVER_EXPECTED * expected;
        let limit = if rare > MAX_CROSSINGS { rare } else { MAX_CROSSINGS };
        (!domain.has_walls && crossings > limit).then_some(crossings)
    }

    /// Whether the last event shifted the clock's origin. This depends on the number of events only.
    #[inline(always)]
    pub(in crate::packing) fn is_clock_shifted(&self) -> bool {
        self.state.events_since_shift == 0
    }

    /// Moves a disc to the adjacent cell. Its record keeps the time of its last collision; only the corner to which the
    /// position refers changes.
    #[inline(always)]
    pub(super) fn cross_cell<const WIDTH: usize, const FALLS: bool>(
        &mut self,
        disc: u32,
        side: Side,
    ) {
        let count = self.state.discs.len();
        let now = self.state.clock.local();
        let grid = &self.cells.grid;
        let record = &mut self.state.discs[disc as usize];
        let from = record.cell;
        let to = grid.neighbor(from, side);
        let offset = grid.offset_from_neighbor(side);
        record.position = [record.position[0] + offset[0], record.position[1] + offset[1]];
        record.cell = to;
        let (position, mut velocity) = record.at::<FALLS>(now, self.state.domain.gravity);
        if FALLS && side == Side::Bottom && velocity[1] > 0.0 {
            // At a turning point, the velocity rounds to either sign, and the disc would cross back at once.
            velocity[1] = 0.0;
        }
        let moving = MovingDisc { id: disc, cell: to, position, velocity, now };
        let prediction = self.predict_next_event::<WIDTH, FALLS>(moving);
        // The lists are changed after the scan, which skips the disc itself, so it does not wait for these stores.
        self.cells.remove(disc, from);
        self.cells.insert(disc, to, count);
        self.set_prediction(disc, prediction);
        self.schedule(disc);
    }
}
