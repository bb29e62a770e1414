//! The gas document's step with its defects mended.
//!
//! As printed, the rest of a step after a hit is a length, one hit a step is allowed and radial hits give 0/0. Here the rest is the
//! time dt - u, the path is mirrored at every hit until the step is used up, and the normal is never the zero vector.

use super::motion::{Chords, Flight, Particle, dot, drifted, reflected, time_to_wall};
use super::particle_groups::{BLOCK, Group, LANES, Lanes, Particles};
use super::wall_tally::Tally;
use crate::simd::dispatch::{self, Kernel};
use rayon::prelude::*;

/// Hits in one step above which the closed form takes the whole step: grazing paths hit as often as they like.
const MOST_REFLECTIONS: u64 = 64;

/// One step of a particle inside the wall: equation (7), and while that leads outside equations (9) and (10) with u in
/// (0, rest of the step], then the mirror.
#[must_use]
#[inline]
pub fn step(particle: Particle, radius: f64, time_step: f64) -> Flight {
    let end = drifted(particle, time_step);
    let [x, y] = end.position;
    if x * x + y * y <= radius * radius {
        return Flight { particle: end, hits: 0, impulse_per_mass: 0.0 };
    }
    step_with_hits(particle, radius, time_step)
}

/// A step that leads outside. Apart from the free step, which is what most particles do most of the time.
fn step_with_hits(particle: Particle, radius: f64, time_step: f64) -> Flight {
    if has_long_chords(particle, radius, time_step) {
        return reflect_until_used_up(particle, radius, time_step);
    }
    let chords = Chords::of(particle, radius);
    if chords.slides() || chords.hits(time_step) > MOST_REFLECTIONS {
        chords.flight(time_step)
    } else {
        reflect_until_used_up(particle, radius, time_step)
    }
}

/// Whether a path neither slides nor can hit more often than it is mirrored, by products alone: most paths, and so they are spared
/// roots and quotients. C^2 v^2 = (p . v)^2 + v^2 (R^2 - p^2), and the way v t of a step is at most as many chords 2 C.
#[inline(always)]
fn has_long_chords(particle: Particle, radius: f64, time_step: f64) -> bool {
    /// Far above the flatness at which a path counts as sliding.
    const FLATTEST: f64 = 1e-6;
    let square = dot(particle.velocity, particle.velocity);
    let along = dot(particle.position, particle.velocity);
    let room = radius * radius - dot(particle.position, particle.position);
    let half_chord_by_speed = along * along + square * room;
    let chords = 2.0 * (MOST_REFLECTIONS - 1) as f64;
    let way = square * time_step;
    (half_chord_by_speed > FLATTEST * square * radius * radius)
        & (way * way < chords * chords * half_chord_by_speed)
}

/// Flies and mirrors until the time is used up. It ends: the path does not slide, so after a mirror the velocity points
/// inwards by far more than its rounding, and the next hit is a chord away.
///
/// A hit is not moved onto the wall, from which it is a rounding away: the mirror keeps p x v where it stands, and every next hit
/// is found from the circle anew, so that neither error adds up.
fn reflect_until_used_up(mut particle: Particle, radius: f64, time: f64) -> Flight {
    let mut rest = time;
    let mut hits = 0;
    let mut impulse_per_mass = 0.0;
    loop {
        let to_wall = time_to_wall(particle, radius);
        if to_wall >= rest {
            return Flight { particle: drifted(particle, rest), hits, impulse_per_mass };
        }
        let before = drifted(particle, to_wall);
        particle = reflected(before);
        impulse_per_mass += impulse_of(before, particle, radius);
        hits += 1;
        rest -= to_wall;
    }
}

/// So many steps of all particles, on all threads. A block takes all its steps before the next one: particles do not meet, and so it
/// stays in the nearest cache.
pub(super) fn walk(
    particles: &mut Particles,
    tallies: &mut [Tally],
    radius: f64,
    time_step: f64,
    steps: u64,
) {
    particles.groups.par_chunks_mut(BLOCK).zip(tallies.par_chunks_mut(BLOCK * LANES)).for_each(
        |(groups, tallies)| {
            dispatch::run(Walk { groups, tallies, radius, time_step, steps });
        },
    );
}

