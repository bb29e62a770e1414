//! Closed-form propagator: computes every frame from the start of the paths, independently of earlier frames.
//!
//! It is the SIMD version of `motion::ChordPath`. The invariants of a path are computed when it starts, so that a position at any time
//! costs one sine and one cosine, without branches, eight particles at a time.

use super::clock::Clock;
use super::motion::{ChordPath, Circle};
use super::particle_groups::{BLOCK, Group, LANES, Lanes};
use super::propagator::Propagator;
use super::sine_cosine::sines_and_cosines;
use super::state::GasState;
use super::tallies::{WallTallies, WallTally};
use crate::model::Target;
use crate::simd::registers::{self, InstructionSet, Kernel, each};
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

/// Four lanes. A loop over eight at a time would not leave enough registers for the constants and sums.
type Four = [f64; 4];

impl Kernel for AdvanceBlock<'_> {
    type Output = BlockSums;

    #[inline(always)]
    fn run<const N: usize, I: InstructionSet<N>>(self, _: I) -> BlockSums {
        if self.instant.wall_speed == 0.0 {
            self.evaluate::<N, true>()
        } else {
            self.evaluate::<N, false>()
        }
    }
}

impl AdvanceBlock<'_> {
    #[inline(always)]
    fn evaluate<const N: usize, const AT_REST: bool>(self) -> BlockSums {
        let mut sums = BlockSums::default();
        for (path, particle) in self.paths.iter_mut().zip(self.particles) {
            advance_four::<0, N, AT_REST>(&self.instant, path, particle, &mut sums);
            advance_four::<4, N, AT_REST>(&self.instant, path, particle, &mut sums);
        }
        sums
    }
}

#[inline(always)]
fn four<const FIRST: usize>(lanes: &Lanes) -> Four {
    each(|lane| lanes[FIRST + lane])
}

#[inline(always)]
fn set_four<const FIRST: usize>(lanes: &mut Lanes, values: Four) {
    lanes[FIRST..FIRST + 4].copy_from_slice(&values);
}

#[inline(always)]
fn add_four<const FIRST: usize>(sums: &mut Lanes, values: Four) {
    let sum = four::<FIRST>(sums);
    set_four::<FIRST>(sums, each(|lane| sum[lane] + values[lane]));
}

/// `ChordPath::flight` for half a group, with each branch replaced by a selection.
#[inline(always)]
fn advance_four<const FIRST: usize, const N: usize, const AT_REST: bool>(
    at: &Instant,
    path: &mut PathGroup,
    to: &mut Group,
    sums: &mut BlockSums,
) {
    let (along, offset) = (four::<FIRST>(&path.along), four::<FIRST>(&path.offset));
    let (half_chord, speed) = (four::<FIRST>(&path.half_chord), four::<FIRST>(&path.speed));
    let turns = four::<FIRST>(&path.rotation_turns);
    let before = four::<FIRST>(&path.collisions);
    let distance = each(|i| along[i] + speed[i] * at.scaled_time);
    let collisions = each(|i| {
        at.after_start * floor::<N>((distance[i] + half_chord[i]) / (2.0 * half_chord[i]))
    });
    set_four::<FIRST>(&mut path.collisions, collisions);
    let position = each(|i| distance[i] - 2.0 * half_chord[i] * collisions[i]);
    // Rounding of a long distance must not place a particle outside the wall.
    let position = each(|i| if position[i] > half_chord[i] { half_chord[i] } else { position[i] });
    let position =
        each(|i| if position[i] < -half_chord[i] { -half_chord[i] } else { position[i] });
    let [sine, cosine] = sines_and_cosines(each(|i| collisions[i] * turns[i]));
    let (dx, dy) = (four::<FIRST>(&path.direction_x), four::<FIRST>(&path.direction_y));
    let unrotated_x = each(|i| position[i] * dx[i] + offset[i] * dy[i]);
    let unrotated_y = each(|i| position[i] * dy[i] - offset[i] * dx[i]);
    let x = each(|i| cosine[i] * unrotated_x[i] - sine[i] * unrotated_y[i]);
    let y = each(|i| sine[i] * unrotated_x[i] + cosine[i] * unrotated_y[i]);
    let scale = each(|i| speed[i] / at.radius);
    let ux = each(|i| scale[i] * (cosine[i] * dx[i] - sine[i] * dy[i]));
    let uy = each(|i| scale[i] * (sine[i] * dx[i] + cosine[i] * dy[i]));
    set_four::<FIRST>(&mut to.x, each(|i| at.radius * x[i]));
    set_four::<FIRST>(&mut to.y, each(|i| at.radius * y[i]));
    // The sum with a product that is zero for a wall at rest decides the sign of a velocity of zero.
    set_four::<FIRST>(&mut to.vx, each(|i| ux[i] + at.wall_speed * x[i]));
    set_four::<FIRST>(&mut to.vy, each(|i| uy[i] + at.wall_speed * y[i]));
    let impulse = impulse_of_collisions::<FIRST, AT_REST>(at, path, collisions);
    let last_impulse = impulse_of_collisions::<FIRST, AT_REST>(at, path, before);
    add_four::<FIRST>(&mut sums.collisions, collisions);
    add_four::<FIRST>(&mut sums.new_collisions, each(|i| collisions[i] - before[i]));
    add_four::<FIRST>(&mut sums.impulse, impulse);
    add_four::<FIRST>(&mut sums.new_impulse, each(|i| impulse[i] - last_impulse[i]));
}

