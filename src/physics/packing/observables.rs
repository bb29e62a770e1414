//! Measured quantities of hard discs: collision counts, pressure, and means of the moments of the velocities.

use super::collision::{Collision, CollisionPartner};
use super::domain::Domain;
use super::falling::Falling;
use super::motion::Vector;
use super::rest;
use super::velocity_moments::VelocityMoments;
use crate::sum::CompensatedSum;
use kinetoscope_recording::channels::{
    PackingCollisions, PackingPressure, PackingTemperature, PerCollision,
};
use serde::{Deserialize, Serialize};

/// Counts, sums and time integrals over all collisions since the start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct CollisionStatistics {
    pairs: u64,
    walls: u64,
    obstacles: u64,
    /// Updated at each collision and recalculated every n collisions: relative error about n 1e-16.
    moments: VelocityMoments,
    initial_mean_square_speed: f64,
    /// Up to the last collision.
    kinetic_energy_time_integral: CompensatedSum,
    /// Up to the last collision.
    a2_time_integral: CompensatedSum,
    /// Sum of a2 after each collision.
    a2_event_sum: CompensatedSum,
    /// Sum of s |J| over pair collisions.
    pair_virial_sum: CompensatedSum,
    /// Sum of |J| over wall collisions.
    wall_impulse_sum: CompensatedSum,
    /// What changes between collisions, if there is gravity.
    falling: Option<Falling>,
}

impl CollisionStatistics {
    /// Whether the sums are numbers, and the kinetic energy is that of the present velocities and not above the initial one, which
    /// no collision increases without gravity. `time_since_last` is the time since the last collision. `range_top` is the top of the displayed speeds; the recording's header contains it.
    pub(super) fn is_valid_for(
        &self,
        present: &VelocityMoments,
        time_since_last: f64,
        range_top: f64,
        domain: &Domain,
    ) -> bool {
        /// Tolerance of energies that are updated at each collision.
        const ROUNDING: f64 = 1e-6;
        /// Greatest root mean square speed over the range of the displayed speeds.
        const MAX_SPEED_OVER_RANGE: f64 = 1e3;
        let updated = self.moments_after(time_since_last);
        let [updated, now] = [&updated, present].map(VelocityMoments::mean_square_speed);
        let initial = self.initial_mean_square_speed;
        let scale = initial + now + self.moments.mean_square_speed();
        let most = (MAX_SPEED_OVER_RANGE * range_top) * (MAX_SPEED_OVER_RANGE * range_top);
        let limit = if self.falling.is_some() { most } else { initial };
        let sums =
            [&self.kinetic_energy_time_integral, &self.pair_virial_sum, &self.wall_impulse_sum];
        self.pairs < 1 << 60
            && self.walls < 1 << 60
            && self.obstacles < 1 << 60
            && sums.iter().all(|sum| sum.is_finite())
            && self.moments.count == present.count
            && self.moments.fourth.is_finite()
            && (updated - now).abs() <= ROUNDING * scale
            && now <= limit * (1.0 + ROUNDING)
            && initial <= most
            && self.falling.as_ref().is_none_or(|falling| falling.is_valid_for(domain))
    }

    /// The statistics at the start.
    pub(super) fn new(initial: VelocityMoments, falling: Option<Falling>) -> Self {
        Self {
            pairs: 0,
            walls: 0,
            obstacles: 0,
            moments: initial,
            initial_mean_square_speed: initial.mean_square_speed(),
            kinetic_energy_time_integral: CompensatedSum::default(),
            a2_time_integral: CompensatedSum::default(),
            a2_event_sum: CompensatedSum::default(),
            pair_virial_sum: CompensatedSum::default(),
            wall_impulse_sum: CompensatedSum::default(),
            falling,
        }
    }

    /// Collisions of pairs, and with walls and obstacles, since the start.
    pub(super) fn collision_count(&self) -> u64 {
        self.pairs + self.walls + self.obstacles
    }

    /// The initial `<v²>`.
    pub(super) fn initial_mean_square_speed(&self) -> f64 {
        self.initial_mean_square_speed
    }

    /// Whether the sums allow for discs at rest. The sums are updated at each collision; therefore, the rounding of a sudden loss
    /// of energy may exceed what is left.
    #[inline(always)]
    pub(super) fn may_be_at_rest(&self) -> bool {
        self.moments.mean_square_speed() < rest::limit(self.initial_mean_square_speed)
    }

    /// The moments after the last collision.
    pub(super) fn moments(&self) -> &VelocityMoments {
        &self.moments
    }

    /// Replaces the moments by those of the present velocities, without the rounding errors of many updates.
    pub(super) fn set_velocities(&mut self, velocities: impl Iterator<Item = Vector> + Clone) {
        if let Some(falling) = &mut self.falling {
            falling.set_velocities(velocities.clone());
        }
        self.moments = VelocityMoments::of(velocities);
    }

    /// The moments at a time after the last collision.
    fn moments_after(&self, time: f64) -> VelocityMoments {
        self.falling.as_ref().map_or(self.moments, |of| of.moments_after(&self.moments, time))
    }

    /// The integrals of the kinetic energy and of a2 over a time after the last collision.
    #[inline(always)]
    fn integrals(&self, time: f64) -> [f64; 2] {
        match &self.falling {
            None => [self.moments.kinetic_energy() * time, self.moments.a2() * time],
            Some(falling) => falling.integrals(&self.moments, time),
        }
    }

