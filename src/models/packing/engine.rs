//! The event-driven engine: from one event to the next, at a cost that does not grow with the number of discs (but for
//! the queue's logarithm).
//!
//! Each disc carries its own clock: it stands where its last collision left it and is looked at by extrapolation. Each
//! disc has one event in the queue, its soonest. A collision predicted with a partner that has collided since is void
//! and is found out when its time comes (Lubachevsky, J. Comput. Phys. 94, 255, 1991; Paul, J. Comput. Phys. 221, 615, 2007).

use super::cells::Cells;
use super::clock::Clock;
use super::events::{Event, EventKind, Side};
use super::motion::{self, Vector};
use super::queue::EventQueue;
use crate::model::Fault;
use crate::random::Generator;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// A pair collision counts as rapid when one of its discs collided less than this share of the time ago that a disc of
/// the root mean square speed takes for a diameter.
const RAPID: f64 = 1e-10;

/// So many rapid collisions in a row of one disc are a collapse. Elastic discs that are free to move hardly have two;
/// in a collapse the relative speeds fall by a constant factor each, so that they still are numbers after so many.
const COLLAPSE: u32 = 100;

/// At least so many events lie between two moves of the clock's zero, and at least one a disc, as a move costs n. So the
/// clock's local time stays near the time between a disc's collisions, and its grain far below all lengths.
const EVENTS_BETWEEN_MOVES: u64 = 16;

/// The box and the laws of collision.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Arena {
    /// Width and height of the box, which is centred on the origin.
    pub(super) sides: Vector,
    /// Radius of a disc.
    pub(super) radius: f64,
    /// Coefficient of restitution of a pair.
    pub(super) restitution: f64,
    /// Standard deviation of the angle by which a wall turns the outgoing direction, rad.
    pub(super) wall_noise_rad: f64,
}

impl Arena {
    /// Distance of two centres at contact.
    pub(super) fn contact_distance(&self) -> f64 {
        2.0 * self.radius
    }

    /// Half the sides of the rectangle that centres stay in.
    pub(super) fn reach(&self) -> Vector {
        [0.5 * self.sides[0] - self.radius, 0.5 * self.sides[1] - self.radius]
    }

    fn wall(&self, side: Side) -> f64 {
        let reach = self.reach()[side.axis()];
        if side.is_upper() { reach } else { -reach }
    }
}

/// One disc, as its last collision left it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Disc {
    position: Vector,
    velocity: Vector,
    /// When it stood there, on the engine's clock.
    time: f64,
    /// Collisions so far, modulo 2^32.
    collisions: u32,
    /// Rapid collisions in a row.
    rapid: u32,
}

impl Disc {
    fn position_at(&self, time: f64) -> Vector {
        motion::free_flight(self.position, self.velocity, time - self.time)
    }
}

/// A collision that has taken place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Collision {
    /// With whom.
    pub(super) with: With,
    /// Velocities before and after, of each disc that took part.
    pub(super) changes: Changes,
    /// Magnitude of the momentum handed over along the normal.
    pub(super) normal_impulse: f64,
    /// Time since the collision before it, of any discs, or since the start.
    pub(super) wait: f64,
}

/// What a disc collided with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum With {
    /// Another disc.
    Disc,
    /// A wall.
    Wall,
}

/// Velocities before and after a collision: of the pair, or of one disc and nobody (at rest before and after).
pub(super) type Changes = [[Vector; 2]; 2];

/// All discs, what will happen to them, and the time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Engine {
    arena: Arena,
    discs: Vec<Disc>,
    cells: Cells,
    queue: EventQueue,
    clock: Clock,
    /// Local time of the last collision.
    last_collision: f64,
    /// Events since the zero of the clock was moved, void ones and crossings included.
    events_since_move: u64,
    wall_noise: Generator,
    /// Mean square speed as of the last [`Engine::set_mean_square_speed`]: the scale of rapid collisions.
    mean_square_speed: f64,
}

impl Engine {
    /// An engine at time 0. There are as many velocities as positions, at least one; positions are inside and apart.
    pub(super) fn new(
        arena: Arena,
        positions: &[Vector],
        velocities: &[Vector],
        mean_square_speed: f64,
        wall_noise: Generator,
    ) -> Self {
        let discs: Vec<Disc> = positions
            .iter()
            .zip(velocities)
            .map(|(&position, &velocity)| Disc {
                position,
                velocity,
                time: 0.0,
                collisions: 0,
                rapid: 0,
            })
            .collect();
        let count = discs.len() as u32;
        let mut engine = Self {
            arena,
            cells: Cells::new(arena.sides, arena.contact_distance(), positions),
            queue: EventQueue::new(count),
            clock: Clock::new(arena.contact_distance(), mean_square_speed),
            last_collision: 0.0,
            events_since_move: 0,
            wall_noise,
            mean_square_speed,
            discs,
        };
        for disc in 0..count {
            engine.reschedule(disc);
        }
        engine
    }

