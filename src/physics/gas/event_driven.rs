//! Event-driven propagator of points for a thermal wall or a wall with an opening: exact, from wall collision to wall collision. Between
//! two of them, a path is the closed form of `motion.rs`, also if the wall moves.

use super::clock::Clock;
use super::motion::{ChordPath, Circle, Particle, dot, drifted};
use super::particle_groups::{BLOCK, Group, LANES};
use super::pressure::speed_at;
use super::propagator::Propagator;
use super::state::{Container, GasState, Substance};
use super::tallies::WallTally;
use crate::model::Target;
use crate::random::{Seed, Stream};
use crate::sum::CompensatedSum;
use kinetoscope_manifest::model::GasConfig;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Paths of all particles between wall collisions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct EventDriven {
    duration_s: f64,
    time_s: f64,
    wall: Wall,
    paths: Vec<Path>,
}

/// What happens to a particle that reaches the wall: it leaves through the opening, is re-emitted thermally or is reflected specularly.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Wall {
    circle: Circle,
    half_opening_rad: Option<f64>,
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

/// Path of one particle since the wall last changed it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Path {
    /// In scaled lengths and times; replaced by free flight from `exit` outside the container.
    chords: ChordPath,
    /// State in which the particle left through the opening.
    exit: Option<Particle>,
    /// Start of the path, s.
    started_s: f64,
    /// Wall collisions since the start of the path.
    collisions: u64,
    /// Wall collisions since the start of the run: the number of the next draw.
    draws: u64,
    mass_ratio: f64,
}

/// Exchange of a block of particles with the wall; energies per first mass, m^2/s^2.
#[derive(Clone, Copy, Debug, Default)]
struct WallExchange {
    wall: WallTally,
    heat: CompensatedSum,
    escaped_energy: CompensatedSum,
    escaped: u64,
}

impl EventDriven {
    /// The scheme at time 0.
    pub(super) fn new(config: &GasConfig, seed: Seed, state: &GasState) -> Self {
        let wall = Wall::new(config, seed, &state.substance, &state.container);
        let particles = state.particles.iter().zip(&state.substance.mass_ratios);
        let paths = particles.map(|(particle, ratio)| wall.start_path(particle, 0.0, *ratio));
        let (duration_s, paths) = (config.duration_s.get(), paths.collect());
        Self { duration_s, time_s: 0.0, wall, paths }
    }
}

impl Propagator for EventDriven {
    fn clock(&self) -> Clock {
        Clock::Continuous { time_s: self.time_s, duration_s: self.duration_s }
    }

    /// Moves all particles to a time, in blocks of fixed size.
    fn is_valid_for(&self, state: &GasState, max_speed: f64) -> bool {
        let circle = state.container.circle;
        let is_inside_now = circle.radius_at(self.time_s) > 0.0;
        self.paths.len() == state.particles.len()
            && self.wall.circle == circle
            && self.wall.half_opening_rad == state.container.half_opening_rad
            && self.wall.emission.is_none_or(|emission| emission.is_valid(max_speed))
            && is_inside_now
            && self.paths.iter().zip(&state.substance.mass_ratios).all(|(path, &mass_ratio)| {
                path.mass_ratio == mass_ratio
                    && (0.0..=self.time_s * (1.0 + 1e-9)).contains(&path.started_s)
                    && path.is_valid(circle, max_speed)
            })
    }

    fn advance(&mut self, target: Target, _budget: &mut u64, state: &mut GasState) -> bool {
        let Target::Time(until_s) = target else { return true };
        let wall = self.wall;
        let blocks: Vec<WallExchange> = self
            .paths
            .par_chunks_mut(BLOCK * LANES)
            .zip(state.particles.groups.par_chunks_mut(BLOCK))
            .enumerate()
            .map(|(block, (paths, groups))| {
                wall.advance_block(block * BLOCK * LANES, paths, groups, until_s)
            })
            .collect();
        let mut sums = WallExchange::default();
        for block in &blocks {
            sums.wall.add(block.wall.collisions, block.wall.impulse_per_mass.value());
            sums.heat.add(block.heat.value());
            sums.escaped_energy.add(block.escaped_energy.value());
            sums.escaped += block.escaped;
        }
        state.wall.add(sums.wall.collisions, sums.wall.impulse_per_mass.value());
        let balance = &mut state.energy_balance;
        balance.heat.add(sums.heat.value());
        balance.escaped_energy.add(sums.escaped_energy.value());
        balance.escaped += sums.escaped;
        self.time_s = until_s;
        true
    }

