//! The frame that turns with a planet: bodies that share its orbit move slowly in it, on tadpoles and horseshoes.

use super::laws::{difference, dot, norm};

/// Positions and velocities of all bodies at one time.
#[derive(Clone, Debug, Default)]
pub(super) struct Instant {
    /// AU.
    pub(super) positions: Vec<[f64; 3]>,
    /// AU/day.
    pub(super) velocities: Vec<[f64; 3]>,
}

/// Largest relative difference of the semi-major axes of bodies that share an orbit.
const MAX_AXIS_DIFFERENCE: f64 = 0.1;

/// Which bodies are shown in the rotating frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RotatingFrame {
    pub(super) central: usize,
    /// The most massive body but the central one.
    pub(super) planet: usize,
    /// Bodies with about the semi-major axis of the planet.
    pub(super) companions: Vec<usize>,
}

impl RotatingFrame {
    /// The frame of a system with a central body and others that share the orbit of the most massive one; `None` without
    /// any.
    pub(super) fn of(gravitational_parameters: &[f64], start: &Instant) -> Option<Self> {
        let total: f64 = gravitational_parameters.iter().sum();
        let central = gravitational_parameters.iter().position(|body| *body > 0.5 * total)?;
        let heavier = |one: &usize, other: &usize| {
            gravitational_parameters[*one].total_cmp(&gravitational_parameters[*other])
        };
        let others = || (0..gravitational_parameters.len()).filter(|body| *body != central);
        let planet = others().max_by(heavier)?;
        if gravitational_parameters[planet] == 0.0 {
            return None;
        }
        let axis = |body: usize| {
            let position = difference(start.positions[body], start.positions[central]);
            let velocity = difference(start.velocities[body], start.velocities[central]);
            let attraction = gravitational_parameters[central] + gravitational_parameters[body];
            1.0 / (2.0 / norm(position) - dot(velocity, velocity) / attraction)
        };
        let is_near = |body: &usize| {
            *body != planet && (axis(*body) / axis(planet) - 1.0).abs() <= MAX_AXIS_DIFFERENCE
        };
        let companions: Vec<usize> = others().filter(is_near).collect();
        (!companions.is_empty()).then_some(Self { central, planet, companions })
    }

    /// Position of a body from the central body in the frame whose x axis points to the planet, in the plane z = 0, AU.
    pub(super) fn position(&self, positions: &[[f64; 3]], body: usize) -> (f64, f64) {
        let from_center = |body: usize| difference(positions[body], positions[self.central]);
        let ([x, y, _], [along_x, along_y, _]) = (from_center(body), from_center(self.planet));
        let length = (along_x * along_x + along_y * along_y).sqrt();
        ((x * along_x + y * along_y) / length, (y * along_x - x * along_y) / length)
    }
}
