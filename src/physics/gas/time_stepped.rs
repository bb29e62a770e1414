//! Time-stepped propagator: the step of the gas exercise with its defects corrected.
//!
//! As printed, the rest of a step after a wall collision is a length, a step has at most one wall collision, and radial collisions give
//! 0/0 (`as_printed.rs`). Here the rest is the time dt - u, the path is reflected until the step is used up, and the normal is never zero.

use super::clock::{Clock, StepClock};
use super::motion::{ChordPath, Flight, Particle, dot, drifted, reflected, time_to_wall};
use super::particle_groups::{BLOCK, Group, LANES, Lanes};
use super::propagator::Propagator;
use super::state::GasState;
use super::tallies::ParticleTally;
use crate::model::Target;
use crate::simd::registers::{self, InstructionSet, Kernel};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Clock of the steps, and wall collisions of each particle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct TimeStepped {
    clock: StepClock,
    /// One per particle and one per empty lane.
    tallies: Vec<ParticleTally>,
}

impl TimeStepped {
    /// The scheme at time 0.
    pub(super) fn new(clock: StepClock, state: &GasState) -> Self {
        let mut tallies = vec![ParticleTally::default(); state.particles.groups.len() * LANES];
        ParticleTally::start_paths(&mut tallies, state.particles.iter());
        Self { clock, tallies }
    }
}

impl Propagator for TimeStepped {
    fn clock(&self) -> Clock {
        Clock::Steps(self.clock)
    }

    fn is_valid_for(&self, state: &GasState, _max_speed: f64) -> bool {
        let radius = state.container.circle.radius;
        let limit = radius * (1.0 + 1e-6);
        let is_path = |(particle, tally): (Particle, &ParticleTally)| {
            dot(particle.position, particle.position) <= limit * limit
                && tally.is_valid()
                && tally.has_invariants_of(particle, radius)
        };
        self.tallies.len() == state.particles.groups.len() * LANES
            && state.particles.lanes().zip(&self.tallies).all(is_path)
    }

    /// Takes the steps on all threads. Each block takes all its steps before the next block, because particles do not interact: its
    /// data stay in the nearest cache.
    fn advance(&mut self, target: Target, budget: &mut u64, state: &mut GasState) -> bool {
        let steps = self.clock.steps_toward(target, budget);
        let (time_step, radius) = (self.clock.time_step_s, state.container.circle.radius);
        let width = Ord::min(state.max_width, WIDTH);
        let blocks = state.particles.groups.par_chunks_mut(BLOCK);
        blocks.zip(self.tallies.par_chunks_mut(BLOCK * LANES)).for_each(|(groups, tallies)| {
            registers::run(BlockSteps { groups, tallies, radius, time_step, steps }, width);
        });
        self.clock.done += steps;
        let is_reached = self.clock.has_reached(target);
        if is_reached {
            state.wall.gather(&self.tallies, &state.substance.mass_ratios);
        }
        is_reached
    }

    fn restart_paths(&mut self, state: &GasState) {
        ParticleTally::start_paths(&mut self.tallies, state.particles.iter());
    }

    fn open_window(&mut self) {
        self.tallies.iter_mut().for_each(ParticleTally::open_window);
    }

    fn description(&self, _state: &GasState) -> String {
        let StepClock { total, time_step_s, .. } = self.clock;
        format!("propagation: {total} steps of {time_step_s} s with all wall collisions of a step")
    }
}

/// Numbers in the widest registers of the steps.
const WIDTH: usize = 4;
/// Maximum number of reflections per step; for more, the step uses the closed form, because the number has no bound for grazing paths.
const MAX_REFLECTIONS: u64 = 64;

/// One step of a particle inside the wall: free flight (gas exercise, equation 7); while that ends outside, flight to the wall by
/// equations (9) and (10) with u in (0, rest of the step], then a specular reflection.
#[must_use]
#[inline]
pub fn step(particle: Particle, radius: f64, time_step: f64) -> Flight {
    let end = drifted(particle, time_step);
    let [x, y] = end.position;
    if x * x + y * y <= radius * radius {
        return Flight { particle: end, wall_collisions: 0, impulse_per_mass: 0.0 };
    }
    step_with_collisions(particle, radius, time_step)
}