    /// What changes between collisions, if there is gravity.
    pub(super) fn falling(&self) -> Option<&Falling> {
        self.falling.as_ref()
    }

    /// Adds a collision, at a cost that does not depend on the number of discs.
    #[inline(always)]
    pub(super) fn add(&mut self, collision: &Collision) {
        let [kinetic_energy, a2] = self.integrals(collision.time_since_previous);
        self.kinetic_energy_time_integral.add(kinetic_energy);
        self.a2_time_integral.add(a2);
        if let Some(falling) = &mut self.falling {
            let moments = self.moments;
            self.moments = falling.moments_after(&moments, collision.time_since_previous);
            falling.add(&moments, collision);
        }
        self.moments.update(&collision.velocity_changes);
        self.a2_event_sum.add(self.moments.a2());
        match collision.partner {
            CollisionPartner::Disc { contact_distance, .. } => {
                self.pairs += 1;
                self.pair_virial_sum.add(contact_distance * collision.normal_impulse);
            }
            CollisionPartner::Obstacle => self.obstacles += 1,
            CollisionPartner::Wall => {
                self.walls += 1;
                self.wall_impulse_sum.add(collision.normal_impulse);
            }
        }
    }

    /// The message of `/temperature`, from recalculated moments. `time_since_last` is the time since the last collision.
    pub(super) fn temperature(
        &self,
        now: &VelocityMoments,
        time_since_last: f64,
    ) -> PackingTemperature {
        let mut a2_integral = self.a2_time_integral;
        a2_integral.add(self.integrals(time_since_last)[1]);
        let mean_square = now.mean_square_speed();
        let initial = self.initial_mean_square_speed;
        PackingTemperature {
            mean_square_velocity: mean_square,
            temperature: 0.5 * mean_square,
            a2: now.a2(),
            temperature_over_initial: if initial > 0.0 { mean_square / initial } else { 1.0 },
            kinetic_energy: now.kinetic_energy(),
            a2_time_integral: a2_integral.value(),
            a2_event_sum: self.a2_event_sum.value(),
        }
    }

    /// The message of `/collisions`: counts, and rates over the time since the start.
    pub(super) fn collisions(&self, time: f64) -> PackingCollisions {
        let rate =
            |count: f64| if time > 0.0 { count / (self.moments.count * time) } else { f64::NAN };
        PackingCollisions {
            pair_collisions: self.pairs,
            wall_collisions: self.walls,
            pair_collision_rate_per_disc: rate(2.0 * self.pairs as f64),
            wall_collision_rate_per_disc: rate(self.walls as f64),
        }
    }

    /// The message of `/pressure`, averaged over the time t since the start. `time_since_last` is the time since the last
    /// collision.
    ///
    /// P = (2 K + W) / (2 a b t),   P = I / (2 (a + b) t),   Z = P A / (N k T) = 1 + W / (2 K)
    ///
    /// K is the time integral of the kinetic energy, W the sum of s |J| over pair collisions, I the sum of |J| over wall
    /// collisions, |J| the normal impulse, and a x b the rectangle accessible to the centers. The long-time means of both
    /// pressures agree (virial theorem). In gravity, the first one is the mean over the area, the second one that over the walls; with
    /// obstacles as well, whose impulses count in neither and whose area counts in the first one.
    pub(super) fn pressure(
        &self,
        domain: &Domain,
        time: f64,
        time_since_last: f64,
    ) -> PackingPressure {
        let mut energy_integral = self.kinetic_energy_time_integral;
        energy_integral.add(self.integrals(time_since_last)[0]);
        let kinetic = energy_integral.value();
        let virial = self.pair_virial_sum.value();
        let wall_impulse = self.wall_impulse_sum.value();
        let [width, height] = domain.accessible_sides();
        let over_time = |sum: f64| if time > 0.0 { sum / time } else { f64::NAN };
        PackingPressure {
            virial: over_time((2.0 * kinetic + virial) / (2.0 * width * height)),
            wall: over_time(wall_impulse / (2.0 * (width + height))),
            compressibility_factor: if kinetic > 0.0 {
                1.0 + 0.5 * virial / kinetic
            } else {
                f64::NAN
            },
            kinetic_energy_time_integral: kinetic,
            collision_virial_sum: virial,
            wall_impulse,
        }
    }
}

/// The time series of all collisions since the last frame, which is recorded on request only.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct CollisionSeries {
    event: Vec<u64>,
    time: Vec<f64>,
    mean_square_speed: Vec<f64>,
    a2: Vec<f64>,
}

impl CollisionSeries {
    /// Whether all columns have one length.
    pub(super) fn is_valid(&self) -> bool {
        let lengths = [self.time.len(), self.mean_square_speed.len(), self.a2.len()];
        lengths.iter().all(|length| *length == self.event.len())
    }

    /// Appends the moments after a collision; event 0 is the start.
    pub(super) fn push(&mut self, event: u64, time: f64, moments: &VelocityMoments) {
        self.event.push(event);
        self.time.push(time);
        self.mean_square_speed.push(moments.mean_square_speed());
        self.a2.push(moments.a2());
    }

    /// Removes all entries.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// The message of `/per_collision`.
    pub(super) fn message(&self) -> PerCollision {
        PerCollision {
            event: self.event.clone(),
            time: self.time.clone(),
            mean_square_velocity: self.mean_square_speed.clone(),
            a2: self.a2.clone(),
        }
    }
}
