//! Counts of collisions and sums of impulse, since the start and since the last frame.

use super::motion::{Flight, Particle, dot};
use crate::sum::CompensatedSum;
use serde::{Deserialize, Serialize};

/// Wall collisions and their normal impulse per first mass, m/s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct WallTally {
    pub(super) collisions: u64,
    pub(super) impulse_per_mass: CompensatedSum,
}

impl WallTally {
    /// Whether the impulse is a number.
    pub(super) fn is_finite(&self) -> bool {
        self.impulse_per_mass.is_finite()
    }

    /// Adds wall collisions and their impulse.
    pub(super) fn add(&mut self, collisions: u64, impulse_per_mass: f64) {
        self.collisions = self.collisions.saturating_add(collisions);
        self.impulse_per_mass.add(impulse_per_mass);
    }
}

/// Wall collisions since the start and since the last frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct WallTallies {
    /// Since the start.
    pub(super) total: WallTally,
    /// Since the last frame.
    pub(super) window: WallTally,
    /// Time of the last frame, s.
    pub(super) window_opened_s: f64,
}

impl WallTallies {
    /// Whether all sums are numbers.
    pub(super) fn is_finite(&self) -> bool {
        self.total.is_finite() && self.window.is_finite() && self.window_opened_s.is_finite()
    }

    /// Resets the sums since the last frame.
    pub(super) fn open_window(&mut self, time_s: f64) {
        self.window = WallTally::default();
        self.window_opened_s = time_s;
    }

    /// Adds collisions to both tallies.
    pub(super) fn add(&mut self, collisions: u64, impulse_per_mass: f64) {
        for tally in [&mut self.total, &mut self.window] {
            tally.add(collisions, impulse_per_mass);
        }
    }

    /// Recomputes both tallies from those of the particles, whose masses are given relative to the first one.
    pub(super) fn gather(&mut self, tallies: &[ParticleTally], mass_ratios: &[f64]) {
        (self.total, self.window) = (WallTally::default(), WallTally::default());
        for (tally, ratio) in tallies.iter().zip(mass_ratios) {
            self.total.add(tally.collisions, ratio * tally.impulse_per_mass);
            self.window.add(tally.window_collisions, ratio * tally.window_impulse_per_mass);
        }
    }
}

/// Wall collisions of one particle. Each particle has its own tally, so that sums do not depend on how the work is divided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct ParticleTally {
    collisions: u64,
    impulse_per_mass: f64,
    /// Since the last frame.
    window_collisions: u64,
    window_impulse_per_mass: f64,
    /// v^2 at the start of the path, m^2/s^2.
    square: f64,
    /// p x v at the start of the path, m^2/s.
    angular_momentum_per_mass: f64,
}

impl ParticleTally {
    /// Whether all sums are numbers, and no count is so large that it could overflow.
    pub(super) fn is_valid(&self) -> bool {
        self.impulse_per_mass.is_finite()
            && self.window_impulse_per_mass.is_finite()
            && (self.collisions | self.window_collisions) < 1 << 60
    }

    /// Whether the invariants are those of a particle in a circle: `restore_invariants` would give it those of another one.
    pub(super) fn has_invariants_of(&self, particle: Particle, radius: f64) -> bool {
        /// Much more than the rounding of a path.
        const TOLERANCE: f64 = 1e-6;
        let square = dot(particle.velocity, particle.velocity);
        let turned = self.angular_momentum_per_mass - particle.angular_momentum_per_mass();
        (self.square - square).abs() <= TOLERANCE * square
            && turned.abs() <= TOLERANCE * radius * square.sqrt()
    }

    /// Tally of an empty lane: its speed is 1, so that no lane divides by zero.
    pub(super) fn at_unit_speed() -> Self {
        Self { square: 1.0, ..Self::default() }
    }

    /// Starts the paths of all particles; tallies of empty lanes stay as they are.
    pub(super) fn start_paths(tallies: &mut [Self], particles: impl Iterator<Item = Particle>) {
        for (tally, particle) in tallies.iter_mut().zip(particles) {
            tally.start_path(particle);
        }
    }

    /// Stores the invariants of the path that a particle starts.
    fn start_path(&mut self, particle: Particle) {
        self.square = dot(particle.velocity, particle.velocity);
        self.angular_momentum_per_mass = particle.angular_momentum_per_mass();
    }

    /// Restores the speed and the angular momentum of the path after a wall collision.
    ///
    /// Each reflection rounds; over a million similar collisions, the error would grow to 4e-12. The velocity is scaled, then the
    /// position is shifted perpendicular to it, both in the last bits.
    #[inline(always)]
    pub(super) fn restore_invariants(&self, particle: Particle) -> Particle {
        let Particle { position: [x, y], velocity } = particle;
        let lost = (self.square - dot(velocity, velocity)) / (2.0 * self.square);
        let [vx, vy] = velocity.map(|component| component + lost * component);
        let shift = ((x * vy - y * vx) - self.angular_momentum_per_mass) / self.square;
        Particle { position: [x - shift * vy, y + shift * vx], velocity: [vx, vy] }
    }

    /// Adds the wall collisions of one step.
    #[inline(always)]
    pub(super) fn add(&mut self, flight: &Flight) {
        self.collisions += flight.wall_collisions;
        self.impulse_per_mass += flight.impulse_per_mass;
        self.window_collisions += flight.wall_collisions;
        self.window_impulse_per_mass += flight.impulse_per_mass;
    }

    /// Resets the sums since the last frame.
    pub(super) fn open_window(&mut self) {
        (self.window_collisions, self.window_impulse_per_mass) = (0, 0.0);
    }
}

/// Collisions between discs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct PairTally {
    /// Since the start.
    pub(super) collisions: u64,
    /// Since the last frame.
    pub(super) window_collisions: u64,
    /// Sum of distance times transferred momentum since the start, per first mass, m^2/s.
    pub(super) virial: CompensatedSum,
}
