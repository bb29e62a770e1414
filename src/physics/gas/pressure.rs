//! Pressure and temperature of an ideal gas in two dimensions: equations (12) and (13) of the gas document, and what they are
//! to be measured against. The "area" A of a circle takes the volume's place and its perimeter the wall's: pressures are
//! forces a length, N/m.

use super::motion::Particle;
use crate::sum::CompensatedSum;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Which mean of the speeds stands for |v|^2 in (12) and (13).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SpeedMean {
    /// `<v>^2`, the square of the mean speed: the document's.
    MeanSpeed,
    /// `<v^2>`, the mean square: equipartition.
    MeanSquare,
}

/// Mean values over all particles.
///
/// A "reduced" speed is v sqrt(m/m1), m1 the first mass: the energy of a particle is then m1 v^2/2 whatever its mass. With
/// one mass it is the speed itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpeedMoments {
    /// Particles counted.
    pub count: f64,
    /// Mean of |v|, m/s.
    pub mean_speed: f64,
    /// Mean of v^2, m^2/s^2.
    pub mean_square: f64,
    /// Mean of the reduced speed, m/s.
    pub reduced_mean_speed: f64,
    /// Mean of the reduced speed's square, m^2/s^2.
    pub reduced_mean_square: f64,
    /// |mean of v|, m/s. The document calls this the mean speed once (14to3); it is near zero.
    pub mean_velocity: f64,
}

impl SpeedMoments {
    /// The moments of particles, each with its mass over the first one; all zero for none.
    #[must_use]
    pub fn of(particles: impl Iterator<Item = (Particle, f64)>) -> Self {
        let mut sums = [CompensatedSum::default(); 6];
        let mut count = 0.0;
        for (particle, mass_ratio) in particles {
            let [vx, vy] = particle.velocity;
            let square = super::motion::dot(particle.velocity, particle.velocity);
            let speed = particle.speed();
            let reduced = mass_ratio * square;
            for (sum, term) in
                sums.iter_mut().zip([speed, square, mass_ratio.sqrt() * speed, reduced, vx, vy])
            {
                sum.add(term);
            }
            count += 1.0;
        }
        if count == 0.0 {
            return Self::default();
        }
        let [speed, square, reduced_speed, reduced_square, vx, vy] =
            sums.map(|sum| sum.value() / count);
        Self {
            count,
            mean_speed: speed,
            mean_square: square,
            reduced_mean_speed: reduced_speed,
            reduced_mean_square: reduced_square,
            mean_velocity: libm::hypot(vx, vy),
        }
    }

    /// |v|^2 of (12) and (13) by a definition, for the first mass, m^2/s^2.
    #[must_use]
    pub fn squared_speed(&self, definition: SpeedMean) -> f64 {
        match definition {
            SpeedMean::MeanSpeed => self.reduced_mean_speed * self.reduced_mean_speed,
            SpeedMean::MeanSquare => self.reduced_mean_square,
        }
    }
}

/// P = N m |v|^2 / (2A), A = pi r^2, N/m: equation (12).
#[must_use]
pub fn kinetic_pressure(
    particles: f64,
    mass_kg: f64,
    squared_speed_m2_per_s2: f64,
    radius_m: f64,
) -> f64 {
    particles * mass_kg * squared_speed_m2_per_s2 / (2.0 * PI * radius_m * radius_m)
}

/// P = N k_B T / A, A = pi r^2, N/m: the ideal gas law, left of (13).
#[must_use]
pub fn ideal_gas_pressure(
    particles: f64,
    boltzmann_j_per_k: f64,
    temperature_k: f64,
    radius_m: f64,
) -> f64 {
    particles * boltzmann_j_per_k * temperature_k / (PI * radius_m * radius_m)
}

/// T = m |v|^2 / (2 k_B), K: equation (13).
#[must_use]
pub fn temperature_of(squared_speed_m2_per_s2: f64, mass_kg: f64, boltzmann_j_per_k: f64) -> f64 {
    mass_kg * squared_speed_m2_per_s2 / (2.0 * boltzmann_j_per_k)
}

/// |v| = sqrt(2 k_B T / m), m/s: equation (13) the other way.
#[must_use]
pub fn speed_at(temperature_k: f64, mass_kg: f64, boltzmann_j_per_k: f64) -> f64 {
    (2.0 * boltzmann_j_per_k * temperature_k / mass_kg).sqrt()
}

/// P = J / (2 pi r t), N/m: normal impulse J on the wall over its perimeter and the time; 0 for no time.
#[must_use]
pub fn measured_pressure(wall_impulse_n_s: f64, radius_m: f64, time_s: f64) -> f64 {
    if time_s > 0.0 { wall_impulse_n_s / (2.0 * PI * radius_m * time_s) } else { 0.0 }
}
