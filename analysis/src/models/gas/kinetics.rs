//! Effect of collisions and time on a gas: relaxation to Maxwell's distribution, collision rates, stationarity.

use super::kinetics_laws::{self as law, relative_entropy_moments};
use super::laws as ideal;
use super::metrics as metric;
use super::observe::GasRun;
use super::scatter::StartScatter;
use super::state::{fraction_within_half_radius, squares_of};
use crate::metric::Measurements;
use crate::models::hard_discs::fixed_energy_speed;
use crate::statistics::{Estimate, MissingError, mean};
use std::f64::consts::PI;

/// Collisions per disc after which the initial speeds are forgotten. The deviation of the fourth moment from Maxwell's
/// falls by a factor of about exp(-0.35) per collision, so 1e-6 of it remains.
const COLLISIONS_TO_FORGET: f64 = 40.0;

/// Container crossings after which the initial positions are forgotten.
const CROSSINGS_TO_FORGET: f64 = 20.0;

impl GasRun {
    /// Adds the metrics of collisions and stationarity.
    pub(super) fn measure_kinetics(&self, found: &mut Measurements) {
        self.measure_velocity_distribution(found);
        self.measure_h(found);
        self.measure_collisions(found);
        self.measure_positions(found);
        self.measure_pressure_drift(found);
    }

    fn particles(&self) -> f64 {
        f64::from(self.config.particles.get())
    }

    /// `<v^2>` of the last frame, m^2/s^2; `None` for several masses.
    fn mean_square_of_one_mass(&self) -> Option<f64> {
        self.mean_square().filter(|_| !ideal::has_several_masses(&self.config))
    }

    /// Whether the discs have collided often enough to forget their initial speeds.
    fn has_relaxed(&self) -> bool {
        let pairs = self.pairs.last().map_or(0.0, |(_, pairs, _)| *pairs);
        self.config.keeps_energy() && 2.0 * pairs / self.particles() >= COLLISIONS_TO_FORGET
    }

    fn measure_velocity_distribution(&self, found: &mut Measurements) {
        let Some(squares) = self.snapshots.last().and_then(squares_of) else { return };
        if self.config.orifice_width_m.is_some() || ideal::has_several_masses(&self.config) {
            return;
        }
        let mean_of =
            |of: fn(f64) -> f64| mean(&squares.iter().copied().map(of).collect::<Vec<_>>());
        let (Some(speed), Some(square), Some(fourth)) =
            (mean_of(f64::sqrt), mean(&squares), mean_of(|square| square * square))
        else {
            return;
        };
        if square == 0.0 {
            return;
        }
        let particles = squares.len() as f64;
        let relaxed = self.has_relaxed();
        // Energies follow an exponential distribution at a fixed total: the variances of x^2 and sqrt(x), reduced by
        // their covariance with x.
        let error = (1.0 - 5.0 * PI / 16.0).sqrt() / particles.sqrt();
        let ratio = Estimate::new(speed / square.sqrt(), relaxed.then_some(error));
        let theory = relaxed.then(|| PI.sqrt() / 2.0 * fixed_energy_speed(particles));
        found.compare(metric::MEAN_OVER_RMS, ratio, theory);
        let a2 = fourth / (2.0 * square * square) - 1.0;
        let a2 = Estimate::new(a2, relaxed.then(|| a2_scatter(particles)));
        found.compare(metric::A2, a2, relaxed.then(|| -1.0 / (particles + 1.0)));
    }

    /// Mean and standard deviation of the relative entropy of discs that have relaxed.
    pub(super) fn relaxed_entropy(&self) -> Option<[f64; 2]> {
        relative_entropy_moments(&self.maxwell_counts()?, self.particles())
    }

    fn measure_h(&self, found: &mut Measurements) {
        let (Some((_, first)), Some((_, last))) =
            (self.relative_entropy.first(), self.relative_entropy.last())
        else {
            return;
        };
        let moments = self.relaxed_entropy().filter(|_| self.has_relaxed());
        let (theory, scatter) = (moments.map(|[mean, _]| mean), moments.map(|[_, std]| std));
        found.compare(metric::RELATIVE_ENTROPY, Estimate::new(*last, scatter), theory);
        found.add(metric::RELATIVE_ENTROPY_AT_START, *first);
        if let Some(square) = self.mean_square_of_one_mass().filter(|square| *square > 0.0) {
            let min = law::min_h(square);
            let theory = theory.map(|excess| min + excess);
            let start = StartScatter::new(&self.config).unwrap_or_default();
            let h = Estimate::new(min + last, scatter).with_scatter_of_starts(start.mean_square);
            found.compare(metric::H_FUNCTION, h, theory);
        }
    }

