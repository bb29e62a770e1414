//! Predicts the next event of a disc: the earliest of contacts, collisions with walls and obstacles, and cell crossings.

use super::state::{Engine, State};
use crate::cell_grid::Side;
use crate::packing::contact::{DiscSizes, MovingDisc, ScanInput};
use crate::packing::domain::Floor;
use crate::packing::events::{EventCode, NEVER};
use crate::packing::motion;
use crate::packing::scan::{first_contact, first_contact_of_equal_discs};
use crate::packing::shaking::Shaking;

/// The predicted next event of a disc.
#[derive(Clone, Copy)]
pub(super) struct Prediction {
    pub(super) time: f64,
    pub(super) event: EventCode,
    /// Of the partner; for an obstacle, its number.
    pub(super) partner_collisions: u32,
}

impl Engine {
    /// Predicts the next event of a disc from scratch and stores it.
    #[inline(always)]
    pub(super) fn predict<const WIDTH: usize, const FALLS: bool>(&mut self, disc: u32) {
        let now = self.state.clock.local();
        let record = &self.state.discs[disc as usize];
        let cell = record.cell;
        let (position, velocity) = record.at::<FALLS>(now, self.state.domain.gravity);
        let moving = MovingDisc { id: disc, cell, position, velocity, now };
        let prediction = self.predict_next_event::<WIDTH, FALLS>(moving);
        self.set_prediction(disc, prediction);
    }

    /// Stores a prediction in the record of its disc.
    #[inline(always)]
    pub(super) fn set_prediction(&mut self, disc: u32, prediction: Prediction) {
        let record = &mut self.state.discs[disc as usize];
        record.event_time = prediction.time;
        record.event = prediction.event;
        record.partner_collisions = prediction.partner_collisions;
    }

    /// Schedules the stored event of a disc.
    #[inline(always)]
    pub(super) fn schedule(&mut self, disc: u32) {
        let record = &self.state.discs[disc as usize];
        self.event_queue.schedule(disc, record.event_time, record.event);
    }

    /// Predicts the next event of a disc from the present positions of all discs.
    #[inline(always)]
    pub(super) fn predict_next_event<const WIDTH: usize, const FALLS: bool>(
        &self,
        moving: MovingDisc,
    ) -> Prediction {
        let (time_to_edge, edge) = self.first_edge::<FALLS>(moving);
        let State { discs, domain, radii, .. } = &self.state;
        let (cells, offsets, gravity) = (&self.cells, &self.offsets, domain.gravity);
        let input = |sizes| ScanInput { discs, cells, offsets, sizes, gravity };
        let contact = if self.are_equal {
            let sizes = DiscSizes::Equal(2.0 * domain.max_radius);
            first_contact_of_equal_discs::<WIDTH, FALLS>(input(sizes), moving)
        } else {
            let sizes = match self.state.growth {
                Some(growth) => DiscSizes::Growing {
                    radii,
                    scale: growth.scale_at(moving.now),
                    rate: growth.rate,
                },
                None => DiscSizes::Mixed(radii),
            };
            first_contact::<FALLS>(input(sizes), moving)
        };
        // Of simultaneous events, a pair collision precedes a wall collision or a crossing.
        let is_pair = (contact.time_to_contact <= time_to_edge) & (contact.time_to_contact < NEVER);
        let time = if is_pair { contact.time_to_contact } else { time_to_edge };
        let first = Prediction {
            time: if time < NEVER { moving.now + time } else { NEVER },
            event: if is_pair { EventCode::pair(contact.partner) } else { edge },
            partner_collisions: discs[contact.partner as usize].collisions,
        };
        if self.obstacles.is_empty() { first } else { self.or_obstacle::<FALLS>(moving, first) }
    }

    /// The coordinate at which a disc in a cell at a wall touches the wall, relative to the corner of the cell.
    #[inline(always)]
    pub(super) fn contact_position_at_wall(&self, disc: u32, side: Side) -> f64 {
        let mut radius = self.radius(disc as usize);
        if let Some(growth) = self.state.growth {
            radius *= growth.scale_at(self.state.clock.local());
        }
        if side.is_upper() { self.cells.grid.cell_sides[side.axis()] - radius } else { radius }
    }

    /// The time until a disc touches a wall or leaves its cell, whichever is earlier, and the event. It has no branch on the
    /// direction of flight, which cannot be predicted.
    #[inline(always)]
    fn first_edge<const FALLS: bool>(&self, moving: MovingDisc) -> (f64, EventCode) {
        let grid = &self.cells.grid;
        let has_walls = self.state.domain.has_walls;
        let mut times = [NEVER; 2];
        let mut events = [EventCode::NONE; 2];
        for axis in 0..if FALLS { 1 } else { 2 } {
            let speed = moving.velocity[axis];
            let is_upper = speed > 0.0;
            let line = grid.edges[axis][usize::from(is_upper)];
            let time = motion::time_to_line(moving.position[axis], speed, line);
            // At speed 0 no line is reached, and 0/0 would be NaN.
            times[axis] = if speed == 0.0 { NEVER } else { time };
            events[axis] = EventCode::cell_crossing(axis, is_upper);
            if has_walls && grid.is_at_edge(moving.cell, axis, is_upper) {
                (times[axis], events[axis]) = self.wall_ahead(moving, axis, is_upper);
            }
        }
        if FALLS {
            (times[1], events[1]) = self.vertical_edge(moving);
        }
        let second = (times[1] < times[0]) | ((times[1] == times[0]) & (events[1] < events[0]));
        let time = if second { times[1] } else { times[0] };
        let event = if second { events[1] } else { events[0] };
        let event = if time < NEVER { event } else { EventCode::NONE };
        let time = if time < NEVER { time } else { NEVER };
        if self.state.growth.is_some() {
            self.or_wall_behind(moving, (time, event))
        } else {
            (time, event)
        }
    }

