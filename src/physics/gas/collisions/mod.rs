//! Event-driven propagator of discs that collide with one another: exact at any time, with a cost of O(log N) per event.
//!
//! Each disc has its own local time, that of its last event, and one future event: its earliest one, found among the discs of its cell
//! and of the adjacent cells. A collision predicted with a partner that has since changed its path is void; this is detected when the
//! collision is due (Lubachevsky, J. Comput. Phys. 94 (1991) 255).

mod tournament_tree;

use self::tournament_tree::TournamentTree;
use super::clock::Clock;
use super::motion::{Particle, dot, drifted, elastic_collision, reflected, time_to_wall};
use super::propagator::Propagator;
use super::state::GasState;
use super::tallies::{PairTally, WallTallies};
use crate::cell_grid::{Cell, CellGrid, Side};
use crate::cell_lists::{CellLists, NO_DISC};
use crate::collision_time::time_to_contact;
use crate::event_record::EventRecord;
use crate::model::{SetupError, Target};
use crate::short_number::short;
use serde::{Deserialize, Serialize};

/// Minimum chord over the radius. A shorter chord departs from the wall by less than rounding (its square over 8), so a disc that slides
/// along the wall is reflected after this distance.
const MIN_CHORD: f64 = 1.5e-8;

/// Overlap over the diameter that the rounding of given decimals may cause.
const OVERLAP_TOLERANCE: f64 = 1e-9;

/// Minimum width of a cell over the diameter of a disc, so that rounding of a position never hides a neighbor.
const MIN_CELL_WIDTH: f64 = 1.0 + 1e-6;

/// All discs and their predicted events.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "DiscStates", into = "DiscStates")]
pub(super) struct CollidingDiscs {
    states: DiscStates,
    /// Rebuilt from the states, as is the tournament.
    cells: CellLists,
    tournament: TournamentTree,
}

/// The part that a checkpoint stores.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct DiscStates {
    duration_s: f64,
    /// Radius of the circle that contains the centers: that of the container minus that of a disc, m.
    center_limit_m: f64,
    diameter_m: f64,
    /// Time of the last event or target, s.
    time_s: f64,
    /// Mass of each disc relative to the first one.
    mass_ratios: Vec<f64>,
    discs: Vec<Disc>,
    tally: PairTally,
    /// The collisions since the last frame, if they are recorded, with impulses over the first mass.
    events: Option<Box<EventRecord>>,
}

/// A disc after its last event.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Disc {
    particle: Particle,
    /// Time of the last event, s.
    time_s: f64,
    cell: Cell,
    /// Number of changes of the path, modulo 2^32.
    path_changes: u32,
    /// Earliest future event and its time, s.
    event: Event,
    event_s: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Event {
    /// Collision with a disc, void if the partner has changed its path since the prediction.
    Pair { partner: u32, path_changes: u32 },
    /// Collision with the wall.
    Wall,
    /// Transfer to another cell.
    Crossing(Cell),
}

impl Propagator for CollidingDiscs {
    fn clock(&self) -> Clock {
        Clock::Continuous { time_s: self.states.time_s, duration_s: self.states.duration_s }
    }

    fn count(&self, state: &GasState) -> u64 {
        state.wall.total.collisions + self.states.tally.collisions
    }

    fn is_valid_for(&self, state: &GasState, max_speed: f64) -> bool {
        let states = &self.states;
        let is_slow = |disc: &Disc| disc.particle.speed() <= max_speed;
        let radius = state.container.circle.radius;
        states.discs.len() == state.particles.len()
            && states.mass_ratios == state.substance.mass_ratios
            && states.center_limit_m == radius - 0.5 * states.diameter_m
            && states.discs.iter().all(is_slow)
            && states.events.as_ref().is_none_or(|events| events.is_valid(states.discs.len()))
    }

    /// Executes events up to the target time, one per unit of the budget, then moves the particles to the positions of the discs.
    fn advance(&mut self, target: Target, budget: &mut u64, state: &mut GasState) -> bool {
        let Target::Time(until_s) = target else { return true };
        loop {
            let (disc, event_s) = self.tournament.earliest();
            if event_s > until_s {
                break;
            }
            if *budget == 0 {
                return false;
            }
            *budget -= 1;
            self.states.time_s = event_s;
            self.execute_event(disc, &mut state.wall);
        }
        self.states.time_s = until_s;
        for (id, disc) in self.states.discs.iter().enumerate() {
            state.particles.set(id, disc.particle_at(until_s));
        }
        true
    }

