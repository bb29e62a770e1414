//! Exact propagation from hit to hit, for walls that do more than mirror: a wall with a temperature, a wall with an opening. Between
//! two hits a path is the closed form of `motion.rs`, also where the wall moves.

use super::motion::{Chords, Circle, Particle, dot};
use super::particle_groups::{BLOCK, Group, LANES, Particles};
use super::wall_tally::WallTally;
use crate::random::{Seed, Stream};
use crate::sum::CompensatedSum;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// What the wall is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct WallLaw {
    pub(super) circle: Circle,
    pub(super) thermal: Option<Thermal>,
    /// Half the angle of the opening about the direction of x, rad.
    pub(super) half_opening: Option<f64>,
}

/// A wall with a temperature.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Thermal {
    /// sqrt(k_B T / m1), m1 the first mass, m/s.
    pub(super) thermal_speed: f64,
    /// Share of the hits that are not mirrored.
    pub(super) accommodation: f64,
    pub(super) seed: Seed,
}

/// The path of one particle since the wall last changed it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Course {
    /// In the circle's own lengths and times; free flight from `exit` once outside.
    chords: Chords,
    /// Where and how it left through the opening.
    exit: Option<Particle>,
    /// When it began, s.
    began_s: f64,
    /// Hits since it began.
    hits: u64,
    /// Hits since the start: the number of the next draw.
    drawn: u64,
    mass_ratio: f64,
}

/// What happened to some particles, energies over the first mass, m^2/s^2.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Happened {
    pub(super) wall: WallTally,
    pub(super) heat: CompensatedSum,
    pub(super) escaped_energy: CompensatedSum,
    pub(super) escaped: u64,
}

impl WallLaw {
    fn circle_at(&self, time_s: f64) -> Circle {
        Circle { radius: self.circle.radius_at(time_s), ..self.circle }
    }

    /// The path that a particle begins now.
    pub(super) fn begin(&self, particle: Particle, time_s: f64, mass_ratio: f64) -> Course {
        let chords = Chords::of(self.circle_at(time_s).scaled(particle, 0.0), 1.0);
        Course { chords, exit: None, began_s: time_s, hits: 0, drawn: 0, mass_ratio }
    }

    /// Moves all particles to a time, in blocks of fixed size.
    pub(super) fn fly(
        &self,
        courses: &mut [Course],
        particles: &mut Particles,
        until_s: f64,
    ) -> Happened {
        let blocks: Vec<Happened> = courses
            .par_chunks_mut(BLOCK * LANES)
            .zip(particles.groups.par_chunks_mut(BLOCK))
            .enumerate()
            .map(|(block, (courses, groups))| {
                self.fly_block(block * BLOCK * LANES, courses, groups, until_s)
            })
            .collect();
        let mut all = Happened::default();
        for block in &blocks {
            all.wall.add(block.wall.hits, block.wall.impulse_per_mass.value());
            all.heat.add(block.heat.value());
            all.escaped_energy.add(block.escaped_energy.value());
            all.escaped += block.escaped;
        }
        all
    }

    fn fly_block(
        &self,
        first_id: usize,
        courses: &mut [Course],
        groups: &mut [Group],
        until_s: f64,
    ) -> Happened {
        let mut happened = Happened::default();
        for (index, course) in courses.iter_mut().enumerate() {
            let id = (first_id + index) as u64;
            while self.hit(id, course, until_s, &mut happened) {}
            groups[index / LANES].set(index % LANES, self.particle_on(course, until_s));
        }
        happened
    }

    fn particle_on(&self, course: &Course, time_s: f64) -> Particle {
        let time = time_s - course.began_s;
        if let Some(exit) = course.exit {
            return super::motion::drifted(exit, time);
        }
        let circle = self.circle_at(course.began_s);
        let scaled = course.chords.after(course.hits, circle.scaled_time(time));
        circle.unscaled(scaled, time)
    }

