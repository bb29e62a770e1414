//! The equation of motion of a light body about a Sun at rest in the origin, and what it conserves.
//!
//! Lengths in AU, times in days; energy and angular momentum are those of a unit mass.

use crate::constants::GM_SUN_AU3_PER_DAY2;
use serde::{Deserialize, Serialize};

/// Where the body is and how it moves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// r, AU.
    pub position: [f64; 3],
    /// v, AU/day.
    pub velocity: [f64; 3],
}

impl State {
    /// Whether all six numbers are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.position.iter().chain(&self.velocity).all(|component| component.is_finite())
    }
}

/// The factor k of the acceleration a = k r, day^-2:
///
/// k = -GM / |r|^3, so that a = -GM r / |r|^3 (orbit document, equation 14).
#[must_use]
pub fn acceleration_over_position(position: [f64; 3]) -> f64 {
    let distance = length(position);
    -GM_SUN_AU3_PER_DAY2 / ((distance * distance) * distance)
}

/// v^2 / 2, AU^2/day^2.
#[must_use]
pub fn kinetic_energy(velocity: [f64; 3]) -> f64 {
    0.5 * dot(velocity, velocity)
}

/// -GM / |r|, AU^2/day^2.
#[must_use]
pub fn potential_energy(position: [f64; 3]) -> f64 {
    -GM_SUN_AU3_PER_DAY2 / length(position)
}

/// v^2 / 2 - GM / |r|, AU^2/day^2: conserved by the exact motion.
#[must_use]
pub fn energy(state: State) -> f64 {
    kinetic_energy(state.velocity) + potential_energy(state.position)
}

/// r x v, AU^2/day: conserved by the exact motion, since the force is central.
#[must_use]
pub fn angular_momentum(state: State) -> [f64; 3] {
    cross(state.position, state.velocity)
}

/// |a| = sqrt((x^2 + y^2) + z^2).
#[must_use]
pub fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// a . b.
#[must_use]
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

/// a x b.
#[must_use]
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a + factor b, component by component.
#[must_use]
pub fn add_scaled(a: [f64; 3], b: [f64; 3], factor: f64) -> [f64; 3] {
    [a[0] + b[0] * factor, a[1] + b[1] * factor, a[2] + b[2] * factor]
}

/// factor a, component by component.
#[must_use]
pub fn scaled(a: [f64; 3], factor: f64) -> [f64; 3] {
    [factor * a[0], factor * a[1], factor * a[2]]
}
