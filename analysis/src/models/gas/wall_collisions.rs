//! Errors of the wall collision rate and of the wall pressure.

use super::laws;
use super::observe::GasRun;
use super::scatter::StartScatter;
use crate::statistics::{Blocking, Entries, Estimate, MissingError};
use kinetoscope_manifest::model::{GasConfig, PositionDistribution, Propagation};
use std::f64::consts::PI;

/// Variance of the sum of the particles' constant rates for given speeds, 1/s^2: that of their inverse chords.
///
/// For a start uniform over the area, the density of d/R is proportional to sqrt(1 - (d/R)^2), so `<1/chord>` is 2/(pi R) and
/// `<1/chord^2>` is 1/(2 R^2). For other starts the variance is that of the particles.
fn chord_variance(rates: &[[f64; 2]], config: &GasConfig) -> f64 {
    let squares = |of: &dyn Fn(&[f64; 2]) -> f64| {
        rates.iter().map(of).map(|value| value * value).sum::<f64>()
    };
    match config.position_distribution {
        PositionDistribution::UniformInArea => {
            let radius = config.radius_m.get();
            squares(&|[_, speed]| *speed) * (0.5 - 4.0 / (PI * PI)) / (radius * radius)
        }
        PositionDistribution::UniformInRadius | PositionDistribution::Barometric => {
            let sum = |index: usize| rates.iter().map(|own| own[index]).sum::<f64>();
            let mean_inverse_chord = sum(0) / sum(1);
            squares(&|[rate, speed]| rate - mean_inverse_chord * speed)
        }
    }
}

/// Variance of the number of wall collisions over a time: the phase of each particle on its chord is at random.
fn phase_variance(rates: &[[f64; 2]], time_s: f64) -> f64 {
    let phases = rates.iter().map(|[rate, _]| (rate * time_s).fract());
    phases.map(|phase| phase * (1.0 - phase)).sum()
}

impl GasRun {
    /// The wall collision rate of all particles, 1/s. For particles without collisions, the error is that of starts with the
    /// same speeds, whose mean determines the theoretical rate, and in addition that of the speeds. For colliding discs, the
    /// error results from blocking.
    pub(super) fn wall_collision_rate(&self) -> Option<Estimate> {
        let &(time, count) = self.wall_counts.last().filter(|(time, _)| *time > 0.0)?;
        let value = Estimate::bare(count / time);
        if self.loses_particles() {
            return Some(value.without_error(MissingError::DependsOnStart));
        }
        let Some(start) = StartScatter::new(&self.config) else { return Some(value) };
        if self.keeps_particles() && !self.own_rates.is_empty() {
            let chords = chord_variance(&self.own_rates, &self.config);
            let variance = chords + phase_variance(&self.own_rates, time) / (time * time);
            let error = Some(variance.sqrt()).filter(|error| error.is_finite());
            let given = Estimate::new(value.value, error);
            return Some(given.with_scatter_of_starts(value.value * start.mean));
        }
        if self.config.disc_radius_m.is_some() && self.keeps_energy() {
            let blocking = windows(self.wall_counts.iter().copied(), 0.0);
            let scatter = value.value * start.mean_square / 2.0;
            return blocking.estimate().map(|rate| rate.with_scatter_of_starts(scatter));
        }
        Some(value)
    }

    /// Whether the reflection as printed moves particles out of the container for good. Which ones depends on the start, so numbers and
    /// momenta of wall collisions scatter more than those of particles that stay on their chords.
    pub(super) fn loses_particles(&self) -> bool {
        matches!(self.config.propagation, Propagation::AsPrinted { .. })
    }

    /// The measured wall pressure, N/m, at this `<v^2>`. Theory uses the `<v^2>` of the run, and for discs the virial of the
    /// run, so the conditional error is that of the momentum in transit. Other seeds have another `<v^2>` if it is not that
    /// of the manifest, and discs another virial: by the finite time and by the energy of rotation, which the circular wall
    /// conserves.
    pub(super) fn measured_pressure(&self, measured: f64, mean_square: Option<f64>) -> Estimate {
        if self.loses_particles() {
            return Estimate::bare(measured).without_error(MissingError::DependsOnStart);
        }
        let (Some(square), Some(start)) = (mean_square, StartScatter::new(&self.config)) else {
            return Estimate::bare(measured);
        };
        let ideal = laws::pressure_n_per_m(&self.config, square);
        let relative = laws::pressure_error_relative(&self.config, square.sqrt(), self.time_s);
        let given = Estimate::new(measured, ideal * relative);
        let by_speeds = measured.abs() * start.mean_square;
        let Some(disc_radius) = self.config.disc_radius_m else {
            return given.with_scatter_of_starts(by_speeds);
        };
        let virial = windows(self.pairs.iter().map(|&(time, _, virial)| (time, virial)), 0.0);
        let radius = self.config.radius_m.get();
        let per_virial = 1.0 / (2.0 * PI * radius * (radius - disc_radius.get()));
        let Some(virial) = virial.estimate() else {
            return given.with_scatter_of_starts(by_speeds);
        };
        match virial.standard_error {
            Some(error) => {
                // The virial is proportional to the thermal energy, from which the conserved rotation takes its share.
                let by_virial =
                    per_virial * libm::hypot(error, virial.value * start.thermal_energy);
                given.with_scatter_of_starts(libm::hypot(by_speeds, by_virial))
            }
            None => Estimate {
                missing_error: virial.missing_error,
                ..given.with_unknown_scatter_of_starts()
            },
        }
    }

    /// Pair collisions per second of all discs after a time, by blocking.
    pub(super) fn pair_rate(&self, from_s: f64) -> Blocking {
        windows(self.pairs.iter().map(|&(time, pairs, _)| (time, pairs)), from_s)
    }

    /// Virial per second of all discs, J, by blocking.
    pub(super) fn virial_rate(&self) -> Blocking {
        windows(self.pairs.iter().map(|&(time, _, virial)| (time, virial)), 0.0)
    }
}

/// Rate of a running total since the start, by blocking of its increments after a time.
fn windows(totals: impl Iterator<Item = (f64, f64)>, from_s: f64) -> Blocking {
    let mut blocking = Blocking::of(Entries::Intervals);
    let mut before: Option<(f64, f64)> = None;
    for (time, total) in totals.filter(|(time, _)| *time >= from_s) {
        if let Some((earlier, less)) = before.replace((time, total)) {
            blocking.add_amount(total - less, time - earlier);
        }
    }
    blocking
}
