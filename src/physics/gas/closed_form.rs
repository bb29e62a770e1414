//! Closed-form propagator: computes every frame from the start of the paths, independently of earlier frames.
//!
//! It is the SIMD version of `motion::ChordPath`. The invariants of a path are computed when it starts, so that a position at any time
//! costs one sine and one cosine, without branches, for a register of particles at a time.

use super::clock::Clock;
use super::motion::{ChordPath, Circle};
use super::particle_groups::{BLOCK, Group, LANES, Lanes};
use super::propagator::Propagator;
use super::sine_cosine::sine_and_cosine;
use super::state::GasState;
use super::tallies::{WallTallies, WallTally};
use crate::model::Target;
use crate::simd::registers::{self, InstructionSet, Kernel, Register as _};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Invariants of eight paths, in scaled lengths and times (`motion::Circle`). No column crosses a cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[repr(align(64))]
struct PathGroup {
    /// b0
    along: Lanes,
    /// d
    offset: Lanes,
    /// C
    half_chord: Lanes,
    /// s
    speed: Lanes,
    /// beta / (2 pi)
    rotation_turns: Lanes,
    /// v^
    direction_x: Lanes,
    direction_y: Lanes,
    /// Mass relative to the first mass; 0 if the lane is empty or its path is one of `chordless`.
    mass_ratio: Lanes,
    /// Wall collisions up to the last time.
    collisions: Lanes,
}

/// Closed-form propagator: the paths of all particles since their start, and the time up to which they are followed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct ClosedForm {
    duration_s: f64,
    time_s: f64,
    /// Start of the present paths, s.
    started_s: f64,
    /// The wall at the start of the present paths.
    circle: Circle,
    groups: Vec<PathGroup>,
    /// Paths without chords: particles at rest and grazing paths.
    chordless: Vec<ChordlessPath>,
    /// Wall collisions before the present paths.
    before: WallTally,
}

/// Path of a particle at rest or of one that slides along the wall, computed by the scalar closed form.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct ChordlessPath {
    id: usize,
    path: ChordPath,
    mass_ratio: f64,
}

impl ClosedForm {
    /// The scheme at time 0.
    pub(super) fn new(duration_s: f64, state: &GasState) -> Self {
        Self::start_paths(state, duration_s, 0.0)
    }

    /// Starts the paths of all particles at the given time.
    fn start_paths(state: &GasState, duration_s: f64, time_s: f64) -> Self {
        let (particles, mass_ratios) = (&state.particles, &state.substance.mass_ratios);
        let circle = state.container.circle.restarted_at(time_s);
        let mut groups = vec![
            PathGroup { half_chord: [1.0; LANES], ..PathGroup::default() };
            particles.groups.len()
        ];
        let mut chordless = Vec::new();
        for (id, (particle, &mass_ratio)) in particles.iter().zip(mass_ratios).enumerate() {
            let scaled = circle.scaled(particle, 0.0);
            let path = ChordPath::of(scaled, 1.0);
            if path.is_grazing() || path.speed == 0.0 {
                chordless.push(ChordlessPath { id, path, mass_ratio });
                continue;
            }
            let (group, lane) = (&mut groups[id / LANES], id % LANES);
            group.along[lane] = path.along;
            group.offset[lane] = path.offset;
            group.half_chord[lane] = path.half_chord;
            group.speed[lane] = path.speed;
            group.rotation_turns[lane] = path.rotation_per_collision() / std::f64::consts::TAU;
            group.direction_x[lane] = scaled.velocity[0] / path.speed;
            group.direction_y[lane] = scaled.velocity[1] / path.speed;
            group.mass_ratio[lane] = mass_ratio;
        }
        let before = state.wall.total;
        Self { duration_s, time_s, started_s: time_s, circle, groups, chordless, before }
    }

    /// Impulse per mass of a grazing path, m/s: the integral of s^2 (1/R0 - u tau) over tau, which is the force s^2/R in scaled units.
    /// Zero for a particle at rest.
    fn grazing_impulse(&self, path: &ChordPath, time_s: f64) -> f64 {
        let (square, tau) = (path.speed * path.speed, self.circle.scaled_time(time_s));
        square * tau * (1.0 / self.circle.radius - self.circle.wall_speed * tau / 2.0)
    }
}

