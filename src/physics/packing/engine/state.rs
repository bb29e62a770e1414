//! The engine's data: the state, from which all events follow, and what is derived from it.

use crate::cell_grid::BlockOffsets;
use crate::cell_lists::CellLists;
use crate::packing::clock::Clock;
use crate::packing::disc::{DiscRecord, LARGE_SYSTEM};
use crate::packing::domain::Domain;
use crate::packing::event_queue::EventQueue;
use crate::packing::events::{EventKind, NEVER};
use crate::packing::growth::Growth;
use crate::packing::inelastic_collapse::CollapseDetector;
use crate::packing::motion::{self, Vector};
use crate::packing::near_obstacles::NearObstacles;
use crate::random::Generator;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Minimum number of events, and minimum number per disc, between two shifts of the clock's origin, whose cost is
/// proportional to the number of discs. Local times then stay near the time between a disc's collisions, and their
/// resolution far below all lengths.
const MIN_EVENTS_BETWEEN_SHIFTS: u64 = 16;
const EVENTS_PER_DISC_BETWEEN_SHIFTS: u64 = 4;

/// All discs, their events, and the time.
#[derive(Clone, Debug)]
pub(in crate::packing) struct Engine {
    pub(super) state: State,
    /// This field and the following ones are derived from the state.
    pub(super) cells: CellLists,
    pub(super) offsets: BlockOffsets,
    pub(super) obstacles: NearObstacles,
    pub(super) event_queue: EventQueue,
    /// Whether all discs have the same constant radius.
    pub(super) are_equal: bool,
    /// Number of events between two shifts of the clock's origin.
    pub(super) events_between_shifts: u64,
    /// Whether memory is prefetched; for few discs, it is in the cache, and prefetching only costs time.
    pub(super) prefetches: bool,
}

/// The state, on which all later events depend.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct State {
    pub(super) domain: Domain,
    pub(super) discs: Vec<DiscRecord>,
    /// Radius of each disc; empty if all are equal.
    pub(super) radii: Vec<f64>,
    /// Growth during compression; `radii` are then the full radii.
    pub(super) growth: Option<Growth>,
    pub(super) clock: Clock,
    /// Local time of the last collision.
    pub(super) last_collision: f64,
    /// Events since the clock's origin was shifted, including invalid ones and crossings.
    pub(super) events_since_shift: u64,
    pub(super) wall_noise: Generator,
    pub(super) collapse_detector: CollapseDetector,
}

impl State {
    /// Whether numbers are finite, discs are in their cells and in the box, and events refer to existing discs.
    fn is_valid(&self) -> bool {
        let Domain { sides, max_radius, has_walls, .. } = self.domain;
        let lengths = [sides[0], sides[1], max_radius];
        if self.discs.is_empty()
            || !lengths.iter().all(|side| side.is_finite() && *side > 0.0)
            || !self.domain.obstacles.is_valid(sides)
        {
            return false;
        }
        let (count, grid) = (self.discs.len(), self.domain.cell_grid(self.discs.len()));
        let obstacles = NearObstacles::new(&self.domain, grid);
        let now = self.clock.local();
        let is_radius = |radius: &f64| *radius > 0.0 && *radius <= max_radius;
        let is_valid = |(index, disc): (usize, &DiscRecord)| {
            let position = grid.point(disc.cell, disc.at::<true>(now, self.domain.gravity).0);
            let has_event = || match disc.event.kind() {
                EventKind::Pair(partner) => (partner as usize) < count && partner as usize != index,
                EventKind::Obstacle => obstacles.near(disc.cell).contains(&disc.partner_collisions),
                EventKind::Wall(_) => has_walls,
                EventKind::CellCrossing(_) => true,
                EventKind::None => disc.event_time == NEVER,
            };
            grid.contains(disc.cell, position)
                && has_event()
                && (0..2).all(|axis| position[axis].abs() <= 0.5 * sides[axis] * (1.0 + 1e-6))
                && disc.velocity.iter().all(|component| component.is_finite())
                && disc.time.is_finite()
                && (0.0..=NEVER).contains(&disc.event_time)
        };
        self.clock.is_valid()
            && self.growth.is_none()
            && (self.radii.is_empty() || self.radii.len() == count)
            && self.radii.iter().all(is_radius)
            && self.last_collision <= now
            && self.last_collision.is_finite()
            && self.events_since_shift < Engine::events_between_shifts(count)
            && self.collapse_detector.is_valid()
            && self.discs.iter().enumerate().all(is_valid)
    }

