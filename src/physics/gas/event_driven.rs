//! Event-driven propagator of points: exact, from one encounter to the next.
//!
//! A particle follows its path (`path.rs`) to what it meets next: the partition, which reflects it; the opening, through which it leaves;
//! or the wall, which re-emits it thermally or reflects it specularly. A particle that has left meets nothing more, not even the
//! container from outside.

use super::clock::Clock;
use super::motion::{Circle, Particle, dot};
use super::particle_groups::{BLOCK, Group, LANES};
use super::path::{Encounter, Obstacle, Path, Space};
use super::pressure::speed_at;
use super::propagator::Propagator;
use super::state::{Container, GasState, Substance};
use super::tallies::WallTally;
use crate::model::Target;
use crate::random::{Seed, Stream, flux_speed, normal};
use crate::sum::CompensatedSum;
use kinetoscope_manifest::model::GasConfig;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Paths of all particles between their encounters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct EventDriven {
    duration_s: f64,
    time_s: f64,
    surroundings: Surroundings,
    paths: Vec<Path>,
    /// How far each block of particles is on the way to the present target; empty at a target.
    blocks: Vec<Progress>,
}

/// Where the particles are, and the emission of a thermal wall.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Surroundings {
    space: Space,
    emission: Option<ThermalEmission>,
}

/// Diffuse emission of a thermal wall.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct ThermalEmission {
    /// sqrt(k_B T / m1) with the first mass m1, m/s.
    thermal_speed: f64,
    /// Fraction of the wall collisions that are not specular.
    accommodation: f64,
    seed: Seed,
}

/// How far a block of particles is on the way to a target. The particles move one after another, so that the sums do not depend on
/// the number of calls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Progress {
    /// Number of particles at the target.
    arrived: usize,
    exchange: WallExchange,
}

/// Exchange of particles with the wall; energies per first mass, m^2/s^2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct WallExchange {
    wall: WallTally,
    heat: CompensatedSum,
    escaped_energy: CompensatedSum,
    escaped: u64,
}

impl ThermalEmission {
    fn new(config: &GasConfig, seed: Seed, substance: &Substance) -> Option<Self> {
        let wall = config.thermal_wall?;
        // k_B T = m s^2 for one component, 2 k_B T = m v^2 for both.
        let temperature_k = wall.temperature_k.get();
        let speed = speed_at(temperature_k, substance.mass_kg, substance.boltzmann_j_per_k);
        let thermal_speed = speed / std::f64::consts::SQRT_2;
        Some(Self { thermal_speed, accommodation: wall.accommodation.get(), seed })
    }

    fn is_valid(&self, max_speed: f64) -> bool {
        (0.0..=max_speed).contains(&self.thermal_speed) && (0.0..=1.0).contains(&self.accommodation)
    }

    /// Velocity components (inward normal g, tangential t) of a thermally emitted particle relative to the wall, m/s; `None` for a
    /// specular reflection. They have the flux distribution of a Maxwellian gas: g exp(-g^2/2s^2) and exp(-t^2/2s^2), s^2 = k_B T/m
    /// (Maxwell, Phil. Trans. 170 (1879) 231).
    fn draw(&self, id: u64, number: u64, mass_ratio: f64) -> Option<[f64; 2]> {
        // The low half of the collision number: the draws of a particle repeat after 4e9 collisions.
        let position = id << 32 | (number & 0xffff_ffff);
        let [choice, inward, radius, angle, ..] =
            self.seed.uniforms_at(Stream::ThermalWall, position);
        if choice >= self.accommodation {
            return None;
        }
        let speed = self.thermal_speed / mass_ratio.sqrt();
        Some([speed * flux_speed(inward), speed * normal([radius, angle])])
    }
}

impl WallExchange {
    fn is_finite(&self) -> bool {
        let Self { wall, heat, escaped_energy, .. } = self;
        wall.is_finite() && heat.is_finite() && escaped_energy.is_finite()
    }

    fn add(&mut self, other: &Self) {
        self.wall.add(other.wall.collisions, other.wall.impulse_per_mass.value());
        self.heat.add(other.heat.value());
        self.escaped_energy.add(other.escaped_energy.value());
        self.escaped += other.escaped;
    }

