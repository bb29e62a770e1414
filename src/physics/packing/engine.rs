//! The event-driven engine: from one event to the next, at a cost that does not grow with the number of discs.
//!
//! Each disc carries its own clock: it stands where its last collision left it and is looked at by extrapolation. Each
//! disc has one event in the calendar, its soonest. A collision predicted with a partner that has collided since is void
//! and is found out when its time comes (Lubachevsky, J. Comput. Phys. 94, 255, 1991; Paul, J. Comput. Phys. 221, 615, 2007).

mod collisions;
mod foresight;
mod growth;
mod prediction;

pub(super) use self::collisions::{Changes, Collision, With};
use self::prediction::Prospect;
use super::arena::{Arena, Growth};
use super::calendar::Calendar;
use super::cells::{Cells, Grid, Shifts};
use super::clock::Clock;
use super::disc::{Disc, MANY};
use super::events::{EventCode, EventKind, NEVER, Side};
use super::motion::{self, Vector};
use super::processor::with_large_pages;
use super::rapid::Rapid;
use super::scan::Seeker;
use crate::model::SimulationFault;
use crate::random::Generator;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// At least so many events lie between two moves of the clock's zero, and at least so many a disc, as a move costs n. So
/// the clock's local time stays near the time between a disc's collisions, and its grain far below all lengths.
const EVENTS_BETWEEN_MOVES: u64 = 16;
const EVENTS_A_DISC_BETWEEN_MOVES: u64 = 4;

/// What a step of the engine was.
pub(super) enum Step {
    /// A collision.
    Collision(Collision),
    /// A crossing, or an event that was void.
    Other,
    /// Nothing happens any more in the time that was given.
    Quiet,
}

/// All discs, what will happen to them, and the time.
#[derive(Clone, Debug)]
pub(super) struct Engine {
    state: State,
    /// From here on all is found again from the state.
    cells: Cells,
    shifts: Shifts,
    calendar: Calendar,
    /// Whether all discs have one radius that stays.
    are_equal: bool,
    /// The clock's zero is moved after so many events.
    events_between_moves: u64,
    /// Whether memory is asked for ahead: of few discs it is at hand, and asking would only cost.
    fetches_ahead: bool,
}

/// What the future depends on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct State {
    arena: Arena,
    discs: Vec<Disc>,
    /// Radius of each disc; empty where all are equal.
    radii: Vec<f64>,
    /// While the start is being compressed; `radii` are then those at the end.
    growth: Option<Growth>,
    clock: Clock,
    /// Local time of the last collision.
    last_collision: f64,
    /// Events since the zero of the clock was moved, void ones and crossings included.
    events_since_move: u64,
    wall_noise: Generator,
    rapid: Rapid,
}

impl Engine {
    /// An engine at time 0. There are as many velocities as positions, at least one; positions are inside and apart.
    /// `radii` are those of all discs, or empty where all are equal.
    pub(super) fn new(
        arena: Arena,
        positions: Vec<Vector>,
        velocities: Vec<Vector>,
        radii: Vec<f64>,
        mean_square_speed: f64,
        wall_noise: Generator,
    ) -> Self {
        let grid = Self::grid(&arena, positions.len());
        let mut discs = with_large_pages(positions.len());
        discs.extend(positions.into_iter().zip(velocities).map(|(position, velocity)| {
            let (cell, inside) = grid.locate(position);
            Disc {
                position: inside,
                velocity,
                time: 0.0,
                event_time: NEVER,
                event: EventCode::NOTHING,
                partner_collisions: 0,
                collisions: 0,
                cell,
            }
        }));
        let contact_distance = 2.0 * arena.largest_radius;
        let mut engine = Self::of(State {
            arena,
            discs,
            radii,
            growth: None,
            clock: Clock::new(contact_distance, mean_square_speed),
            last_collision: 0.0,
            events_since_move: 0,
            wall_noise,
            rapid: Rapid::new(contact_distance, mean_square_speed),
        });
        for disc in 0..engine.state.discs.len() as u32 {
            engine.predict::<false>(disc);
        }
        engine.calendar = Calendar::new(&engine.state.discs, engine.mean_wait_ahead());
        engine
    }

