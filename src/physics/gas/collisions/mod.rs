//! Discs in the circle that collide with one another, from event to event: a cost of log N an event.
//!
//! Each disc carries its own clock: it stands where its last event left it. Each has one event, its soonest, found among the discs of
//! its cell and the cells around. A collision predicted with a partner that has turned aside since is void, which is found out when its
//! time comes (Lubachevsky, J. Comput. Phys. 94, 255 (1991)).

mod cells;
mod soonest;

use self::cells::{Cell, Cells};
use self::soonest::Soonest;
use super::groups::Particles;
use super::motion::{Particle, dot, drifted, elastic_impact, reflected, time_to_wall};
use super::wall::WallLedger;
use crate::collision_time::time_to_contact;
use crate::model::SetupError;
use crate::sum::CompensatedSum;
use serde::{Deserialize, Serialize};

/// A chord shorter than this share of the radius leaves the wall by less than rounding (its square over 8): a disc that slides along the
/// wall is mirrored after so long a way.
const SHORTEST_CHORD: f64 = 1.5e-8;

/// Overlap, over the diameter, that written decimals may have.
const WRITTEN_IN_TOUCH: f64 = 1e-9;

/// No disc has this number.
const NOBODY: u32 = u32::MAX;

/// All discs and what will happen to them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "State", into = "State")]
pub(super) struct Discs {
    state: State,
    /// From here on all is found again from the state.
    cells: Cells,
    soonest: Soonest,
}

/// What the future depends on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct State {
    /// Radius of the circle that the centers keep to: the container's less a disc's, m.
    reach_m: f64,
    diameter_m: f64,
    /// Time of the last event or target, s.
    time_s: f64,
    /// Each disc's mass over the first one's.
    mass_ratios: Vec<f64>,
    discs: Vec<Disc>,
    tally: PairTally,
}

/// Collisions of discs with one another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct PairTally {
    /// Since the start.
    pub(super) collisions: u64,
    /// Since the last frame.
    pub(super) window: u64,
    /// Sum of distance times momentum handed over since the start, over the first mass, m^2/s.
    pub(super) virial: CompensatedSum,
}

/// A disc as its last event left it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Disc {
    particle: Particle,
    /// When that was, s.
    time_s: f64,
    cell: Cell,
    /// How often its path was turned, modulo 2^32.
    turns: u32,
    /// Its soonest event, and when that is, s.
    event: Event,
    event_s: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Event {
    /// It meets a disc, if that has been turned only so often by then.
    Pair {
        partner: u32,
        turns: u32,
    },
    Wall,
    /// It enters another cell.
    Crossing(Cell),
}

impl From<State> for Discs {
    fn from(state: State) -> Self {
        let mut cells = Cells::new(state.reach_m, state.diameter_m, state.discs.len());
        for (id, disc) in state.discs.iter().enumerate() {
            cells.insert(disc.cell, id as u32);
        }
        let soonest = Soonest::of(state.discs.iter().map(|disc| disc.event_s).collect());
        Self { state, cells, soonest }
    }
}

impl From<Discs> for State {
    fn from(discs: Discs) -> Self {
        discs.state
    }
}

impl Discs {
    /// Discs at time 0 in a container of this radius; refused where two overlap or one reaches through the wall.
    pub(super) fn new(
        particles: &[Particle],
        mass_ratios: &[f64],
        container_radius_m: f64,
        disc_radius_m: f64,
    ) -> Result<Self, SetupError> {
        let (reach_m, diameter_m) = (container_radius_m - disc_radius_m, 2.0 * disc_radius_m);
        let cells = Cells::new(reach_m, diameter_m, particles.len());
        let begun = particles.iter().map(|&particle| Disc {
            particle,
            time_s: 0.0,
            cell: cells.cell_of(particle.position),
            turns: 0,
            event: Event::Wall,
            event_s: f64::INFINITY,
        });
        let mut discs = Self::from(State {
            reach_m,
            diameter_m,
            time_s: 0.0,
            mass_ratios: mass_ratios.to_vec(),
            discs: begun.collect(),
            tally: PairTally::default(),
        });
        discs.check_room()?;
        discs.predict_all();
        Ok(discs)
    }

    /// Refuses a start without room for its discs.
    fn check_room(&self) -> Result<(), SetupError> {
        let State { reach_m, diameter_m, discs, .. } = &self.state;
        let touching = diameter_m * (1.0 - WRITTEN_IN_TOUCH);
        for (id, disc) in discs.iter().enumerate() {
            let place = disc.particle.position;
            let distance = dot(place, place).sqrt();
            if distance > reach_m * (1.0 + WRITTEN_IN_TOUCH) {
                return Err(SetupError(format!(
                    "disc {id} (counted from 0) is {distance} m from the center and reaches through the wall: \
                     keep centers within radius_m - disc_radius_m = {reach_m} m"
                )));
            }
            for other in self.cells.around(disc.cell).filter(|other| (*other as usize) < id) {
                let [x, y] = discs[other as usize].particle.position;
                let apart = [x - place[0], y - place[1]];
                if dot(apart, apart) < touching * touching {
                    return Err(SetupError(format!(
                        "discs {other} and {id} (counted from 0) overlap: move them apart or choose a smaller disc_radius_m"
                    )));
                }
            }
        }
        Ok(())
    }

    pub(super) fn time_s(&self) -> f64 {
        self.state.time_s
    }

    pub(super) fn tally(&self) -> &PairTally {
        &self.state.tally
    }

    /// Radius of the circle that the centers keep to, m.
    pub(super) fn reach_m(&self) -> f64 {
        self.state.reach_m
    }

