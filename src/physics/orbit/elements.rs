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

/// An ellipse, and the place of a body on it: what determines a state, in AU and rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse {
    /// Semi-major axis, AU; above zero.
    pub semi_major_axis: f64,
    /// In [0, 1).
    pub eccentricity: f64,
    /// In [0, pi].
    pub inclination: f64,
    /// Longitude of the ascending node.
    pub ascending_node: f64,
    /// Angle from the ascending node to the perihelion.
    pub argument_of_perihelion: f64,
    /// Where the body is.
    pub anomaly: Anomaly,
}

/// Place on an ellipse, rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Anomaly {
    /// Angle from the perihelion.
    True(f64),
    /// Time since the perihelion, as a fraction of the period times 2 pi.
    Mean(f64),
}

impl Ellipse {
    /// State of a body on the ellipse around a mass with this G m, AU^3/day^2.
    ///
    /// With P toward the perihelion and Q ahead of it in the orbital plane, and b = a sqrt(1 - e^2):
    /// r = a (cos E - e) P + b sin E Q, v = sqrt(GM a) / |r| (-sin E P + b/a cos E Q) (Murray and Dermott: Solar System
    /// Dynamics, sections 2.4 and 2.8). The cosine of E is 1 - 2 sin^2(E/2), so that nothing cancels near the perihelion.
    #[must_use]
    pub fn state(&self, gravitational_parameter: f64) -> State {
        let (a, e) = (self.semi_major_axis, self.eccentricity);
        let ratio = ((1.0 - e) * (1.0 + e)).sqrt();
        let anomaly = match self.anomaly {
            Anomaly::Mean(mean) => eccentric_anomaly(mean, e),
            // tan(E/2) = sqrt((1 - e) / (1 + e)) tan(f/2)
            Anomaly::True(angle) => {
                let (sine, cosine) = (libm::sin(0.5 * angle), libm::cos(0.5 * angle));
                2.0 * libm::atan2((1.0 - e).sqrt() * sine, (1.0 + e).sqrt() * cosine)
            }
        };
        let half = libm::sin(0.5 * anomaly);
        let (sine, cosine) = (libm::sin(anomaly), libm::cos(anomaly));
        let distance = a * ((1.0 - e) + 2.0 * e * half * half);
        let rate = (gravitational_parameter * a).sqrt() / distance;
        let [perihelion, ahead] = self.axes();
        let along = |radial: f64, transverse: f64| {
            std::array::from_fn(|axis| radial * perihelion[axis] + transverse * ahead[axis])
        };
        State {
            position: along(a * ((1.0 - e) - 2.0 * half * half), a * ratio * sine),
            velocity: along(-rate * sine, rate * ratio * cosine),
        }
    }

    /// Unit vectors in the orbital plane: toward the perihelion, and ahead of it.
    fn axes(&self) -> [[f64; 3]; 2] {
        let pair = |angle| (libm::sin(angle), libm::cos(angle));
        let (sin_node, cos_node) = pair(self.ascending_node);
        let (sin_tilt, cos_tilt) = pair(self.inclination);
        let (sin_argument, cos_argument) = pair(self.argument_of_perihelion);
        // In the orbital plane: toward the ascending node, and ahead of it.
        let node = [cos_node, sin_node, 0.0];
        let next = [-sin_node * cos_tilt, cos_node * cos_tilt, sin_tilt];
        let turned = |first: f64, second: f64| {
            std::array::from_fn(|axis| first * node[axis] + second * next[axis])
        };
        [turned(cos_argument, sin_argument), turned(-sin_argument, cos_argument)]
    }
}

/// Solves Kepler's equation E - e sin E = M by Newton's method. From the right end of the bracket [M, M + e], M in [0, pi], where
/// the left side is convex, the iterates decrease to the solution.
fn eccentric_anomaly(mean: f64, eccentricity: f64) -> f64 {
    let mean = mean - TAU * (mean / TAU + 0.5).floor();
    let magnitude = mean.abs();
    let right = magnitude + eccentricity;
    let mut anomaly = if right < PI { right } else { PI };
    for _ in 0..100 {
        let excess = anomaly - eccentricity * libm::sin(anomaly) - magnitude;
        let next = anomaly - excess / (1.0 - eccentricity * libm::cos(anomaly));
        if next >= anomaly || next.is_nan() {
            break;
        }
        anomaly = next;
    }
    if mean < 0.0 { -anomaly } else { anomaly }
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
