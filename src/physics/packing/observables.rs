//! What is measured of hard discs: moments of the velocities, collisions, pressure.

use super::domain::Domain;
use super::engine::{Changes, Collision, CollisionPartner};
use super::motion::Vector;
use crate::sum::CompensatedSum;
use kinetoscope_recording::channels::{
    PackingCollisions, PackingPressure, PackingTemperature, PerCollision,
};
use serde::{Deserialize, Serialize};

/// Sums of v^2 and v^4 over discs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct VelocityMoments {
    second: f64,
    fourth: f64,
    count: f64,
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

    /// T = <v^2>: the packing document's temperature, twice the physical k_B T / m.
    pub(super) fn temperature(&self) -> f64 {
        self.second / self.count
    }

    /// a2 = <v^4> / (2 <v^2>^2) - 1 (packing document, `calculate_averages`); 0 where all discs are at rest.
    pub(super) fn a2(&self) -> f64 {
        if self.second > 0.0 {
            0.5 * self.count * self.fourth / (self.second * self.second) - 1.0
        } else {
            0.0
        }
    }

    /// Sum of v^2 / 2.
    fn kinetic_energy(&self) -> f64 {
        0.5 * self.second
    }

    fn follow(&mut self, changes: &Changes) {
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

/// What collisions have added up to since the start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct CollisionStatistics {
    pairs: u64,
    walls: u64,
    /// Followed from collision to collision and summed anew every n collisions: relative error about n 1e-16.
    moments: VelocityMoments,
    temperature_at_start: f64,
    /// Up to the last collision.
    kinetic_energy_time_integral: CompensatedSum,
    collision_virial: CompensatedSum,
    wall_impulse: CompensatedSum,
}

impl CollisionStatistics {
    /// Nothing has happened yet.
    pub(super) fn new(start: VelocityMoments) -> Self {
        Self {
            pairs: 0,
            walls: 0,
            moments: start,
            temperature_at_start: start.temperature(),
            kinetic_energy_time_integral: CompensatedSum::default(),
            collision_virial: CompensatedSum::default(),
            wall_impulse: CompensatedSum::default(),
        }
    }

    /// Collisions since the start, of pairs and with walls.
    pub(super) fn events(&self) -> u64 {
        self.pairs + self.walls
    }

    /// The moments after the last collision.
    pub(super) fn moments(&self) -> &VelocityMoments {
        &self.moments
    }

    /// Takes moments that were summed anew, free of the rounding of many small changes.
    pub(super) fn renew_moments(&mut self, moments: VelocityMoments) {
        self.moments = moments;
    }

    /// Counts one collision, at a cost that does not depend on the number of discs.
    #[inline(always)]
    pub(super) fn count(&mut self, collision: &Collision) {
        self.kinetic_energy_time_integral.add(self.moments.kinetic_energy() * collision.wait);
        self.moments.follow(&collision.changes);
        match collision.with {
            CollisionPartner::Disc(distance) => {
                self.pairs += 1;
                self.collision_virial.add(distance * collision.normal_impulse);
            }
            CollisionPartner::Wall => {
                self.walls += 1;
                self.wall_impulse.add(collision.normal_impulse);
            }
        }
    }

    /// The moments now, from moments summed anew.
    pub(super) fn temperature(&self, now: &VelocityMoments) -> PackingTemperature {
        let temperature = now.temperature();
        let initial = self.temperature_at_start;
        PackingTemperature {
            temperature,
            kinetic_temperature: 0.5 * temperature,
            a2: now.a2(),
            temperature_over_initial: if initial > 0.0 { temperature / initial } else { 1.0 },
            kinetic_energy: now.kinetic_energy(),
        }
    }

    /// Collisions and their rates over all the time since the start.
    pub(super) fn collisions(&self, time: f64) -> PackingCollisions {
        let rate = |count: f64| if time > 0.0 { count / (self.moments.count * time) } else { 0.0 };
        PackingCollisions {
            pair: self.pairs,
            wall: self.walls,
            pair_rate_per_disc: rate(2.0 * self.pairs as f64),
            wall_rate_per_disc: rate(self.walls as f64),
        }
    }

    /// Pressure over all the time t since the start, `wait` of it since the last collision.
    ///
    /// Both ways refer to the rectangle that the centers stay in, a x b:
    ///
    /// P = (2 K + W) / (2 a b t),   P = I / (2 (a + b) t)
    ///
    /// with K the time integral of the kinetic energy, W the sum of s |J| over pair collisions, I the sum of |J| over wall
    /// collisions, |J| the normal impulse. By the virial theorem their long-time means agree. The compressibility factor
    /// P A / (N k T) = 1 + W / (2 K) needs no area.
    pub(super) fn pressure(&self, domain: &Domain, time: f64, wait: f64) -> PackingPressure {
        let mut energy_integral = self.kinetic_energy_time_integral;
        energy_integral.add(self.moments.kinetic_energy() * wait);
        let kinetic = energy_integral.value();
        let virial = self.collision_virial.value();
        let wall_impulse = self.wall_impulse.value();
        let [width, height] = domain.accessible_sides();
        let over_time = |sum: f64| if time > 0.0 { sum / time } else { 0.0 };
        PackingPressure {
            virial: over_time((2.0 * kinetic + virial) / (2.0 * width * height)),
            wall: over_time(wall_impulse / (2.0 * (width + height))),
            compressibility_factor: if kinetic > 0.0 { 1.0 + 0.5 * virial / kinetic } else { 0.0 },
            kinetic_energy_time_integral: kinetic,
            collision_virial: virial,
            wall_impulse,
        }
    }
}

/// The series of every collision since the last frame, kept only when it is asked for.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct CollisionSeries {
    event: Vec<u64>,
    time: Vec<f64>,
    temperature: Vec<f64>,
    a2: Vec<f64>,
}

impl CollisionSeries {
    /// Adds the moments after an event; event 0 is the start.
    pub(super) fn push(&mut self, event: u64, time: f64, moments: &VelocityMoments) {
        self.event.push(event);
        self.time.push(time);
        self.temperature.push(moments.temperature());
        self.a2.push(moments.a2());
    }

    /// Forgets all entries.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// The message.
    pub(super) fn message(&self) -> PerCollision {
        PerCollision {
            event: self.event.clone(),
            time: self.time.clone(),
            temperature: self.temperature.clone(),
            a2: self.a2.clone(),
        }
    }
}
