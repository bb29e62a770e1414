//! Observer of gas runs: wall pressure, speed moments, wall collisions, conserved quantities.

use super::kinetics::{Inputs, Kinetics, share_inside_half};
use super::kinetics_laws as kinetics;
use super::laws as law;
use super::metrics as metric;
use crate::metric::Measurement;
use crate::models::contract::Observer;
use crate::models::max_or_nan;
use crate::models::relative_change;
use crate::models::series::Series;
use crate::models::snapshots::{Snapshots, StateStyle};
use crate::plot::drawing;
use crate::statistics::{Estimate, mean, standard_deviation};
use kinetoscope_manifest::model::{GasConfig, PositionDistribution};
use kinetoscope_recording::channels::{
    GasCollisions, GasEnergyBalance, GasInvariants, GasPressure, GasSpeeds, GasTemperature,
};
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::{RecordedFrame, StateTable};

/// Moments of the speeds at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SpeedMeans {
    mean_m_per_s: f64,
    mean_square_m2_per_s2: f64,
    /// |`<v>`|, m/s.
    drift_m_per_s: f64,
}

/// Observer of one gas run.
#[derive(Clone, Debug)]
pub struct GasRun {
    pub(crate) config: GasConfig,
    pub(crate) time_s: f64,
    /// Time, s, and mean pressure since the start, N/m.
    pub(crate) pressure_series: Series<(f64, f64)>,
    pub(crate) pressure: Option<GasPressure>,
    pub(crate) histogram: Option<GasSpeeds>,
    pub(crate) snapshots: Snapshots,
    /// As recorded in `/temperature`.
    recorded_speeds: Option<SpeedMeans>,
    /// Wall collision rate of each particle at the start, 1/s.
    wall_collision_rates: Vec<f64>,
    wall_collisions: Option<u64>,
    first_invariants: Option<GasInvariants>,
    invariants: Option<GasInvariants>,
    max_speed_change: f64,
    max_angular_momentum_change: f64,
    max_outside: u64,
    energy_balance: Option<GasEnergyBalance>,
    pub(crate) kinetics: Kinetics,
    first_mean_speed_m_per_s: Option<f64>,
}

/// Radius of a drawn point over that of the container.
const POINT_OVER_CONTAINER: f64 = 0.006;

impl GasRun {
    /// Creates an observer without frames.
    #[must_use]
    pub fn new(config: GasConfig, snapshots: Snapshots) -> Self {
        let radius = config.radius_m.get();
        let walls = vec![drawing::circle(config.center_m.map(|part| part.get()), radius)];
        let particle =
            config.disc_radius_m.map_or(POINT_OVER_CONTAINER * radius, |disc| disc.get());
        let style = StateStyle { walls, radius: particle };
        Self {
            config,
            time_s: 0.0,
            pressure_series: Series::default(),
            pressure: None,
            histogram: None,
            snapshots: snapshots.with_style(style),
            recorded_speeds: None,
            wall_collision_rates: Vec::new(),
            wall_collisions: None,
            first_invariants: None,
            invariants: None,
            max_speed_change: 0.0,
            max_angular_momentum_change: 0.0,
            max_outside: 0,
            energy_balance: None,
            kinetics: Kinetics::default(),
            first_mean_speed_m_per_s: None,
        }
    }

