//! Law: the engine finds the same collisions in the same order at the same times as the plainest program does.
//! Reference: written here, O(n^2): all discs are moved to each event, all pairs and walls are looked at anew, with another
//! form of the collision time (the textbook's quadratic formula) and no cells, no queue, no clocks of discs.
//! Setup: 20 discs at fraction 0.25, no wall noise, elastic and alpha = 0.8 (400 events before it is cold); 2000 events.
//! Rounding grows by some 2 l / s = 4 a collision with the free path l, whatever program: every 20 events the reference
//! takes over what the engine shows.
//! Tolerance: 1e-11 in time, place and velocity: 1e-14 of the plain formula, grown over a few collisions of one disc.
//! Control: the reference with a radius larger by 1e-6 is rejected.

// A test judges within tolerances: no bit of a run depends on it.
#![allow(clippy::disallowed_methods)]

use crate::runs::{
    Seen, advance_to_count, at_fraction, look, prepare, with_restitution, without_noise,
};
use kinetoscope_physics::model::Model;

/// The plainest event-driven program.
struct Reference {
    half: f64,
    radius: f64,
    restitution: f64,
    time: f64,
    discs: Vec<Seen>,
}

#[derive(Clone, Copy)]
enum Next {
    Pair(usize, usize),
    Wall(usize, usize),
}

impl Reference {
    fn pair_time(&self, first: usize, second: usize) -> Option<f64> {
        let [one, other] = [self.discs[first], self.discs[second]];
        let r = [other.position[0] - one.position[0], other.position[1] - one.position[1]];
        let v = [other.velocity[0] - one.velocity[0], other.velocity[1] - one.velocity[1]];
        let b = 2.0 * (r[0] * v[0] + r[1] * v[1]);
        let a = v[0] * v[0] + v[1] * v[1];
        let c = r[0] * r[0] + r[1] * r[1] - 4.0 * self.radius * self.radius;
        let discriminant = b * b - 4.0 * a * c;
        (b < 0.0 && discriminant >= 0.0).then(|| (-b - discriminant.sqrt()) / (2.0 * a))
    }

    fn next(&self) -> (f64, Next) {
        let mut soonest = (f64::INFINITY, Next::Wall(0, 0));
        for (index, disc) in self.discs.iter().enumerate() {
            for axis in 0..2 {
                let limit = (self.half - self.radius).copysign(disc.velocity[axis]);
                let wait = (limit - disc.position[axis]) / disc.velocity[axis];
                if wait < soonest.0 {
                    soonest = (wait, Next::Wall(index, axis));
                }
            }
            for other in 0..index {
                if let Some(wait) = self.pair_time(other, index)
                    && wait < soonest.0
                {
                    soonest = (wait, Next::Pair(other, index));
                }
            }
        }
        soonest
    }

    fn step(&mut self) {
        let (wait, next) = self.next();
        self.time += wait;
        for disc in &mut self.discs {
            for axis in 0..2 {
                disc.position[axis] += disc.velocity[axis] * wait;
            }
        }
        match next {
            Next::Wall(disc, axis) => self.discs[disc].velocity[axis] *= -1.0,
            Next::Pair(first, second) => {
                let [one, other] = [self.discs[first], self.discs[second]];
                let r = [other.position[0] - one.position[0], other.position[1] - one.position[1]];
                let v = [other.velocity[0] - one.velocity[0], other.velocity[1] - one.velocity[1]];
                let share = (1.0 + self.restitution) / 2.0 * (r[0] * v[0] + r[1] * v[1])
                    / (r[0] * r[0] + r[1] * r[1]);
                for (axis, along) in r.into_iter().enumerate() {
                    self.discs[first].velocity[axis] += share * along;
                    self.discs[second].velocity[axis] -= share * along;
                }
            }
        }
    }
}

fn difference(one: &[Seen], other: &[Seen]) -> f64 {
    let mut largest = 0.0_f64;
    for (one, other) in one.iter().zip(other) {
        for axis in 0..2 {
            largest = largest.max((one.position[axis] - other.position[axis]).abs());
            largest = largest.max((one.velocity[axis] - other.velocity[axis]).abs());
        }
    }
    largest
}

/// Largest difference of times, places and velocities over so many events.
fn largest_difference(restitution: f64, radius_error: f64, events: u64) -> f64 {
    let config = with_restitution(without_noise(at_fraction(20, 0.25)), restitution);
    let mut packing = prepare(&config, 12, 0);
    let mut reference = Reference {
        half: 0.5 * config.width.get(),
        radius: config.radius.get() + radius_error,
        restitution,
        time: 0.0,
        discs: look(&packing),
    };
    let mut largest = 0.0_f64;
    for count in 1..=events {
        advance_to_count(&mut packing, count);
        reference.step();
        let seen = look(&packing);
        largest = largest.max((packing.time() - reference.time).abs());
        largest = largest.max(difference(&seen, &reference.discs));
        if count % 20 == 0 {
            (reference.time, reference.discs) = (packing.time(), seen);
        }
    }
    largest
}

#[test]
fn events_agree_one_by_one() {
    for (restitution, events) in [(1.0, 2000), (0.8, 400)] {
        let difference = largest_difference(restitution, 0.0, events);
        println!("alpha {restitution}, {events} events: largest difference {difference:e}");
        assert!(difference < 1e-11);
        assert!(largest_difference(restitution, 1e-6, events) > 1e-11);
    }
}
