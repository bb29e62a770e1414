//! Gas of particles in a circular container: gas exercise 14g1.
//!
//! N points of mass m move in a circle of radius r without interacting; the wall reflects them specularly. Without collisions, each
//! particle keeps its speed and angular momentum, so the speeds never become Maxwellian. Discs that collide with one another reach the
//! Maxwell distribution.
//!
//! `motion.rs` holds the equations of motion and `propagator.rs` the interface of the schemes that apply them (`schemes.rs` lists the
//! schemes). `pressure.rs` holds the ideal-gas laws, `observe.rs` what a frame contains.

pub mod as_printed;
mod clock;
mod closed_form;
mod collisions;
mod energy_balance;
mod event_driven;
mod initial_positions;
mod initial_state;
mod log;
pub mod motion;
mod numeric_range;
mod observe;
pub mod parabola;
mod particle_groups;
mod path;
pub mod pressure;
mod propagator;
mod schemes;
mod sine_cosine;
pub mod speed_distribution;
mod state;
mod tallies;
mod temperature_schedule;
pub mod time_stepped;

use self::energy_balance::EnergyBalance;
use self::motion::Particle;
use self::particle_groups::Particles;
use self::pressure::{SpeedMoments, speed_at};
use self::schemes::Scheme;
use self::speed_distribution::InitialSpeeds;
use self::state::{Container, GasState, Substance, max_width};
use self::tallies::WallTallies;
use self::temperature_schedule::TemperatureSchedule;
use crate::model::{
    Extent, Model, ModelKind, Proceed, Progress, SetupError, SimulationFault, Target,
};
use crate::random::Seed;
use crate::sum::CompensatedSum;
use kinetoscope_manifest::model::GasConfig;
use kinetoscope_recording::channels::{
    ChannelDeclaration, GasCollisions, GasEnergyBalance, GasEvents, GasInvariants, GasPressure,
    GasSpeeds, GasTemperature,
};
use kinetoscope_recording::frame::{Frame, StateColumn};
use kinetoscope_recording::scenery::Scenery;
use serde::{Deserialize, Serialize};

/// A gas in its container at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gas {
    state: GasState,
    scheme: Scheme,
    schedule: TemperatureSchedule,
    initial_speeds: InitialSpeeds,
    /// Upper end of the displayed speeds, m/s.
    speed_range_top: f64,
    /// Particles at the start of the present paths.
    start: Particles,
    /// Start of the present paths, s.
    start_s: f64,
    /// Number of particles outside the wall at the last frame.
    outside_at_last_frame: u64,
    /// Whether the last target was reached, so that the next call opens a window.
    is_target_reached: bool,
}

/// Greatest speed of a restored particle over the range of the displayed speeds. A thermal wall or a set temperature may be far
/// hotter than the start; much faster particles would have so many collisions that the run would not end.
const MAX_SPEED_OVER_RANGE: f64 = 1e3;

/// Columns of the state, the last of which is recorded if there are several masses.
const COLUMNS: &[StateColumn] = &[
    StateColumn { name: "x", unit: "m" },
    StateColumn { name: "y", unit: "m" },
    StateColumn { name: "vx", unit: "m/s" },
    StateColumn { name: "vy", unit: "m/s" },
    StateColumn { name: "mass", unit: "kg" },
];

const COLUMNS_OF_ONE_MASS: &[StateColumn] = COLUMNS.split_at(4).0;

const KIND: ModelKind = ModelKind {
    name: "gas",
    physics_version: 2,
    time_unit: "s",
    state_columns: COLUMNS_OF_ONE_MASS,
    channels: &[
        ChannelDeclaration::of::<GasPressure>(),
        ChannelDeclaration::of::<GasTemperature>(),
        ChannelDeclaration::of::<GasInvariants>(),
        ChannelDeclaration::of::<GasEnergyBalance>(),
        ChannelDeclaration::of::<GasCollisions>(),
        ChannelDeclaration::of::<GasSpeeds>(),
        ChannelDeclaration::opt_in::<GasEvents>(),
    ],
};

impl Model for Gas {
    type Config = GasConfig;