    /// Collision rate and compressibility factor, for discs only.
    fn measure_collisions(&self, found: &mut Measurements) {
        let (Some(_), Some((time, ..)), Some(start)) =
            (self.config.disc_radius_m, self.pairs.last(), StartScatter::new(&self.config))
        else {
            return;
        };
        let square = self.mean_square_of_one_mass().filter(|_| self.config.keeps_energy());
        let theory = square.and_then(|square| law::collisions(&self.config, square));
        let half = self.pairs.iter().find(|(at, ..)| 2.0 * at >= *time);
        if let Some((from, ..)) = half.filter(|(from, ..)| from < time) {
            let rate = self.pair_rate(*from).estimate();
            let rate = rate.map(|rate| {
                let rotation = rate.value * start.thermal_energy / 2.0;
                let rate = rate.with_further_error(rotation);
                let scatter = rate.value * start.mean_square / 2.0;
                rate.with_scatter_of_starts(scatter).times(2.0 / self.particles())
            });
            let theory = theory.filter(|_| self.has_relaxed()).map(|theory| theory.rate());
            found.compare(metric::PAIR_COLLISION_RATE, rate, theory);
        }
        let energy = self.invariants.as_ref().map(|invariants| invariants.kinetic_j);
        if let Some(energy) =
            energy.filter(|energy| *energy > 0.0 && *time > 0.0 && self.config.keeps_energy())
        {
            let factor = self.virial_rate().estimate();
            let factor = factor.map(|virial| {
                let excess = virial.times(0.5 / energy);
                excess.with_further_error(excess.value * start.thermal_energy).plus(1.0)
            });
            let theory = theory.map(|theory| theory.compressibility());
            found.compare(metric::COMPRESSIBILITY, factor, theory);
        }
    }

    /// Fraction of particles within half the radius. The theory is that of points, because discs exclude each other.
    fn measure_positions(&self, found: &mut Measurements) {
        let distribution = self.config.position_distribution;
        let are_points = self.config.disc_radius_m.is_none() && self.keeps_particles();
        let speed = self.mean_square_of_one_mass().map_or(0.0, f64::sqrt);
        let crossings = speed * self.time_s / (2.0 * self.config.radius_m.get());
        let start = law::fraction_within_at_start(distribution);
        let later = law::fraction_within_later(distribution);
        let later = (start == later || crossings > CROSSINGS_TO_FORGET).then_some(later);
        let later = later.filter(|_| !self.loses_particles());
        let last = self.snapshots.last();
        let last = last.and_then(|state| fraction_within_half_radius(state, &self.config));
        for (definition, fraction, theory) in [
            (metric::WITHIN_HALF_RADIUS, last, later),
            (metric::WITHIN_HALF_RADIUS_AT_START, self.within_half_radius_at_start, Some(start)),
        ] {
            let theory = theory.filter(|_| are_points);
            let error = theory.map(|p| (p * (1.0 - p) / self.particles()).sqrt());
            let fraction = fraction.map(|value| Estimate::new(value, error));
            found.compare(definition, fraction, theory);
        }
    }

    /// Pressure of the second half of the run over that of the first. The momentum in transit at midtime counts negatively
    /// in one half and positively in the other: three times the variance of a single half.
    fn measure_pressure_drift(&self, found: &mut Measurements) {
        let Some(&(time, since_start)) = self.pressure_series.last() else { return };
        let half = self.pressure_series.iter().find(|(at, _)| 2.0 * at >= time);
        let Some(&(middle, first)) = half.filter(|(at, first)| *at < time && *first != 0.0) else {
            return;
        };
        let second = (since_start * time - first * middle) / (time - middle);
        if self.loses_particles() {
            let ratio = Estimate::bare(second / first).without_error(MissingError::DependsOnStart);
            found.add(metric::PRESSURE_DRIFT, ratio);
            return;
        }
        let keeps_particles = self.keeps_particles();
        let square =
            self.mean_square_of_one_mass().filter(|square| keeps_particles && *square > 0.0);
        let error = square.map(|square| {
            let half = ideal::pressure_error_relative(&self.config, square.sqrt(), time / 2.0);
            3.0_f64.sqrt() * half
        });
        let distribution = self.config.position_distribution;
        let is_stationary =
            law::fraction_within_later(distribution) == law::fraction_within_at_start(distribution);
        let theory = (is_stationary && error.is_some()).then_some(1.0);
        found.compare(metric::PRESSURE_DRIFT, Estimate::new(second / first, error), theory);
    }
}

/// Standard deviation of a2 of N particles whose energies are uniform on the simplex of a fixed total, about 1/sqrt(N):
/// a2 + 1 = N/2 times the sum of the squared fractions, whose moments are those of Dirichlet's distribution.
fn a2_scatter(particles: f64) -> f64 {
    let n = particles;
    let variance = n * n * (n - 1.0) / ((n + 1.0) * (n + 1.0) * (n + 2.0) * (n + 3.0));
    variance.sqrt()
}