    /// The engine of a state: discs into their cells, events into the calendar.
    fn of(state: State) -> Self {
        let grid = Self::grid(&state.arena, state.discs.len());
        let mut cells = Cells::new(grid);
        for (disc, record) in state.discs.iter().enumerate() {
            cells.insert(disc as u32, record.cell, state.discs.len());
        }
        let mut engine = Self {
            calendar: Calendar::new(&[], 1.0),
            shifts: grid.shifts(),
            cells,
            are_equal: state.radii.is_empty(),
            fetches_ahead: state.discs.len() >= MANY,
            events_between_moves: EVENTS_BETWEEN_MOVES
                .max(EVENTS_A_DISC_BETWEEN_MOVES * state.discs.len() as u64),
            state,
        };
        engine.calendar = Calendar::new(&engine.state.discs, engine.mean_wait_ahead());
        engine
    }

    fn grid(arena: &Arena, discs: usize) -> Grid {
        Grid::new(arena.sides, 2.0 * arena.largest_radius, discs, arena.has_walls)
    }

    /// How long discs wait for their events, on average over those that have one.
    fn mean_wait_ahead(&self) -> f64 {
        let now = self.state.clock.local();
        let waits = self.state.discs.iter().filter(|disc| disc.event_time < NEVER);
        let (sum, count) = waits
            .fold((0.0, 0.0), |(sum, count), disc| (sum + (disc.event_time - now), count + 1.0));
        if count > 0.0 { sum / count } else { 1.0 }
    }

    /// The box and the laws of collision.
    pub(super) fn arena(&self) -> &Arena {
        &self.state.arena
    }

    /// Number of discs.
    pub(super) fn count(&self) -> usize {
        self.state.discs.len()
    }

    /// Radius of a disc, at the end of all growth.
    #[inline(always)]
    pub(super) fn radius(&self, disc: usize) -> f64 {
        if self.state.radii.is_empty() {
            self.state.arena.largest_radius
        } else {
            self.state.radii[disc]
        }
    }

    /// Time since the start.
    pub(super) fn time(&self) -> f64 {
        self.state.clock.time()
    }

    /// Lets time pass up to a time since the start before the next event. Only the clock goes on: no disc is moved, and
    /// what happens next does not depend on it.
    pub(super) fn wait_until(&mut self, time: f64) {
        self.state.clock.advance_to(self.state.clock.to_local(time));
    }

    /// Positions and velocities now, in the order of the discs.
    pub(super) fn look(&self) -> impl Iterator<Item = (Vector, Vector)> {
        let now = self.state.clock.local();
        let arena = &self.state.arena;
        self.state.discs.iter().map(move |disc| {
            let mut place = self.cells.grid.place(disc.cell, disc.position_at(now));
            if !arena.has_walls {
                // On its way out of its cell a disc may be a rounding error beyond the box.
                for (coordinate, side) in place.iter_mut().zip(arena.sides) {
                    *coordinate = motion::wrapped(*coordinate, side);
                }
            }
            (place, disc.velocity)
        })
    }

    /// All velocities, in the order of the discs.
    pub(super) fn velocities(&self) -> impl Iterator<Item = Vector> {
        self.state.discs.iter().map(|disc| disc.velocity)
    }

    /// Time since the last collision of any discs, or since the start.
    pub(super) fn time_since_collision(&self) -> f64 {
        self.state.clock.local() - self.state.last_collision
    }

    /// Tells the engine how fast discs are now: what counts as a rapid collision follows a system that cools.
    pub(super) fn set_mean_square_speed(&mut self, mean_square_speed: f64) {
        self.state.rapid.set_scale(2.0 * self.state.arena.largest_radius, mean_square_speed);
    }