/// A step whose free flight ends outside. It is separate from `step`, because most steps are free.
fn step_with_collisions(particle: Particle, radius: f64, time_step: f64) -> Flight {
    if has_long_chords(particle, radius, time_step) {
        return reflect_until_used_up(particle, radius, time_step);
    }
    let path = ChordPath::of(particle, radius);
    if path.is_grazing() || path.wall_collisions(time_step) > MAX_REFLECTIONS {
        path.flight(time_step)
    } else {
        reflect_until_used_up(particle, radius, time_step)
    }
}

/// Whether a path is not grazing and has at most `MAX_REFLECTIONS` collisions. Only products are needed, so most paths avoid roots and
/// quotients: C^2 v^2 = (p . v)^2 + v^2 (R^2 - p^2), and the distance v t is at most that many chords 2 C.
#[inline(always)]
fn has_long_chords(particle: Particle, radius: f64, time_step: f64) -> bool {
    /// Much larger than the flatness of a grazing path.
    const FLATTEST: f64 = 1e-6;
    let square = dot(particle.velocity, particle.velocity);
    let along = dot(particle.position, particle.velocity);
    let room = radius * radius - dot(particle.position, particle.position);
    let half_chord_by_speed = along * along + square * room;
    let chords = 2.0 * (MAX_REFLECTIONS - 1) as f64;
    let distance_by_speed = square * time_step;
    (half_chord_by_speed > FLATTEST * square * radius * radius)
        & (distance_by_speed * distance_by_speed < chords * chords * half_chord_by_speed)
}

/// Reflects a path until the time is used up. The loop ends, because the path is not grazing: after a reflection, the velocity points
/// inward by far more than its rounding, and the next collision is one chord away.
///
/// The particle is not moved onto the wall, from which it differs by rounding. The reflection conserves p x v at the present position,
/// and each collision is computed from the circle, so neither error accumulates.
fn reflect_until_used_up(mut particle: Particle, radius: f64, time: f64) -> Flight {
    let mut rest = time;
    let mut wall_collisions = 0;
    let mut impulse_per_mass = 0.0;
    loop {
        let to_wall = time_to_wall(particle, radius);
        if to_wall >= rest {
            let particle = drifted(particle, rest);
            return Flight { particle, wall_collisions, impulse_per_mass };
        }
        let before = drifted(particle, to_wall);
        particle = reflected(before);
        impulse_per_mass += impulse_per_mass_of(before, particle, radius);
        wall_collisions += 1;
        rest -= to_wall;
    }
}

/// Steps of one block.
struct BlockSteps<'a> {
    groups: &'a mut [Group],
    tallies: &'a mut [ParticleTally],
    radius: f64,
    time_step: f64,
    steps: u64,
}

/// Particle whose free flight ends outside, with its position before the step.
#[derive(Clone, Copy, Default)]
struct Leaving {
    id: usize,
    position: [f64; 2],
}

impl Kernel for BlockSteps<'_> {
    type Output = ();

    /// In each step, all particles drift; those that end outside are listed and then reflected eight at a time. The list has one more
    /// entry than particles, because an entry is written before it is known whether the particle leaves.
    #[inline(always)]
    fn run<const N: usize, I: InstructionSet<N>>(mut self, _: I) {
        let mut leaving = [Leaving::default(); BLOCK * LANES + 1];
        for _ in 0..self.steps {
            let count = self.drift(&mut leaving);
            for lanes in leaving[..count].chunks(LANES) {
                self.reflect(lanes);
            }
        }
    }
}