    fn restart_paths(&mut self, state: &GasState) {
        for (disc, particle) in self.states.discs.iter_mut().zip(state.particles.iter()) {
            disc.particle = particle;
            disc.time_s = self.states.time_s;
            disc.path_changes = disc.path_changes.wrapping_add(1);
        }
        self.predict_all();
    }

    fn open_window(&mut self) {
        self.states.tally.window_collisions = 0;
        self.states.events.iter_mut().for_each(|events| events.clear());
    }

    fn conserves_invariants(&self) -> bool {
        false
    }

    fn center_limit_m(&self) -> Option<f64> {
        Some(self.states.center_limit_m)
    }

    fn pair_tally(&self) -> PairTally {
        self.states.tally
    }

    fn events(&self) -> Option<&EventRecord> {
        self.states.events.as_deref()
    }

    fn description(&self, state: &GasState) -> String {
        let disc_radius = state.container.circle.radius - self.states.center_limit_m;
        format!(
            "propagation: discs of radius {} m from collision to collision, exact at any time",
            short(disc_radius)
        )
    }
}

impl TryFrom<DiscStates> for CollidingDiscs {
    type Error = &'static str;

    /// Rejects states that no run can have: a checkpoint may contain any numbers.
    fn try_from(states: DiscStates) -> Result<Self, Self::Error> {
        if states.is_valid() { Ok(Self::of(states)) } else { Err("impossible discs") }
    }
}

impl DiscStates {
    /// Whether numbers are finite, cells exist and contain their discs, and partners exist.
    fn is_valid(&self) -> bool {
        let count = self.discs.len();
        let lengths = [self.center_limit_m, self.diameter_m];
        let has_lengths = lengths.iter().all(|length| length.is_finite() && *length > 0.0);
        if count == 0 || !has_lengths || !self.time_s.is_finite() {
            return false;
        }
        let grid = grid(self.center_limit_m, self.diameter_m, count);
        let is_valid = |disc: &Disc| {
            let Particle { position, velocity } = disc.particle_at(self.time_s);
            let has_event = match disc.event {
                Event::Pair { partner, .. } => (partner as usize) < count,
                Event::Wall => true,
                Event::Crossing(next) => grid.contains(next, grid.point(next, [0.0; 2])),
            };
            let limit = self.center_limit_m * (1.0 + 1e-6);
            has_event
                && velocity.iter().all(|component| component.is_finite())
                && grid.contains(disc.cell, position)
                && dot(position, position) <= limit * limit
                && disc.time_s <= self.time_s * (1.0 + 1e-9)
                // An event that rounding placed before the present occurs now.
                && disc.event_s >= self.time_s * (1.0 - 1e-9)
        };
        self.mass_ratios.len() == count
            && self.tally.collisions < 1 << 60
            && self.tally.virial.is_finite()
            && self.discs.iter().all(is_valid)
    }
}

impl CollidingDiscs {
    /// Discs with their cells and the order of their events.
    fn of(states: DiscStates) -> Self {
        let count = states.discs.len();
        let mut cells = CellLists::new(grid(states.center_limit_m, states.diameter_m, count));
        for (id, disc) in states.discs.iter().enumerate() {
            cells.insert(id as u32, disc.cell, count);
        }
        let times = states.discs.iter().map(|disc| disc.event_s);
        let tournament = TournamentTree::new(times.collect());
        Self { states, cells, tournament }
    }
}

impl From<CollidingDiscs> for DiscStates {
    fn from(discs: CollidingDiscs) -> Self {
        discs.states
    }
}

impl CollidingDiscs {
    /// Discs at time 0, which record their collisions or not; rejected if two overlap or one intersects the wall.
    pub(super) fn new(
        duration_s: f64,
        disc_radius_m: f64,
        state: &GasState,
        records_events: bool,
    ) -> Result<Self, SetupError> {
        let center_limit_m = state.container.circle.radius - disc_radius_m;
        let diameter_m = 2.0 * disc_radius_m;
        let grid = grid(center_limit_m, diameter_m, state.particles.len());
        let discs = state.particles.iter().map(|particle| Disc {
            particle,
            time_s: 0.0,
            cell: grid.cell_at(particle.position),
            path_changes: 0,
            event: Event::Wall,
            event_s: f64::INFINITY,
        });
        let mut colliding = Self::of(DiscStates {
            duration_s,
            center_limit_m,
            diameter_m,
            time_s: 0.0,
            mass_ratios: state.substance.mass_ratios.clone(),
            discs: discs.collect(),
            tally: PairTally::default(),
            events: records_events.then(Box::default),
        });
        colliding.check_overlaps()?;
        colliding.predict_all();
        Ok(colliding)
    }

