//! Closed-form propagator: computes every frame from the start of the paths, independently of earlier frames.
//!
//! It is the SIMD version of `motion::ChordPath`. The invariants of a path are computed when it starts, so that a position at any time
//! costs one sine and one cosine, without branches, eight particles at a time.

use super::clock::Clock;
use super::motion::{ChordPath, Circle};
use super::particle_groups::{BLOCK, Group, LANES, Lanes};
use super::propagator::Propagator;
use super::sine_cosine::sine_and_cosine;
use super::state::GasState;
use super::tallies::{WallTallies, WallTally};
use crate::model::Target;
use crate::simd::registers::{self, InstructionSet, Kernel};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// 2^52: its addition to a number below 2^51 rounds that number to the nearest integer.
const ROUNDING: f64 = 4_503_599_627_370_496.0;

/// Invariants of eight paths, in scaled lengths and times (`motion::Circle`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
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
        let (instant, particles) = (Instant::of(&self.circle, time_s), &mut state.particles);
        let blocks = self.groups.par_chunks_mut(BLOCK).zip(particles.groups.par_chunks_mut(BLOCK));
        let blocks: Vec<BlockSums> = blocks
            .map(|(paths, particles)| registers::run(AdvanceBlock { instant, paths, particles }, 4))
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
    fn run<const N: usize, I: InstructionSet<N>>(self, _: I) -> BlockSums {
        let mut sums = BlockSums::default();
        for (path, particle) in self.paths.iter_mut().zip(self.particles) {
            // Copies show the compiler that the memory does not overlap.
            let (from, mut to, mut group_sums) = (*path, Group::default(), sums);
            for lane in 0..LANES {
                path.collisions[lane] =
                    advance_lane(&self.instant, &from, lane, &mut to, &mut group_sums);
            }
            (*particle, sums) = (to, group_sums);
        }
        sums
    }
}

/// `ChordPath::flight` for one particle of a group, with each branch replaced by a selection. Returns its wall collisions.
#[inline(always)]
fn advance_lane(
    at: &Instant,
    path: &PathGroup,
    lane: usize,
    to: &mut Group,
    sums: &mut BlockSums,
) -> f64 {
    let (along, offset) = (path.along[lane], path.offset[lane]);
    let (half_chord, speed) = (path.half_chord[lane], path.speed[lane]);
    let distance = along + speed * at.scaled_time;
    let collisions = at.after_start * floor((distance + half_chord) / (2.0 * half_chord));
    let position = distance - 2.0 * half_chord * collisions;
    // Rounding of a long distance must not place a particle outside the wall.
    let position = if position > half_chord { half_chord } else { position };
    let position = if position < -half_chord { -half_chord } else { position };
    let (sine, cosine) = sine_and_cosine(collisions * path.rotation_turns[lane]);
    let (dx, dy) = (path.direction_x[lane], path.direction_y[lane]);
    let (x, y) = (position * dx + offset * dy, position * dy - offset * dx);
    let (x, y) = (cosine * x - sine * y, sine * x + cosine * y);
    let (ux, uy) = (cosine * dx - sine * dy, sine * dx + cosine * dy);
    to.x[lane] = at.radius * x;
    to.y[lane] = at.radius * y;
    let scale = speed / at.radius;
    to.vx[lane] = scale * ux + at.wall_speed * x;
    to.vy[lane] = scale * uy + at.wall_speed * y;
    let before = path.collisions[lane];
    sums.collisions[lane] += collisions;
    sums.new_collisions[lane] += collisions - before;
    let impulse = impulse_of_collisions(at, path, lane, collisions);
    sums.impulse[lane] += impulse;
    sums.new_impulse[lane] += impulse - impulse_of_collisions(at, path, lane, before);
    collisions
}

/// Impulse of the first collisions of a path per first mass, m/s: the sum of `Circle::impulse_of_collision` over collisions 2 C/s apart.
#[inline(always)]
fn impulse_of_collisions(at: &Instant, path: &PathGroup, lane: usize, collisions: f64) -> f64 {
    let half_chord = path.half_chord[lane];
    let series = collisions * ((half_chord - path.along[lane]) + half_chord * (collisions - 1.0));
    let per_mass = 2.0
        * half_chord
        * (path.speed[lane] * collisions / at.radius_at_start - at.wall_speed * series);
    path.mass_ratio[lane] * per_mass
}

/// Largest integer that is not above a number in [0, 2^51).
#[inline(always)]
fn floor(number: f64) -> f64 {
    let nearest = (number + ROUNDING) - ROUNDING;
    if nearest > number { nearest - 1.0 } else { nearest }
}