    /// Takes the next hit of a particle if it comes before a time, and says whether there was one. A path that slides along the
    /// wall has no hits.
    fn hit(&self, id: u64, course: &mut Course, until_s: f64, happened: &mut Happened) -> bool {
        let chords = course.chords;
        if course.exit.is_some() || chords.speed == 0.0 || chords.slides() {
            return false;
        }
        let circle = self.circle_at(course.began_s);
        let scaled_time = chords.time_of_hit(course.hits + 1);
        if scaled_time > circle.scaled_time(until_s - course.began_s) {
            return false;
        }
        let time = circle.time_of(scaled_time);
        let before = chords.after(course.hits, scaled_time);
        let arriving = circle.unscaled(before, time);
        let energy = |particle: &Particle| {
            course.mass_ratio * dot(particle.velocity, particle.velocity) / 2.0
        };
        let [x, y] = before.position;
        if self.half_opening.is_some_and(|half| libm::atan2(y, x).abs() < half) {
            happened.escaped += 1;
            happened.escaped_energy.add(energy(&arriving));
            (course.exit, course.began_s) = (Some(arriving), course.began_s + time);
            return true;
        }
        course.hits += 1;
        course.drawn += 1;
        let arrival = chords.speed * chords.half_chord;
        match self.emission(id, course) {
            None => {
                let impulse = circle.impulse_of_hit(arrival, scaled_time);
                happened.wall.add(1, course.mass_ratio * impulse);
            }
            Some([normal, tangential]) => {
                let normal_in = arrival * (1.0 / circle.radius - circle.wall_speed * scaled_time);
                let impulse = course.mass_ratio * (normal_in + normal);
                let leaving = self.leaving(arriving, [normal, tangential]);
                happened.wall.add(1, impulse);
                let work = -self.circle.wall_speed * impulse;
                happened.heat.add(energy(&leaving) - energy(&arriving) - work);
                let drawn = course.drawn;
                *course = self.begin(leaving, course.began_s + time, course.mass_ratio);
                course.drawn = drawn;
            }
        }
        true
    }

    /// Speeds (inwards, along the wall) that the wall gives a particle, seen from the wall; `None` for a mirror. The flux through
    /// a wall of a gas with Maxwell's velocities: g exp(-g^2/2s^2) inwards, exp(-t^2/2s^2) along it, s^2 = k_B T/m
    /// (Maxwell, Phil. Trans. 170, 231 (1879)).
    fn emission(&self, id: u64, course: &Course) -> Option<[f64; 2]> {
        let thermal = self.thermal?;
        // The low half of the hit's number: after 4e9 hits of one particle its draws begin again.
        let place = id << 32 | (course.drawn & 0xffff_ffff);
        let mut draws = thermal.seed.stream_at(Stream::ThermalWall, place);
        if draws.uniform() >= thermal.accommodation {
            return None;
        }
        let speed = thermal.thermal_speed / course.mass_ratio.sqrt();
        let inwards = speed * (-2.0 * libm::log(1.0 - draws.uniform())).sqrt();
        Some([inwards, speed * draws.normal_pair()[0]])
    }

    /// A particle at the wall as the wall gives it back.
    fn leaving(&self, arriving: Particle, [normal, tangential]: [f64; 2]) -> Particle {
        let [x, y] = arriving.position;
        let distance = dot(arriving.position, arriving.position).sqrt();
        let [nx, ny] = [x / distance, y / distance];
        let outwards = self.circle.wall_speed - normal;
        Particle {
            position: arriving.position,
            velocity: [outwards * nx - tangential * ny, outwards * ny + tangential * nx],
        }
    }
}

impl Course {
    pub(super) fn is_inside(&self) -> bool {
        self.exit.is_none()
    }

    /// The same particle on a new path, with its draws numbered on.
    pub(super) fn rebegin(&mut self, law: &WallLaw, particle: Particle, time_s: f64) {
        let drawn = self.drawn;
        *self = law.begin(particle, time_s, self.mass_ratio);
        self.drawn = drawn;
    }
}
