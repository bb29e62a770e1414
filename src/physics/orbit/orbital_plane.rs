//! The angle that the body has turned through about the Sun, beyond one revolution.

use super::motion::{State, angular_momentum, cross, dot, length, scaled};
use serde::{Deserialize, Serialize};

/// The plane of the motion at the start, with a right-handed pair of axes that turns as the body does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plane {
    /// Unit vector toward the start.
    ahead: [f64; 3],
    /// Unit vector across it, into the direction of the motion.
    across: [f64; 3],
}

impl Plane {
    /// The plane of position and velocity; they are not parallel.
    #[must_use]
    pub fn of(start: State) -> Self {
        let momentum = angular_momentum(start);
        let normal = scaled(momentum, 1.0 / length(momentum));
        let ahead = scaled(start.position, 1.0 / length(start.position));
        Self { ahead, across: cross(normal, ahead) }
    }

    /// The angle from the start, in (-pi, pi].
    #[must_use]
    pub fn angle(&self, position: [f64; 3]) -> f64 {
        let [ahead, across] = self.coordinates(position);
        // Adding zero turns -0.0 into 0.0: the branch itself is pi, as in `turns_between`.
        libm::atan2(across + 0.0, ahead)
    }

    /// Whether [`Plane::angle`] is at least zero.
    #[inline]
    #[must_use]
    pub fn is_first_half(&self, position: [f64; 3]) -> bool {
        dot(position, self.across) >= 0.0
    }

    /// How [`Plane::angle`] jumps on the straight way from one position to the next, in whole turns: 1 where it crosses
    /// the branch (opposite the start) forwards, -1 backwards, else 0. A way spans less than half a turn.
    #[inline]
    #[must_use]
    pub fn turns_between(&self, from: [f64; 3], to: [f64; 3]) -> i64 {
        let [ahead, across] = self.coordinates(from);
        let [next_ahead, next_across] = self.coordinates(to);
        match (across >= 0.0, next_across >= 0.0) {
            (true, false) => i64::from(ahead * next_across - across * next_ahead > 0.0),
            (false, true) => -i64::from(ahead * next_across - across * next_ahead < 0.0),
            _ => 0,
        }
    }

    fn coordinates(&self, position: [f64; 3]) -> [f64; 2] {
        [dot(position, self.ahead), dot(position, self.across)]
    }
}
