//! The closed form of `motion.rs` for all particles at once: what a path keeps is computed when it begins, so that a
//! position at any time costs a sine and a cosine, without branches, eight particles abreast.

use super::motion::{Chords, Circle};
use super::particle_groups::{BLOCK, Group, LANES, Lanes, Particles};
use super::sine_cosine::sine_and_cosine;
use crate::simd::dispatch::{self, Kernel};
use crate::sum::CompensatedSum;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Added to a number below 2^51 this leaves no bits behind the point: it rounds to the nearest whole number.
const ROUNDING: f64 = 4_503_599_627_370_496.0;

/// What eight paths keep, in the circle's own lengths and times (`motion::Circle`).
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
    /// beta over 2 pi.
    turn: Lanes,
    /// v^
    direction_x: Lanes,
    direction_y: Lanes,
    /// Mass over the first mass; 0 where the lane is empty or its path is one of `alone`.
    mass_ratio: Lanes,
    /// Hits at the last time.
    hits: Lanes,
}

/// All paths from where they began.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Paths {
    circle: Circle,
    groups: Vec<PathGroup>,
    /// Paths without chords: particles at rest, and those that slide along the wall.
    alone: Vec<Alone>,
    /// Time of the last jump since the beginning, s.
    time_s: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Alone {
    id: usize,
    chords: Chords,
    mass_ratio: f64,
}

/// Hits and impulse of all particles, the latter over the first mass, m/s.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct WallSums {
    /// Since the paths began.
    pub(super) hits: u64,
    /// Since the paths began.
    pub(super) impulse: CompensatedSum,
    /// Since the last jump.
    pub(super) fresh_hits: u64,
    /// Since the last jump.
    pub(super) fresh_impulse: CompensatedSum,
}

impl Paths {
    /// The paths that begin now with these particles, whose masses are these times the first one.
    pub(super) fn begin(particles: &Particles, mass_ratios: &[f64], circle: Circle) -> Self {
        let mut groups = vec![
            PathGroup { half_chord: [1.0; LANES], ..PathGroup::default() };
            particles.groups.len()
        ];
        let mut alone = Vec::new();
        for (id, (particle, &mass_ratio)) in particles.iter().zip(mass_ratios).enumerate() {
            let scaled = circle.scaled(particle, 0.0);
            let chords = Chords::of(scaled, 1.0);
            if chords.slides() || chords.speed == 0.0 {
                alone.push(Alone { id, chords, mass_ratio });
                continue;
            }
            let (group, lane) = (&mut groups[id / LANES], id % LANES);
            group.along[lane] = chords.along;
            group.offset[lane] = chords.offset;
            group.half_chord[lane] = chords.half_chord;
            group.speed[lane] = chords.speed;
            group.turn[lane] = chords.turn_of_a_hit() / std::f64::consts::TAU;
            group.direction_x[lane] = scaled.velocity[0] / chords.speed;
            group.direction_y[lane] = scaled.velocity[1] / chords.speed;
            group.mass_ratio[lane] = mass_ratio;
        }
        Self { circle, groups, alone, time_s: 0.0 }
    }

    /// Puts the particles where their paths are at this time since they began.
    pub(super) fn jump_to(&mut self, time_s: f64, particles: &mut Particles) -> WallSums {
        let instant = Instant::of(&self.circle, time_s);
        let blocks: Vec<BlockSums> = self
            .groups
            .par_chunks_mut(BLOCK)
            .zip(particles.groups.par_chunks_mut(BLOCK))
            .map(|(paths, particles)| dispatch::run(Jump { instant, paths, particles }))
            .collect();
        let mut sums = WallSums::default();
        for block in &blocks {
            sums.hits += lane_sum(&block.hits) as u64;
            sums.fresh_hits += lane_sum(&block.fresh_hits) as u64;
            sums.impulse.add(lane_sum(&block.impulse));
            sums.fresh_impulse.add(lane_sum(&block.fresh_impulse));
        }
        let slid = |chords: &Chords, time: f64| self.slide_impulse(chords, time);
        for Alone { id, chords, mass_ratio } in &self.alone {
            let flight = chords.flight(instant.scaled_time);
            particles.set(*id, self.circle.unscaled(flight.particle, time_s));
            let impulse = mass_ratio * slid(chords, time_s);
            sums.impulse.add(impulse);
            sums.fresh_impulse.add(impulse - mass_ratio * slid(chords, self.time_s));
        }
        self.time_s = time_s;
        sums
    }

    /// Impulse over the mass of a path that slides along the wall, force s^2/R in the circle's own units: the integral of
    /// s^2 (1/R0 - u tau) over tau. Nothing for a particle at rest.
    fn slide_impulse(&self, chords: &Chords, time_s: f64) -> f64 {
        let (square, tau) = (chords.speed * chords.speed, self.circle.scaled_time(time_s));
        square * tau * (1.0 / self.circle.radius - self.circle.wall_speed * tau / 2.0)
    }
}