/// Impulse of the first collisions of a path per first mass, m/s: the sum of `Circle::impulse_of_collision` over collisions 2 C/s apart.
/// The series is only that of a moving wall: 0 times a finite number changes no bit of a number that is not negative.
#[inline(always)]
fn impulse_of_collisions<const FIRST: usize, const AT_REST: bool>(
    at: &Instant,
    path: &PathGroup,
    collisions: Four,
) -> Four {
    let (half_chord, speed) = (four::<FIRST>(&path.half_chord), four::<FIRST>(&path.speed));
    let (along, mass) = (four::<FIRST>(&path.along), four::<FIRST>(&path.mass_ratio));
    let at_rest = each(|i| speed[i] * collisions[i] / at.radius_at_start);
    let per_mass = if AT_REST {
        at_rest
    } else {
        each(|i| {
            let rest = (half_chord[i] - along[i]) + half_chord[i] * (collisions[i] - 1.0);
            at_rest[i] - at.wall_speed * (collisions[i] * rest)
        })
    };
    each(|i| mass[i] * (2.0 * half_chord[i] * per_mass[i]))
}

/// Largest integer that is not above a number in [0, 2^51).
#[inline(always)]
fn floor<const N: usize>(number: f64) -> f64 {
    if N > 1 {
        return number.floor();
    }
    // Without wide registers, the processor may not have an instruction for it.
    let nearest = (number + ROUNDING) - ROUNDING;
    if nearest > number { nearest - 1.0 } else { nearest }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The fractional parts of multiples of irrational numbers fill the unit interval evenly (Weyl 1916).
    fn part(index: usize, root: f64) -> f64 {
        (index as f64 * root.sqrt()).fract()
    }

    /// Paths of particles with speeds up to 3 and offsets up to 0.9, some of which have collided before.
    fn paths() -> Vec<PathGroup> {
        let lanes = |group: usize, root: f64| {
            std::array::from_fn(|lane| part(LANES * group + lane + 1, root))
        };
        let path = |group: usize| {
            let offset: Lanes = lanes(group, 2.0).map(|part| 1.8 * part - 0.9);
            let half_chord = offset.map(|offset| (1.0 - offset * offset).sqrt());
            let turns = lanes(group, 5.0);
            let [sine, cosine] =
                [lanes(group, 7.0), lanes(group, 7.0).map(|y| (1.0 - y * y).sqrt())];
            PathGroup {
                along: std::array::from_fn(|lane| half_chord[lane] * (1.0 - 2.0 * turns[lane])),
                offset,
                half_chord,
                speed: lanes(group, 3.0).map(|part| 3.0 * part),
                rotation_turns: turns,
                direction_x: cosine,
                direction_y: sine,
                mass_ratio: lanes(group, 11.0),
                collisions: lanes(group, 13.0).map(|part| (3.0 * part).floor()),
            }
        };
        (0..64).map(path).collect()
    }

    /// All bits that a block of paths has at an instant.
    fn bits(
        evaluate: impl FnOnce(AdvanceBlock<'_>) -> BlockSums,
    ) -> impl FnOnce(Instant) -> Vec<u64> {
        |instant| {
            let (mut paths, mut particles) = (paths(), vec![Group::default(); 64]);
            let block = AdvanceBlock { instant, paths: &mut paths, particles: &mut particles };
            let sums = evaluate(block);
            let BlockSums { collisions, new_collisions, impulse, new_impulse } = sums;
            let of_groups =
                particles.iter().flat_map(|group| [group.x, group.y, group.vx, group.vy]);
            let numbers = of_groups.chain(paths.iter().map(|path| path.collisions));
            let sums = [collisions, new_collisions, impulse, new_impulse];
            numbers.chain(sums).flatten().map(f64::to_bits).collect()
        }
    }

    /// Guarantee: the shorter formulas of a wall at rest and the wider registers give the bits of the full scalar formula, at the start and
    /// after up to thousands of collisions. Control: the formulas of a wall at rest are wrong for one that moves.
    #[test]
    fn wall_at_rest_and_wide_registers_change_no_bit() {
        for (radius, time_s) in [(1.0, 0.0), (1.0, 4.62), (0.7, 13.0), (3.0, 12_345.6)] {
            for wall_speed in [0.0, -0.0] {
                let at = Instant::of(&Circle { radius, wall_speed }, time_s);
                let full = bits(|block| block.evaluate::<1, false>())(at);
                for width in [1, 4, 8] {
                    assert_eq!(bits(|block| registers::run(block, width))(at), full, "{width}");
                }
            }
        }
        let moving = Instant::of(&Circle { radius: 1.0, wall_speed: 0.01 }, 4.62);
        let full = bits(|block| block.evaluate::<1, false>())(moving);
        assert_ne!(bits(|block| block.evaluate::<1, true>())(moving), full);
        assert_eq!(bits(|block| registers::run(block, 4))(moving), full);
    }
}