    /// Rejects a start in which discs overlap or intersect the wall.
    fn check_overlaps(&self) -> Result<(), SetupError> {
        let DiscStates { center_limit_m, diameter_m, discs, .. } = &self.states;
        let min_distance = diameter_m * (1.0 - OVERLAP_TOLERANCE);
        for (id, disc) in discs.iter().enumerate() {
            let position = disc.particle.position;
            let distance = dot(position, position).sqrt();
            if distance > center_limit_m * (1.0 + OVERLAP_TOLERANCE) {
                return Err(SetupError::new(
                    format!(
                        "disc {id} (counted from 0) is {distance} m from the center and intersects the wall"
                    ),
                    format!(
                        "move its center to within radius_m - disc_radius_m = {center_limit_m} m"
                    ),
                ));
            }
            for other in self.cells.discs_around(disc.cell).filter(|other| (*other as usize) < id) {
                let [x, y] = discs[other as usize].particle.position;
                let separation = [x - position[0], y - position[1]];
                if dot(separation, separation) < min_distance * min_distance {
                    return Err(SetupError::new(
                        format!("discs {other} and {id} (counted from 0) overlap"),
                        "increase their distance or reduce disc_radius_m",
                    ));
                }
            }
        }
        Ok(())
    }

    fn predict_all(&mut self) {
        for disc in 0..self.states.discs.len() as u32 {
            self.predict(disc);
        }
    }

    /// Executes the event of a disc at the current time.
    fn execute_event(&mut self, disc: u32, wall: &mut WallTallies) {
        self.synchronize(disc);
        match self.states.discs[disc as usize].event {
            Event::Wall => self.collide_with_wall(disc, wall),
            Event::Crossing(next) => {
                let count = self.states.discs.len();
                let cell = &mut self.states.discs[disc as usize].cell;
                self.cells.remove(disc, *cell);
                *cell = next;
                self.cells.insert(disc, next, count);
            }
            Event::Pair { partner, path_changes } => {
                if self.states.discs[partner as usize].path_changes == path_changes {
                    self.synchronize(partner);
                    self.collide(disc, partner, wall);
                    self.predict(partner);
                }
            }
        }
        self.predict(disc);
    }

    /// Moves a disc to the current time.
    fn synchronize(&mut self, disc: u32) {
        let now = self.states.time_s;
        let disc = &mut self.states.discs[disc as usize];
        (disc.particle, disc.time_s) = (disc.particle_at(now), now);
    }

    fn collide_with_wall(&mut self, id: u32, wall: &mut WallTallies) {
        let mass = self.states.mass_ratios[id as usize];
        let center_limit = self.states.center_limit_m;
        let disc = &mut self.states.discs[id as usize];
        let Particle { position, velocity } = disc.particle;
        let outward = dot(position, velocity) / center_limit;
        if outward > 0.0 {
            disc.particle = reflected(disc.particle);
            disc.path_changes = disc.path_changes.wrapping_add(1);
            let after = disc.particle.velocity;
            wall.add(1, 2.0 * mass * outward);
            let impulse = [0, 1].map(|axis| mass * (after[axis] - velocity[axis]));
            self.record([id; 2], impulse, position, wall);
        }
    }

    fn collide(&mut self, first: u32, second: u32, wall: &WallTallies) {
        let pair = [first as usize, second as usize];
        let masses = pair.map(|disc| self.states.mass_ratios[disc]);
        let particles = pair.map(|disc| self.states.discs[disc].particle);
        let collision = elastic_collision(particles, masses);
        for (disc, velocity) in pair.into_iter().zip(collision.velocities) {
            let disc = &mut self.states.discs[disc];
            disc.particle.velocity = velocity;
            disc.path_changes = disc.path_changes.wrapping_add(1);
        }
        let tally = &mut self.states.tally;
        tally.collisions += 1;
        tally.window_collisions += 1;
        tally.virial.add(collision.virial);
        let [one, other] = particles;
        let after = collision.velocities[0];
        let impulse = [0, 1].map(|axis| masses[0] * (after[axis] - one.velocity[axis]));
        let separation = [0, 1].map(|axis| other.position[axis] - one.position[axis]);
        self.record([first, second], impulse, separation, wall);
    }

