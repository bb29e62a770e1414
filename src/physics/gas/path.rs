//! Path of a point to what it meets next: the wall, its opening, or the partition.
//!
//! There are two kinds of paths. Without gravity and partition, it is the closed form of `motion.rs`: all chords at once, also if the wall
//! moves, so that specular reflections cause no rounding errors that add up. Otherwise, it is the parabola of `parabola.rs`, or a straight
//! line without gravity, from one collision to the next; each specular reflection restores the energy of the path.

use super::motion::{ChordPath, Circle, Particle, dot, reflected, time_to_wall};
use super::parabola::{energy_per_mass, flown, time_to_wall_in_gravity};
use super::state::Container;
use kinetoscope_manifest::model::GasConfig;
use serde::{Deserialize, Serialize};

/// Minimum normal speed after a reflection over the speed scale sqrt(v^2 + g R). A particle that slides along the wall makes hops with
/// a height of about 1e-12 R, so that the number of collisions is finite.
const MIN_NORMAL_SPEED: f64 = 1e-6;

/// Maximum relative correction of v^2 by the conserved energy: more is not rounding, but a particle almost at rest.
const MAX_CORRECTION: f64 = 1e-6;

/// What acts on the particles, and what they can meet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Space {
    pub(super) circle: Circle,
    half_opening_rad: Option<f64>,
    /// Toward -y, m/s^2.
    pub(super) gravity: f64,
    pub(super) partition: Option<PartitionWall>,
}

/// A partition relative to the center of the container.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct PartitionWall {
    pub(super) x: f64,
    /// When it is removed, s; `None` if it stays.
    pub(super) opens_s: Option<f64>,
}

/// Path of one particle since its velocity last changed other than by the path itself.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Path {
    flight: Flight,
    /// Start of the path, s.
    pub(super) started_s: f64,
    /// Whether the particle is to the left of the partition.
    is_left: bool,
    /// Wall collisions since the start of the run.
    pub(super) wall_collisions: u64,
    pub(super) mass_ratio: f64,
}

/// How a particle moves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Flight {
    /// On chords in scaled lengths and times (`Circle`), of which it has completed some.
    Chords { chords: ChordPath, collisions: u64 },
    /// On a parabola or a straight line, with its conserved energy per mass, m^2/s^2.
    Parabola { start: Particle, energy: f64 },
    /// Outside, since it left through the opening in this state.
    Outside { exit: Particle },
}

/// What a particle meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Obstacle {
    Wall,
    Opening,
    Partition,
}

/// The next encounter on a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Encounter {
    pub(super) obstacle: Obstacle,
    /// Time since the start of the path, s.
    pub(super) time: f64,
    /// The particle just before.
    pub(super) incident: Particle,
    /// Speed along the outward normal relative to the wall, m/s; 0 at the partition.
    pub(super) outward: f64,
}

impl Space {
    /// The space of a container that the manifest describes.
    pub(super) fn new(config: &GasConfig, container: &Container) -> Self {
        let partition = config.partition.map(|partition| PartitionWall {
            x: partition.x_m.get() - config.center_m[0].get(),
            opens_s: partition.opens_s.map(|time| time.get()),
        });
        Self {
            circle: container.circle,
            half_opening_rad: container.half_opening_rad,
            gravity: config.gravity_m_per_s2.get(),
            partition,
        }
    }

    /// Whether paths are chords.
    #[inline]
    pub(super) fn has_chords(&self) -> bool {
        self.gravity == 0.0 && self.partition.is_none()
    }

    /// Energy per mass, v^2/2 + g (y + R), m^2/s^2.
    #[inline]
    pub(super) fn energy_per_mass(&self, particle: Particle) -> f64 {
        energy_per_mass(particle, self.gravity, self.circle.radius)
    }

    /// Path of a particle that starts at the given time.
    pub(super) fn start_path(&self, particle: Particle, time_s: f64, mass_ratio: f64) -> Path {
        Path {
            flight: self.start_flight(particle, time_s),
            started_s: time_s,
            is_left: self.partition.is_some_and(|wall| particle.position[0] < wall.x),
            wall_collisions: 0,
            mass_ratio,
        }
    }

    /// Continues with another velocity from the same side of the partition.
    #[inline]
    pub(super) fn restart_path(&self, path: &mut Path, particle: Particle, time_s: f64) {
        (path.flight, path.started_s) = (self.start_flight(particle, time_s), time_s);
    }

