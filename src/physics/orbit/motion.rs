//! Equations of motion of the orbit: a light body around a Sun fixed at the origin, with its conserved quantities, and several bodies
//! that attract one another (`bodies.rs` holds their conserved quantities).
//!
//! Lengths are in AU, times in days; energy and angular momentum are per unit mass.

use crate::constants::GM_SUN_AU3_PER_DAY2;
use serde::{Deserialize, Serialize};

/// Positions and velocities, three components per body: `Phase<[f64; 3]>` for one body, `Phase<Vec<f64>>` for several.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Phase<V> {
    /// r, AU.
    pub position: V,
    /// v, AU/day.
    pub velocity: V,
}

/// Position and velocity of one body.
pub type State = Phase<[f64; 3]>;

impl<V: AsRef<[f64]>> Phase<V> {
    /// Whether all numbers are finite.
    #[inline]
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let finite = |numbers: &V| numbers.as_ref().iter().all(|component| component.is_finite());
        finite(&self.position) && finite(&self.velocity)
    }

    /// The shortest step, days, in which a position changes by its last digit.
    pub(super) fn least_step(&self) -> f64 {
        let components = self.position.as_ref().iter().zip(self.velocity.as_ref());
        let steps =
            components.map(|(position, velocity)| (position / velocity).abs() * f64::EPSILON);
        // A component at rest gives infinity, or no number.
        steps.fold(f64::INFINITY, |least, step| if step < least { step } else { least })
    }
}

impl<V: AsRef<[f64]> + AsMut<[f64]>> Phase<V> {
    /// Copies a state of as many bodies into the memory of this one.
    #[inline]
    pub(super) fn copy_from(&mut self, source: &Self) {
        self.position.as_mut().copy_from_slice(source.position.as_ref());
        self.velocity.as_mut().copy_from_slice(source.velocity.as_ref());
    }
}

/// Accelerations of bodies as a function of their positions.
pub trait Force {
    /// Positions, velocities or accelerations of all bodies, three components per body.
    type Vector: Clone + AsRef<[f64]> + AsMut<[f64]>;
    /// Distances of the pairs of bodies that attract, which the force needs anyway.
    type Separations: Default;

    /// Computes the accelerations at the given positions, AU/day^2.
    fn accelerations(&self, positions: &Self::Vector, into: &mut Self::Vector);

    /// Computes the accelerations and the separations, AU.
    #[inline]
    fn accelerations_and_separations(
        &self,
        positions: &Self::Vector,
        into: &mut Self::Vector,
        _: &mut Self::Separations,
    ) {
        self.accelerations(positions, into);
    }
}

/// Gravity of a Sun fixed at the origin on a light body: [`acceleration_over_position`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FixedSun;

impl Force for FixedSun {
    type Vector = [f64; 3];
    type Separations = ();

    #[inline]
    fn accelerations(&self, position: &[f64; 3], into: &mut [f64; 3]) {
        *into = scaled(*position, acceleration_over_position(*position));
    }
}

/// Gravity between all bodies: [`mutual_accelerations`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MutualGravity {
    /// G m of each body, AU^3/day^2.
    pub gravitational_parameters: Vec<f64>,
}

impl Force for MutualGravity {
    type Vector = Vec<f64>;
    type Separations = Vec<f64>;

    #[inline]
    fn accelerations(&self, positions: &Vec<f64>, into: &mut Vec<f64>) {
        mutual_accelerations(&self.gravitational_parameters, positions, into);
    }

    #[inline]
    fn accelerations_and_separations(
        &self,
        positions: &Vec<f64>,
        into: &mut Vec<f64>,
        separations: &mut Vec<f64>,
    ) {
        accelerations_and_separations(&self.gravitational_parameters, positions, into, separations);
    }
}

/// Pairs of bodies of which at least one has mass, the lower number first, in the order in which the force adds them.
pub(super) fn attracting_pairs(
    gravitational_parameters: &[f64],
) -> impl Iterator<Item = [usize; 2]> {
    let count = gravitational_parameters.len();
    let all = (0..count).flat_map(move |one| (one + 1..count).map(move |other| [one, other]));
    all.filter(|pair| pair.iter().any(|body| gravitational_parameters[*body] != 0.0))
}