impl BlockSteps<'_> {
    /// Moves all particles by a step, lists those that end outside, and returns their number.
    #[inline(always)]
    fn drift(&mut self, leaving: &mut [Leaving; BLOCK * LANES + 1]) -> usize {
        let (time_step, square) = (self.time_step, self.radius * self.radius);
        let mut count = 0;
        for (index, group) in self.groups.iter_mut().enumerate() {
            let (mut x, mut y) = (group.x, group.y);
            let mut outside = 0;
            for lane in 0..LANES {
                x[lane] += time_step * group.vx[lane];
                y[lane] += time_step * group.vy[lane];
                outside |= u64::from(x[lane] * x[lane] + y[lane] * y[lane] > square);
            }
            if outside != 0 {
                for lane in 0..LANES {
                    let position = [group.x[lane], group.y[lane]];
                    leaving[count] = Leaving { id: index * LANES + lane, position };
                    count += usize::from(x[lane] * x[lane] + y[lane] * y[lane] > square);
                }
            }
            (group.x, group.y) = (x, y);
        }
        count
    }

    /// Completes the step of at most eight particles that end outside: by `reflected_once`, or by the scalar step where that is invalid.
    #[inline(always)]
    fn reflect(&mut self, leaving: &[Leaving]) {
        let mut before = Group { vx: [1.0; LANES], ..Group::default() };
        let mut tallies = [ParticleTally::at_unit_speed(); LANES];
        for (lane, Leaving { id, position }) in leaving.iter().enumerate() {
            let velocity = self.groups[id / LANES].particle(id % LANES).velocity;
            before.set(lane, Particle { position: *position, velocity });
            tallies[lane] = self.tallies[*id];
        }
        let (after, impulses, is_valid) =
            reflected_once(&before, &tallies, self.radius, self.time_step);
        for (lane, Leaving { id, .. }) in leaving.iter().enumerate() {
            let tally = &mut self.tallies[*id];
            let particle = if is_valid[lane] {
                let particle = after.particle(lane);
                let impulse_per_mass = impulses[lane];
                tally.add(&Flight { particle, wall_collisions: 1, impulse_per_mass });
                particle
            } else {
                tallied_step(before.particle(lane), tally, self.radius, self.time_step)
            };
            self.groups[id / LANES].set(id % LANES, particle);
        }
    }
}

/// `step` of eight particles that collide with the wall once, in the same arithmetic without branches. Returns the particles with
/// restored invariants, their impulses, and whether each of them had exactly one collision.
#[inline(always)]
fn reflected_once(
    before: &Group,
    tallies: &[ParticleTally; LANES],
    radius: f64,
    time_step: f64,
) -> (Group, Lanes, [bool; LANES]) {
    let (mut after, mut impulses, mut is_valid) = (Group::default(), [0.0; LANES], [false; LANES]);
    for lane in 0..LANES {
        let particle = before.particle(lane);
        let to_wall = time_to_wall(particle, radius);
        let before = drifted(particle, to_wall);
        let outgoing = reflected(before);
        impulses[lane] = impulse_per_mass_of(before, outgoing, radius);
        let end = drifted(outgoing, time_step - to_wall);
        is_valid[lane] = (dot(end.position, end.position) <= radius * radius)
            & (to_wall < time_step)
            & has_long_chords(particle, radius, time_step);
        after.set(lane, tallies[lane].restore_invariants(end));
    }
    (after, impulses, is_valid)
}

/// Normal impulse of a reflection on the wall per mass, m/s.
#[inline(always)]
fn impulse_per_mass_of(before: Particle, after: Particle, radius: f64) -> f64 {
    let change = [before.velocity[0] - after.velocity[0], before.velocity[1] - after.velocity[1]];
    dot(change, before.position) / radius
}

/// A step that ends outside, added to the tally.
#[inline(never)]
fn tallied_step(
    particle: Particle,
    tally: &mut ParticleTally,
    radius: f64,
    time_step: f64,
) -> Particle {
    let flight = step_with_collisions(particle, radius, time_step);
    tally.add(&flight);
    if flight.wall_collisions > 0 {
        tally.restore_invariants(flight.particle)
    } else {
        flight.particle
    }
}
