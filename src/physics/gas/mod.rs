//! Particles in a circular container: the gas document's exercise 14g1.
//!
//! N points of mass m fly in a circle of radius r without meeting one another; the wall mirrors them. `motion.rs` holds the law of
//! motion, `exact.rs` jumps along it, `stepped.rs` walks it, `literal.rs` keeps the document's scheme as printed;
//! `pressure.rs` holds the gas laws. In `collisions/` the particles are discs that meet.
//!
//! Without collisions every speed and every angular momentum stays for ever: the speeds never become Maxwell's. With them they do.

mod collisions;
mod exact;
mod groups;
mod hit_by_hit;
mod ledger;
mod limits;
pub mod literal;
pub mod motion;
mod observe;
mod paths;
pub mod pressure;
mod propagator;
mod schedule;
pub mod speeds;
mod start;
pub mod stepped;
pub mod turns;
mod wall;

use self::exact::ExactClock;
use self::groups::Particles;
use self::ledger::Ledger;
use self::motion::{Circle, Flight, Particle};
use self::pressure::{SpeedMean, SpeedMoments};
use self::propagator::{Propagator, StepClock};
use self::schedule::Schedule;
use self::speeds::SpeedLaw;
use self::wall::{Tally, WallLedger};
use crate::constants::{BOLTZMANN_CODATA_1986_J_PER_K, BOLTZMANN_SI_2019_J_PER_K};
use crate::model::{Extent, Model, ModelKind, Progress, SetupError, SimulationFault, Target};
use crate::random::Seed;
use kinetoscope_manifest::model::{BoltzmannConstant, GasConfig, TemperatureDefinition};
use kinetoscope_recording::channels::{
    ChannelDeclaration, GasCollisions, GasInvariants, GasLedger, GasPressure, GasSpeeds,
    GasTemperature,
};
use kinetoscope_recording::frame::{Frame, StateColumn};
use kinetoscope_recording::scenery::Scenery;
use serde::{Deserialize, Serialize};

/// N = floor(T / dt + this): a duration that is a whole number of steps but for rounding has all of them.
const STEP_ROUNDING: f64 = 1e-9;

/// A gas in its container, at one time. Particles stand relative to the center, so that a center far away costs no digits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gas {
    container: Container,
    substance: Substance,
    speed_law: SpeedLaw,
    /// Upper end of the speeds shown, m/s.
    speed_range_top: f64,
    /// The particles where their paths began.
    start: Particles,
    /// When that was, s.
    start_s: f64,
    /// The particles now.
    particles: Particles,
    propagator: Propagator,
    wall: WallLedger,
    ledger: Ledger,
    schedule: Schedule,
    /// Particles outside the wall at the last frame.
    outside_at_last_frame: u64,
    /// Whether the last target was reached: the next call opens a window.
    reached: bool,
}

/// The circle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Container {
    center_m: [f64; 2],
    circle: Circle,
}

/// What the particles are made of, and what their temperature means.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Substance {
    /// Mass of the first particle.
    mass_kg: f64,
    /// Each particle's mass over the first one's.
    mass_ratios: Vec<f64>,
    boltzmann_j_per_k: f64,
    definition: SpeedMean,
}

const KIND: ModelKind = ModelKind {
    name: "gas",
    physics_version: 2,
    time_unit: "s",
    state_columns: &[
        StateColumn { name: "x", unit: "m" },
        StateColumn { name: "y", unit: "m" },
        StateColumn { name: "vx", unit: "m/s" },
        StateColumn { name: "vy", unit: "m/s" },
    ],
    channels: &[
        ChannelDeclaration::of::<GasPressure>(),
        ChannelDeclaration::of::<GasTemperature>(),
        ChannelDeclaration::of::<GasInvariants>(),
        ChannelDeclaration::of::<GasLedger>(),
        ChannelDeclaration::of::<GasCollisions>(),
        ChannelDeclaration::of::<GasSpeeds>(),
    ],
};

impl Model for Gas {
    type Config = GasConfig;

