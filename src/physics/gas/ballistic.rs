//! Propagator of points in uniform gravity or behind a partition: exact, from collision to collision.
//!
//! Between two collisions, a particle moves on the parabola of `parabola.rs`, or on a straight line without gravity. The circular wall
//! and, until it is removed, the partition reflect it specularly. Its energy is that of the start to rounding, because each reflection
//! restores it.

use super::clock::Clock;
use super::motion::{Particle, dot, reflected, time_to_wall};
use super::parabola::{energy_per_mass, flown, time_to_wall_in_gravity};
use super::particle_groups::{BLOCK, Group, LANES};
use super::propagator::Propagator;
use super::state::GasState;
use super::tallies::WallTally;
use crate::model::Target;
use kinetoscope_manifest::model::GasConfig;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Minimum normal speed after a reflection over the speed scale sqrt(v^2 + g R). A particle that slides along the wall makes hops with
/// a height of about 1e-12 R, so that the number of collisions is finite.
const MIN_NORMAL_SPEED: f64 = 1e-6;

/// Maximum relative correction of v^2 by the conserved energy: more is not rounding, but a particle almost at rest.
const MAX_CORRECTION: f64 = 1e-6;

/// Paths of all particles between collisions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Ballistic {
    duration_s: f64,
    time_s: f64,
    space: Space,
    paths: Vec<Path>,
    /// How far each block of particles is on the way to the present target; empty at a target.
    blocks: Vec<Progress>,
}

/// How far a block of particles is on the way to a target. The particles move one after another, so that the sums do not depend on
/// the number of calls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Progress {
    /// Number of particles at the target.
    arrived: usize,
    tally: WallTally,
}

/// What acts on the particles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Space {
    radius: f64,
    /// Toward -y, m/s^2.
    gravity: f64,
    partition: Option<PartitionWall>,
}

/// A partition relative to the center of the container.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct PartitionWall {
    x: f64,
    /// When it is removed, s; `None` if it stays.
    opens_s: Option<f64>,
}

/// Path of one particle since its last collision.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Path {
    start: Particle,
    /// Start of the path, s.
    started_s: f64,
    /// Whether the particle is to the left of the partition.
    is_left: bool,
    /// Conserved energy per mass, m^2/s^2.
    energy: f64,
    mass_ratio: f64,
}

/// What a particle meets next.
enum Obstacle {
    Wall,
    Partition,
}

impl Space {
    fn new(config: &GasConfig) -> Self {
        let partition = config.partition.map(|partition| PartitionWall {
            x: partition.x_m.get() - config.center_m[0].get(),
            opens_s: partition.opens_s.map(|time| time.get()),
        });
        Self { radius: config.radius_m.get(), gravity: config.gravity_m_per_s2.get(), partition }
    }

    fn start_path(&self, particle: Particle, time_s: f64, mass_ratio: f64) -> Path {
        Path {
            start: particle,
            started_s: time_s,
            is_left: self.partition.is_some_and(|wall| particle.position[0] < wall.x),
            energy: energy_per_mass(particle, self.gravity, self.radius),
            mass_ratio,
        }
    }

    /// Time and kind of the next collision after the start of a path.
    fn next_collision(&self, path: &Path) -> (f64, Obstacle) {
        let wall = if self.gravity > 0.0 {
            time_to_wall_in_gravity(path.start, self.gravity, self.radius)
        } else {
            time_to_wall(path.start, self.radius)
        };
        match self.time_to_partition(path) {
            Some(time) if time < wall => (time, Obstacle::Partition),
            _ => (wall, Obstacle::Wall),
        }
    }

    /// Time until a particle that moves toward the partition reaches it, u = (x_p - x) / v_x; `None` if it is removed before.
    fn time_to_partition(&self, path: &Path) -> Option<f64> {
        let wall = self.partition?;
        let [x, speed] = [path.start.position[0], path.start.velocity[0]];
        let time = if (speed > 0.0) == path.is_left && speed != 0.0 {
            let time = (wall.x - x) / speed;
            if time > 0.0 { time } else { 0.0 }
        } else {
            return None;
        };
        wall.opens_s.is_none_or(|opens| path.started_s + time < opens).then_some(time)
    }

