//! The gas document's step with its defects mended.
//!
//! As printed, the rest of a step after a hit is a length, one hit a step is allowed and radial hits give 0/0. Here the rest is the
//! time dt - u, the path is mirrored at every hit until the step is used up, and the normal is never the zero vector.

use super::groups::{BLOCK, Group, LANES, Lanes, Particles};
use super::motion::{Chords, Flight, Particle, dot, drifted, reflected, time_to_wall};
use super::wall::Tally;
use crate::vector_width::{self, Kernel};
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
fn has_long_chords(particle: Particle, radius: f64, time_step: f64) -> bool {
    /// Far above the flatness at which a path counts as sliding.
    const FLATTEST: f64 = 1e-6;
    let square = dot(particle.velocity, particle.velocity);
    let along = dot(particle.position, particle.velocity);
    let room = radius * radius - dot(particle.position, particle.position);
    let half_chord_by_speed = along * along + square * room;
    let chords = 2.0 * (MOST_REFLECTIONS - 1) as f64;
    let way = square * time_step;
    half_chord_by_speed > FLATTEST * square * radius * radius
        && way * way < chords * chords * half_chord_by_speed
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
        let [x, y] = particle.position;
        let change =
            [before.velocity[0] - particle.velocity[0], before.velocity[1] - particle.velocity[1]];
        impulse_per_mass += (change[0] * x + change[1] * y) / radius;
        hits += 1;
        rest -= to_wall;
    }
}

/// So many steps of all particles, on all threads. Each group of particles takes all its steps before the next one: they do
/// not meet, and so it stays in registers.
pub(super) fn walk(
    particles: &mut Particles,
    tallies: &mut [Tally],
    radius: f64,
    time_step: f64,
    steps: u64,
) {
    particles.groups.par_chunks_mut(BLOCK).zip(tallies.par_chunks_mut(BLOCK * LANES)).for_each(
        |(groups, tallies)| {
            vector_width::run(Walk { groups, tallies, radius, time_step, steps });
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

impl Kernel for Walk<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { groups, tallies, radius, time_step, steps } = self;
        let square = radius * radius;
        for (group, tallies) in groups.iter_mut().zip(tallies.chunks_mut(LANES)) {
            let mut missing = steps;
            while missing > 0 {
                missing -= free_steps(group, square, time_step, missing);
                if missing > 0 {
                    step_near_the_wall(group, tallies, radius, time_step);
                    missing -= 1;
                }
            }
        }
    }
}

/// Takes steps while none of the group leads outside, at most so many, and says how many.
#[inline(always)]
fn free_steps(group: &mut Group, square: f64, time_step: f64, at_most: u64) -> u64 {
    let Group { mut x, mut y, vx, vy } = *group;
    let dx = vx.map(|component| time_step * component);
    let dy = vy.map(|component| time_step * component);
    let mut done = 0;
    while done < at_most {
        let next_x = sum(&x, &dx);
        let next_y = sum(&y, &dy);
        let mut outside = 0;
        for lane in 0..LANES {
            let distance = next_x[lane] * next_x[lane] + next_y[lane] * next_y[lane];
            outside |= u64::from(distance > square);
        }
        if outside != 0 {
            break;
        }
        (x, y) = (next_x, next_y);
        done += 1;
    }
    (group.x, group.y) = (x, y);
    done
}

#[inline(always)]
fn sum(a: &Lanes, b: &Lanes) -> Lanes {
    let mut sum = [0.0; LANES];
    for lane in 0..LANES {
        sum[lane] = a[lane] + b[lane];
    }
    sum
}

/// A step of a group of which some lead outside.
#[inline(never)]
fn step_near_the_wall(group: &mut Group, tallies: &mut [Tally], radius: f64, time_step: f64) {
    for (lane, tally) in tallies.iter_mut().enumerate() {
        let flight = step(group.particle(lane), radius, time_step);
        if flight.hits > 0 {
            group.set(lane, tally.on_its_path(flight.particle));
        } else {
            group.set(lane, flight.particle);
        }
        tally.book(&flight);
    }
}