    /// Starts "since the last frame" again from zero.
    pub(super) fn open_window(&mut self) {
        self.state.tally.window = 0;
    }

    /// Lets events happen up to a time, at most so many, which it counts down, and says whether the time is reached; then the
    /// particles stand where the discs are.
    pub(super) fn collide_until(
        &mut self,
        until_s: f64,
        at_most: &mut u64,
        wall: &mut WallLedger,
        particles: &mut Particles,
    ) -> bool {
        loop {
            let (disc, event_s) = self.soonest.first();
            if event_s > until_s {
                break;
            }
            if *at_most == 0 {
                return false;
            }
            *at_most -= 1;
            self.state.time_s = event_s;
            self.happen(disc, wall);
        }
        self.state.time_s = until_s;
        for (id, disc) in self.state.discs.iter().enumerate() {
            particles.set(id, disc.at(until_s));
        }
        true
    }

    /// Goes on with these particles, whose velocities somebody has changed.
    pub(super) fn rebegin(&mut self, particles: &Particles) {
        for (disc, particle) in self.state.discs.iter_mut().zip(particles.iter()) {
            disc.particle = particle;
            disc.time_s = self.state.time_s;
            disc.turns = disc.turns.wrapping_add(1);
        }
        self.predict_all();
    }

    fn predict_all(&mut self) {
        for disc in 0..self.state.discs.len() as u32 {
            self.predict(disc);
        }
    }

    /// The event of a disc, whose time it is.
    fn happen(&mut self, disc: u32, wall: &mut WallLedger) {
        self.bring_to_now(disc);
        match self.state.discs[disc as usize].event {
            Event::Wall => self.meet_wall(disc, wall),
            Event::Crossing(next) => {
                let cell = &mut self.state.discs[disc as usize].cell;
                self.cells.remove(*cell, disc);
                *cell = next;
                self.cells.insert(next, disc);
            }
            Event::Pair { partner, turns } => {
                if self.state.discs[partner as usize].turns == turns {
                    self.bring_to_now(partner);
                    self.meet(disc, partner);
                    self.predict(partner);
                }
            }
        }
        self.predict(disc);
    }

    fn bring_to_now(&mut self, disc: u32) {
        let now = self.state.time_s;
        let disc = &mut self.state.discs[disc as usize];
        (disc.particle, disc.time_s) = (disc.at(now), now);
    }

    fn meet_wall(&mut self, disc: u32, wall: &mut WallLedger) {
        let (reach, mass) = (self.state.reach_m, self.state.mass_ratios[disc as usize]);
        let disc = &mut self.state.discs[disc as usize];
        let Particle { position, velocity } = disc.particle;
        let outwards = dot(position, velocity) / reach;
        if outwards > 0.0 {
            disc.particle = reflected(disc.particle);
            disc.turns = disc.turns.wrapping_add(1);
            wall.total.add(1, 2.0 * mass * outwards);
            wall.window.add(1, 2.0 * mass * outwards);
        }
    }

    fn meet(&mut self, first: u32, second: u32) {
        let pair = [first as usize, second as usize];
        let masses = pair.map(|disc| self.state.mass_ratios[disc]);
        let impact = elastic_impact(pair.map(|disc| self.state.discs[disc].particle), masses);
        for (disc, velocity) in pair.into_iter().zip(impact.velocities) {
            let disc = &mut self.state.discs[disc];
            disc.particle.velocity = velocity;
            disc.turns = disc.turns.wrapping_add(1);
        }
        let tally = &mut self.state.tally;
        tally.collisions += 1;
        tally.window += 1;
        tally.virial.add(impact.virial);
    }

    /// Finds the soonest event of a disc that stands where it is now.
    fn predict(&mut self, disc: u32) {
        let State { reach_m, diameter_m, time_s: now, discs, .. } = &self.state;
        let Disc { particle, cell, .. } = discs[disc as usize];
        let Particle { position: place, velocity } = particle;
        let (crossing, next) = self.cells.crossing(cell, place, velocity);
        let (mut wait, mut event) = (crossing, Event::Crossing(next));
        let to_wall = wait_for_wall(particle, *reach_m);
        if to_wall < wait {
            (wait, event) = (to_wall, Event::Wall);
        }
        // The order of a cell's discs depends on how they came there: of equal times the lower number wins.
        let mut met = NOBODY;
        for partner in self.cells.around(cell).filter(|partner| *partner != disc) {
            let other = &discs[partner as usize];
            let Particle { position: [x, y], velocity: [vx, vy] } = other.at(*now);
            let (r, v) = ([x - place[0], y - place[1]], [vx - velocity[0], vy - velocity[1]]);
            let to_contact = time_to_contact(r, v, *diameter_m);
            let as_soon = to_contact == wait && met != NOBODY;
            if to_contact < wait || (as_soon && partner < met) {
                (wait, met) = (to_contact, partner);
                event = Event::Pair { partner, turns: other.turns };
            }
        }
        let event_s = now + wait;
        let record = &mut self.state.discs[disc as usize];
        (record.event, record.event_s) = (event, event_s);
        self.soonest.set(disc, event_s);
    }
}

impl Disc {
    fn at(&self, time_s: f64) -> Particle {
        drifted(self.particle, time_s - self.time_s)
    }
}

/// Time to the wall; of a chord so short that it would be rounding, the time of the shortest.
fn wait_for_wall(particle: Particle, reach_m: f64) -> f64 {
    let wait = time_to_wall(particle, reach_m);
    if dot(particle.position, particle.velocity) > 0.0 {
        return wait;
    }
    let shortest = SHORTEST_CHORD * reach_m / particle.speed();
    if wait < shortest { shortest } else { wait }
}