    fn add_to(&self, state: &mut GasState) {
        state.wall.add(self.wall.collisions, self.wall.impulse_per_mass.value());
        let balance = &mut state.energy_balance;
        balance.heat.add(self.heat.value());
        balance.escaped_energy.add(self.escaped_energy.value());
        balance.escaped += self.escaped;
    }
}

impl Surroundings {
    /// Moves a particle to a time through all its encounters, of which there may be as many as the budget; `None` if there are more.
    fn advance(
        &self,
        id: u64,
        path: &mut Path,
        until_s: f64,
        exchange: &mut WallExchange,
        budget: &mut u64,
    ) -> Option<Particle> {
        while let Some(encounter) = self.space.next_encounter(path, until_s) {
            *budget = budget.checked_sub(1)?;
            match encounter.obstacle {
                Obstacle::Partition => {
                    self.space.reflect_by_partition(path, &encounter);
                }
                Obstacle::Opening => {
                    exchange.escaped += 1;
                    exchange.escaped_energy.add(self.energy(path, encounter.incident));
                    path.leave(&encounter);
                }
                Obstacle::Wall => self.collide(id, path, &encounter, exchange),
            }
        }
        Some(self.space.particle_at(path, until_s))
    }

    /// A collision with the wall: thermal re-emission or specular reflection.
    #[inline]
    fn collide(
        &self,
        id: u64,
        path: &mut Path,
        encounter: &Encounter,
        exchange: &mut WallExchange,
    ) {
        path.wall_collisions += 1;
        let mass_ratio = path.mass_ratio;
        let emission = self.emission;
        match emission.and_then(|wall| wall.draw(id, path.wall_collisions, mass_ratio)) {
            None => {
                let impulse = self.space.reflect_by_wall(path, encounter);
                exchange.wall.add(1, mass_ratio * impulse);
            }
            Some(velocity) => {
                let impulse = mass_ratio * (encounter.outward + velocity[0]);
                let emitted = emitted(&self.space.circle, encounter.incident, velocity);
                exchange.wall.add(1, impulse);
                let work = -self.space.circle.wall_speed * impulse;
                let [before, after] =
                    [encounter.incident, emitted].map(|particle| self.energy(path, particle));
                exchange.heat.add(after - before - work);
                let time_s = path.started_s + encounter.time;
                self.space.restart_path(path, emitted, time_s);
            }
        }
    }

    /// Energy per first mass, m^2/s^2.
    #[inline]
    fn energy(&self, path: &Path, particle: Particle) -> f64 {
        path.mass_ratio * self.space.energy_per_mass(particle)
    }

    /// Moves a block toward a time. The budget limits its encounters; returns whether all of its particles are there.
    fn advance_block(
        &self,
        first_id: usize,
        until_s: f64,
        mut budget: u64,
        progress: &mut Progress,
        (paths, groups): (&mut [Path], &mut [Group]),
    ) -> bool {
        while let Some(path) = paths.get_mut(progress.arrived) {
            let Progress { arrived, exchange } = progress;
            let id = (first_id + *arrived) as u64;
            let moved = self.advance(id, path, until_s, exchange, &mut budget);
            let Some(particle) = moved else { return false };
            groups[*arrived / LANES].set(*arrived % LANES, particle);
            *arrived += 1;
        }
        true
    }
}

/// Particle at the wall with its velocity replaced by the emitted one.
#[inline]
fn emitted(circle: &Circle, incident: Particle, [normal, tangential]: [f64; 2]) -> Particle {
    let [x, y] = incident.position;
    let distance = dot(incident.position, incident.position).sqrt();
    let [nx, ny] = [x / distance, y / distance];
    let outward = circle.wall_speed - normal;
    Particle {
        position: incident.position,
        velocity: [outward * nx - tangential * ny, outward * ny + tangential * nx],
    }
}

impl EventDriven {
    /// The scheme at time 0.
    pub(super) fn new(config: &GasConfig, seed: Seed, state: &GasState) -> Self {
        let space = Space::new(config, &state.container);
        let particles = state.particles.iter().zip(&state.substance.mass_ratios);
        let paths = particles.map(|(particle, ratio)| space.start_path(particle, 0.0, *ratio));
        Self {
            duration_s: config.duration_s.get(),
            time_s: 0.0,
            surroundings: Surroundings {
                space,
                emission: ThermalEmission::new(config, seed, &state.substance),
            },
            paths: paths.collect(),
            blocks: Vec::new(),
        }
    }