    fn restart_paths(&mut self, state: &GasState) {
        for (id, path) in self.paths.iter_mut().enumerate() {
            if path.exit.is_none() {
                self.wall.restart_path(path, state.particles.get(id), self.time_s);
            }
        }
    }

    fn is_inside(&self, id: usize) -> bool {
        self.paths[id].exit.is_none()
    }

    fn conserves_invariants(&self) -> bool {
        self.wall.emission.is_none()
    }

    fn description(&self, _state: &GasState) -> String {
        "propagation: closed form between wall collisions, exact at any time".to_owned()
    }
}

impl ThermalEmission {
    fn is_valid(&self, max_speed: f64) -> bool {
        (0.0..=max_speed).contains(&self.thermal_speed) && (0.0..=1.0).contains(&self.accommodation)
    }
}

impl Path {
    /// Whether the path is possible in a container; an open path begins where the particle left.
    fn is_valid(&self, circle: Circle, max_speed: f64) -> bool {
        // A scaled velocity is R v - u p.
        let radius = circle.radius_at(self.started_s);
        let scaled = radius * max_speed + (circle.wall_speed * radius).abs();
        let is_finite = |particle: Particle| {
            let numbers = [particle.position, particle.velocity];
            numbers.iter().flatten().all(|number| number.is_finite())
        };
        self.chords.is_in_unit_circle(2.0 * scaled)
            && self.exit.is_none_or(is_finite)
            && self.collisions < 1 << 60
            && self.draws < 1 << 60
    }
}

impl Wall {
    fn new(config: &GasConfig, seed: Seed, substance: &Substance, container: &Container) -> Self {
        let emission = config.thermal_wall.map(|wall| {
            let temperature_k = wall.temperature_k.get();
            // k_B T = m s^2 for one component, 2 k_B T = m v^2 for both.
            let speed = speed_at(temperature_k, substance.mass_kg, substance.boltzmann_j_per_k);
            ThermalEmission {
                thermal_speed: speed / std::f64::consts::SQRT_2,
                accommodation: wall.accommodation.get(),
                seed,
            }
        });
        Self { circle: container.circle, half_opening_rad: container.half_opening_rad, emission }
    }

    /// Path of a particle that starts at the given time.
    fn start_path(&self, particle: Particle, time_s: f64, mass_ratio: f64) -> Path {
        let scaled = self.circle.restarted_at(time_s).scaled(particle, 0.0);
        let chords = ChordPath::of(scaled, 1.0);
        Path { chords, exit: None, started_s: time_s, collisions: 0, draws: 0, mass_ratio }
    }

    /// Replaces a path by that of the given particle; the numbers of the draws continue.
    fn restart_path(&self, path: &mut Path, particle: Particle, time_s: f64) {
        *path = Path { draws: path.draws, ..self.start_path(particle, time_s, path.mass_ratio) };
    }

    fn advance_block(
        &self,
        first_id: usize,
        paths: &mut [Path],
        groups: &mut [Group],
        until_s: f64,
    ) -> WallExchange {
        let mut exchange = WallExchange::default();
        for (index, path) in paths.iter_mut().enumerate() {
            let id = (first_id + index) as u64;
            while self.collide_next(id, path, until_s, &mut exchange) {}
            groups[index / LANES].set(index % LANES, self.particle_at(path, until_s));
        }
        exchange
    }

