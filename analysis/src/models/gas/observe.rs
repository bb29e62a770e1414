//! Observer of gas runs: wall pressure, speed moments, wall collisions, conserved quantities.

use super::box_entropy::box_entropy;
use super::chi_square::ChiSquare;
use super::kinetics_laws as kinetics;
use super::laws as law;
use super::metrics as metric;
use super::scatter::{StartScatter, temperature_in_equilibrium};
use super::state::{
    OwnRates, SpeedMeans, fraction_within_half_radius, own_rates, speeds_of, squares_of,
};
use crate::metric::deviation::ROUNDING_FRACTION;
use crate::metric::theory::ExpectedValue;
use crate::metric::{Measurements, Quantity, Violation};
use crate::models::contract::Observer;
use crate::models::series::Series;
use crate::models::snapshots::{Snapshots, StateStyle};
use crate::models::{max_or_nan, relative_change};
use crate::statistics::{Estimate, MissingError};
use kinetoscope_manifest::model::{
    GasConfig, PositionDistribution, SpeedScale, TemperatureDefinition,
};
use kinetoscope_recording::channels::{
    GasCollisions, GasEnergyBalance, GasInvariants, GasPressure, GasSpeeds, GasTemperature,
};
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::RecordedFrame;

/// Observer of one gas run.
#[derive(Clone, Debug, Default)]
pub(super) struct GasRun {
    pub(super) config: GasConfig,
    pub(super) time_s: f64,
    /// Time, s, and mean pressure since the start, N/m.
    pub(super) pressure_series: Series<(f64, f64)>,
    pub(super) pressure: Option<GasPressure>,
    pub(super) histogram: Option<GasSpeeds>,
    pub(super) snapshots: Snapshots,
    /// Time, s, then the temperatures by the mean square and by the mean speed, K.
    pub(super) temperatures: Series<(f64, f64, f64)>,
    /// Time, s, and radius of the container, m.
    pub(super) radii: Series<(f64, f64)>,
    /// Time, s, and number of particles that have left.
    pub(super) escaped: Series<(f64, f64)>,
    /// As recorded in `/temperature`.
    recorded_speeds: Option<SpeedMeans>,
    pub(super) own_rates: OwnRates,
    /// Squared speeds of the first frame, m^2/s^2, of a gas that starts in equilibrium with gravity.
    first_squares: Vec<f64>,
    /// Time, s, and wall collisions since the start.
    pub(super) wall_counts: Series<(f64, f64)>,
    first_invariants: Option<GasInvariants>,
    pub(super) invariants: Option<GasInvariants>,
    max_speed_change: f64,
    max_angular_momentum_change: f64,
    max_outside: u64,
    energy_balance: Option<GasEnergyBalance>,
    /// Time, s, then the pair collisions and their virial, J s, since the start.
    pub(super) pairs: Series<(f64, f64, f64)>,
    /// Time, s, and H above its minimum.
    pub(super) relative_entropy: Series<(f64, f64)>,
    pub(super) within_half_radius_at_start: Option<f64>,
    pub(super) first_mean_speed_m_per_s: Option<f64>,
    first_temperature_k: Option<f64>,
    /// Maximum relative change of the temperature.
    pub(super) max_temperature_change: f64,
    /// Time, s, and entropy by boxes.
    pub(super) box_entropy: Series<(f64, f64)>,
}

/// Container crossings at the rms speed after which a thermal wall has determined the state of the gas.
const CROSSINGS_TO_THERMALIZE: f64 = 20.0;

/// Radius of a drawn point over that of the container.
const POINT_OVER_CONTAINER: f64 = 0.006;

impl GasRun {
    /// Creates an observer without frames.
    pub(super) fn new(config: GasConfig, snapshots: Snapshots) -> Self {
        let radius = config.radius_m.get();
        let walls = super::extent(&config).walls;
        let particle =
            config.disc_radius_m.map_or(POINT_OVER_CONTAINER * radius, |disc| disc.get());
        Self {
            config,
            snapshots: snapshots.with_style(StateStyle { walls, radius: particle }),
            ..Self::default()
        }
    }

    /// `<v^2>` of the last frame, m^2/s^2.
    pub(super) fn mean_square(&self) -> Option<f64> {
        self.speeds().map(|speeds| speeds.mean_square_m2_per_s2)
    }

    /// Speed moments of the last frame: from the state if it was recorded and all particles are still inside.
    fn speeds(&self) -> Option<SpeedMeans> {
        let seen = self.snapshots.last().filter(|_| self.config.orifice_width_m.is_none());
        seen.and_then(speeds_of).or(self.recorded_speeds)
    }