/// An instant in both clocks.
#[derive(Clone, Copy)]
struct Instant {
    scaled_time: f64,
    radius_at_start: f64,
    radius: f64,
    wall_speed: f64,
    /// 1 after the start, 0 at it: a particle on the wall has not hit yet.
    later: f64,
}

impl Instant {
    fn of(circle: &Circle, time_s: f64) -> Self {
        Self {
            scaled_time: circle.scaled_time(time_s),
            radius_at_start: circle.radius,
            radius: circle.radius_at(time_s),
            wall_speed: circle.wall_speed,
            later: if time_s > 0.0 { 1.0 } else { 0.0 },
        }
    }
}

/// Sums over a block, lane by lane.
#[derive(Clone, Copy, Default)]
struct BlockSums {
    hits: Lanes,
    fresh_hits: Lanes,
    impulse: Lanes,
    fresh_impulse: Lanes,
}

fn lane_sum(lanes: &Lanes) -> f64 {
    lanes.iter().fold(0.0, |sum, lane| sum + lane)
}

/// The closed form over one block.
struct Jump<'a> {
    instant: Instant,
    paths: &'a mut [PathGroup],
    particles: &'a mut [Group],
}

impl Kernel for Jump<'_> {
    type Output = BlockSums;

    #[inline(always)]
    fn run(self) -> BlockSums {
        let mut sums = BlockSums::default();
        for (path, particle) in self.paths.iter_mut().zip(self.particles) {
            // Copies: the compiler then sees that nothing overlaps.
            let (from, mut to, mut group_sums) = (*path, Group::default(), sums);
            for lane in 0..LANES {
                path.hits[lane] = jump_lane(&self.instant, &from, lane, &mut to, &mut group_sums);
            }
            (*particle, sums) = (to, group_sums);
        }
        sums
    }
}

/// `Chords::flight` of `motion.rs` for one particle of a group, branch by branch turned into a choice of values. Returns its hits.
#[inline(always)]
fn jump_lane(
    at: &Instant,
    path: &PathGroup,
    lane: usize,
    to: &mut Group,
    sums: &mut BlockSums,
) -> f64 {
    let (along, offset) = (path.along[lane], path.offset[lane]);
    let (half_chord, speed) = (path.half_chord[lane], path.speed[lane]);
    let way = along + speed * at.scaled_time;
    let hits = at.later * floor((way + half_chord) / (2.0 * half_chord));
    let run = way - 2.0 * half_chord * hits;
    // Rounding of a long way must not carry a particle beyond the wall.
    let run = if run > half_chord { half_chord } else { run };
    let run = if run < -half_chord { -half_chord } else { run };
    let (sine, cosine) = sine_and_cosine(hits * path.turn[lane]);
    let (dx, dy) = (path.direction_x[lane], path.direction_y[lane]);
    let (x, y) = (run * dx + offset * dy, run * dy - offset * dx);
    let (x, y) = (cosine * x - sine * y, sine * x + cosine * y);
    let (ux, uy) = (cosine * dx - sine * dy, sine * dx + cosine * dy);
    to.x[lane] = at.radius * x;
    to.y[lane] = at.radius * y;
    let scale = speed / at.radius;
    to.vx[lane] = scale * ux + at.wall_speed * x;
    to.vy[lane] = scale * uy + at.wall_speed * y;
    let before = path.hits[lane];
    sums.hits[lane] += hits;
    sums.fresh_hits[lane] += hits - before;
    let impulse = impulse_of_hits(at, path, lane, hits);
    sums.impulse[lane] += impulse;
    sums.fresh_impulse[lane] += impulse - impulse_of_hits(at, path, lane, before);
    hits
}

/// Impulse of a path's first hits over the first mass: the sum of `Circle::impulse_of_hit` over hits 2 C/s apart.
#[inline(always)]
fn impulse_of_hits(at: &Instant, path: &PathGroup, lane: usize, hits: f64) -> f64 {
    let half_chord = path.half_chord[lane];
    let series = hits * ((half_chord - path.along[lane]) + half_chord * (hits - 1.0));
    let of_mass =
        2.0 * half_chord * (path.speed[lane] * hits / at.radius_at_start - at.wall_speed * series);
    path.mass_ratio[lane] * of_mass
}

/// The largest whole number that is not above a number in [0, 2^51).
#[inline(always)]
fn floor(number: f64) -> f64 {
    let nearest = (number + ROUNDING) - ROUNDING;
    if nearest > number { nearest - 1.0 } else { nearest }
}