    /// Lets the next event take place, unless it is later than a time since the start. `WIDE` takes the instructions of
    /// 512 bits.
    ///
    /// # Errors
    /// Inelastic collapse (McNamara and Young, Phys. Fluids A 4, 496, 1992), or a jam.
    #[inline(always)]
    pub(super) fn step<const WIDE: bool>(&mut self, until: f64) -> Result<Step, SimulationFault> {
        let Some(disc) = self.next() else { return Ok(Step::Quiet) };
        let record = &self.state.discs[disc as usize];
        if record.event_time > self.state.clock.to_local(until) {
            return Ok(Step::Quiet);
        }
        self.state.clock.advance_to(record.event_time);
        let step = match record.event.kind() {
            EventKind::Pair(partner)
                if self.state.discs[partner as usize].collisions == record.partner_collisions =>
            {
                Step::Collision(self.collide_pair::<WIDE>(disc, partner)?)
            }
            EventKind::Wall(side) => Step::Collision(self.collide_wall::<WIDE>(disc, side)),
            EventKind::Crossing(side) => {
                self.cross::<WIDE>(disc, side);
                Step::Other
            }
            EventKind::Pair(_) | EventKind::Nothing => {
                self.predict::<WIDE>(disc);
                self.file(disc);
                Step::Other
            }
        };
        self.state.events_since_move += 1;
        if self.state.events_since_move >= self.events_between_moves {
            self.move_clock();
        }
        Ok(step)
    }

    /// A disc goes on into the next cell. Its clock stays: it is as if its last collision had been seen from there.
    #[inline(always)]
    fn cross<const WIDE: bool>(&mut self, disc: u32, side: Side) {
        let count = self.state.discs.len();
        let now = self.state.clock.local();
        let grid = &self.cells.grid;
        let record = &mut self.state.discs[disc as usize];
        let from = record.cell;
        let to = grid.beyond(from, side);
        let shift = grid.step_back(side);
        let velocity = record.velocity;
        let position = [record.position[0] + shift[0], record.position[1] + shift[1]];
        let flown = now - record.time;
        record.position = position;
        record.cell = to;
        let position = motion::free_flight(position, velocity, flown);
        let prospect = self.soonest::<WIDE>(Seeker { disc, cell: to, position, velocity, now });
        // What was written is read only later, when it has arrived: the search passes the disc itself over.
        self.cells.remove(disc, from);
        self.cells.insert(disc, to, count);
        self.set(disc, prospect);
        self.file(disc);
    }

    /// Files the event of a disc.
    #[inline(always)]
    fn file(&mut self, disc: u32) {
        let record = &self.state.discs[disc as usize];
        self.calendar.file(disc, record.event_time, record.event);
    }

    #[inline(always)]
    fn set(&mut self, disc: u32, prospect: Prospect) {
        let record = &mut self.state.discs[disc as usize];
        record.event_time = prospect.time;
        record.event = prospect.event;
        record.partner_collisions = prospect.partner_collisions;
    }

    /// Finds the soonest event of a disc anew.
    #[inline(always)]
    fn predict<const WIDE: bool>(&mut self, disc: u32) {
        let now = self.state.clock.local();
        let record = &self.state.discs[disc as usize];
        let (cell, velocity) = (record.cell, record.velocity);
        let position = record.position_at(now);
        let prospect = self.soonest::<WIDE>(Seeker { disc, cell, position, velocity, now });
        self.set(disc, prospect);
    }

    /// Moves the clock's zero near to the present: by the number of events, never because somebody looks.
    #[inline(never)]
    fn move_clock(&mut self) {
        self.state.events_since_move = 0;
        let shift = self.state.clock.move_zero();
        self.state.last_collision -= shift;
        for disc in &mut self.state.discs {
            disc.time -= shift;
            if disc.event_time < NEVER {
                disc.event_time -= shift;
            }
        }
        if let Some(growth) = &mut self.state.growth {
            growth.scale += growth.rate * shift;
        }
        self.calendar.file_anew(&self.state.discs, self.mean_wait_ahead());
    }
}

impl PartialEq for Engine {
    /// Equal where the future is.
    fn eq(&self, other: &Self) -> bool {
        self.state == other.state
    }
}

impl Serialize for Engine {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.state.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Engine {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        State::deserialize(deserializer).map(Self::of)
    }
}
