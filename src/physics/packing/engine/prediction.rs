//! What happens to a disc next: the soonest of contacts, walls and edges of its cell.

use super::{Engine, State};
use crate::cell_grid::Side;
use crate::packing::events::{EventCode, NEVER};
use crate::packing::motion;
use crate::packing::scan::{
    DiscSizes, MovingDisc, ScanInput, first_contact, first_contact_of_equal_discs,
};

/// The soonest event of a disc.
#[derive(Clone, Copy)]
pub(super) struct Prediction {
    pub(super) time: f64,
    pub(super) event: EventCode,
    pub(super) partner_collisions: u32,
}

impl Engine {
    /// The soonest event of a disc, from where everybody is now.
    #[inline(always)]
    pub(super) fn soonest<const HAS_AVX512: bool>(&self, moving: MovingDisc) -> Prediction {
        let (edge_wait, edge) = self.first_edge(moving);
        let State { discs, domain, radii, .. } = &self.state;
        let contact = if self.are_equal {
            let distance = 2.0 * domain.max_radius;
            first_contact_of_equal_discs::<HAS_AVX512>(
                discs,
                &self.cells,
                &self.offsets,
                moving,
                distance,
            )
        } else {
            let sizes = match self.state.growth {
                Some(growth) => DiscSizes::Growing {
                    radii,
                    scale: growth.scale_at(moving.now),
                    rate: growth.rate,
                },
                None => DiscSizes::Mixed(radii),
            };
            first_contact(
                ScanInput { discs, cells: &self.cells, offsets: &self.offsets, sizes },
                moving,
            )
        };
        // At the same time a pair comes before a wall or a crossing.
        let is_pair = (contact.wait <= edge_wait) & (contact.wait < NEVER);
        let wait = if is_pair { contact.wait } else { edge_wait };
        Prediction {
            time: if wait < NEVER { moving.now + wait } else { NEVER },
            event: if is_pair { EventCode::pair(contact.partner) } else { edge },
            partner_collisions: discs[contact.partner as usize].collisions,
        }
    }

    /// Where a disc of a cell at a wall touches it, from the cell's corner.
    #[inline(always)]
    pub(super) fn wall(&self, disc: u32, side: Side) -> f64 {
        let mut radius = self.radius(disc as usize);
        if let Some(growth) = self.state.growth {
            radius *= growth.scale_at(self.state.clock.local());
        }
        if side.is_upper() { self.cells.grid.cell_sides[side.axis()] - radius } else { radius }
    }

    /// When a disc reaches a wall or leaves its cell, whichever comes first. Written without branches on the direction of
    /// flight, which no processor can guess.
    #[inline(always)]
    fn first_edge(&self, moving: MovingDisc) -> (f64, EventCode) {
        let grid = &self.cells.grid;
        let has_walls = self.state.domain.has_walls;
        let mut waits = [NEVER; 2];
        let mut events = [EventCode::NONE; 2];
        for axis in 0..2 {
            let speed = moving.velocity[axis];
            let is_upper = speed > 0.0;
            let line = grid.edges[axis][usize::from(is_upper)];
            let wait = motion::time_to_line(moving.position[axis], speed, line);
            // Without speed there is no line to be reached, and 0/0 would be no number.
            waits[axis] = if speed == 0.0 { NEVER } else { wait };
            events[axis] = EventCode::cell_crossing(axis, is_upper);
            if has_walls && grid.is_at_edge(moving.cell, axis, is_upper) {
                (waits[axis], events[axis]) = self.wall_ahead(moving, axis, is_upper);
            }
        }
        let second = (waits[1] < waits[0]) | ((waits[1] == waits[0]) & (events[1] < events[0]));
        let wait = if second { waits[1] } else { waits[0] };
        let event = if second { events[1] } else { events[0] };
        let event = if wait < NEVER { event } else { EventCode::NONE };
        let wait = if wait < NEVER { wait } else { NEVER };
        if self.state.growth.is_some() {
            self.before_wall_behind(moving, (wait, event))
        } else {
            (wait, event)
        }
    }

    /// When a disc of a cell at a wall reaches it.
    #[inline(always)]
    fn wall_ahead(&self, moving: MovingDisc, axis: usize, is_upper: bool) -> (f64, EventCode) {
        let side = Side::along(axis, is_upper);
        let mut speed = moving.velocity[axis];
        let at_rest = speed == 0.0;
        if let Some(growth) = self.state.growth {
            // A growing disc reaches the wall by its growth, too.
            let growth = growth.rate * self.radius(moving.id as usize);
            speed += if is_upper { growth } else { -growth };
        }
        let line = self.wall(moving.id, side);
        let wait = motion::time_to_line(moving.position[axis], speed, line);
        (if at_rest { NEVER } else { wait }, EventCode::wall(side))
    }

    /// The same, or when a growing disc is caught up at a wall behind it.
    #[inline(never)]
    fn before_wall_behind(
        &self,
        moving: MovingDisc,
        mut first: (f64, EventCode),
    ) -> (f64, EventCode) {
        for axis in 0..2 {
            let behind = self.wall_behind(moving, axis, moving.velocity[axis] > 0.0);
            first = if behind < first { behind } else { first };
        }
        first
    }

    /// When a growing disc is caught up by its own growth at the wall that it leaves too slowly.
    fn wall_behind(&self, moving: MovingDisc, axis: usize, is_upper: bool) -> (f64, EventCode) {
        let rate = self.state.growth.map_or(0.0, |growth| growth.rate);
        let speed = rate * self.radius(moving.id as usize) - moving.velocity[axis].abs();
        let is_there = self.state.domain.has_walls
            && self.cells.grid.is_at_edge(moving.cell, axis, !is_upper)
            && speed > 0.0;
        if !is_there {
            return (NEVER, EventCode::NONE);
        }
        let side = Side::along(axis, !is_upper);
        let speed = if is_upper { -speed } else { speed };
        let line = self.wall(moving.id, side);
        (motion::time_to_line(moving.position[axis], speed, line), EventCode::wall(side))
    }
}
