//! Angle of the body around the Sun since the start, counted beyond one revolution.

use super::motion::{State, angular_momentum, cross, dot, length, scaled};
use serde::{Deserialize, Serialize};

/// Orbital plane at the start, with two axes whose sense of rotation is that of the body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OrbitalPlane {
    /// Unit vector toward the start.
    radial: [f64; 3],
    /// Unit vector perpendicular to it, in the direction of the motion.
    transverse: [f64; 3],
}

impl OrbitalPlane {
    /// Plane of a position and a velocity that are not parallel.
    #[must_use]
    pub fn of(start: State) -> Self {
        let momentum = angular_momentum(start);
        let normal = scaled(momentum, 1.0 / length(momentum));
        let radial = scaled(start.position, 1.0 / length(start.position));
        Self { radial, transverse: cross(normal, radial) }
    }

    /// Angle from the start, rad, in (-pi, pi].
    #[must_use]
    pub fn angle(&self, position: [f64; 3]) -> f64 {
        let [radial, transverse] = self.coordinates(position);
        // The added zero replaces -0.0 by 0.0: the angle on the branch is pi, as in `turns_between`.
        libm::atan2(transverse + 0.0, radial)
    }

    /// Whether [`OrbitalPlane::angle`] is at least zero.
    #[inline]
    #[must_use]
    pub fn is_first_half(&self, position: [f64; 3]) -> bool {
        dot(position, self.transverse) >= 0.0
    }

    /// Jump of [`OrbitalPlane::angle`] on the straight line between two positions, in whole turns: 1 if it crosses the branch (opposite
    /// the start) forward, -1 backward, otherwise 0. The line must span less than half a turn.
    #[inline]
    #[must_use]
    pub fn turns_between(&self, from: [f64; 3], to: [f64; 3]) -> i64 {
        let [radial, transverse] = self.coordinates(from);
        let [next_radial, next_transverse] = self.coordinates(to);
        match (transverse >= 0.0, next_transverse >= 0.0) {
            (true, false) => i64::from(radial * next_transverse - transverse * next_radial > 0.0),
            (false, true) => -i64::from(radial * next_transverse - transverse * next_radial < 0.0),
            _ => 0,
        }
    }

    /// Whether the straight line between two positions crosses the direction of the start forward. The line must span less than half a
    /// turn.
    #[must_use]
    pub fn passes_start(&self, from: [f64; 3], to: [f64; 3]) -> bool {
        let [radial, transverse] = self.coordinates(from);
        let [next_radial, next_transverse] = self.coordinates(to);
        let is_forward = radial * next_transverse - transverse * next_radial > 0.0;
        transverse < 0.0 && next_transverse >= 0.0 && is_forward
    }

    /// Distance from the line through the Sun and the start, positive ahead of the start, AU.
    #[must_use]
    pub fn transverse(&self, position: [f64; 3]) -> f64 {
        dot(position, self.transverse)
    }

    fn coordinates(&self, position: [f64; 3]) -> [f64; 2] {
        [dot(position, self.radial), dot(position, self.transverse)]
    }
}