    fn add_invariants(&mut self, invariants: GasInvariants) {
        self.max_speed_change =
            max_or_nan(self.max_speed_change, invariants.max_speed_change_relative);
        self.max_angular_momentum_change = max_or_nan(
            self.max_angular_momentum_change,
            invariants.max_angular_momentum_change_relative,
        );
        self.max_outside = self.max_outside.max(invariants.particles_outside);
        self.first_invariants.get_or_insert_with(|| invariants.clone());
        self.invariants = Some(invariants);
    }

    /// Number of particles per bin of the last histogram that Maxwell's distribution gives at the same `<v^2>`.
    pub(super) fn maxwell_counts(&self) -> Option<Vec<f64>> {
        let histogram = self.histogram.as_ref()?;
        let bins = &histogram.speed_m_per_s;
        let width = bins.get(1)? - bins[0];
        let counted = f64::from(self.config.particles.get()) * width;
        Some(histogram.maxwell.iter().map(|density| counted * density).collect())
    }

    /// Whether no particle leaves the whole container or changes its speed.
    pub(super) fn keeps_particles(&self) -> bool {
        self.config.keeps_speeds() && self.fills_container()
    }

    /// Whether neither an opening nor a partition divides the container.
    fn fills_container(&self) -> bool {
        self.config.orifice_width_m.is_none() && self.config.partition.is_none()
    }

    /// Whether no particle leaves and the total energy is conserved.
    pub(super) fn keeps_energy(&self) -> bool {
        self.config.keeps_energy() && self.fills_container()
    }

    /// Whether in addition all particles have the same mass.
    pub(super) fn keeps_energy_of_one_mass(&self) -> bool {
        self.keeps_energy() && !law::has_several_masses(&self.config)
    }

    /// Pressure of discs, N/m, from `<v^2>` and the virial of their collisions.
    pub(super) fn pressure_by_virial(&self, mean_square_m2_per_s2: f64) -> Option<f64> {
        let (_, _, virial) = self.pairs.last()?;
        let radius = self.config.radius_m.get();
        let reach = radius - self.config.disc_radius_m?.get();
        let mass = f64::from(self.config.particles.get()) * self.config.mass_kg.get();
        let force = (mass * mean_square_m2_per_s2 + virial / self.time_s) / reach;
        Some(force / (2.0 * std::f64::consts::PI * radius))
    }

    /// Scatter of the means over speeds that particles keep; none where they change or differ in mass.
    fn start_scatter(&self) -> StartScatter {
        let is_kept = self.config.keeps_speeds() && self.config.orifice_width_m.is_none();
        let start = StartScatter::new(&self.config).filter(|_| is_kept);
        start.unwrap_or_default()
    }

    /// The violation, unless the particles have crossed the container often enough to forget their start next to a thermal wall.
    pub(super) fn not_thermalized(&self) -> Option<Violation> {
        let speed = self.mean_square().map_or(0.0, f64::sqrt);
        let crossings = speed * self.time_s / (2.0 * self.config.radius_m.get());
        Quantity::Crossings.at_least(crossings, CROSSINGS_TO_THERMALIZE)
    }

    fn measure_pressure(&self, found: &mut Measurements) {
        let Some(pressure) = &self.pressure else { return };
        let by_square = |square: f64| law::pressure_n_per_m(&self.config, square);
        if self.time_s > 0.0 {
            let square = self.mean_square().filter(|_| self.keeps_energy_of_one_mass());
            let measured = self.measured_pressure(pressure.measured_since_start_n_per_m, square);
            let (law, theory) = match (self.config.disc_radius_m, square) {
                (Some(_), Some(square)) => (kinetics::CLAUSIUS, self.pressure_by_virial(square)),
                _ => (law::KINETIC_PRESSURE, square.map(by_square)),
            };
            found.compare_with(metric::PRESSURE_MEASURED, measured, law, theory);
        }
        let moments = law::speed_moments(&self.config);
        let start = self.start_scatter();
        let mean_speed = moments.map(|of| by_square(of.mean_m_per_s * of.mean_m_per_s));
        let mean_square = moments.map(|of| by_square(of.mean_square_m2_per_s2));
        let by_mean_speed = scattered(pressure.mean_speed_formula_n_per_m, 2.0 * start.mean);
        found.compare(metric::PRESSURE_MEAN_SPEED, by_mean_speed, mean_speed);
        let by_mean_square = scattered(pressure.mean_square_formula_n_per_m, start.mean_square);
        found.compare(metric::PRESSURE_MEAN_SQUARE, by_mean_square, mean_square);
        if self.config.gravity_m_per_s2.get() != 0.0 {
            let reason = "in gravity, the pressure depends on the height";
            found.explain(metric::PRESSURE_IDEAL, reason);
        } else if self.config.temperature_definition == TemperatureDefinition::MeanSpeed {
            let reason = "T by the mean speed is not that of the ideal gas law; it gives pressure.mean_speed_formula";
            found.explain(metric::PRESSURE_IDEAL, reason);
        } else {
            let ideal = pressure.ideal_gas_n_per_m;
            // Through an orifice, the pressure follows which particles have left, also if none has.
            let given = law::ideal_gas_pressure_n_per_m(&self.config)
                .filter(|_| self.config.orifice_width_m.is_none());
            let is_given =
                given.is_some_and(|given| (ideal - given).abs() <= ROUNDING_FRACTION * given);
            let ideal =
                if is_given { Estimate::set_by_manifest(ideal) } else { Estimate::bare(ideal) };
            found.add(metric::PRESSURE_IDEAL, ideal);
        }
    }