    /// Moves a particle to a time through all its collisions, of which there may be as many as the budget; `None` if there are
    /// more.
    fn advance(
        &self,
        path: &mut Path,
        until_s: f64,
        tally: &mut WallTally,
        budget: &mut u64,
    ) -> Option<Particle> {
        loop {
            let (time, obstacle) = self.next_collision(path);
            if path.started_s + time > until_s || !time.is_finite() {
                return Some(flown(path.start, self.gravity, until_s - path.started_s));
            }
            *budget = budget.checked_sub(1)?;
            let incident = flown(path.start, self.gravity, time);
            let emitted = match obstacle {
                Obstacle::Partition => self.reflected_by_partition(incident),
                Obstacle::Wall => {
                    let (emitted, impulse) = self.reflected_by_wall(incident);
                    tally.add(1, path.mass_ratio * impulse);
                    emitted
                }
            };
            path.start = self.with_energy(emitted, path.energy);
            path.started_s += time;
        }
    }

    /// Reflection at the partition: x = x_p, v_x' = -v_x.
    fn reflected_by_partition(&self, incident: Particle) -> Particle {
        let Particle { position: [x, y], velocity: [vx, vy] } = incident;
        let x = self.partition.map_or(x, |wall| wall.x);
        Particle { position: [x, y], velocity: [-vx, vy] }
    }

    /// Reflection at the wall, and the impulse on it per mass, m/s. The position is moved onto the circle.
    fn reflected_by_wall(&self, incident: Particle) -> (Particle, f64) {
        let distance = dot(incident.position, incident.position).sqrt();
        let position = incident.position.map(|axis| axis * (self.radius / distance));
        let normal = position.map(|axis| axis / self.radius);
        let outward = dot(incident.velocity, normal);
        let mut emitted = reflected(Particle { position, ..incident });
        let inward = -dot(emitted.velocity, normal);
        let scale = dot(incident.velocity, incident.velocity) + self.gravity * self.radius;
        let missing = MIN_NORMAL_SPEED * scale.sqrt() - inward;
        if missing > 0.0 {
            let [vx, vy] = emitted.velocity;
            emitted.velocity = [vx - missing * normal[0], vy - missing * normal[1]];
        }
        (emitted, outward - dot(emitted.velocity, normal))
    }

    /// The particle with its velocity scaled to the conserved energy, in the last bits.
    fn with_energy(&self, particle: Particle, energy: f64) -> Particle {
        let square = dot(particle.velocity, particle.velocity);
        let lost = (energy - energy_per_mass(particle, self.gravity, self.radius)) / square;
        if lost.abs() < MAX_CORRECTION {
            let velocity = particle.velocity.map(|component| component + lost * component);
            return Particle { velocity, ..particle };
        }
        particle
    }
}

impl Ballistic {
    /// The scheme at time 0.
    pub(super) fn new(config: &GasConfig, state: &GasState) -> Self {
        let space = Space::new(config);
        let particles = state.particles.iter().zip(&state.substance.mass_ratios);
        let paths = particles.map(|(particle, ratio)| space.start_path(particle, 0.0, *ratio));
        let (duration_s, paths) = (config.duration_s.get(), paths.collect());
        Self { duration_s, time_s: 0.0, space, paths, blocks: Vec::new() }
    }

    /// Moves a block toward a time. The budget limits its collisions; returns whether all of its particles are there.
    fn advance_block(
        space: Space,
        until_s: f64,
        budget: u64,
        progress: &mut Progress,
        (paths, groups): (&mut [Path], &mut [Group]),
    ) -> bool {
        let mut budget = budget;
        while let Some(path) = paths.get_mut(progress.arrived) {
            let moved = space.advance(path, until_s, &mut progress.tally, &mut budget);
            let Some(particle) = moved else { return false };
            groups[progress.arrived / LANES].set(progress.arrived % LANES, particle);
            progress.arrived += 1;
        }
        true
    }