    #[inline]
    fn start_flight(&self, particle: Particle, time_s: f64) -> Flight {
        if self.has_chords() {
            let scaled = self.circle.restarted_at(time_s).scaled(particle, 0.0);
            return Flight::Chords { chords: ChordPath::of(scaled, 1.0), collisions: 0 };
        }
        Flight::Parabola { start: particle, energy: self.energy_per_mass(particle) }
    }

    /// The particle at a time before its next encounter.
    #[inline]
    pub(super) fn particle_at(&self, path: &Path, time_s: f64) -> Particle {
        let time = time_s - path.started_s;
        match path.flight {
            Flight::Chords { chords, collisions } => {
                let circle = self.circle.restarted_at(path.started_s);
                let scaled = chords.particle_after(collisions, circle.scaled_time(time));
                circle.unscaled(scaled, time)
            }
            Flight::Parabola { start, .. } => flown(start, self.gravity, time),
            Flight::Outside { exit } => flown(exit, self.gravity, time),
        }
    }

    /// What a particle meets next; `None` if that is after `until_s`, or nothing.
    #[inline(always)]
    pub(super) fn next_encounter(&self, path: &Path, until_s: f64) -> Option<Encounter> {
        match path.flight {
            Flight::Chords { chords, collisions } => {
                self.end_of_chord(path.started_s, &chords, collisions, until_s)
            }
            Flight::Parabola { start, .. } => self.end_of_parabola(path, start, until_s),
            Flight::Outside { .. } => None,
        }
    }

    /// The next wall collision on a path of chords. Grazing paths have none.
    #[inline(always)]
    fn end_of_chord(
        &self,
        started_s: f64,
        chords: &ChordPath,
        collisions: u64,
        until_s: f64,
    ) -> Option<Encounter> {
        if chords.speed == 0.0 || chords.is_grazing() {
            return None;
        }
        let circle = self.circle.restarted_at(started_s);
        let scaled_time = chords.time_of_collision(collisions + 1);
        if scaled_time > circle.scaled_time(until_s - started_s) {
            return None;
        }
        let time = circle.time_of(scaled_time);
        let before = chords.particle_after(collisions, scaled_time);
        let normal_speed = chords.speed * chords.half_chord;
        Some(Encounter {
            obstacle: self.wall_or_opening(before.position),
            time,
            incident: circle.unscaled(before, time),
            outward: normal_speed * (1.0 / circle.radius - circle.wall_speed * scaled_time),
        })
    }

    /// The next collision on a parabola or a straight line. The position at the wall is moved onto the circle.
    #[inline(always)]
    fn end_of_parabola(&self, path: &Path, start: Particle, until_s: f64) -> Option<Encounter> {
        let radius = self.circle.radius;
        let to_wall = if self.gravity > 0.0 {
            time_to_wall_in_gravity(start, self.gravity, radius)
        } else {
            time_to_wall(start, radius)
        };
        let to_partition = self.time_to_partition(path, start).filter(|time| *time < to_wall);
        let time = to_partition.unwrap_or(to_wall);
        if path.started_s + time > until_s || !time.is_finite() {
            return None;
        }
        let mut incident = flown(start, self.gravity, time);
        if to_partition.is_some() {
            let obstacle = Obstacle::Partition;
            return Some(Encounter { obstacle, time, incident, outward: 0.0 });
        }
        let distance = dot(incident.position, incident.position).sqrt();
        incident.position = incident.position.map(|axis| axis * (radius / distance));
        Some(Encounter {
            obstacle: self.wall_or_opening(incident.position),
            time,
            incident,
            outward: dot(incident.velocity, self.normal(incident)),
        })
    }

    /// Time until a particle that moves toward the partition reaches it, u = (x_p - x) / v_x, with and without gravity; `None` if the
    /// partition is removed before.
    #[inline]
    fn time_to_partition(&self, path: &Path, start: Particle) -> Option<f64> {
        let wall = self.partition?;
        let [x, speed] = [start.position[0], start.velocity[0]];
        let time = if (speed > 0.0) == path.is_left && speed != 0.0 {
            let time = (wall.x - x) / speed;
            if time > 0.0 { time } else { 0.0 }
        } else {
            return None;
        };
        wall.opens_s.is_none_or(|opens| path.started_s + time < opens).then_some(time)
    }