    fn measure_speeds(&self, found: &mut Measurements) {
        let Some(speeds) = self.speeds() else { return };
        let (mean, square) = (speeds.mean_m_per_s, speeds.mean_square_m2_per_s2);
        let moments = law::speed_moments(&self.config);
        let expected_mean = moments.map(|moments| moments.mean_m_per_s);
        let expected_square = moments.map(|moments| moments.mean_square_m2_per_s2);
        let start = self.start_scatter();
        // The state does not contain the masses of the particles.
        if !law::has_several_masses(&self.config) {
            let kelvin = |square: f64| law::temperature_of_k(&self.config, square);
            if law::is_in_barometric_equilibrium(&self.config) {
                self.measure_barometric_temperature(found);
            } else {
                let theory = expected_square.map(kelvin);
                let temperature = scattered(kelvin(square), start.mean_square);
                found.compare(metric::TEMPERATURE_MEAN_SQUARE, temperature, theory);
            }
            let theory = expected_mean.map(|mean| kelvin(mean * mean));
            let temperature = scattered(kelvin(mean * mean), 2.0 * start.mean);
            found.compare(metric::TEMPERATURE_MEAN_SPEED, temperature, theory);
        }
        found.compare(metric::MEAN_SPEED, scattered(mean, start.mean), expected_mean);
        let rms = scattered(square.sqrt(), start.mean_square / 2.0);
        found.compare(metric::RMS_SPEED, rms, expected_square.map(f64::sqrt));
        found.add(metric::MEAN_VELOCITY, speeds.drift_m_per_s);
    }

    /// The temperature at the end of a gas that starts in equilibrium with gravity, which keeps it.
    fn measure_barometric_temperature(&self, found: &mut Measurements) {
        let squares = self.snapshots.last().and_then(squares_of);
        let estimate = squares
            .and_then(|last| temperature_in_equilibrium(&self.config, &self.first_squares, &last))
            .or_else(|| {
                let square = self.mean_square()?;
                Some(Estimate::bare(law::temperature_of_k(&self.config, square)))
            });
        let theory = law::barometric_mean_square_m2_per_s2(&self.config);
        let theory = theory.map(|square| law::temperature_of_k(&self.config, square));
        let law = law::BAROMETRIC_TEMPERATURE;
        found.compare_with(metric::TEMPERATURE_MEAN_SQUARE, estimate, law, theory);
    }

    fn measure_wall_collisions(&self, found: &mut Measurements) {
        let Some(rate) = self.wall_collision_rate() else { return };
        let is_stationary = self.keeps_particles()
            && self.config.position_distribution == PositionDistribution::UniformInArea;
        let theory = self
            .speeds()
            .filter(|_| is_stationary)
            .map(|speeds| law::wall_collision_rate_per_s(&self.config, speeds.mean_m_per_s));
        found.compare(metric::WALL_COLLISION_RATE, rate, theory);
    }