    fn kind() -> &'static ModelKind {
        &KIND
    }

    fn state_columns(config: &GasConfig) -> &'static [StateColumn] {
        if config.additional_masses_kg.is_empty() { COLUMNS_OF_ONE_MASS } else { COLUMNS }
    }

    /// Draws positions and velocities from separate streams. Only colliding discs record single collisions.
    fn prepare(config: &GasConfig, seed: Seed, records_events: bool) -> Result<Self, SetupError> {
        Self::prepare_while(config, seed, records_events, &|_| true)
    }

    fn prepare_while(
        config: &GasConfig,
        seed: Seed,
        records_events: bool,
        proceed: Proceed<'_>,
    ) -> Result<Self, SetupError> {
        let substance = Substance::new(config);
        let initial = initial_state::prepare(config, seed, &substance, proceed)?;
        numeric_range::check(config, &initial.particles)?;
        let particles = Particles::of(&initial.particles);
        let state = GasState {
            container: Container::new(config),
            substance,
            particles: particles.clone(),
            wall: WallTallies::default(),
            energy_balance: EnergyBalance::default(),
            max_width: max_width(),
        };
        let mut gas = Self {
            scheme: Scheme::prepare(config, seed, &state, records_events)?,
            state,
            schedule: TemperatureSchedule::new(config),
            initial_speeds: initial.initial_speeds,
            speed_range_top: 1.0,
            start: particles,
            start_s: 0.0,
            outside_at_last_frame: 0,
            is_target_reached: true,
        };
        let moments = gas.moments();
        gas.state.energy_balance.at_start =
            moments.reduced_mean_square * moments.count / 2.0 + gas.potential_energy();
        let rms_speed = moments.mean_square.sqrt();
        let top = gas.initial_speeds.range_top(rms_speed, config.disc_radius_m.is_some());
        // Slow compression multiplies every speed by r0/r.
        let circle = gas.state.container.circle;
        let end_radius = circle.radius_at(config.duration_s.get());
        let compression = if end_radius < circle.radius { circle.radius / end_radius } else { 1.0 };
        let gravity = config.gravity_m_per_s2.get();
        gas.speed_range_top = if gravity > 0.0 {
            (top * top + 4.0 * gravity * circle.radius).sqrt()
        } else {
            top * compression
        };
        Ok(gas)
    }

    fn is_valid_for(&self, config: &GasConfig) -> bool {
        let count = config.particles.get() as usize;
        let duration_s = config.duration_s.get();
        // The header of the recording contains the top of the range, and is compared with the file.
        let max_speed = MAX_SPEED_OVER_RANGE * self.speed_range_top;
        let state = &self.state;
        state.container == Container::new(config)
            && state.substance == Substance::new(config)
            && state.wall.is_finite()
            && state.energy_balance.is_finite()
            && [&state.particles, &self.start]
                .into_iter()
                .all(|particles| particles.is_valid(count, max_speed))
            && self.schedule.is_valid_for(config)
            && (0.0..=duration_s).contains(&self.start_s)
            && self.speed_range_top.is_finite()
            && self.scheme.is_of(config)
            && self.time() <= duration_s * (1.0 + 1e-9)
            && self.scheme.is_valid_for(state, max_speed)
    }

    fn channels(&self) -> &'static [ChannelDeclaration] {
        KIND.channels
    }

    fn extent(&self) -> Extent {
        self.scheme.clock().extent()
    }

    /// Reaches the target in one call, whatever the budget, if the propagator needs no events.
    fn advance(&mut self, target: Target, mut at_most: u64) -> Result<Progress, SimulationFault> {
        if self.is_target_reached {
            self.open_window();
        }
        let target_s = self.scheme.clock().time_of(target)?;
        self.is_target_reached = false;
        while let Some([time_s, temperature_k]) = self.schedule.due(target_s) {
            if !self.scheme.advance(Target::Time(time_s), &mut at_most, &mut self.state) {
                return Ok(Progress::Working);
            }
            self.set_temperature(temperature_k)?;
        }
        self.is_target_reached = self.scheme.advance(target, &mut at_most, &mut self.state);
        Ok(if self.is_target_reached { Progress::Reached } else { Progress::Working })
    }

    /// Steps done; for exact propagation, collisions with the wall and between discs.
    fn count(&self) -> u64 {
        self.scheme.count(&self.state)
    }

    fn time(&self) -> f64 {
        self.scheme.clock().time_s()
    }

    fn observe(&self, frame: &mut Frame) {
        self.fill(frame);
    }

    fn scenery(&self) -> Scenery {
        self.draw()
    }
}