    #[inline]
    fn wall_or_opening(&self, [x, y]: [f64; 2]) -> Obstacle {
        let is_open = self.half_opening_rad.is_some_and(|half| libm::atan2(y, x).abs() < half);
        if is_open { Obstacle::Opening } else { Obstacle::Wall }
    }

    /// Outward normal of a wall at rest at a particle on it.
    #[inline]
    fn normal(&self, particle: Particle) -> [f64; 2] {
        particle.position.map(|axis| axis / self.circle.radius)
    }

    /// Follows a path after its specular reflection at the wall, and returns the impulse on the wall per mass, m/s.
    #[inline(always)]
    pub(super) fn reflect_by_wall(&self, path: &mut Path, encounter: &Encounter) -> f64 {
        let &Encounter { time, incident, outward, .. } = encounter;
        if let Flight::Chords { collisions, .. } = &mut path.flight {
            *collisions += 1;
            return 2.0 * outward;
        }
        let normal = self.normal(incident);
        let mut emitted = reflected(incident);
        let inward = -dot(emitted.velocity, normal);
        let scale = dot(incident.velocity, incident.velocity) + self.gravity * self.circle.radius;
        let missing = MIN_NORMAL_SPEED * scale.sqrt() - inward;
        if missing > 0.0 {
            let [vx, vy] = emitted.velocity;
            emitted.velocity = [vx - missing * normal[0], vy - missing * normal[1]];
        }
        self.continue_parabola(path, emitted, time);
        outward - dot(emitted.velocity, normal)
    }

    /// Follows a path after its reflection at the partition: x = x_p, v_x' = -v_x.
    pub(super) fn reflect_by_partition(&self, path: &mut Path, encounter: &Encounter) {
        let Particle { position: [x, y], velocity: [vx, vy] } = encounter.incident;
        let x = self.partition.map_or(x, |wall| wall.x);
        let reflected = Particle { position: [x, y], velocity: [-vx, vy] };
        self.continue_parabola(path, reflected, encounter.time);
    }

    /// Continues after a reflection, with the velocity scaled to the conserved energy, in the last bits.
    fn continue_parabola(&self, path: &mut Path, mut particle: Particle, time: f64) {
        let Flight::Parabola { start, energy } = &mut path.flight else { return };
        let square = dot(particle.velocity, particle.velocity);
        let lost = (*energy - self.energy_per_mass(particle)) / square;
        if lost.abs() < MAX_CORRECTION {
            particle.velocity = particle.velocity.map(|component| component + lost * component);
        }
        *start = particle;
        path.started_s += time;
    }
}

impl Path {
    /// Leaves the container.
    pub(super) fn leave(&mut self, encounter: &Encounter) {
        self.flight = Flight::Outside { exit: encounter.incident };
        self.started_s += encounter.time;
    }

    /// Whether the particle has not left the container.
    pub(super) fn is_inside(&self) -> bool {
        !matches!(self.flight, Flight::Outside { .. })
    }

    /// Whether a restored path is possible in a space in which no particle is faster than `max_speed`, m/s, and none started after
    /// `last_start_s`.
    pub(super) fn is_valid_in(&self, space: &Space, max_speed: f64, last_start_s: f64) -> bool {
        let Space { circle, gravity, .. } = *space;
        let is_valid_flight = match self.flight {
            Flight::Chords { chords, collisions } => {
                // A scaled velocity is R v - u p.
                let radius = circle.radius_at(self.started_s);
                let scaled = radius * max_speed + (circle.wall_speed * radius).abs();
                space.has_chords() && chords.is_in_unit_circle(2.0 * scaled) && collisions < 1 << 60
            }
            Flight::Parabola { start, energy } => {
                let max_energy = max_speed * max_speed / 2.0 + 2.0 * gravity * circle.radius;
                let reach = circle.radius * circle.radius * (1.0 + 1e-6);
                !space.has_chords()
                    && dot(start.position, start.position) <= reach
                    && (0.0..=2.0 * max_energy).contains(&energy)
                    && dot(start.velocity, start.velocity) <= 4.0 * max_energy
            }
            Flight::Outside { exit } => {
                let numbers = [exit.position, exit.velocity];
                space.half_opening_rad.is_some()
                    && numbers.iter().flatten().all(|number| number.is_finite())
            }
        };
        (0.0..=last_start_s).contains(&self.started_s)
            && self.wall_collisions < 1 << 60
            && is_valid_flight
    }
}