    /// The time until a falling disc touches the floor or the ceiling or leaves its cell up or down, and the event. A disc that
    /// rises to the upper line does so before it falls to the lower one.
    #[inline(always)]
    fn vertical_edge(&self, moving: MovingDisc) -> (f64, EventCode) {
        let (grid, domain) = (&self.cells.grid, &self.state.domain);
        let ([_, y], [_, speed]) = (moving.position, moving.velocity);
        let line = |is_upper| {
            let side = Side::along(1, is_upper);
            if grid.is_at_edge(moving.cell, 1, is_upper) {
                (self.contact_position_at_wall(moving.id, side), EventCode::wall(side))
            } else {
                (grid.edges[1][usize::from(is_upper)], EventCode::cell_crossing(1, is_upper))
            }
        };
        let (upper, above) = line(true);
        let time = motion::time_to_rise(upper - y, speed, domain.gravity);
        let first = if time < NEVER {
            (time, above)
        } else {
            let (lower, below) = line(false);
            (motion::time_to_fall(y - lower, speed, domain.gravity), below)
        };
        match domain.floor {
            Floor::Shaken(shaking) => self.or_shaken_floor(moving, shaking, first),
            Floor::AtRest | Floor::Thermal { .. } => first,
        }
    }

    /// The earlier of an event and the contact of a disc with a shaken floor, which may be above the lowest cells.
    #[inline(never)]
    fn or_shaken_floor(
        &self,
        moving: MovingDisc,
        shaking: Shaking,
        first: (f64, EventCode),
    ) -> (f64, EventCode) {
        let is_below = first.1 == EventCode::wall(Side::Bottom);
        let until = if is_below { NEVER } else { first.0 };
        let row = f64::from(moving.cell[1]) * self.cells.grid.cell_sides[1];
        let height = row + moving.position[1] - self.radius(moving.id as usize);
        let flight = [height, moving.velocity[1], self.state.domain.gravity];
        let now = self.state.clock.time();
        match shaking.time_to_contact(now, flight, until) {
            Some(time) if is_below || time <= first.0 => (time, EventCode::wall(Side::Bottom)),
            _ => first,
        }
    }

    /// The time until a disc in a cell at a wall touches it, and the event.
    #[inline(always)]
    fn wall_ahead(&self, moving: MovingDisc, axis: usize, is_upper: bool) -> (f64, EventCode) {
        let side = Side::along(axis, is_upper);
        let mut speed = moving.velocity[axis];
        let is_at_rest = speed == 0.0;
        if let Some(growth) = self.state.growth {
            // The surface of a growing disc approaches the wall faster than its center.
            let growth_rate = growth.rate * self.radius(moving.id as usize);
            speed += if is_upper { growth_rate } else { -growth_rate };
        }
        let line = self.contact_position_at_wall(moving.id, side);
        let time = motion::time_to_line(moving.position[axis], speed, line);
        (if is_at_rest { NEVER } else { time }, EventCode::wall(side))
    }

    /// The earlier of an event and the contact of a growing disc with a wall behind it.
    #[inline(never)]
    fn or_wall_behind(&self, moving: MovingDisc, mut first: (f64, EventCode)) -> (f64, EventCode) {
        for axis in 0..2 {
            let behind = self.wall_behind(moving, axis, moving.velocity[axis] > 0.0);
            first = if behind < first { behind } else { first };
        }
        first
    }

    /// The time until a growing disc touches the wall from which it moves away more slowly than it grows, and the event.
    fn wall_behind(&self, moving: MovingDisc, axis: usize, is_upper: bool) -> (f64, EventCode) {
        let rate = self.state.growth.map_or(0.0, |growth| growth.rate);
        let speed = rate * self.radius(moving.id as usize) - moving.velocity[axis].abs();
        let approaches = self.state.domain.has_walls
            && self.cells.grid.is_at_edge(moving.cell, axis, !is_upper)
            && speed > 0.0;
        if !approaches {
            return (NEVER, EventCode::NONE);
        }
        let side = Side::along(axis, !is_upper);
        let speed = if is_upper { -speed } else { speed };
        let line = self.contact_position_at_wall(moving.id, side);
        (motion::time_to_line(moving.position[axis], speed, line), EventCode::wall(side))
    }
}