    fn measure_histogram(&self, found: &mut Measurements) {
        let Some(histogram) = &self.histogram else { return };
        let bins = &histogram.speed_m_per_s;
        let width = if bins.len() > 1 { bins[1] - bins[0] } else { return };
        let particles = f64::from(self.config.particles.get());
        let counted = particles * width;
        let maxwell = law::barometric_mean_square_m2_per_s2(&self.config);
        let expected = |(bin, initial): (usize, &f64)| match maxwell {
            // In strong gravity, the bins are wider than the distribution.
            Some(square) => particles * law::maxwell_fraction(bin, width, square),
            None => counted * initial,
        };
        let expected = histogram.initial_distribution.iter().enumerate().map(expected);
        let pairs = histogram.density.iter().zip(expected);
        let counts = pairs.map(|(density, expected)| [counted * density, expected]);
        if let Some(chi_square) = ChiSquare::of(counts) {
            // The number of particles is given, and so is their mean speed or mean square if they were rescaled.
            let is_rescaled = matches!(self.config.speed_scale, SpeedScale::Temperature(_));
            // In gravity, the kinetic energy is not given, and a barometric start stays in equilibrium.
            let is_barometric = maxwell.is_some();
            let is_fixed = is_rescaled && !is_barometric;
            let theory = chi_square.expected(if is_fixed { 2.0 } else { 1.0 });
            let theory = theory.filter(|_| {
                self.config.keeps_speeds() && self.config.orifice_width_m.is_none() || is_barometric
            });
            let error = theory.map(|expected| (2.0 * expected / chi_square.bins).sqrt());
            let per_bin = Estimate::new(chi_square.per_bin, error);
            found.compare(metric::HISTOGRAM_CHI_SQUARE, per_bin, theory);
        }
        let pairs = histogram.density.iter().zip(&histogram.maxwell);
        let distance: f64 =
            pairs.map(|(density, maxwell)| (density - maxwell).abs() * width / 2.0).sum();
        found.add(metric::TOTAL_VARIATION_DISTANCE, distance);
    }

    fn measure_invariants(&self, found: &mut Measurements) {
        let (Some(first), Some(last)) = (&self.first_invariants, &self.invariants) else { return };
        let drift = relative_change(last.kinetic_j, first.kinetic_j);
        // In gravity, the kinetic energy is not the energy; the energy balance includes the potential energy.
        if self.config.gravity_m_per_s2.get() == 0.0 {
            found.compare(metric::ENERGY_DRIFT, drift, self.keeps_energy().then_some(0.0));
        }
        found.compare(metric::PARTICLES_OUTSIDE, self.of_motion(self.max_outside as f64), 0.0);
        // A thermal wall, gravity and collisions between discs change the speed of each particle; nothing is recorded then.
        let keeps_speeds = self.config.disc_radius_m.is_none()
            && self.config.thermal_wall.is_none()
            && !self.config.has_gravity_or_partition();
        if keeps_speeds {
            found.compare(metric::MAX_SPEED_CHANGE, self.of_motion(self.max_speed_change), 0.0);
            let change = self.of_motion(self.max_angular_momentum_change);
            found.compare(metric::MAX_ANGULAR_MOMENTUM_CHANGE, change, 0.0);
        }
    }

    /// A violation of the motion's laws. The reflection as printed violates them for particles that their start brings outside.
    fn of_motion(&self, violation: f64) -> Estimate {
        let violation = Estimate::bare(violation);
        match self.loses_particles() {
            true => violation.without_error(MissingError::DependsOnStart),
            false => violation,
        }
    }

    fn measure_energy_balance(&self, found: &mut Measurements) {
        let Some(balance) = &self.energy_balance else { return };
        found.compare(metric::RESIDUAL, balance.residual_relative, 0.0);
        if let Some(leaving) = self
            .first_mean_speed_m_per_s
            .and_then(|speed| law::escaped(&self.config, speed, self.time_s))
            .filter(|_| self.time_s > 0.0)
        {
            let escaped = balance.particles_escaped as f64;
            let rate = Estimate::new(escaped / self.time_s, escaped.sqrt() / self.time_s);
            let has_counted = escaped > 0.0;
            let rate =
                if has_counted { rate } else { rate.without_error(MissingError::NothingCounted) };
            let theory = leaving / self.time_s;
            let fraction = escaped / f64::from(self.config.particles.get());
            let accuracy = Some(theory * fraction / 2.0);
            let theory = ExpectedValue { value: theory, accuracy, violation: None };
            found.compare(metric::EFFUSION_RATE, rate, theory);
        }
        if self.config.wall_speed_m_per_s.get() != 0.0 {
            let invariant = balance.energy_times_area_over_initial;
            let rms = self.mean_square().map_or(0.0, f64::sqrt);
            let ratio = self.config.wall_speed_m_per_s.get().abs() / rms;
            let violation = Quantity::WallSpeed.below(ratio, 0.1);
            let theory = ExpectedValue { value: 1.0, accuracy: None, violation };
            let invariant = Estimate::bare(invariant).without_error(MissingError::DependsOnStart);
            found.compare(metric::ADIABATIC_INVARIANT, invariant, theory);
        }
        if let (Some(wall), Some(speeds)) = (self.config.thermal_wall, self.speeds())
            && !law::has_several_masses(&self.config)
        {
            let temperature = law::temperature_of_k(&self.config, speeds.mean_square_m2_per_s2);
            // In two dimensions, the standard deviation of a particle's energy equals its mean.
            let error = temperature / f64::from(self.config.particles.get()).sqrt();
            let estimate = Estimate::new(temperature, error);
            let (value, violation) = (wall.temperature_k.get(), self.not_thermalized());
            let theory = ExpectedValue { value, accuracy: None, violation };
            found.compare(metric::THERMALIZED_TEMPERATURE, estimate, theory);
        }
    }
}