impl Propagator for ClosedForm {
    fn clock(&self) -> Clock {
        Clock::Continuous { time_s: self.time_s, duration_s: self.duration_s }
    }

    fn is_valid_for(&self, state: &GasState, max_speed: f64) -> bool {
        let has_chords = |group: &PathGroup| {
            let PathGroup { along, offset, half_chord, speed, rotation_turns, .. } = group;
            let lanes = [
                along,
                offset,
                half_chord,
                speed,
                rotation_turns,
                &group.direction_x,
                &group.direction_y,
                &group.mass_ratio,
                &group.collisions,
            ];
            lanes.into_iter().flatten().all(|number| number.is_finite())
                && half_chord.iter().all(|half_chord| *half_chord > 0.0)
        };
        let scaled = 2.0 * self.circle.radius * (max_speed + self.circle.wall_speed.abs());
        (0.0..=self.time_s).contains(&self.started_s)
            && self.circle == state.container.circle.restarted_at(self.started_s)
            && self.groups.len() == state.particles.groups.len()
            && self.groups.iter().all(has_chords)
            && self.chordless.iter().all(|chordless| {
                chordless.id < state.particles.len()
                    && chordless.mass_ratio.is_finite()
                    && chordless.path.is_in_unit_circle(scaled)
            })
    }

    /// Counts the wall collisions since the start of the paths by the closed form, and those since the last call by its difference.
    fn advance(&mut self, target: Target, _budget: &mut u64, state: &mut GasState) -> bool {
        let Target::Time(until_s) = target else { return true };
        let (time_s, last_s) = (until_s - self.started_s, self.time_s - self.started_s);
        let (instant, max_width) = (Instant::of(&self.circle, time_s), state.max_width);
        let particles = &mut state.particles;
        let blocks = self.groups.par_chunks_mut(BLOCK).zip(particles.groups.par_chunks_mut(BLOCK));
        let blocks: Vec<BlockSums> = blocks
            .map(|(paths, particles)| {
                registers::run(AdvanceBlock { instant, paths, particles }, max_width)
            })
            .collect();
        let (mut since_start, mut since_last) = (WallTally::default(), WallTally::default());
        for block in &blocks {
            since_start.add(lane_sum(&block.collisions) as u64, lane_sum(&block.impulse));
            since_last.add(lane_sum(&block.new_collisions) as u64, lane_sum(&block.new_impulse));
        }
        for ChordlessPath { id, path, mass_ratio } in &self.chordless {
            let flight = path.flight(instant.scaled_time);
            particles.set(*id, self.circle.unscaled(flight.particle, time_s));
            let impulse = mass_ratio * self.grazing_impulse(path, time_s);
            since_start.add(0, impulse);
            since_last.add(0, impulse - mass_ratio * self.grazing_impulse(path, last_s));
        }
        let WallTallies { total, window, .. } = &mut state.wall;
        *total = self.before;
        total.add(since_start.collisions, since_start.impulse_per_mass.value());
        window.add(since_last.collisions, since_last.impulse_per_mass.value());
        self.time_s = until_s;
        true
    }

    fn restart_paths(&mut self, state: &GasState) {
        *self = Self::start_paths(state, self.duration_s, self.time_s);
    }

    /// No position is beyond the end of its chord.
    fn can_end_outside(&self) -> bool {
        false
    }

    fn description(&self, _state: &GasState) -> String {
        "propagation: closed form, exact at any time".to_owned()
    }
}

/// An instant in real and scaled time.
#[derive(Clone, Copy)]
struct Instant {
    scaled_time: f64,
    radius_at_start: f64,
    radius: f64,
    wall_speed: f64,
    /// 1 after the start, 0 at the start: a particle on the wall has not yet collided.
    after_start: f64,
}

