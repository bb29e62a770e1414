//! What is seen of a gas run: pressure of the wall, moments of the speeds, hits.

use super::dem::largest_or_nan;
use super::{Observer, Snapshot, relative_change};
use crate::figures::{self, Figures};
use crate::laws::gas as law;
use crate::measurement::Measurement;
use crate::statistics::{Estimate, mean, standard_deviation};
use kinetoscope_manifest::model::{GasConfig, PlaceDistribution};
use kinetoscope_recording::channels::{
    GasCollisions, GasInvariants, GasLedger, GasPressure, GasSpeeds, GasTemperature,
};
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::{RecordedFrame, StateTable};

/// Moments of the speeds at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Speeds {
    mean_m_per_s: f64,
    mean_square_m2_per_s2: f64,
    /// |<v>|, m/s.
    drift_m_per_s: f64,
}

/// A gas run while its frames go by.
#[derive(Clone, Debug)]
pub struct GasRun {
    pub(crate) config: GasConfig,
    pub(crate) time_s: f64,
    /// Time and pressure measured since the start.
    pub(crate) pressure_series: Vec<(f64, f64)>,
    pub(crate) pressure: Option<GasPressure>,
    pub(crate) histogram: Option<GasSpeeds>,
    pub(crate) snapshot: Snapshot,
    speeds: Option<Speeds>,
    /// Each particle's own rate of hits at the start, 1/s.
    hit_rates: Vec<f64>,
    hits: Option<u64>,
    first_invariants: Option<GasInvariants>,
    invariants: Option<GasInvariants>,
    largest_speed_change: f64,
    largest_angular_momentum_change: f64,
    most_outside: u64,
    ledger: Option<GasLedger>,
    first_mean_speed_m_per_s: Option<f64>,
}

impl GasRun {
    /// Nothing seen yet.
    #[must_use]
    pub fn new(config: GasConfig) -> Self {
        Self {
            config,
            time_s: 0.0,
            pressure_series: Vec::new(),
            pressure: None,
            histogram: None,
            snapshot: Snapshot::default(),
            speeds: None,
            hit_rates: Vec::new(),
            hits: None,
            first_invariants: None,
            invariants: None,
            largest_speed_change: 0.0,
            largest_angular_momentum_change: 0.0,
            most_outside: 0,
            ledger: None,
            first_mean_speed_m_per_s: None,
        }
    }

    /// <v^2> as recorded, m^2/s^2.
    pub(crate) fn mean_square(&self) -> Option<f64> {
        self.speeds.map(|speeds| speeds.mean_square_m2_per_s2)
    }

    fn see_invariants(&mut self, invariants: GasInvariants) {
        self.largest_speed_change =
            largest_or_nan(self.largest_speed_change, invariants.largest_speed_change_relative);
        self.largest_angular_momentum_change = largest_or_nan(
            self.largest_angular_momentum_change,
            invariants.largest_angular_momentum_change_relative,
        );
        self.most_outside = self.most_outside.max(invariants.particles_outside);
        self.first_invariants.get_or_insert_with(|| invariants.clone());
        self.invariants = Some(invariants);
    }

    fn pressure_measurements(&self, found: &mut Vec<Measurement>) {
        let Some(pressure) = &self.pressure else { return };
        let moments = law::speed_moments(&self.config);
        let unit = "N/m";
        if self.time_s > 0.0 {
            let value = pressure.measured_since_start_n_per_m;
            let theory = self
                .mean_square()
                .filter(|_| self.config.keeps_speeds() && self.config.opening_width_m.is_none())
                .filter(|_| !law::has_several_masses(&self.config));
            let standard_error = theory.map(|square| {
                let exact = law::pressure_n_per_m(&self.config, square);
                exact * law::pressure_error_relative(&self.config, square.sqrt(), self.time_s)
            });
            let from =
                "/pressure: impulse on the wall since the start; error R P / (v_rms t sqrt(2N))";
            let estimate = Estimate { value, standard_error };
            found.push(Measurement::new("pressure.measured", unit, estimate, from).against(
                theory.map(|square| law::pressure_n_per_m(&self.config, square)),
                law::KINETIC_PRESSURE,
            ));
        }
        let value = pressure.mean_speed_formula_n_per_m;
        let from = "/pressure: N m <v>^2 / (2A), the gas document's formula (12)";
        let theory = moments.map(|moments| {
            law::pressure_n_per_m(&self.config, moments.mean_m_per_s * moments.mean_m_per_s)
        });
        found.push(
            Measurement::new("pressure.mean_speed_formula", unit, value, from)
                .against(theory, law::SPEED_LAW),
        );
        let value = pressure.mean_square_formula_n_per_m;
        let theory = moments
            .map(|moments| law::pressure_n_per_m(&self.config, moments.mean_square_m2_per_s2));
        found.push(
            Measurement::new(
                "pressure.mean_square_formula",
                unit,
                value,
                "/pressure: N m <v^2> / (2A)",
            )
            .against(theory, law::SPEED_LAW),
        );
        let value = pressure.ideal_gas_n_per_m;
        let theory = law::temperature_k(&self.config)
            .map(|temperature| law::pressure_slope_n_per_m_k(&self.config) * temperature);
        found.push(
            Measurement::new("pressure.ideal_gas", unit, value, "/pressure: N k_B T / A")
                .against(theory, law::IDEAL_GAS),
        );
    }