    /// Appends the collision that was just counted, if collisions are recorded.
    fn record(
        &mut self,
        discs: [u32; 2],
        impulse: [f64; 2],
        separation: [f64; 2],
        wall: &WallTallies,
    ) {
        let number = wall.total.collisions + self.states.tally.collisions;
        if let Some(events) = &mut self.states.events {
            events.push((number, self.states.time_s), discs, impulse, separation);
        }
    }

    /// Predicts the earliest event of a disc at the current time.
    fn predict(&mut self, disc: u32) {
        let DiscStates { center_limit_m, diameter_m, time_s: now, discs, .. } = &self.states;
        let Disc { particle, cell, .. } = discs[disc as usize];
        let Particle { position: [px, py], velocity: [ux, uy] } = particle;
        let (to_crossing, next) = first_crossing(&self.cells.grid, cell, particle);
        let (mut delay, mut event) = (to_crossing, Event::Crossing(next));
        let to_wall = delay_to_wall(particle, *center_limit_m);
        if to_wall < delay {
            (delay, event) = (to_wall, Event::Wall);
        }
        // The order of the discs in a cell depends on their history; among equal times, the lower number takes precedence.
        let mut earliest_partner = NO_DISC;
        for partner in self.cells.discs_around(cell).filter(|partner| *partner != disc) {
            let other = &discs[partner as usize];
            let Particle { position: [x, y], velocity: [vx, vy] } = other.particle_at(*now);
            let to_contact = time_to_contact([x - px, y - py], [vx - ux, vy - uy], *diameter_m);
            let is_tie = to_contact == delay && earliest_partner != NO_DISC;
            if to_contact < delay || (is_tie && partner < earliest_partner) {
                (delay, earliest_partner) = (to_contact, partner);
                event = Event::Pair { partner, path_changes: other.path_changes };
            }
        }
        let event_s = now + delay;
        let record = &mut self.states.discs[disc as usize];
        (record.event, record.event_s) = (event, event_s);
        self.tournament.set(disc, event_s);
    }
}

impl Disc {
    fn particle_at(&self, time_s: f64) -> Particle {
        drifted(self.particle, time_s - self.time_s)
    }
}

/// Time to the wall, s, but at least that of the minimum chord.
fn delay_to_wall(particle: Particle, center_limit_m: f64) -> f64 {
    let delay = time_to_wall(particle, center_limit_m);
    if dot(particle.position, particle.velocity) > 0.0 {
        return delay;
    }
    let min_delay = MIN_CHORD * center_limit_m / particle.speed();
    if delay < min_delay { min_delay } else { delay }
}

/// Square grid over the container, about one cell per disc. Cells are wider than a disc: discs in contact are in the same or adjacent
/// cells.
fn grid(center_limit_m: f64, diameter_m: f64, discs: usize) -> CellGrid {
    let side = 2.0 * center_limit_m;
    // The cast saturates.
    let fitting = (side / (diameter_m * MIN_CELL_WIDTH)) as u32;
    let count = fitting.min((discs as f64).sqrt() as u32 + 1);
    CellGrid::new([-center_limit_m; 2], [side; 2], [count; 2], false)
}

/// Time until a disc enters another cell, and that cell; [`f64::MAX`] if it stays.
fn first_crossing(grid: &CellGrid, cell: Cell, particle: Particle) -> (f64, Cell) {
    let mut earliest = (f64::MAX, cell);
    for (axis, &velocity) in particle.velocity.iter().enumerate() {
        let is_upper = velocity > 0.0;
        if velocity == 0.0 || grid.is_at_edge(cell, axis, is_upper) {
            continue;
        }
        let delay = (grid.edge(cell, axis, is_upper) - particle.position[axis]) / velocity;
        let delay = if delay > 0.0 { delay } else { 0.0 };
        if delay < earliest.0 {
            earliest = (delay, grid.neighbor(cell, Side::along(axis, is_upper)));
        }
    }
    earliest
}