/// Equation of motion of a light body around a fixed Sun: a = -GM r / |r|^3 (orbit exercise, equation 14). Returns the factor k of
/// a = k r, day^-2:
///
/// k = -GM / |r|^3, GM in AU^3/day^2, r in AU.
#[inline]
#[must_use]
pub fn acceleration_over_position(position: [f64; 3]) -> f64 {
    let distance = length(position);
    -GM_SUN_AU3_PER_DAY2 / ((distance * distance) * distance)
}

/// Equation of motion of several bodies that attract one another, AU/day^2, pair by pair in the order of their numbers:
///
/// a_i = sum over j of G m_j (r_j - r_i) / |r_j - r_i|^3, G m in AU^3/day^2, r in AU
///
/// (Newton; Hairer, Lubich, Wanner: Geometric Numerical Integration, equation I.2.8). A body without mass adds nothing to the sum of
/// another one, not even a zero, so that no bit of the others' motion depends on it.
pub fn mutual_accelerations(gravitational_parameters: &[f64], positions: &[f64], into: &mut [f64]) {
    add_attractions(gravitational_parameters, positions, into, |_| ());
}

/// [`mutual_accelerations`], and the separations of the [`attracting_pairs`], AU. Not inlined: the vectors of the integration then stay in
/// registers.
#[inline(never)]
fn accelerations_and_separations(
    gravitational_parameters: &[f64],
    positions: &[f64],
    into: &mut [f64],
    separations: &mut Vec<f64>,
) {
    separations.clear();
    let note = |distance| separations.push(distance);
    add_attractions(gravitational_parameters, positions, into, note);
}

/// [`mutual_accelerations`]; `note` receives |r_j - r_i| of each pair, in the order of [`attracting_pairs`].
#[inline]
fn add_attractions(
    gravitational_parameters: &[f64],
    positions: &[f64],
    into: &mut [f64],
    mut note: impl FnMut(f64),
) {
    into.fill(0.0);
    let (positions, _) = positions.as_chunks::<3>();
    let (sums, _) = into.as_chunks_mut::<3>();
    for (i, first) in positions.iter().enumerate() {
        for (j, second) in positions.iter().enumerate().skip(i + 1) {
            let [of_first, of_second] = [gravitational_parameters[i], gravitational_parameters[j]];
            if of_first == 0.0 && of_second == 0.0 {
                continue;
            }
            let separation = add_scaled(*second, *first, -1.0);
            let distance = length(separation);
            note(distance);
            let inverse_cube = 1.0 / ((distance * distance) * distance);
            let attraction = scaled(separation, inverse_cube);
            if of_second != 0.0 {
                sums[i] = add_scaled(sums[i], attraction, of_second);
            }
            if of_first != 0.0 {
                sums[j] = add_scaled(sums[j], attraction, -of_first);
            }
        }
    }
}

/// Kinetic energy per unit mass, v^2 / 2, AU^2/day^2.
#[must_use]
pub fn kinetic_energy(velocity: [f64; 3]) -> f64 {
    0.5 * dot(velocity, velocity)
}

/// Potential energy per unit mass, -GM / |r|, AU^2/day^2.
#[must_use]
pub fn potential_energy(position: [f64; 3]) -> f64 {
    -GM_SUN_AU3_PER_DAY2 / length(position)
}

/// Energy per unit mass, v^2 / 2 - GM / |r|, AU^2/day^2: conserved by the exact motion.
#[must_use]
pub fn energy(state: State) -> f64 {
    kinetic_energy(state.velocity) + potential_energy(state.position)
}

/// Angular momentum per unit mass, r x v, AU^2/day: conserved by the exact motion, because the force is central.
#[must_use]
pub fn angular_momentum(state: State) -> [f64; 3] {
    cross(state.position, state.velocity)
}

/// |a| = sqrt((x^2 + y^2) + z^2)
#[inline]
#[must_use]
pub fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// a . b
#[inline]
#[must_use]
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

/// a x b
#[inline]
#[must_use]
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a + factor b
#[inline]
#[must_use]
pub fn add_scaled(a: [f64; 3], b: [f64; 3], factor: f64) -> [f64; 3] {
    [a[0] + b[0] * factor, a[1] + b[1] * factor, a[2] + b[2] * factor]
}

/// factor a
#[inline]
#[must_use]
pub fn scaled(a: [f64; 3], factor: f64) -> [f64; 3] {
    [factor * a[0], factor * a[1], factor * a[2]]
}
