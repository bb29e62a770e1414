//! The equations of motion: of a light body about a Sun at rest in the origin, with what it conserves, and of several bodies
//! that attract each other (what those conserve: `bodies`).
//!
//! Lengths in AU, times in days; energy and angular momentum are those of a unit mass.

use crate::constants::GM_SUN_AU3_PER_DAY2;
use serde::{Deserialize, Serialize};

/// Positions and velocities: of one body as `Phase<[f64; 3]>`, of several as `Phase<Vec<f64>>`, three components a body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Phase<V> {
    /// r, AU.
    pub position: V,
    /// v, AU/day.
    pub velocity: V,
}

/// Where the body is and how it moves.
pub type State = Phase<[f64; 3]>;

impl<V: AsRef<[f64]>> Phase<V> {
    /// Whether all numbers are finite.
    #[inline]
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let finite = |numbers: &V| numbers.as_ref().iter().all(|component| component.is_finite());
        finite(&self.position) && finite(&self.velocity)
    }
}

/// What accelerates bodies, by where they are.
pub trait Force {
    /// Positions, velocities or accelerations of all bodies, three components each.
    type Vector: Clone + AsRef<[f64]> + AsMut<[f64]>;

    /// The accelerations at these positions, AU/day^2.
    fn accelerations(&self, positions: &Self::Vector, into: &mut Self::Vector);
}

/// The pull of a Sun at rest in the origin on a light body: [`acceleration_over_position`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FixedSun;

impl Force for FixedSun {
    type Vector = [f64; 3];

    #[inline]
    fn accelerations(&self, position: &[f64; 3], into: &mut [f64; 3]) {
        *into = scaled(*position, acceleration_over_position(*position));
    }
}

/// The pull of all bodies on each other: [`mutual_accelerations`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mutual {
    /// G m of each body, AU^3/day^2.
    pub gravitational_parameters: Vec<f64>,
}

impl Force for Mutual {
    type Vector = Vec<f64>;

    fn accelerations(&self, positions: &Vec<f64>, into: &mut Vec<f64>) {
        mutual_accelerations(&self.gravitational_parameters, positions, into);
    }
}

/// The factor k of the acceleration a = k r, day^-2:
///
/// k = -GM / |r|^3, so that a = -GM r / |r|^3 (orbit document, equation 14).
#[inline]
#[must_use]
pub fn acceleration_over_position(position: [f64; 3]) -> f64 {
    let distance = length(position);
    -GM_SUN_AU3_PER_DAY2 / ((distance * distance) * distance)
}

/// The accelerations of bodies that attract each other, AU/day^2, pair by pair in the order of their ids:
///
/// a_i = sum over j of G m_j (r_j - r_i) / |r_j - r_i|^3 (Newton; Hairer, Lubich, Wanner: Geometric Numerical Integration,
/// equation I.2.8).
pub fn mutual_accelerations(gravitational_parameters: &[f64], positions: &[f64], into: &mut [f64]) {
    into.fill(0.0);
    let (places, _) = positions.as_chunks::<3>();
    let (sums, _) = into.as_chunks_mut::<3>();
    for (i, here) in places.iter().enumerate() {
        for (j, there) in places.iter().enumerate().skip(i + 1) {
            let apart = add_scaled(*there, *here, -1.0);
            let distance = length(apart);
            let inverse_cube = 1.0 / ((distance * distance) * distance);
            let pull = scaled(apart, inverse_cube);
            sums[i] = add_scaled(sums[i], pull, gravitational_parameters[j]);
            sums[j] = add_scaled(sums[j], pull, -gravitational_parameters[i]);
        }
    }
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
#[inline]
#[must_use]
pub fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// a . b.
#[inline]
#[must_use]
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

/// a x b.
#[inline]
#[must_use]
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a + factor b, component by component.
#[inline]
#[must_use]
pub fn add_scaled(a: [f64; 3], b: [f64; 3], factor: f64) -> [f64; 3] {
    [a[0] + b[0] * factor, a[1] + b[1] * factor, a[2] + b[2] * factor]
}

/// factor a, component by component.
#[inline]
#[must_use]
pub fn scaled(a: [f64; 3], factor: f64) -> [f64; 3] {
    [factor * a[0], factor * a[1], factor * a[2]]
}