    /// `<v^2>` of the last frame, m^2/s^2.
    pub(crate) fn mean_square(&self) -> Option<f64> {
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

    /// Whether no particle leaves or changes its speed.
    fn keeps_particles(&self) -> bool {
        self.config.keeps_speeds() && self.config.orifice_width_m.is_none()
    }

    /// Whether no particle leaves and the total energy is conserved.
    fn keeps_energy(&self) -> bool {
        self.config.keeps_energy() && self.config.orifice_width_m.is_none()
    }

    /// Whether in addition all particles have the same mass.
    fn keeps_energy_of_one_mass(&self) -> bool {
        self.keeps_energy() && !law::has_several_masses(&self.config)
    }

    /// Pressure of discs, N/m, from `<v^2>` and the virial of their collisions.
    fn pressure_by_virial(&self, mean_square_m2_per_s2: f64) -> Option<f64> {
        let (_, _, virial) = self.kinetics.pairs.last()?;
        let radius = self.config.radius_m.get();
        let reach = radius - self.config.disc_radius_m?.get();
        let mass = f64::from(self.config.particles.get()) * self.config.mass_kg.get();
        let force = (mass * mean_square_m2_per_s2 + virial / self.time_s) / reach;
        Some(force / (2.0 * std::f64::consts::PI * radius))
    }

    fn pressure_measurements(&self, found: &mut Vec<Measurement>) {
        let Some(pressure) = &self.pressure else { return };
        let moments = law::speed_moments(&self.config);
        let by_square = |square: f64| law::pressure_n_per_m(&self.config, square);
        if self.time_s > 0.0 {
            let value = pressure.measured_since_start_n_per_m;
            let square = self.mean_square().filter(|_| self.keeps_energy_of_one_mass());
            let error = |square: f64| {
                by_square(square)
                    * law::pressure_error_relative(&self.config, square.sqrt(), self.time_s)
            };
            let estimate = Estimate { value, standard_error: square.map(error) };
            let measured = Measurement::new(metric::PRESSURE_MEASURED, estimate);
            found.push(match (self.config.disc_radius_m, square) {
                (Some(_), Some(square)) => {
                    measured.against_law(self.pressure_by_virial(square), kinetics::CLAUSIUS)
                }
                _ => measured.against(square.map(by_square)),
            });
        }
        let mean_speed =
            moments.map(|moments| by_square(moments.mean_m_per_s * moments.mean_m_per_s));
        let mean_square = moments.map(|moments| by_square(moments.mean_square_m2_per_s2));
        let ideal = law::temperature_k(&self.config)
            .filter(|_| self.keeps_particles())
            .map(|temperature| law::pressure_slope_n_per_m_k(&self.config) * temperature);
        found.extend([
            Measurement::new(metric::PRESSURE_MEAN_SPEED, pressure.mean_speed_formula_n_per_m)
                .against(mean_speed),
            Measurement::new(metric::PRESSURE_MEAN_SQUARE, pressure.mean_square_formula_n_per_m)
                .against(mean_square),
            Measurement::new(metric::PRESSURE_IDEAL, pressure.ideal_gas_n_per_m).against(ideal),
        ]);
    }

    fn speed_measurements(&self, found: &mut Vec<Measurement>) {
        let Some(speeds) = self.speeds() else { return };
        let moments = law::speed_moments(&self.config);
        let in_kelvin = |square: f64| law::temperature_of_k(&self.config, square);
        let square = speeds.mean_square_m2_per_s2;
        let mean = speeds.mean_m_per_s;
        let expected_square = moments.map(|moments| moments.mean_square_m2_per_s2);
        let expected_mean = moments.map(|moments| moments.mean_m_per_s);
        // The state does not contain the masses of the particles.
        if !law::has_several_masses(&self.config) {
            found.extend([
                Measurement::new(metric::TEMPERATURE_MEAN_SQUARE, in_kelvin(square))
                    .against(expected_square.map(in_kelvin)),
                Measurement::new(metric::TEMPERATURE_MEAN_SPEED, in_kelvin(mean * mean))
                    .against(expected_mean.map(|mean| in_kelvin(mean * mean))),
            ]);
        }
        found.extend([
            Measurement::new(metric::MEAN_SPEED, mean).against(expected_mean),
            Measurement::new(metric::RMS_SPEED, square.sqrt())
                .against(expected_square.map(f64::sqrt)),
            Measurement::new(metric::MEAN_VELOCITY, speeds.drift_m_per_s),
        ]);
    }

    fn wall_collision_measurement(&self) -> Option<Measurement> {
        let wall_collisions = self.wall_collisions.filter(|_| self.time_s > 0.0)?;
        let value = wall_collisions as f64 / self.time_s;
        let standard_error = wall_collision_rate_error(&self.wall_collision_rates, self.time_s);
        let stationary = self.keeps_particles()
            && self.config.position_distribution == PositionDistribution::UniformInArea;
        let theory = self
            .speeds()
            .filter(|_| stationary)
            .map(|speeds| law::wall_collision_rate_per_s(&self.config, speeds.mean_m_per_s));
        let estimate = Estimate { value, standard_error };
        Some(Measurement::new(metric::HIT_RATE, estimate).against(theory))
    }

    fn histogram_measurements(&self, found: &mut Vec<Measurement>) {
        let Some(histogram) = &self.histogram else { return };
        let bins = &histogram.speed_m_per_s;
        let width = if bins.len() > 1 { bins[1] - bins[0] } else { return };
        let counted = f64::from(self.config.particles.get()) * width;
        let pairs = histogram.density.iter().zip(&histogram.initial_distribution);
        let terms: Vec<f64> = pairs
            .map(|(density, law)| (counted * density, counted * law))
            .filter(|(_, expected)| *expected >= 5.0)
            .map(|(count, expected)| (count - expected) * (count - expected) / expected)
            .collect();
        if let Some(value) = mean(&terms) {
            let standard_error = Some((2.0 / terms.len() as f64).sqrt());
            let estimate = Estimate { value, standard_error };
            let theory = self.keeps_particles().then_some(1.0);
            found.push(Measurement::new(metric::HISTOGRAM_CHI_SQUARE, estimate).against(theory));
        }
        let apart: f64 = histogram
            .density
            .iter()
            .zip(&histogram.maxwell)
            .map(|(density, maxwell)| (density - maxwell).abs() * width / 2.0)
            .sum();
        found.push(Measurement::new(metric::HISTOGRAM_MAXWELL, apart));
    }

    fn invariant_measurements(&self, found: &mut Vec<Measurement>) {
        let (Some(first), Some(last)) = (&self.first_invariants, &self.invariants) else { return };
        let drift = relative_change(last.kinetic_j, first.kinetic_j);
        let angular_momentum = self.max_angular_momentum_change;
        found.extend([
            Measurement::new(metric::ENERGY_DRIFT, drift)
                .against(self.keeps_energy().then_some(0.0)),
            Measurement::new(metric::OUTSIDE, self.max_outside as f64).against(0.0),
        ]);
        if self.config.disc_radius_m.is_none() {
            found.extend([
                Measurement::new(metric::SPEED_CHANGE, self.max_speed_change).against(0.0),
                Measurement::new(metric::ANGULAR_MOMENTUM_CHANGE, angular_momentum).against(0.0),
            ]);
        }
    }
}

/// Metrics from the energy balance.
impl GasRun {
    fn energy_balance_measurements(&self, found: &mut Vec<Measurement>) {
        let Some(energy_balance) = &self.energy_balance else { return };
        found.push(
            Measurement::new(metric::RESIDUAL, energy_balance.residual_relative).against(0.0),
        );
        if let Some(theory) = self
            .first_mean_speed_m_per_s
            .and_then(|speed| law::effusion_rate_per_s(&self.config, speed))
            .filter(|_| self.time_s > 0.0)
        {
            let left = energy_balance.particles_escaped as f64;
            let estimate = Estimate {
                value: left / self.time_s,
                standard_error: Some(left.sqrt() / self.time_s),
            };
            found.push(Measurement::new(metric::EFFUSION_RATE, estimate).against(theory));
        }
        if self.config.wall_speed_m_per_s.get() != 0.0 {
            let value = energy_balance.energy_times_area_over_initial;
            found.push(Measurement::new(metric::ADIABATIC_INVARIANT, value).against(1.0));
        }
        if let (Some(wall), Some(speeds)) = (self.config.thermal_wall, self.speeds())
            && !law::has_several_masses(&self.config)
        {
            let temperature = law::temperature_of_k(&self.config, speeds.mean_square_m2_per_s2);
            // In two dimensions, the standard deviation of a particle's energy equals its mean.
            let standard_error = Some(temperature / f64::from(self.config.particles.get()).sqrt());
            let estimate = Estimate { value: temperature, standard_error };
            found.push(
                Measurement::new(metric::TEMPERATURE_THERMALISED, estimate)
                    .against(wall.temperature_k.get()),
            );
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
            self.recorded_speeds = Some(SpeedMeans {
                mean_m_per_s: temperature.mean_speed_m_per_s,
                mean_square_m2_per_s2: temperature.rms_speed_m_per_s
                    * temperature.rms_speed_m_per_s,
                drift_m_per_s: temperature.mean_velocity_m_per_s,
            });
        }
        if let Some(state) = frame.take_state() {
            if self.wall_collision_rates.is_empty() {
                self.wall_collision_rates = own_wall_collision_rates(&state, &self.config);
            }
            if self.kinetics.inside_half_at_start.is_none() {
                self.kinetics.inside_half_at_start = share_inside_half(&state, &self.config);
            }
            self.snapshots.add_state(&frame, state);
        }
        if let Some(speeds) = frame.get::<GasSpeeds>()? {
            self.kinetics.bins = speeds.density.len();
            self.histogram = Some(speeds);
        }
        if let Some(collisions) = frame.get::<GasCollisions>()? {
            self.wall_collisions = Some(collisions.wall_collisions);
            let GasCollisions { pair_collisions, pair_virial_sum_j_s, .. } = collisions;
            self.kinetics.pairs.add((self.time_s, pair_collisions as f64, pair_virial_sum_j_s));
        }
        // Computed once, because the moments take longer than all else of a frame.
        if self.first_mean_speed_m_per_s.is_none() {
            self.first_mean_speed_m_per_s = self.speeds().map(|speeds| speeds.mean_m_per_s);
        }
        if let Some(energy_balance) = frame.get::<GasEnergyBalance>()? {
            self.kinetics.relative_entropy.add((self.time_s, energy_balance.relative_entropy));
            self.energy_balance = Some(energy_balance);
        }
        if let Some(invariants) = frame.get::<GasInvariants>()? {
            self.kinetics.energy_j = Some(invariants.kinetic_j);
            self.add_invariants(invariants);
        }
        self.snapshots.keep_scenes(frame);
        Ok(())
    }