    /// Whether the scheme is that of a manifest.
    pub(super) fn is_of(&self, config: &GasConfig) -> bool {
        let Surroundings { space, emission } = &self.surroundings;
        *space == Space::new(config, &Container::new(config))
            && emission.is_some() == config.thermal_wall.is_some()
    }
}

impl Propagator for EventDriven {
    fn clock(&self) -> Clock {
        Clock::Continuous { time_s: self.time_s, duration_s: self.duration_s }
    }

    fn is_valid_for(&self, state: &GasState, max_speed: f64) -> bool {
        let Surroundings { space, emission } = &self.surroundings;
        let blocks = state.particles.groups.chunks(BLOCK).len();
        let most = BLOCK * LANES;
        // On the way to a target, particles are ahead of the time.
        let reached_s = if self.blocks.is_empty() { self.time_s } else { self.duration_s };
        let last_start_s = reached_s * (1.0 + 1e-9);
        let masses = &state.substance.mass_ratios;
        self.paths.len() == state.particles.len()
            && (self.blocks.is_empty() || self.blocks.len() == blocks)
            && self.blocks.iter().all(|block| block.arrived <= most && block.exchange.is_finite())
            && space.circle.radius_at(self.time_s) > 0.0
            && emission.is_none_or(|emission| emission.is_valid(max_speed))
            && self.paths.iter().zip(masses).all(|(path, &mass_ratio)| {
                path.mass_ratio == mass_ratio && path.is_valid_in(space, max_speed, last_start_s)
            })
    }

    /// Moves all particles to a time, in blocks of fixed size, each by as many encounters as the budget.
    fn advance(&mut self, target: Target, budget: &mut u64, state: &mut GasState) -> bool {
        let Target::Time(until_s) = target else { return true };
        let (surroundings, share) = (self.surroundings, *budget);
        let groups = state.particles.groups.par_chunks_mut(BLOCK);
        let blocks = self.paths.par_chunks_mut(BLOCK * LANES).zip(groups);
        self.blocks.resize(blocks.len(), Progress::default());
        let moved = self.blocks.par_iter_mut().zip(blocks).enumerate();
        let moved = moved.map(|(number, (progress, block))| {
            let first_id = number * BLOCK * LANES;
            surroundings.advance_block(first_id, until_s, share, progress, block)
        });
        let have_arrived: Vec<bool> = moved.collect();
        if have_arrived.contains(&false) {
            *budget = 0;
            return false;
        }
        let exchanges = self.blocks.drain(..).map(|block| block.exchange);
        // The last bits of a sum depend on its order. Recordings have these two.
        if surroundings.space.has_chords() {
            let mut sums = WallExchange::default();
            exchanges.for_each(|exchange| sums.add(&exchange));
            sums.add_to(state);
        } else {
            exchanges.for_each(|exchange| exchange.add_to(state));
        }
        self.time_s = until_s;
        true
    }

    fn restart_paths(&mut self, state: &GasState) {
        for (path, particle) in self.paths.iter_mut().zip(state.particles.iter()) {
            if path.is_inside() {
                self.surroundings.space.restart_path(path, particle, self.time_s);
            }
        }
    }

    fn is_inside(&self, id: usize) -> bool {
        self.paths[id].is_inside()
    }

    fn conserves_invariants(&self) -> bool {
        self.surroundings.space.has_chords() && self.surroundings.emission.is_none()
    }

    fn gravity_m_per_s2(&self) -> f64 {
        self.surroundings.space.gravity
    }

    fn partition_m(&self) -> Option<f64> {
        self.surroundings.space.partition.map(|wall| wall.x)
    }

    fn is_partition_closed(&self) -> bool {
        let wall = self.surroundings.space.partition;
        wall.is_some_and(|wall| wall.opens_s.is_none_or(|opens| self.time_s < opens))
    }

    fn description(&self, _state: &GasState) -> String {
        let Space { gravity, partition, .. } = self.surroundings.space;
        let paths = match (gravity > 0.0, partition) {
            (false, None) => "closed form between wall collisions",
            (true, None) => "parabolas between wall collisions",
            (false, Some(_)) => "straight lines between collisions with wall and partition",
            (true, Some(_)) => "parabolas between collisions with wall and partition",
        };
        format!("propagation: {paths}, exact at any time")
    }
}
