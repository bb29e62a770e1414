//! Moments of the velocities of all discs.

use super::collision::VelocityChanges;
use super::motion::Vector;
use serde::{Deserialize, Serialize};

/// Sums of v² and v⁴ over all discs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct VelocityMoments {
    pub(super) second: f64,
    pub(super) fourth: f64,
    pub(super) count: f64,
}

impl VelocityMoments {
    /// The moments of these velocities, summed in their order.
    pub(super) fn of(velocities: impl Iterator<Item = Vector>) -> Self {
        let mut moments = Self { second: 0.0, fourth: 0.0, count: 0.0 };
        for velocity in velocities {
            let square = square(velocity);
            moments.second += square;
            moments.fourth += square * square;
            moments.count += 1.0;
        }
        moments
    }

    /// `<v²>` = 2 k T/m in two dimensions: what the packing exercise calls temperature.
    pub(super) fn mean_square_speed(&self) -> f64 {
        self.second / self.count
    }

    /// a2 = `<v⁴>` / (2 `<v²>`²) − 1 (packing exercise, `calculate_averages`); 0 if all discs are at rest.
    pub(super) fn a2(&self) -> f64 {
        if self.second > 0.0 {
            0.5 * self.count * self.fourth / (self.second * self.second) - 1.0
        } else {
            0.0
        }
    }

    /// Sum of v²/2.
    pub(super) fn kinetic_energy(&self) -> f64 {
        0.5 * self.second
    }

    /// Updates the sums after a collision.
    pub(super) fn update(&mut self, changes: &VelocityChanges) {
        for [before, after] in changes {
            let [old, new] = [square(*before), square(*after)];
            self.second += new - old;
            self.fourth += new * new - old * old;
        }
    }
}

fn square(velocity: Vector) -> f64 {
    velocity[0] * velocity[0] + velocity[1] * velocity[1]
}