    fn measurements(&self) -> Vec<Measurement> {
        let mut found = Vec::new();
        self.pressure_measurements(&mut found);
        self.speed_measurements(&mut found);
        found.extend(self.wall_collision_measurement());
        self.histogram_measurements(&mut found);
        self.invariant_measurements(&mut found);
        self.energy_balance_measurements(&mut found);
        found.extend(self.kinetics.measurements(&Inputs {
            config: &self.config,
            time_s: self.time_s,
            state: self.snapshots.last(),
            mean_square: self.mean_square().filter(|_| !law::has_several_masses(&self.config)),
            pressures: &self.pressure_series,
            keeps_particles: self.keeps_particles(),
        }));
        found
    }
}

/// Speed moments of a state; `None` without velocities.
fn speeds_of(state: &StateTable) -> Option<SpeedMeans> {
    let (vx, vy): (Vec<f64>, Vec<f64>) =
        (state.column("vx")?.collect(), state.column("vy")?.collect());
    let squares: Vec<f64> = vx.iter().zip(&vy).map(|(x, y)| x * x + y * y).collect();
    let lengths: Vec<f64> = squares.iter().map(|square| square.sqrt()).collect();
    Some(SpeedMeans {
        mean_m_per_s: mean(&lengths)?,
        mean_square_m2_per_s2: mean(&squares)?,
        drift_m_per_s: mean(&vx)?.hypot(mean(&vy)?),
    })
}

/// Wall collision rate of each particle: its speed over its chord 2 sqrt(R^2 - d^2), d its distance of closest
/// approach.
fn own_wall_collision_rates(state: &StateTable, config: &GasConfig) -> Vec<f64> {
    let columns = ["x", "y", "vx", "vy"];
    let places = columns.map(|name| state.columns().iter().position(|column| column == name));
    let [Some(x), Some(y), Some(vx), Some(vy)] = places else { return Vec::new() };
    let [center_x, center_y] = config.center_m.map(|component| component.get());
    let radius = config.radius_m.get();
    (0..state.rows())
        .map(|particle| {
            let row = state.row(particle);
            let moment = (row[x] - center_x) * row[vy] - (row[y] - center_y) * row[vx];
            let square = row[vx] * row[vx] + row[vy] * row[vy];
            let chord = 2.0 * (radius * radius - moment * moment / square).sqrt();
            if square > 0.0 { square.sqrt() / chord } else { 0.0 }
        })
        .collect()
}

/// Standard error of the total wall collision rate: the scatter of the particles' constant rates, and of the phase of
/// each particle.
fn wall_collision_rate_error(rates: &[f64], time_s: f64) -> Option<f64> {
    let scatter = standard_deviation(rates)?;
    let begun: f64 = rates
        .iter()
        .map(|rate| {
            let share = (rate * time_s).fract();
            share * (1.0 - share)
        })
        .sum();
    let variance = rates.len() as f64 * scatter * scatter + begun / (time_s * time_s);
    variance.is_finite().then(|| variance.sqrt())
}