impl Observer for GasRun {
    fn observe(&mut self, mut frame: RecordedFrame) -> Result<(), ReadError> {
        self.time_s = frame.clock.time;
        if let Some(pressure) = frame.get::<GasPressure>()? {
            if self.time_s > 0.0 {
                self.pressure_series.add((self.time_s, pressure.measured_since_start_n_per_m));
            }
            self.pressure = Some(pressure);
        }
        if let Some(temperature) = frame.get::<GasTemperature>()? {
            let present = temperature.mean_square_temperature_k;
            let by_speed = temperature.mean_speed_temperature_k;
            self.temperatures.add((self.time_s, present, by_speed));
            let first = *self.first_temperature_k.get_or_insert(present);
            self.max_temperature_change = max_or_nan(
                self.max_temperature_change,
                if present == first { 0.0 } else { relative_change(present, first).abs() },
            );
            self.recorded_speeds = Some(SpeedMeans {
                mean_m_per_s: temperature.mean_speed_m_per_s,
                mean_square_m2_per_s2: temperature.rms_speed_m_per_s
                    * temperature.rms_speed_m_per_s,
                drift_m_per_s: temperature.mean_velocity_m_per_s,
            });
        }
        if let Some(state) = frame.take_state() {
            if self.own_rates.is_empty() {
                self.own_rates = own_rates(&state, &self.config);
            }
            if self.first_squares.is_empty() && law::is_in_barometric_equilibrium(&self.config) {
                self.first_squares = squares_of(&state).unwrap_or_default();
            }
            if let Some(entropy) = box_entropy(&state, &self.config) {
                self.box_entropy.add((self.time_s, entropy));
            }
            if self.within_half_radius_at_start.is_none() {
                self.within_half_radius_at_start =
                    fraction_within_half_radius(&state, &self.config);
            }
            self.snapshots.add_state(&frame, state);
        }
        self.histogram = frame.get::<GasSpeeds>()?.or(self.histogram.take());
        if let Some(collisions) = frame.get::<GasCollisions>()? {
            self.wall_counts.add((self.time_s, collisions.wall_collisions as f64));
            let GasCollisions { pair_collisions, pair_virial_sum_j_s, .. } = collisions;
            self.pairs.add((self.time_s, pair_collisions as f64, pair_virial_sum_j_s));
        }
        // Computed once, because the moments take longer than all else of a frame.
        if self.first_mean_speed_m_per_s.is_none() {
            self.first_mean_speed_m_per_s = self.speeds().map(|speeds| speeds.mean_m_per_s);
        }
        if let Some(energy_balance) = frame.get::<GasEnergyBalance>()? {
            self.relative_entropy.add((self.time_s, energy_balance.relative_entropy));
            self.radii.add((self.time_s, energy_balance.radius_m));
            self.escaped.add((self.time_s, energy_balance.particles_escaped as f64));
            self.energy_balance = Some(energy_balance);
        }
        if let Some(invariants) = frame.get::<GasInvariants>()? {
            self.add_invariants(invariants);
        }
        self.snapshots.keep_scenes(frame);
        Ok(())
    }

    fn measure(&self, found: &mut Measurements) {
        self.measure_start(found);
        self.measure_pressure(found);
        self.measure_speeds(found);
        self.measure_wall_collisions(found);
        self.measure_histogram(found);
        self.measure_invariants(found);
        self.measure_energy_balance(found);
        self.measure_kinetics(found);
        self.measure_layers(found);
        self.measure_boxes(found);
    }
}

/// A value with its relative scatter over seeds; a value that all seeds share has no error.
fn scattered(value: f64, relative: f64) -> Estimate {
    Estimate::new(value, (relative > 0.0).then_some(value.abs() * relative))
}