    fn kind() -> &'static ModelKind {
        &KIND
    }

    /// Places and speeds are drawn from their own streams. A gas has no series of single collisions: `per_collision` changes nothing.
    fn prepare(config: &GasConfig, seed: Seed, _per_collision: bool) -> Result<Self, SetupError> {
        let substance = Substance::of(config);
        let start = start::start(
            config,
            seed,
            substance.definition,
            substance.boltzmann_j_per_k,
            &substance.mass_ratios,
        )?;
        limits::check(config, &start.particles)?;
        let container = Container {
            center_m: config.center_m.map(|axis| axis.get()),
            circle: Circle {
                radius: config.radius_m.get(),
                wall_speed: config.wall_speed_m_per_s.get(),
            },
        };
        let particles = Particles::of(&start.particles);
        let propagator = Propagator::of(config, seed, &particles, &substance, container)?;
        let mut gas = Self {
            container,
            substance,
            speed_law: start.speed_law,
            speed_range_top: 1.0,
            propagator,
            start: particles.clone(),
            start_s: 0.0,
            particles,
            wall: WallLedger::default(),
            ledger: Ledger::default(),
            schedule: Schedule::of(config),
            outside_at_last_frame: 0,
            reached: true,
        };
        let moments = gas.moments();
        gas.ledger.energy_at_start = moments.reduced_mean_square * moments.count / 2.0;
        let rms_speed = moments.mean_square.sqrt();
        gas.speed_range_top = gas.speed_law.range_top(rms_speed, config.disc_radius_m.is_some());
        Ok(gas)
    }

    fn channels(&self) -> &'static [ChannelDeclaration] {
        KIND.channels
    }

    fn extent(&self) -> Extent {
        match &self.propagator {
            Propagator::Exact(ExactClock { duration_s, .. })
            | Propagator::HitByHit { duration_s, .. }
            | Propagator::Colliding { duration_s, .. } => Extent::Time(*duration_s),
            Propagator::Stepped { clock, .. } | Propagator::Literal { clock, .. } => {
                Extent::Steps { total: clock.total, step: clock.time_step_s }
            }
        }
    }

    /// Exact propagation of points reaches a time in one call, whatever the budget.
    fn advance(&mut self, target: Target, at_most: u64) -> Result<Progress, SimulationFault> {
        if self.reached {
            self.open_window();
        }
        self.reached = match &self.propagator {
            Propagator::Exact(_) | Propagator::HitByHit { .. } | Propagator::Colliding { .. } => {
                self.jump(target, at_most)?
            }
            Propagator::Stepped { clock, .. } | Propagator::Literal { clock, .. } => {
                let (wanted, done) = (clock.count_of(target), clock.done);
                let Some(missing) = wanted.checked_sub(done) else {
                    return Err(SimulationFault(format!(
                        "step {wanted} was asked for after step {done}: frames must come in the order of time"
                    )));
                };
                self.walk_by_schedule(if missing < at_most { missing } else { at_most })?;
                if missing <= at_most {
                    self.gather();
                }
                missing <= at_most
            }
        };
        Ok(if self.reached { Progress::Reached } else { Progress::Working })
    }

    /// Steps done; in exact propagation hits of the wall, and of discs with one another.
    fn count(&self) -> u64 {
        match &self.propagator {
            Propagator::Exact(_) | Propagator::HitByHit { .. } => self.wall.total.hits,
            Propagator::Colliding { discs, .. } => self.wall.total.hits + discs.tally().collisions,
            Propagator::Stepped { clock, .. } | Propagator::Literal { clock, .. } => clock.done,
        }
    }

    fn time(&self) -> f64 {
        match &self.propagator {
            Propagator::Exact(ExactClock { time_s, .. }) | Propagator::HitByHit { time_s, .. } => {
                *time_s
            }
            Propagator::Colliding { discs, .. } => discs.time_s(),
            Propagator::Stepped { clock, .. } | Propagator::Literal { clock, .. } => clock.time_s(),
        }
    }

    fn observe(&self, frame: &mut Frame) {
        self.fill(frame);
    }

    fn scenery(&self) -> Scenery {
        self.draw()
    }
}

impl Substance {
    fn of(config: &GasConfig) -> Self {
        Self {
            mass_kg: config.mass_kg.get(),
            mass_ratios: {
                let mut masses = vec![config.mass_kg.get()];
                masses.extend(config.further_masses_kg.iter().map(|mass| mass.get()));
                let count = config.particles.get() as usize;
                masses.iter().map(|mass| mass / masses[0]).cycle().take(count).collect()
            },
            boltzmann_j_per_k: match config.boltzmann_constant {
                BoltzmannConstant::Codata1986 => BOLTZMANN_CODATA_1986_J_PER_K,
                BoltzmannConstant::Si2019 => BOLTZMANN_SI_2019_J_PER_K,
            },
            definition: match config.temperature_definition {
                TemperatureDefinition::MeanSpeed => SpeedMean::MeanSpeed,
                TemperatureDefinition::MeanSquare => SpeedMean::MeanSquare,
            },
        }
    }
}

impl Gas {
    /// Means over all particles now.
    fn moments(&self) -> SpeedMoments {
        let ratios = self.substance.mass_ratios.iter().copied();
        let all = self.particles.iter().zip(ratios).enumerate();
        SpeedMoments::of(all.filter(|(id, _)| self.is_inside(*id)).map(|(_, particle)| particle))
    }

