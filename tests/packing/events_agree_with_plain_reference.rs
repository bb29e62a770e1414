//! Law: the engine finds the same collisions in the same order at the same times as the plain reference program.
//!
//! Source: the reference program below, O(n^2), which moves all discs to each event and checks all pairs and walls
//! again. It uses a different form of the collision time (the textbook's quadratic formula), no cells, no event queue,
//! and no local times of discs.
//! Setup: 20 discs at fraction 0.25, no wall noise; 2000 events for elastic discs, also in gravity, 400 for alpha = 0.8, which then
//! cool. In any program, rounding grows by about 2 l / s = 4 per collision with the free path l, so the reference
//! copies the engine's state every 20 events.
//! Tolerance: 1e-11 in time, position and velocity: 1e-14 of the plain formula, grown over a few collisions of one disc.
//! Control: the reference with a radius larger by 1e-6 is rejected.

// Assertions compare within tolerances, so no bit of a run depends on these functions.
#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use crate::runs::{
    DiscState, advance_to_count, at_fraction, disc_states, prepare, with_restitution, without_noise,
};
use kinetoscope_manifest::model::PackingConfig;
use kinetoscope_manifest::quantity::NonNegative;
use kinetoscope_physics::model::Model;

/// A plain event-driven program.
struct Reference {
    half: f64,
    radius: f64,
    restitution: f64,
    gravity: f64,
    time: f64,
    discs: Vec<DiscState>,
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

    /// Time to the ceiling, or else to the floor, by the quadratic formula.
    fn vertical_time(&self, disc: &DiscState) -> f64 {
        let (y, speed) = (disc.position[1], disc.velocity[1]);
        let root = |line: f64| (speed * speed - 2.0 * self.gravity * (line - y)).sqrt();
        let up = (speed - root(self.half - self.radius)) / self.gravity;
        if speed > 0.0 && !up.is_nan() {
            return up;
        }
        (speed + root(self.radius - self.half)) / self.gravity
    }

    fn next(&self) -> (f64, Next) {
        let mut earliest = (f64::INFINITY, Next::Wall(0, 0));
        for (index, disc) in self.discs.iter().enumerate() {
            for axis in 0..2 {
                let limit = (self.half - self.radius).copysign(disc.velocity[axis]);
                let mut wait = (limit - disc.position[axis]) / disc.velocity[axis];
                if axis == 1 && self.gravity > 0.0 {
                    wait = self.vertical_time(disc);
                }
                if wait < earliest.0 {
                    earliest = (wait, Next::Wall(index, axis));
                }
            }
            for other in 0..index {
                if let Some(wait) = self.pair_time(other, index)
                    && wait < earliest.0
                {
                    earliest = (wait, Next::Pair(other, index));
                }
            }
        }
        earliest
    }

    fn step(&mut self) {
        let (wait, next) = self.next();
        self.time += wait;
        for disc in &mut self.discs {
            for axis in 0..2 {
                disc.position[axis] += disc.velocity[axis] * wait;
            }
            disc.position[1] -= 0.5 * self.gravity * wait * wait;
            disc.velocity[1] -= self.gravity * wait;
        }
        match next {
            Next::Wall(disc, axis) => self.discs[disc].velocity[axis] *= -1.0,
            Next::Pair(first, second) => {
                let [one, other] = [self.discs[first], self.discs[second]];
                let r = [other.position[0] - one.position[0], other.position[1] - one.position[1]];
                let v = [other.velocity[0] - one.velocity[0], other.velocity[1] - one.velocity[1]];
                let factor = (1.0 + self.restitution) / 2.0 * (r[0] * v[0] + r[1] * v[1])
                    / (r[0] * r[0] + r[1] * r[1]);
                for (axis, along) in r.into_iter().enumerate() {
                    self.discs[first].velocity[axis] += factor * along;
                    self.discs[second].velocity[axis] -= factor * along;
                }
            }
        }
    }
}

fn state_difference(one: &[DiscState], other: &[DiscState]) -> f64 {
    let mut max = 0.0_f64;
    for (one, other) in one.iter().zip(other) {
        for axis in 0..2 {
            max = max.max((one.position[axis] - other.position[axis]).abs());
            max = max.max((one.velocity[axis] - other.velocity[axis]).abs());
        }
    }
    max
}

/// Largest difference in times, positions and velocities over a number of events.
fn max_difference(restitution: f64, gravity: f64, radius_error: f64, events: u64) -> f64 {
    let config = PackingConfig {
        gravity: NonNegative::new(gravity).unwrap(),
        ..with_restitution(without_noise(at_fraction(20, 0.25)), restitution)
    };
    let mut packing = prepare(&config, 12, 0);
    let mut reference = Reference {
        half: 0.5 * config.width.get(),
        radius: config.radius.get() + radius_error,
        restitution,
        gravity,
        time: 0.0,
        discs: disc_states(&packing),
    };
    let mut max = 0.0_f64;
    for count in 1..=events {
        advance_to_count(&mut packing, count);
        reference.step();
        let discs = disc_states(&packing);
        max = max.max((packing.time() - reference.time).abs());
        max = max.max(state_difference(&discs, &reference.discs));
        if count % 20 == 0 {
            (reference.time, reference.discs) = (packing.time(), discs);
        }
    }
    max
}

#[test]
fn every_event_agrees_with_the_reference() {
    for (restitution, gravity, events) in [(1.0, 0.0, 2000), (0.8, 0.0, 400), (1.0, 0.2, 2000)] {
        let difference = max_difference(restitution, gravity, 0.0, events);
        println!(
            "alpha {restitution}, gravity {gravity}, {events} events: largest difference {difference:e}"
        );
        assert!(difference < 1e-11);
        // Control.
        assert!(max_difference(restitution, gravity, 1e-6, events) > 1e-11);
    }
}