    /// Whether the scheme is that of a manifest.
    pub(super) fn is_of(&self, config: &GasConfig) -> bool {
        self.space == Space::new(config)
    }
}

impl Propagator for Ballistic {
    fn clock(&self) -> Clock {
        Clock::Continuous { time_s: self.time_s, duration_s: self.duration_s }
    }

    fn is_valid_for(&self, state: &GasState, max_speed: f64) -> bool {
        let Space { radius, gravity, .. } = self.space;
        let max_energy = max_speed * max_speed / 2.0 + 2.0 * gravity * radius;
        let reach = radius * radius * (1.0 + 1e-6);
        let blocks = state.particles.groups.chunks(BLOCK).len();
        let most = BLOCK * LANES;
        // On the way to a target, particles are ahead of the time.
        let reached_s = if self.blocks.is_empty() { self.time_s } else { self.duration_s };
        let last_start_s = reached_s * (1.0 + 1e-9);
        self.paths.len() == state.particles.len()
            && (self.blocks.is_empty() || self.blocks.len() == blocks)
            && self.blocks.iter().all(|block| block.arrived <= most && block.tally.is_finite())
            && self.paths.iter().zip(&state.substance.mass_ratios).all(|(path, &mass_ratio)| {
                let Path { start, energy, .. } = *path;
                path.mass_ratio == mass_ratio
                    && (0.0..=last_start_s).contains(&path.started_s)
                    && dot(start.position, start.position) <= reach
                    && (0.0..=2.0 * max_energy).contains(&energy)
                    && dot(start.velocity, start.velocity) <= 4.0 * max_energy
            })
    }

    /// Moves all particles to a time, in blocks of fixed size, each by as many collisions as the budget.
    fn advance(&mut self, target: Target, budget: &mut u64, state: &mut GasState) -> bool {
        let Target::Time(until_s) = target else { return true };
        let (space, share) = (self.space, *budget);
        let groups = state.particles.groups.par_chunks_mut(BLOCK);
        let blocks = self.paths.par_chunks_mut(BLOCK * LANES).zip(groups);
        self.blocks.resize(blocks.len(), Progress::default());
        let moved =
            self.blocks.par_iter_mut().zip(blocks).map(|(progress, block)| {
                Self::advance_block(space, until_s, share, progress, block)
            });
        let have_arrived: Vec<bool> = moved.collect();
        if have_arrived.contains(&false) {
            *budget = 0;
            return false;
        }
        for Progress { tally, .. } in self.blocks.drain(..) {
            state.wall.add(tally.collisions, tally.impulse_per_mass.value());
        }
        self.time_s = until_s;
        true
    }

    fn restart_paths(&mut self, state: &GasState) {
        for (path, particle) in self.paths.iter_mut().zip(state.particles.iter()) {
            *path = self.space.start_path(particle, self.time_s, path.mass_ratio);
        }
    }

    fn conserves_invariants(&self) -> bool {
        false
    }

    fn gravity_m_per_s2(&self) -> f64 {
        self.space.gravity
    }

    fn partition_m(&self) -> Option<f64> {
        self.space.partition.map(|wall| wall.x)
    }

    fn is_partition_closed(&self) -> bool {
        let wall = self.space.partition;
        wall.is_some_and(|wall| wall.opens_s.is_none_or(|opens| self.time_s < opens))
    }

    fn description(&self, _state: &GasState) -> String {
        if self.space.gravity > 0.0 {
            "propagation: parabolas between wall collisions, exact at any time".to_owned()
        } else {
            "propagation: straight lines between collisions with wall and partition, exact at any time".to_owned()
        }
    }
}
