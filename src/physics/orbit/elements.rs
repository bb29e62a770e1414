//! Osculating orbital elements of a state.

use super::motion::{State, angular_momentum, cross, dot, energy, length};
use crate::constants::GM_SUN_AU3_PER_DAY2;
use std::f64::consts::{PI, TAU};

/// Elements of the conic section that the body would follow without numerical error. Lengths in AU, times in days, angles in rad.
///
/// Angles are computed from two components (atan2), never only from a cosine: an inclination of 7e-5 would lose half its digits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elements {
    /// Energy per unit mass, v^2 / 2 - GM / r, AU^2/day^2.
    pub energy: f64,
    /// Angular momentum per unit mass, L = |r x v|, AU^2/day.
    pub angular_momentum: f64,
    /// Semi-major axis a = -GM / (2 energy), AU; negative for a hyperbola.
    pub semi_major_axis: f64,
    /// Eccentricity e, the length of (L^2 / (GM r) - 1, L (r . v) / (GM r)): radial and transverse components.
    pub eccentricity: f64,
    /// Perihelion distance L^2 / (GM (1 + e)), AU.
    pub perihelion: f64,
    /// Angle between r x v and the z axis, rad.
    pub inclination: f64,
    /// Longitude of the ascending node: angle from the x axis, rad, in (-pi, pi]; 0 if the orbit is in the plane z = 0.
    pub ascending_node: f64,
    /// Angle from the ascending node to the perihelion, rad, in [-pi, pi]; for a circle, the current position counts as perihelion.
    pub argument_of_perihelion: f64,
    /// Angle from the perihelion to the body, rad, in (-pi, pi].
    pub true_anomaly: f64,
    /// Elements that only closed orbits have.
    pub bound: Option<BoundElements>,
}

/// Elements of an ellipse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundElements {
    /// Period P = 2 pi sqrt(a^3 / GM), days (Kepler's third law).
    pub period: f64,
    /// Aphelion distance a (1 + e), AU.
    pub aphelion: f64,
    /// Mean anomaly M = E - e sin E, rad, with e cos E = 1 - r/a and e sin E = r . v / sqrt(GM a).
    pub mean_anomaly: f64,
}

impl Elements {
    /// Computes the elements of a state whose position is not zero.
    #[must_use]
    pub fn of(state: State) -> Self {
        const GM: f64 = GM_SUN_AU3_PER_DAY2;
        let distance = length(state.position);
        let radial_motion = dot(state.position, state.velocity);
        let energy = energy(state);
        let momentum = angular_momentum(state);
        let magnitude = length(momentum);
        let semi_latus_rectum = magnitude * magnitude / GM;
        let radial = semi_latus_rectum / distance - 1.0;
        let transverse = magnitude * radial_motion / (GM * distance);
        let eccentricity = (radial * radial + transverse * transverse).sqrt();
        let semi_major_axis = -GM / (2.0 * energy);
        let bound = (energy < 0.0).then(|| {
            let cosine = 1.0 - distance / semi_major_axis;
            let sine = radial_motion / (GM * semi_major_axis).sqrt();
            BoundElements {
                period: TAU * semi_major_axis * (semi_major_axis / GM).sqrt(),
                aphelion: semi_major_axis * (1.0 + eccentricity),
                mean_anomaly: libm::atan2(sine, cosine) - sine,
            }
        });
        let across = (momentum[0] * momentum[0] + momentum[1] * momentum[1]).sqrt();
        // The added zero replaces -0.0 by 0.0, for which atan2 differs.
        let ascending_node = libm::atan2(momentum[0] + 0.0, -momentum[1] + 0.0);
        let true_anomaly = libm::atan2(transverse, radial);
        let (sine, cosine) = (libm::sin(ascending_node), libm::cos(ascending_node));
        let towards_node = [cosine, sine, 0.0];
        let ahead_of_node = cross(momentum, towards_node);
        let from_node = libm::atan2(
            dot(state.position, ahead_of_node),
            dot(state.position, towards_node) * magnitude,
        );
        Self {
            energy,
            angular_momentum: magnitude,
            semi_major_axis,
            eccentricity,
            perihelion: semi_latus_rectum / (1.0 + eccentricity),
            inclination: libm::atan2(across, momentum[2]),
            ascending_node,
            argument_of_perihelion: within_half_a_turn(from_node - true_anomaly),
            true_anomaly,
            bound,
        }
    }
}

/// Equivalent angle in [-pi, pi].
fn within_half_a_turn(angle: f64) -> f64 {
    if angle > PI {
        angle - TAU
    } else if angle < -PI {
        angle + TAU
    } else {
        angle
    }
}

/// log10 of |change| / |reference|, or NaN without a change: a plot then shows drifts of any order of magnitude.
pub(super) fn log10_of_change(change: f64, reference: f64) -> f64 {
    let relative = (change / reference).abs();
    if relative > 0.0 { libm::log10(relative) } else { f64::NAN }
}