    /// The box and the laws of collision.
    pub(super) fn arena(&self) -> &Arena {
        &self.arena
    }

    /// Number of discs.
    pub(super) fn count(&self) -> usize {
        self.discs.len()
    }

    /// Time since the start.
    pub(super) fn time(&self) -> f64 {
        self.clock.time()
    }

    /// Local time of the next event; `None` if nothing ever happens.
    fn next_time(&self) -> Option<f64> {
        let (_, event) = self.queue.soonest();
        (event.kind != EventKind::Nothing).then_some(event.time)
    }

    /// Whether anything will ever happen.
    pub(super) fn is_at_rest(&self) -> bool {
        self.next_time().is_none()
    }

    /// Whether all that happens up to this time since the start has happened.
    pub(super) fn is_done_until(&self, time: f64) -> bool {
        self.next_time().is_none_or(|next| next > self.clock.to_local(time))
    }

    /// Lets time pass up to a time since the start before the next event. Only the clock goes on: no disc is moved, and
    /// what happens next does not depend on it.
    pub(super) fn wait_until(&mut self, time: f64) {
        self.clock.advance_to(self.clock.to_local(time));
    }

    /// Positions and velocities now, in the order of the discs.
    pub(super) fn look(&self) -> impl Iterator<Item = (Vector, Vector)> {
        let now = self.clock.local();
        self.discs.iter().map(move |disc| (disc.position_at(now), disc.velocity))
    }

    /// All velocities, in the order of the discs.
    pub(super) fn velocities(&self) -> impl Iterator<Item = Vector> {
        self.discs.iter().map(|disc| disc.velocity)
    }

    /// Time since the last collision of any discs, or since the start.
    pub(super) fn time_since_collision(&self) -> f64 {
        self.clock.local() - self.last_collision
    }

    /// Tells the engine how fast discs are now: what counts as a rapid collision follows a system that cools.
    pub(super) fn set_mean_square_speed(&mut self, mean_square_speed: f64) {
        self.mean_square_speed = mean_square_speed;
    }

    /// Lets the next event take place; returns it if it was a collision, and `None` where it was void or a crossing.
    ///
    /// # Errors
    /// Inelastic collapse (McNamara and Young, Phys. Fluids A 4, 496, 1992), or a jam.
    pub(super) fn step(&mut self) -> Result<Option<Collision>, Fault> {
        let (disc, event) = self.queue.soonest();
        if event.kind == EventKind::Nothing {
            return Ok(None);
        }
        self.clock.advance_to(event.time);
        let collision = match event.kind {
            EventKind::Pair { partner, partner_collisions }
                if self.discs[partner as usize].collisions == partner_collisions =>
            {
                Some(self.collide_pair(disc, partner)?)
            }
            EventKind::Wall(side) => Some(self.collide_wall(disc, side)),
            EventKind::Crossing(side) => {
                self.cells.cross(disc, side);
                self.reschedule(disc);
                None
            }
            EventKind::Pair { .. } | EventKind::Nothing => {
                self.reschedule(disc);
                None
            }
        };
        self.keep_clock();
        Ok(collision)
    }

    fn collide_pair(&mut self, disc: u32, partner: u32) -> Result<Collision, Fault> {
        // The same arithmetic whichever of the two predicted it.
        let pair = if disc < partner { [disc, partner] } else { [partner, disc] };
        self.watch_for_collapse(pair)?;
        let now = self.clock.local();
        let [first, second] = pair.map(|disc| self.discs[disc as usize]);
        let positions = [first.position_at(now), second.position_at(now)];
        let before = [first.velocity, second.velocity];
        let separation = motion::difference(positions[0], positions[1]);
        let impact = motion::pair_impact(separation, before, self.arena.restitution);
        for (place, disc) in pair.into_iter().enumerate() {
            self.leave(disc, positions[place], impact.velocities[place]);
        }
        for disc in pair {
            self.reschedule(disc);
        }
        Ok(Collision {
            with: With::Disc,
            changes: [[before[0], impact.velocities[0]], [before[1], impact.velocities[1]]],
            normal_impulse: impact.normal_impulse,
            wait: self.mark_collision(),
        })
    }