    /// Starts "since the last frame" again from zero.
    fn open_window(&mut self) {
        self.wall.open_window(self.time());
        self.outside_at_last_frame = self.particles_outside();
        if let Propagator::Stepped { tallies, .. } | Propagator::Literal { tallies, .. } =
            &mut self.propagator
        {
            tallies.iter_mut().for_each(Tally::open_window);
        }
        if let Propagator::Colliding { discs, .. } = &mut self.propagator {
            discs.open_window();
        }
    }

    /// Whether a particle has not left through the opening.
    fn is_inside(&self, id: usize) -> bool {
        match &self.propagator {
            Propagator::HitByHit { courses, .. } => courses[id].is_inside(),
            _ => true,
        }
    }

    /// Exact propagation toward a target, which must be a time, by at most so many events; whether it is reached.
    fn jump(&mut self, target: Target, mut at_most: u64) -> Result<bool, SimulationFault> {
        let time = match target {
            Target::Time(time) if time >= self.time() => time,
            Target::Time(time) => {
                return Err(SimulationFault(format!(
                    "{time} s was asked for after {} s: frames must come in the order of time",
                    self.time()
                )));
            }
            Target::Count(_) => {
                return Err(SimulationFault(
                    "exact propagation counts no steps: ask for frames by time".to_owned(),
                ));
            }
        };
        while let Some([at, temperature_k]) = self.schedule.due(time) {
            if !self.fly_to(at, &mut at_most) {
                return Ok(false);
            }
            self.set_temperature(temperature_k)?;
        }
        Ok(self.fly_to(time, &mut at_most))
    }

    /// Exact propagation toward a time by at most so many events, of which points need none.
    fn fly_to(&mut self, time: f64, at_most: &mut u64) -> bool {
        match &mut self.propagator {
            Propagator::Exact(clock) => {
                clock.jump_to(time, &mut self.particles, &mut self.wall);
            }
            Propagator::HitByHit { law, courses, time_s, .. } => {
                let happened = law.fly(courses, &mut self.particles, time);
                self.wall.book(&happened.wall);
                self.ledger.book(&happened);
                *time_s = time;
            }
            Propagator::Colliding { discs, .. } => {
                return discs.collide_until(time, at_most, &mut self.wall, &mut self.particles);
            }
            Propagator::Stepped { .. } | Propagator::Literal { .. } => {}
        }
        true
    }

    /// So many steps, cut where a temperature is to be set.
    fn walk_by_schedule(&mut self, steps: u64) -> Result<(), SimulationFault> {
        let (Propagator::Stepped { clock, .. } | Propagator::Literal { clock, .. }) =
            &self.propagator
        else {
            return Ok(());
        };
        let StepClock { time_step_s, done, .. } = *clock;
        let end = done + steps;
        let mut at = done;
        while let Some([time, temperature_k]) = self.schedule.due(end as f64 * time_step_s) {
            let step = (time / time_step_s + STEP_ROUNDING) as u64;
            let step = if step > at { step } else { at };
            self.walk(step - at);
            at = step;
            self.set_temperature(temperature_k)?;
        }
        self.walk(end - at);
        Ok(())
    }

    /// Reads the wall's tallies off those of the particles.
    fn gather(&mut self) {
        if let Propagator::Stepped { tallies, .. } | Propagator::Literal { tallies, .. } =
            &self.propagator
        {
            self.wall.gather(tallies, &self.substance.mass_ratios);
        }
    }

    /// So many steps of all particles.
    fn walk(&mut self, steps: u64) {
        let Container { center_m, circle: Circle { radius, .. } } = self.container;
        match &mut self.propagator {
            Propagator::Exact(_) | Propagator::HitByHit { .. } | Propagator::Colliding { .. } => {}
            Propagator::Stepped { clock, tallies } => {
                stepped::walk(&mut self.particles, tallies, radius, clock.time_step_s, steps);
                clock.done += steps;
            }
            Propagator::Literal { clock, tallies, frozen } => {
                for (id, (tally, frozen)) in tallies.iter_mut().zip(frozen).enumerate() {
                    let mut particle = self.particles.get(id);
                    for _ in 0..steps {
                        if *frozen {
                            break;
                        }
                        let dt = clock.time_step_s;
                        let flight = literal::step_as_printed(particle, center_m, radius, dt);
                        *frozen = !is_finite(&flight);
                        if !*frozen {
                            particle = flight.particle;
                            tally.book(&flight);
                        }
                    }
                    self.particles.set(id, particle);
                }
                clock.done += steps;
            }
        }
    }
}

fn is_finite(flight: &Flight) -> bool {
    let Particle { position, velocity } = flight.particle;
    position.iter().chain(&velocity).all(|component| component.is_finite())
}