impl Instant {
    fn of(circle: &Circle, time_s: f64) -> Self {
        Self {
            scaled_time: circle.scaled_time(time_s),
            radius_at_start: circle.radius,
            radius: circle.radius_at(time_s),
            wall_speed: circle.wall_speed,
            after_start: if time_s > 0.0 { 1.0 } else { 0.0 },
        }
    }
}

/// Sums over a block, one per lane.
#[derive(Clone, Copy, Default)]
struct BlockSums {
    collisions: Lanes,
    new_collisions: Lanes,
    impulse: Lanes,
    new_impulse: Lanes,
}

fn lane_sum(lanes: &Lanes) -> f64 {
    lanes.iter().fold(0.0, |sum, lane| sum + lane)
}

/// Evaluation of the closed form for one block.
struct AdvanceBlock<'a> {
    instant: Instant,
    paths: &'a mut [PathGroup],
    particles: &'a mut [Group],
}

impl Kernel for AdvanceBlock<'_> {
    type Output = BlockSums;

    #[inline(always)]
    fn run<const N: usize, I: InstructionSet<N>>(self, instructions: I) -> BlockSums {
        let Instant { wall_speed, radius, .. } = self.instant;
        if wall_speed != 0.0 {
            self.evaluate::<N, I, MOVING>(instructions)
        } else if is_power_of_two(radius) {
            self.evaluate::<N, I, AT_REST_BINARY>(instructions)
        } else {
            self.evaluate::<N, I, AT_REST>(instructions)
        }
    }
}

/// Kinds of walls, by the formulas that suffice for them: one that moves; one at rest; and one at rest whose radius is a power of two,
/// such as 1 m, so that products with 1/R are the quotients, to the last bit.
const MOVING: u8 = 0;
const AT_REST: u8 = 1;
const AT_REST_BINARY: u8 = 2;

/// Whether a positive number and its inverse are powers of two.
fn is_power_of_two(number: f64) -> bool {
    number.is_normal() && number.recip().is_normal() && number.to_bits() << 12 == 0
}

impl AdvanceBlock<'_> {
    #[inline(always)]
    fn evaluate<const N: usize, I: InstructionSet<N>, const WALL: u8>(
        self,
        instructions: I,
    ) -> BlockSums {
        let at = InstantRegisters::<N, I>::of(instructions, &self.instant);
        let mut sums = BlockSums::default();
        for (path, particle) in self.paths.iter_mut().zip(self.particles) {
            for part in 0..LANES / N {
                at.advance::<WALL>(part, path, particle, &mut sums);
            }
        }
        sums
    }
}

/// As many lanes of a group as a register holds.
#[inline(always)]
fn part_of_mut<const N: usize>(lanes: &mut Lanes, part: usize) -> &mut [f64; N] {
    &mut lanes.as_chunks_mut().0[part]
}

/// An instant, each number in all lanes.
struct InstantRegisters<const N: usize, I: InstructionSet<N>> {
    instructions: I,
    one: I::Register,
    two: I::Register,
    scaled_time: I::Register,
    radius_at_start: I::Register,
    radius: I::Register,
    inverse_radius: I::Register,
    wall_speed: I::Register,
    after_start: I::Register,
}

/// What the impulse of collisions depends on.
struct Chords<R> {
    along: R,
    half_chord: R,
    speed: R,
    mass_ratio: R,
}

impl<const N: usize, I: InstructionSet<N>> InstantRegisters<N, I> {
    #[inline(always)]
    fn of(instructions: I, at: &Instant) -> Self {
        Self {
            instructions,
            one: instructions.splat(1.0),
            two: instructions.splat(2.0),
            scaled_time: instructions.splat(at.scaled_time),
            radius_at_start: instructions.splat(at.radius_at_start),
            radius: instructions.splat(at.radius),
            inverse_radius: instructions.splat(at.radius.recip()),
            wall_speed: instructions.splat(at.wall_speed),
            after_start: instructions.splat(at.after_start),
        }
    }