    /// The mean time until the events of the discs that have one.
    pub(super) fn mean_time_to_event(&self) -> f64 {
        let now = self.clock.local();
        let scheduled = self.discs.iter().filter(|disc| disc.event_time < NEVER);
        let (sum, count) = scheduled
            .fold((0.0, 0.0), |(sum, count), disc| (sum + (disc.event_time - now), count + 1.0));
        if count > 0.0 { sum / count } else { 1.0 }
    }
}

impl Engine {
    /// The engine of a state: inserts the discs into their cells and the events into the queue.
    pub(super) fn from_state(state: State) -> Self {
        let grid = state.domain.cell_grid(state.discs.len());
        let mut cells = CellLists::new(grid);
        for (disc, record) in state.discs.iter().enumerate() {
            cells.insert(disc as u32, record.cell, state.discs.len());
        }
        Self {
            event_queue: EventQueue::new(&state.discs, state.mean_time_to_event()),
            obstacles: NearObstacles::new(&state.domain, grid),
            offsets: grid.block_offsets(),
            cells,
            are_equal: state.radii.is_empty(),
            prefetches: state.discs.len() >= LARGE_SYSTEM,
            events_between_shifts: Self::events_between_shifts(state.discs.len()),
            state,
        }
    }

    fn events_between_shifts(discs: usize) -> u64 {
        MIN_EVENTS_BETWEEN_SHIFTS.max(EVENTS_PER_DISC_BETWEEN_SHIFTS * discs as u64)
    }

    /// The box and the collision parameters.
    pub(in crate::packing) fn domain(&self) -> &Domain {
        &self.state.domain
    }

    /// Number of discs.
    pub(in crate::packing) fn count(&self) -> usize {
        self.state.discs.len()
    }

    /// Full radius of a disc.
    #[inline(always)]
    pub(in crate::packing) fn radius(&self, disc: usize) -> f64 {
        if self.state.radii.is_empty() {
            self.state.domain.max_radius
        } else {
            self.state.radii[disc]
        }
    }

    /// Time since the start.
    pub(in crate::packing) fn time(&self) -> f64 {
        self.state.clock.time()
    }

    /// Time since the last collision in the system, or since the start.
    pub(in crate::packing) fn time_since_last_collision(&self) -> f64 {
        self.state.clock.local() - self.state.last_collision
    }

    /// Advances the clock to a time since the start that is before the next event. No disc is moved, and later events do
    /// not depend on it.
    pub(in crate::packing) fn advance_clock_to(&mut self, time: f64) {
        self.state.clock.advance_to(self.state.clock.to_local(time));
    }

    /// Present positions and velocities, in the order of the discs.
    pub(in crate::packing) fn positions_and_velocities(
        &self,
    ) -> impl Iterator<Item = (Vector, Vector)> {
        let now = self.state.clock.local();
        let domain = &self.state.domain;
        self.state.discs.iter().map(move |disc| {
            let (position, velocity) = disc.at::<true>(now, domain.gravity);
            let mut position = self.cells.grid.point(disc.cell, position);
            if !domain.has_walls {
                // A disc that is about to leave its cell may be outside of the box by a rounding error.
                for (coordinate, side) in position.iter_mut().zip(domain.sides) {
                    *coordinate = motion::wrapped(*coordinate, side);
                }
            }
            (position, velocity)
        })
    }

    /// All present velocities, in the order of the discs.
    pub(in crate::packing) fn velocities(&self) -> impl Iterator<Item = Vector> + Clone {
        let (now, gravity) = (self.state.clock.local(), self.state.domain.gravity);
        self.state.discs.iter().map(move |disc| disc.at::<true>(now, gravity).1)
    }

    /// Adapts the detection of inelastic collapse to the present speeds.
    pub(in crate::packing) fn set_mean_square_speed(&mut self, mean_square_speed: f64) {
        let diameter = 2.0 * self.state.domain.max_radius;
        let fallen = self.state.domain.gravity * diameter;
        self.state.collapse_detector.set_scale(diameter, mean_square_speed + fallen);
    }
}

impl PartialEq for Engine {
    /// Two engines are equal if all later events are.
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
        let state = State::deserialize(deserializer)?;
        // A checkpoint may contain any numbers; the cells and the queue of an impossible state would panic.
        if state.is_valid() {
            Ok(Self::from_state(state))
        } else {
            Err(D::Error::custom("impossible discs"))
        }
    }
}