/// The steps of one block.
struct Walk<'a> {
    groups: &'a mut [Group],
    tallies: &'a mut [Tally],
    radius: f64,
    time_step: f64,
    steps: u64,
}

/// A particle whose step leads outside, and where it was before.
#[derive(Clone, Copy, Default)]
struct Leaving {
    id: usize,
    position: [f64; 2],
}

impl Kernel for Walk<'_> {
    type Output = ();

    /// In each step all particles fly; those that come outside are listed, and then mirrored eight at a time. One place of the list is
    /// never read: particles are written there before it is known whether they leave.
    #[inline(always)]
    fn run(mut self) {
        let mut leaving = [Leaving::default(); BLOCK * LANES + 1];
        for _ in 0..self.steps {
            let count = self.fly(&mut leaving);
            for few in leaving[..count].chunks(LANES) {
                self.mirror(few);
            }
        }
    }
}

impl Walk<'_> {
    /// Moves all particles by a step, lists those that come outside, and says how many they are.
    #[inline(always)]
    fn fly(&mut self, leaving: &mut [Leaving; BLOCK * LANES + 1]) -> usize {
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

    /// Takes the step of at most eight particles that leads outside: by `mirrored_once`, or where that does not hold one by one.
    #[inline(always)]
    fn mirror(&mut self, leaving: &[Leaving]) {
        let mut before = Group { vx: [1.0; LANES], ..Group::default() };
        let mut tallies = [Tally::at_unit_speed(); LANES];
        for (lane, Leaving { id, position }) in leaving.iter().enumerate() {
            let velocity = self.groups[id / LANES].particle(id % LANES).velocity;
            before.set(lane, Particle { position: *position, velocity });
            tallies[lane] = self.tallies[*id];
        }
        let (after, impulses, holds) =
            mirrored_once(&before, &tallies, self.radius, self.time_step);
        for (lane, Leaving { id, .. }) in leaving.iter().enumerate() {
            let tally = &mut self.tallies[*id];
            let particle = if holds[lane] {
                let particle = after.particle(lane);
                tally.book(&Flight { particle, hits: 1, impulse_per_mass: impulses[lane] });
                particle
            } else {
                step_to_the_wall(before.particle(lane), tally, self.radius, self.time_step)
            };
            self.groups[id / LANES].set(id % LANES, particle);
        }
    }
}

/// `step` of eight particles that meet the wall once, in the same arithmetic without branches: where they are after it, brought back
/// to their paths, their impulses, and for which of them it holds.
#[inline(always)]
fn mirrored_once(
    before: &Group,
    tallies: &[Tally; LANES],
    radius: f64,
    time_step: f64,
) -> (Group, Lanes, [bool; LANES]) {
    let (mut after, mut impulses, mut holds) = (Group::default(), [0.0; LANES], [false; LANES]);
    for lane in 0..LANES {
        let particle = before.particle(lane);
        let to_wall = time_to_wall(particle, radius);
        let there = drifted(particle, to_wall);
        let turned = reflected(there);
        impulses[lane] = impulse_of(there, turned, radius);
        let end = drifted(turned, time_step - to_wall);
        holds[lane] = (dot(end.position, end.position) <= radius * radius)
            & (to_wall < time_step)
            & has_long_chords(particle, radius, time_step);
        after.set(lane, tallies[lane].on_its_path(end));
    }
    (after, impulses, holds)
}

/// Normal impulse over the mass of a mirror at the wall, m/s.
#[inline(always)]
fn impulse_of(before: Particle, after: Particle, radius: f64) -> f64 {
    let change = [before.velocity[0] - after.velocity[0], before.velocity[1] - after.velocity[1]];
    dot(change, before.position) / radius
}

/// A step that leads outside, booked.
#[inline(never)]
fn step_to_the_wall(
    particle: Particle,
    tally: &mut Tally,
    radius: f64,
    time_step: f64,
) -> Particle {
    let flight = step_with_hits(particle, radius, time_step);
    tally.book(&flight);
    if flight.hits > 0 { tally.on_its_path(flight.particle) } else { flight.particle }
}