    fn speed_measurements(&self, found: &mut Vec<Measurement>) {
        let Some(speeds) = self.speeds else { return };
        let moments = law::speed_moments(&self.config);
        let squared_mean = speeds.mean_m_per_s * speeds.mean_m_per_s;
        let in_kelvin = |square: f64| law::temperature_of_k(&self.config, square);
        let expected_square = moments.map(|moments| moments.mean_square_m2_per_s2);
        let expected_mean = moments.map(|moments| moments.mean_m_per_s);
        let rms = speeds.mean_square_m2_per_s2.sqrt();
        found.extend([
            Measurement::new(
                "temperature.mean_square",
                "K",
                in_kelvin(speeds.mean_square_m2_per_s2),
                "speeds of the last frame: m <v^2> / (2 k_B)",
            )
            .against(expected_square.map(in_kelvin), law::SPEED_LAW),
            Measurement::new(
                "temperature.mean_speed",
                "K",
                in_kelvin(squared_mean),
                "speeds of the last frame: m <v>^2 / (2 k_B), the gas document's equation (13)",
            )
            .against(expected_mean.map(|mean| in_kelvin(mean * mean)), law::SPEED_LAW),
            Measurement::new("mean_speed", "m/s", speeds.mean_m_per_s, "mean |v|, last frame")
                .against(expected_mean, law::SPEED_LAW),
            Measurement::new("rms_speed", "m/s", rms, "sqrt <v^2>, last frame")
                .against(expected_square.map(f64::sqrt), law::SPEED_LAW),
            Measurement::new("mean_velocity", "m/s", speeds.drift_m_per_s, "|mean v|, last frame"),
        ]);
    }

    fn hit_measurement(&self) -> Option<Measurement> {
        let hits = self.hits.filter(|_| self.time_s > 0.0)?;
        let value = hits as f64 / self.time_s;
        let standard_error = hit_rate_error(&self.hit_rates, self.time_s);
        let stationary = self.config.keeps_speeds()
            && self.config.opening_width_m.is_none()
            && self.config.place_distribution == PlaceDistribution::Area;
        let theory = self
            .speeds
            .filter(|_| stationary)
            .map(|speeds| law::hit_rate_per_s(&self.config, speeds.mean_m_per_s));
        let from = "/collisions: hits of the wall over time; error from the scatter of the particles' own rates";
        let estimate = Estimate { value, standard_error };
        Some(Measurement::new("hit_rate", "1/s", estimate, from).against(theory, law::HIT_RATE))
    }

    fn invariant_measurements(&self, found: &mut Vec<Measurement>) {
        let (Some(first), Some(last)) = (&self.first_invariants, &self.invariants) else { return };
        let energy = relative_change(last.kinetic_j, first.kinetic_j);
        let changes = [
            (
                "energy.drift_relative",
                energy,
                "/energy: kinetic energy, last frame against the first",
            ),
            (
                "largest_speed_change_relative",
                self.largest_speed_change,
                "/energy: largest of any particle and frame",
            ),
            (
                "largest_angular_momentum_change_relative",
                self.largest_angular_momentum_change,
                "/energy: largest of any particle and frame, over m r v",
            ),
        ];
        for (name, value, from) in changes {
            let kept = self.config.keeps_speeds() && self.config.opening_width_m.is_none();
            let theory = (kept || name != "energy.drift_relative").then_some(0.0);
            found.push(Measurement::new(name, "1", value, from).against(theory, law::INVARIANTS));
        }
        let outside = self.most_outside as f64;
        found.push(
            Measurement::new("particles_outside", "1", outside, "/energy: most of any frame")
                .against(0.0, law::INVARIANTS),
        );
    }
}

/// What `/ledger` says, and what belongs to it.
impl GasRun {
    fn ledger_measurements(&self, found: &mut Vec<Measurement>) {
        let Some(ledger) = &self.ledger else { return };
        found.push(
            Measurement::new(
                "energy.residual_relative",
                "1",
                ledger.residual_relative,
                "/ledger: error of the ledger over the energy at the start",
            )
            .against(0.0, law::LEDGER),
        );
        if let Some(theory) = self
            .first_mean_speed_m_per_s
            .and_then(|speed| law::effusion_rate_per_s(&self.config, speed))
            .filter(|_| self.time_s > 0.0)
        {
            let left = ledger.particles_escaped as f64;
            let estimate = Estimate {
                value: left / self.time_s,
                standard_error: Some(left.sqrt() / self.time_s),
            };
            let from = "/ledger: particles that left over time; error sqrt of their number";
            found.push(
                Measurement::new("effusion_rate", "1/s", estimate, from)
                    .against(theory, law::EFFUSION),
            );
        }
        if self.config.wall_speed_m_per_s.get() != 0.0 {
            let value = ledger.energy_times_area_over_initial;
            let from = "/ledger: energy times area, last frame over the first";
            found.push(
                Measurement::new("adiabatic_invariant", "1", value, from)
                    .against(1.0, law::ADIABATIC),
            );
        }
        if let (Some(wall), Some(speeds)) = (self.config.thermal_wall, self.speeds) {
            let temperature = law::temperature_of_k(&self.config, speeds.mean_square_m2_per_s2);
            // In two dimensions the energy of one particle scatters by its mean.
            let standard_error = Some(temperature / f64::from(self.config.particles.get()).sqrt());
            let estimate = Estimate { value: temperature, standard_error };
            let from = "speeds of the last frame; error T / sqrt(N)";
            found.push(
                Measurement::new("temperature.thermalised", "K", estimate, from)
                    .against(wall.temperature_k.get(), law::THERMALISATION),
            );
        }
        found.push(Measurement::new(
            "excess_h",
            "1",
            ledger.excess_h,
            "/ledger: H above Maxwell's, last frame",
        ));
    }
}