impl Gas {
    /// Limits the registers of the propagators to `max_width` numbers (1, 4 or 8), which changes no bit; for tests and benchmarks.
    #[must_use]
    pub fn with_max_width(self, max_width: usize) -> Self {
        Self { state: GasState { max_width, ..self.state }, ..self }
    }

    /// The masses that the particles have in turn, kg.
    #[must_use]
    pub fn masses_kg(&self) -> &[f64] {
        &self.state.substance.masses_kg
    }

    /// Mean values over the particles inside the container.
    fn moments(&self) -> SpeedMoments {
        let ratios = self.state.substance.mass_ratios.iter().copied();
        let particles = self.state.particles.iter().zip(ratios).enumerate();
        let inside = particles.filter(|(id, _)| self.is_inside(*id));
        SpeedMoments::of(inside.map(|(_, particle)| particle))
    }

    /// Whether a particle has not left through the opening. Without an opening, no virtual call per particle is needed.
    #[inline]
    fn is_inside(&self, id: usize) -> bool {
        self.state.container.half_opening_rad.is_none() || self.scheme.is_inside(id)
    }

    /// Potential energy of the particles inside in gravity above the bottom of the container, per first mass, m^2/s^2; 0 without gravity.
    fn potential_energy(&self) -> f64 {
        let (gravity, radius) =
            (self.scheme.gravity_m_per_s2(), self.state.container.circle.radius);
        let mut sum = CompensatedSum::default();
        if gravity > 0.0 {
            let ratios = &self.state.substance.mass_ratios;
            for (id, (particle, ratio)) in self.state.particles.iter().zip(ratios).enumerate() {
                if self.is_inside(id) {
                    sum.add(ratio * gravity * (particle.position[1] + radius));
                }
            }
        }
        sum.value()
    }

    /// Resets the sums since the last frame.
    fn open_window(&mut self) {
        self.state.wall.open_window(self.time());
        // Checking every particle costs as much as half of a frame of the closed form (`benches/gas_exact.rs`).
        if self.scheme.can_end_outside() {
            self.outside_at_last_frame = self.particles_outside();
        }
        self.scheme.open_window();
    }

    /// Rescales all velocities to a temperature and starts new paths: step (d) of the gas exercise.
    fn set_temperature(&mut self, temperature_k: f64) -> Result<(), SimulationFault> {
        self.schedule.complete();
        let moments = self.moments();
        let Substance { mass_kg, boltzmann_j_per_k, definition, .. } = self.state.substance;
        let present = moments.squared_speed(definition).sqrt();
        let target = speed_at(temperature_k, mass_kg, boltzmann_j_per_k);
        if target > 0.0 && present == 0.0 {
            return Err(SimulationFault::new(
                format!(
                    "all particles are at rest at {} s: no factor scales them to {temperature_k} K",
                    self.time()
                ),
                "remove 0 K from temperature_schedule",
            ));
        }
        let factor = if target > 0.0 { target / present } else { 0.0 };
        let added = (factor * factor - 1.0) * moments.reduced_mean_square * moments.count / 2.0;
        self.state.energy_balance.rescaling.add(added);
        for id in 0..self.state.particles.len() {
            if self.is_inside(id) {
                let Particle { position, velocity } = self.state.particles.get(id);
                let velocity = velocity.map(|component| component * factor + 0.0);
                self.state.particles.set(id, Particle { position, velocity });
            }
        }
        self.scheme.restart_paths(&self.state);
        self.start = self.state.particles.clone();
        self.start_s = self.time();
        Ok(())
    }
}
