//! Pressure and temperature of an ideal gas in two dimensions: equations (12) and (13) of the gas exercise, and the measured pressure.
//! The area A of the circle replaces the volume and its circumference replaces the wall area, so pressures are forces per length, N/m.

use super::motion::{Particle, dot};
use crate::sum::CompensatedSum;
use kinetoscope_manifest::model::TemperatureDefinition;
use std::f64::consts::PI;

/// Mean values over all particles.
///
/// The reduced speed is v sqrt(m/m1) with the first mass m1, so that the energy of any particle is m1/2 times its square. For equal
/// masses, it is the speed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpeedMoments {
    /// Number of particles.
    pub count: f64,
    /// Mean of |v|, m/s.
    pub mean_speed: f64,
    /// Mean of v^2, m^2/s^2.
    pub mean_square: f64,
    /// Mean of the reduced speed, m/s.
    pub reduced_mean_speed: f64,
    /// Mean of the squared reduced speed, m^2/s^2.
    pub reduced_mean_square: f64,
    /// |mean of v|, m/s, which is near zero. The gas exercise calls it the mean speed once (14to3).
    pub mean_velocity: f64,
}

impl SpeedMoments {
    /// Computes the moments of particles with their masses relative to the first one; zero if there are none.
    #[must_use]
    pub fn of(particles: impl Iterator<Item = (Particle, f64)>) -> Self {
        let mut sums = [CompensatedSum::default(); 6];
        let mut count = 0.0;
        for (particle, mass_ratio) in particles {
            let [vx, vy] = particle.velocity;
            let square = dot(particle.velocity, particle.velocity);
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

    /// |v|^2 in (12) and (13) by a definition, for the first mass, m^2/s^2: `<v>^2` as printed, or `<v^2>` (equipartition).
    #[must_use]
    pub fn squared_speed(&self, definition: TemperatureDefinition) -> f64 {
        match definition {
            TemperatureDefinition::MeanSpeed => self.reduced_mean_speed * self.reduced_mean_speed,
            TemperatureDefinition::MeanSquare => self.reduced_mean_square,
        }
    }
}

/// Kinetic pressure P = N m |v|^2 / (2A), A = pi r^2, N/m (gas exercise, equation 12).
#[must_use]
pub fn kinetic_pressure(
    particles: f64,
    mass_kg: f64,
    squared_speed_m2_per_s2: f64,
    radius_m: f64,
) -> f64 {
    particles * mass_kg * squared_speed_m2_per_s2 / (2.0 * PI * radius_m * radius_m)
}

/// Ideal gas law P = N k_B T / A, A = pi r^2, N/m (gas exercise, left of equation 13).
#[must_use]
pub fn ideal_gas_pressure(
    particles: f64,
    boltzmann_j_per_k: f64,
    temperature_k: f64,
    radius_m: f64,
) -> f64 {
    particles * boltzmann_j_per_k * temperature_k / (PI * radius_m * radius_m)
}

/// Temperature T = m |v|^2 / (2 k_B), K (gas exercise, equation 13).
#[must_use]
pub fn temperature_of(squared_speed_m2_per_s2: f64, mass_kg: f64, boltzmann_j_per_k: f64) -> f64 {
    mass_kg * squared_speed_m2_per_s2 / (2.0 * boltzmann_j_per_k)
}

/// Speed |v| = sqrt(2 k_B T / m), m/s (gas exercise, equation 13 solved for |v|).
#[must_use]
pub fn speed_at(temperature_k: f64, mass_kg: f64, boltzmann_j_per_k: f64) -> f64 {
    (2.0 * boltzmann_j_per_k * temperature_k / mass_kg).sqrt()
}

/// Measured pressure P = J / (2 pi r t), N/m: normal impulse J on the wall per circumference and time; NaN for t = 0.
#[must_use]
pub fn measured_pressure(wall_impulse_n_s: f64, radius_m: f64, time_s: f64) -> f64 {
    if time_s > 0.0 { wall_impulse_n_s / (2.0 * PI * radius_m * time_s) } else { f64::NAN }
}