impl Observer for GasRun {
    fn see(&mut self, frame: &RecordedFrame) -> Result<(), ReadError> {
        self.time_s = frame.clock.time;
        if let Some(pressure) = frame.get::<GasPressure>()? {
            if self.time_s > 0.0 {
                self.pressure_series.push((self.time_s, pressure.measured_since_start_n_per_m));
            }
            self.pressure = Some(pressure);
        }
        if let Some(temperature) = frame.get::<GasTemperature>()? {
            self.speeds = Some(Speeds {
                mean_m_per_s: temperature.mean_speed_m_per_s,
                mean_square_m2_per_s2: temperature.rms_speed_m_per_s
                    * temperature.rms_speed_m_per_s,
                drift_m_per_s: temperature.mean_velocity_m_per_s,
            });
        }
        if let Some(state) = frame.state() {
            self.snapshot.take(self.time_s, state, None);
            if let Some(speeds) = speeds_of(state) {
                self.speeds = Some(speeds);
            }
            if self.hit_rates.is_empty() {
                self.hit_rates = own_hit_rates(state, &self.config);
            }
        }
        if let Some(speeds) = frame.get::<GasSpeeds>()? {
            self.histogram = Some(speeds);
        }
        if let Some(collisions) = frame.get::<GasCollisions>()? {
            self.hits = Some(collisions.wall);
        }
        if let (None, Some(speeds)) = (self.first_mean_speed_m_per_s, self.speeds) {
            self.first_mean_speed_m_per_s = Some(speeds.mean_m_per_s);
        }
        if let Some(ledger) = frame.get::<GasLedger>()? {
            self.ledger = Some(ledger);
        }
        if let Some(invariants) = frame.get::<GasInvariants>()? {
            self.see_invariants(invariants);
        }
        Ok(())
    }

    fn measurements(&self) -> Vec<Measurement> {
        let mut found = Vec::new();
        self.pressure_measurements(&mut found);
        self.speed_measurements(&mut found);
        found.extend(self.hit_measurement());
        self.invariant_measurements(&mut found);
        self.ledger_measurements(&mut found);
        found
    }

    fn figures(&self) -> Figures {
        figures::gas::figures(self)
    }
}

/// Moments of the speeds of a state; `None` without velocities.
fn speeds_of(state: &StateTable) -> Option<Speeds> {
    let (vx, vy): (Vec<f64>, Vec<f64>) =
        (state.column("vx")?.collect(), state.column("vy")?.collect());
    let squares: Vec<f64> = vx.iter().zip(&vy).map(|(x, y)| x * x + y * y).collect();
    let lengths: Vec<f64> = squares.iter().map(|square| square.sqrt()).collect();
    Some(Speeds {
        mean_m_per_s: mean(&lengths)?,
        mean_square_m2_per_s2: mean(&squares)?,
        drift_m_per_s: mean(&vx)?.hypot(mean(&vy)?),
    })
}

/// How often each particle meets the wall: speed over its chord 2 sqrt(R^2 - d^2), d its distance of closest approach.
fn own_hit_rates(state: &StateTable, config: &GasConfig) -> Vec<f64> {
    let columns = ["x", "y", "vx", "vy"];
    let places = columns.map(|name| state.columns().iter().position(|column| column == name));
    let [Some(x), Some(y), Some(vx), Some(vy)] = places else { return Vec::new() };
    let [centre_x, centre_y] = config.centre_m.map(|component| component.get());
    let radius = config.radius_m.get();
    (0..state.rows())
        .map(|particle| {
            let row = state.row(particle);
            let moment = (row[x] - centre_x) * row[vy] - (row[y] - centre_y) * row[vx];
            let square = row[vx] * row[vx] + row[vy] * row[vy];
            let chord = 2.0 * (radius * radius - moment * moment / square).sqrt();
            if square > 0.0 { square.sqrt() / chord } else { 0.0 }
        })
        .collect()
}

/// Error of the rate of all hits: the scatter of the particles' frozen rates, and of the hit that each has begun.
fn hit_rate_error(rates: &[f64], time_s: f64) -> Option<f64> {
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