    /// `ChordPath::flight` for a part of a group, with each branch replaced by a selection.
    #[inline(always)]
    fn advance<const WALL: u8>(
        &self,
        part: usize,
        path: &mut PathGroup,
        to: &mut Group,
        sums: &mut BlockSums,
    ) {
        let instructions = self.instructions;
        let (along, offset) = (self.load(&path.along, part), self.load(&path.offset, part));
        let (half_chord, speed) = (self.load(&path.half_chord, part), self.load(&path.speed, part));
        let turns = self.load(&path.rotation_turns, part);
        let dx = self.load(&path.direction_x, part);
        let dy = self.load(&path.direction_y, part);
        let mass_ratio = self.load(&path.mass_ratio, part);
        let before = self.load(&path.collisions, part);
        let distance = along + speed * self.scaled_time;
        let chord = self.two * half_chord;
        let collisions = self.after_start * instructions.floor((distance + half_chord) / chord);
        instructions.store(collisions, part_of_mut(&mut path.collisions, part));
        let position = distance - chord * collisions;
        // Rounding of a long distance must not place a particle outside the wall.
        let position = half_chord.or_else(half_chord.is_less(position), position);
        let position = (-half_chord).or_else(position.is_less(-half_chord), position);
        let [sine, cosine] = sine_and_cosine(instructions, collisions * turns);
        let unrotated_x = position * dx + offset * dy;
        let unrotated_y = position * dy - offset * dx;
        let x = cosine * unrotated_x - sine * unrotated_y;
        let y = sine * unrotated_x + cosine * unrotated_y;
        let scale = self.over_radius::<WALL>(speed, self.radius);
        let ux = scale * (cosine * dx - sine * dy);
        let uy = scale * (sine * dx + cosine * dy);
        instructions.store(self.radius * x, part_of_mut(&mut to.x, part));
        instructions.store(self.radius * y, part_of_mut(&mut to.y, part));
        // The sum with a product that is zero for a wall at rest decides the sign of a velocity of zero.
        instructions.store(ux + self.wall_speed * x, part_of_mut(&mut to.vx, part));
        instructions.store(uy + self.wall_speed * y, part_of_mut(&mut to.vy, part));
        let chords = Chords { along, half_chord, speed, mass_ratio };
        let impulse = self.impulse_of_collisions::<WALL>(&chords, collisions);
        let last_impulse = self.impulse_of_collisions::<WALL>(&chords, before);
        self.add(&mut sums.collisions, part, collisions);
        self.add(&mut sums.new_collisions, part, collisions - before);
        self.add(&mut sums.impulse, part, impulse);
        self.add(&mut sums.new_impulse, part, impulse - last_impulse);
    }

    /// Impulse of the first collisions of a path per first mass, m/s: the sum of `Circle::impulse_of_collision` over collisions 2 C/s apart.
    /// The series is only that of a moving wall: 0 times a finite number changes no bit of a number that is not negative.
    #[inline(always)]
    fn impulse_of_collisions<const WALL: u8>(
        &self,
        &Chords { along, half_chord, speed, mass_ratio }: &Chords<I::Register>,
        collisions: I::Register,
    ) -> I::Register {
        let mut per_mass = self.over_radius::<WALL>(speed * collisions, self.radius_at_start);
        if WALL == MOVING {
            let rest = (half_chord - along) + half_chord * (collisions - self.one);
            per_mass = per_mass - self.wall_speed * (collisions * rest);
        }
        mass_ratio * (self.two * half_chord * per_mass)
    }

    /// A number over the radius, now or at the start.
    #[inline(always)]
    fn over_radius<const WALL: u8>(&self, number: I::Register, radius: I::Register) -> I::Register {
        if WALL == AT_REST_BINARY { number * self.inverse_radius } else { number / radius }
    }

    /// As many lanes as a register holds.
    #[inline(always)]
    fn load(&self, lanes: &Lanes, part: usize) -> I::Register {
        self.instructions.load(&lanes.as_chunks().0[part])
    }

    #[inline(always)]
    fn add(&self, sums: &mut Lanes, part: usize, values: I::Register) {
        let sum = part_of_mut(sums, part);
        self.instructions.store(self.instructions.load(sum) + values, sum);
    }
}