    fn particle_at(&self, path: &Path, time_s: f64) -> Particle {
        let time = time_s - path.started_s;
        if let Some(exit) = path.exit {
            return drifted(exit, time);
        }
        let circle = self.circle.restarted_at(path.started_s);
        let scaled = path.chords.particle_after(path.collisions, circle.scaled_time(time));
        circle.unscaled(scaled, time)
    }

    /// Executes the next wall collision of a particle unless it comes after `until_s`, and returns whether there was one. Grazing paths
    /// have no collisions.
    fn collide_next(
        &self,
        id: u64,
        path: &mut Path,
        until_s: f64,
        exchange: &mut WallExchange,
    ) -> bool {
        let chords = path.chords;
        if path.exit.is_some() || chords.speed == 0.0 || chords.is_grazing() {
            return false;
        }
        let circle = self.circle.restarted_at(path.started_s);
        let scaled_time = chords.time_of_collision(path.collisions + 1);
        if scaled_time > circle.scaled_time(until_s - path.started_s) {
            return false;
        }
        let time = circle.time_of(scaled_time);
        let before = chords.particle_after(path.collisions, scaled_time);
        let incident = circle.unscaled(before, time);
        let energy =
            |particle: &Particle| path.mass_ratio * dot(particle.velocity, particle.velocity) / 2.0;
        let [x, y] = before.position;
        if self.half_opening_rad.is_some_and(|half| libm::atan2(y, x).abs() < half) {
            exchange.escaped += 1;
            exchange.escaped_energy.add(energy(&incident));
            (path.exit, path.started_s) = (Some(incident), path.started_s + time);
            return true;
        }
        path.collisions += 1;
        path.draws += 1;
        let normal_speed = chords.speed * chords.half_chord;
        match self.emitted_velocity(id, path) {
            None => {
                let impulse = circle.impulse_of_collision(normal_speed, scaled_time);
                exchange.wall.add(1, path.mass_ratio * impulse);
            }
            Some([normal, tangential]) => {
                let normal_in =
                    normal_speed * (1.0 / circle.radius - circle.wall_speed * scaled_time);
                let impulse = path.mass_ratio * (normal_in + normal);
                let emitted = self.emitted(incident, [normal, tangential]);
                exchange.wall.add(1, impulse);
                let work = -self.circle.wall_speed * impulse;
                exchange.heat.add(energy(&emitted) - energy(&incident) - work);
                self.restart_path(path, emitted, path.started_s + time);
            }
        }
        true
    }

    /// Velocity components (inward normal g, tangential t) of a thermally emitted particle relative to the wall, m/s; `None` for a
    /// specular reflection. They have the flux distribution of a Maxwellian gas: g exp(-g^2/2s^2) and exp(-t^2/2s^2), s^2 = k_B T/m
    /// (Maxwell, Phil. Trans. 170 (1879) 231).
    fn emitted_velocity(&self, id: u64, path: &Path) -> Option<[f64; 2]> {
        let emission = self.emission?;
        // The low half of the collision number: the draws of a particle repeat after 4e9 collisions.
        let position = id << 32 | (path.draws & 0xffff_ffff);
        let mut draws = emission.seed.stream_at(Stream::ThermalWall, position);
        if draws.uniform() >= emission.accommodation {
            return None;
        }
        let speed = emission.thermal_speed / path.mass_ratio.sqrt();
        let inward = speed * (-2.0 * libm::log(1.0 - draws.uniform())).sqrt();
        Some([inward, speed * draws.normal_pair()[0]])
    }

    /// Particle at the wall with its velocity replaced by the emitted one.
    fn emitted(&self, incident: Particle, [normal, tangential]: [f64; 2]) -> Particle {
        let [x, y] = incident.position;
        let distance = dot(incident.position, incident.position).sqrt();
        let [nx, ny] = [x / distance, y / distance];
        let outward = self.circle.wall_speed - normal;
        Particle {
            position: incident.position,
            velocity: [outward * nx - tangential * ny, outward * ny + tangential * nx],
        }
    }
}