    fn collide_wall(&mut self, disc: u32, side: Side) -> Collision {
        let axis = side.axis();
        let Disc { velocity: before, .. } = self.discs[disc as usize];
        let mut position = self.discs[disc as usize].position_at(self.clock.local());
        position[axis] = self.arena.wall(side);
        let after = self.leave_wall(before, axis);
        self.leave(disc, position, after);
        self.reschedule(disc);
        Collision {
            with: With::Wall,
            changes: [[before, after], [[0.0; 2]; 2]],
            normal_impulse: (after[axis] - before[axis]).abs(),
            wait: self.mark_collision(),
        }
    }

    /// The velocity after a wall: the angle is drawn again until the disc leaves the wall.
    fn leave_wall(&mut self, velocity: Vector, axis: usize) -> Vector {
        loop {
            let angles = if self.arena.wall_noise_rad > 0.0 {
                self.wall_noise.normal_pair().map(|normal| normal * self.arena.wall_noise_rad)
            } else {
                [0.0; 2]
            };
            let turned = |angle| motion::wall_impact(velocity, axis, angle);
            if let Some(leaving) = angles.into_iter().find_map(turned) {
                return leaving;
            }
        }
    }

    /// Sends a disc on its way from here and now.
    fn leave(&mut self, disc: u32, position: Vector, velocity: Vector) {
        let disc = &mut self.discs[disc as usize];
        disc.position = position;
        disc.velocity = velocity;
        disc.time = self.clock.local();
        disc.collisions = disc.collisions.wrapping_add(1);
    }

    /// Notes that a collision takes place now; returns the time since the one before.
    fn mark_collision(&mut self) -> f64 {
        let wait = self.time_since_collision();
        self.last_collision = self.clock.local();
        wait
    }

    fn watch_for_collapse(&mut self, pair: [u32; 2]) -> Result<(), Fault> {
        let now = self.clock.local();
        let rapid = RAPID * self.arena.contact_distance();
        for id in pair {
            let disc = &mut self.discs[id as usize];
            let is_rapid = (now - disc.time) * self.mean_square_speed.sqrt() < rapid;
            disc.rapid = if is_rapid { disc.rapid + 1 } else { 0 };
            if disc.rapid >= COLLAPSE {
                return Err(Fault(format!(
                    "inelastic collapse at time {}: disc {id} collided {COLLAPSE} times in a row while time stood still; \
                     a restitution nearer to 1, a shorter run, or a start that is not jammed avoids it",
                    self.clock.time()
                )));
            }
        }
        Ok(())
    }

    fn reschedule(&mut self, disc: u32) {
        let event = self.predict(disc);
        self.queue.schedule(disc, event);
    }

    /// The soonest event of a disc, from where everybody is now.
    fn predict(&self, disc: u32) -> Event {
        let now = self.clock.local();
        let Disc { velocity, .. } = self.discs[disc as usize];
        let position = self.discs[disc as usize].position_at(now);
        let mut soonest = self.predict_edges(disc, position, velocity);
        self.cells.for_each_near(disc, |partner| {
            let other = &self.discs[partner as usize];
            let separation = motion::difference(position, other.position_at(now));
            let relative_velocity = motion::difference(velocity, other.velocity);
            let contact_distance = self.arena.contact_distance();
            let wait = motion::time_to_contact(separation, relative_velocity, contact_distance);
            if let Some(wait) = wait {
                let partner_collisions = other.collisions;
                let kind = EventKind::Pair { partner, partner_collisions };
                soonest = earlier(soonest, Event { time: now + wait, kind });
            }
        });
        soonest
    }

    /// When a disc reaches a wall or leaves its cell, whichever comes first.
    fn predict_edges(&self, disc: u32, position: Vector, velocity: Vector) -> Event {
        let now = self.clock.local();
        let mut soonest = Event::NOTHING;
        for axis in 0..2 {
            let Some(side) = Side::ahead(axis, velocity[axis]) else { continue };
            let (line, kind) = match self.cells.edge(disc, side) {
                Some(edge) => (edge, EventKind::Crossing(side)),
                None => (self.arena.wall(side), EventKind::Wall(side)),
            };
            let wait = motion::time_to_line(position[axis], velocity[axis], line);
            soonest = earlier(soonest, Event { time: now + wait, kind });
        }
        soonest
    }

    /// Moves the clock's zero near to the present now and then: by the number of events, never because somebody looks.
    fn keep_clock(&mut self) {
        self.events_since_move += 1;
        if self.events_since_move < EVENTS_BETWEEN_MOVES.max(self.discs.len() as u64) {
            return;
        }
        self.events_since_move = 0;
        let shift = self.clock.move_zero();
        self.last_collision -= shift;
        self.queue.shift(shift);
        for disc in &mut self.discs {
            disc.time -= shift;
        }
    }
}

fn earlier(first: Event, second: Event) -> Event {
    if second.order(&first) == Ordering::Less { second } else { first }
}
