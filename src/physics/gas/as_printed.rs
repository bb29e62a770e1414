//! As-printed propagator: the step of the gas exercise with its defects, kept to show their effect. It is not suitable for physics.
//!
//! Its defects:
//! 1. u of (9) is sought in (0, 1], although p + v u makes it a time in (0, dt];
//! 2. step 4(b) scales v to the LENGTH 1 - u: after a wall collision, the particle is 1 - u meters from the wall, possibly outside;
//! 3. step 3(a) projects the point p1 instead of p1 - c: the reflection is wrong if the center is not the origin;
//! 4. a radial collision scales the zero vector (0/0), and a start on the wall has no positive root;
//! 5. a step has at most one reflection.
//!
//! If (9) has no root in (0, 1] (on the wall, or outside and moving away), the exercise does not define the step; the particle then
//! drifts. A particle whose position becomes 0/0 is lost and keeps its last position.

use super::clock::{Clock, StepClock};
use super::motion::{Flight, Particle, dot, drifted};
use super::propagator::Propagator;
use super::state::{Container, GasState};
use super::tallies::ParticleTally;
use crate::model::Target;
use serde::{Deserialize, Serialize};

/// Clock of the steps, and wall collisions of each particle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct AsPrinted {
    clock: StepClock,
    tallies: Vec<ParticleTally>,
    /// Whether the step of a particle gave 0/0.
    is_lost: Vec<bool>,
}

impl AsPrinted {
    /// The scheme at time 0.
    pub(super) fn new(clock: StepClock, state: &GasState) -> Self {
        let mut tallies = vec![ParticleTally::default(); state.particles.len()];
        ParticleTally::start_paths(&mut tallies, state.particles.iter());
        Self { clock, is_lost: vec![false; tallies.len()], tallies }
    }
}

impl Propagator for AsPrinted {
    fn clock(&self) -> Clock {
        Clock::Steps(self.clock)
    }

    fn is_valid_for(&self, state: &GasState, _max_speed: f64) -> bool {
        let count = state.particles.len();
        self.tallies.len() == count
            && self.is_lost.len() == count
            && self.tallies.iter().all(ParticleTally::is_valid)
    }

    fn advance(&mut self, target: Target, budget: &mut u64, state: &mut GasState) -> bool {
        let steps = self.clock.steps_toward(target, budget);
        let time_step = self.clock.time_step_s;
        let Container { center_m, circle, .. } = state.container;
        for (id, (tally, is_lost)) in self.tallies.iter_mut().zip(&mut self.is_lost).enumerate() {
            let mut particle = state.particles.get(id);
            for _ in 0..steps {
                if *is_lost {
                    break;
                }
                let flight = step_as_printed(particle, center_m, circle.radius, time_step);
                *is_lost = !is_finite(&flight);
                if !*is_lost {
                    particle = flight.particle;
                    tally.add(&flight);
                }
            }
            state.particles.set(id, particle);
        }
        self.clock.done += steps;
        let is_reached = self.clock.has_reached(target);
        if is_reached {
            state.wall.gather(&self.tallies, &state.substance.mass_ratios);
        }
        is_reached
    }

    /// Does nothing: the scheme keeps no invariants.
    fn restart_paths(&mut self, _state: &GasState) {}

    fn open_window(&mut self) {
        self.tallies.iter_mut().for_each(ParticleTally::open_window);
    }

    fn lost_particles(&self) -> &[bool] {
        &self.is_lost
    }

    fn description(&self, _state: &GasState) -> String {
        let StepClock { total, time_step_s, .. } = self.clock;
        format!(
            "propagation: {total} steps of {time_step_s} s as printed in the exercise, with its defects"
        )
    }
}

fn is_finite(flight: &Flight) -> bool {
    let Particle { position, velocity } = flight.particle;
    position.iter().chain(&velocity).all(|component| component.is_finite())
}

/// One step of a particle: equations (7) to (10) and steps 1 to 4 of the gas exercise as printed. Positions are relative to the center,
/// except p1 in step 3(a). The particle may end outside, and its state may not be finite.
#[must_use]
pub fn step_as_printed(
    particle: Particle,
    center: [f64; 2],
    radius: f64,
    time_step: f64,
) -> Flight {
    let free = drifted(particle, time_step);
    let drift = Flight { particle: free, wall_collisions: 0, impulse_per_mass: 0.0 };
    // (8)
    if length(free.position) <= radius {
        return drift;
    }
    // (9), (10)
    let Some(u) = positive_root(particle, radius) else { return drift };
    let Particle { position: p1, velocity: v } = particle;
    let pc = drifted(particle, u).position;
    // 3(a) to 3(c)
    let vp = difference(add(p1, center), projection(add(p1, center), pc));
    let mirror_image = add(p1, scale(vp, 2.0 * length(vp)));
    let v2 = scale(difference(pc, mirror_image), length(v));
    // 4(a), 4(b)
    let position = add(pc, scale(v2, 1.0 - u));
    let impulse_per_mass = dot(difference(v2, v), pc) / radius;
    Flight { particle: Particle { position, velocity: v2 }, wall_collisions: 1, impulse_per_mass }
}

/// Larger root u of (9) if it is in (0, 1].
fn positive_root(particle: Particle, radius: f64) -> Option<f64> {
    let Particle { position, velocity } = particle;
    let a = dot(velocity, velocity);
    let b = 2.0 * dot(position, velocity);
    let c = dot(position, position) - radius * radius;
    let u = (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);
    (u > 0.0 && u <= 1.0).then_some(u)
}

/// Equation (1): length.
fn length(v: [f64; 2]) -> f64 {
    (v[0] * v[0] + v[1] * v[1]).sqrt()
}

/// Equation (2): vector of length s in the direction of v; 0/0 for the zero vector.
fn scale(v: [f64; 2], s: f64) -> [f64; 2] {
    [v[0] / length(v) * s, v[1] / length(v) * s]
}

/// Equation (3): vector from the first point to the second.
fn difference(from: [f64; 2], to: [f64; 2]) -> [f64; 2] {
    [to[0] - from[0], to[1] - from[1]]
}

/// Equation (4): sum.
fn add(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

/// Equation (6): projection of p on v.
fn projection(p: [f64; 2], v: [f64; 2]) -> [f64; 2] {
    let factor = dot(p, v) / dot(v, v);
    [factor * v[0], factor * v[1]]
}
