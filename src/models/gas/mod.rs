//! Point particles in a circular container: the gas document's exercise 14g1.
//!
//! N points of mass m fly in a circle of radius r without meeting one another; the wall mirrors them. `motion.rs` holds the law of
//! motion, `exact.rs` jumps along it, `stepped.rs` walks it, `literal.rs` keeps the document's scheme as printed;
//! `pressure.rs` holds the gas laws.
//!
//! Without collisions every speed and every angular momentum stays for ever: the speeds never become Maxwell's.

mod exact;
mod limits;
pub mod literal;
pub mod motion;
mod observe;
pub mod pressure;
pub mod speeds;
mod start;
pub mod stepped;
mod wall;

use self::exact::ExactClock;
use self::motion::{Flight, Particle};
use self::pressure::{SpeedMean, SpeedMoments};
use self::speeds::SpeedLaw;
use self::wall::WallLedger;
use crate::constants::{BOLTZMANN_CODATA_1986_J_PER_K, BOLTZMANN_SI_2019_J_PER_K};
use crate::model::{Extent, Fault, Model, Progress, Refusal, Target};
use crate::random::Seed;
use kinetoscope_manifest::model::{
    BoltzmannConstant, GasConfig, Propagation, TemperatureDefinition,
};
use kinetoscope_recording::channels::{
    ChannelDeclaration, GasCollisions, GasInvariants, GasPressure, GasSpeeds, GasTemperature,
};
use kinetoscope_recording::frame::{Frame, StateColumn};
use kinetoscope_recording::scenery::Scenery;
use serde::{Deserialize, Serialize};

/// N = floor(T / dt + this): a duration that is a whole number of steps but for rounding has all of them.
const STEP_ROUNDING: f64 = 1e-9;

/// A gas in its container, at one time. Particles stand relative to the centre, so that a centre far away costs no digits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gas {
    container: Container,
    substance: Substance,
    speed_law: SpeedLaw,
    /// Upper end of the speeds shown, m/s.
    speed_range_top: f64,
    /// The particles at time 0.
    start: Vec<Particle>,
    /// The particles now, in the order of their ids.
    particles: Vec<Particle>,
    propagator: Propagator,
    wall: WallLedger,
    /// Particles outside the wall at the last frame.
    outside_at_last_frame: u64,
    /// Whether the last target was reached: the next call opens a window.
    reached: bool,
}

/// The circle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Container {
    centre_m: [f64; 2],
    radius_m: f64,
}

/// What the particles are made of, and what their temperature means.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Substance {
    mass_kg: f64,
    boltzmann_j_per_k: f64,
    definition: SpeedMean,
}

/// How particles are moved, and how far they are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum Propagator {
    /// Closed form, any time.
    Exact(ExactClock),
    /// The document's steps, mended.
    Stepped(StepClock),
    /// The document's steps as printed.
    Literal {
        clock: StepClock,
        /// Particles that a 0/0 lost: they stay as they last were.
        frozen: Vec<bool>,
    },
}

/// Steps of one length.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct StepClock {
    time_step_s: f64,
    total: u64,
    done: u64,
}

impl StepClock {
    fn new(duration_s: f64, time_step_s: f64) -> Self {
        let total = (duration_s / time_step_s + STEP_ROUNDING) as u64;
        Self { time_step_s, total, done: 0 }
    }

    /// Time after the steps done, s: a product, never a sum.
    fn time_s(&self) -> f64 {
        self.done as f64 * self.time_step_s
    }

    /// The count that a target stands for; a time between two steps is the earlier one.
    fn count_of(&self, target: Target) -> u64 {
        match target {
            Target::Count(count) => count,
            Target::Time(time) => (time / self.time_step_s + STEP_ROUNDING) as u64,
        }
    }
}

impl Model for Gas {
    type Config = GasConfig;
    const NAME: &'static str = "gas";
    const PHYSICS_VERSION: u32 = 1;
    const TIME_UNIT: &'static str = "s";
    const STATE_COLUMNS: &'static [StateColumn] = &[
        StateColumn { name: "x", unit: "m" },
        StateColumn { name: "y", unit: "m" },
        StateColumn { name: "vx", unit: "m/s" },
        StateColumn { name: "vy", unit: "m/s" },
    ];
    const CHANNELS: &'static [ChannelDeclaration] = &[
        ChannelDeclaration::of::<GasPressure>(),
        ChannelDeclaration::of::<GasTemperature>(),
        ChannelDeclaration::of::<GasInvariants>(),
        ChannelDeclaration::of::<GasCollisions>(),
        ChannelDeclaration::of::<GasSpeeds>(),
    ];

    /// Places and speeds are drawn from their own streams. A gas has no series of single collisions: `per_collision` changes nothing.
    fn prepare(config: &GasConfig, seed: Seed, _per_collision: bool) -> Result<Self, Refusal> {
        let substance = Substance {
            mass_kg: config.mass_kg.get(),
            boltzmann_j_per_k: match config.boltzmann_constant {
                BoltzmannConstant::Codata1986 => BOLTZMANN_CODATA_1986_J_PER_K,
                BoltzmannConstant::Si2019 => BOLTZMANN_SI_2019_J_PER_K,
            },
            definition: match config.temperature_definition {
                TemperatureDefinition::MeanSpeed => SpeedMean::MeanSpeed,
                TemperatureDefinition::MeanSquare => SpeedMean::MeanSquare,
            },
        };
        let start = start::start(config, seed, substance.definition, substance.boltzmann_j_per_k)?;
        limits::check(config, &start.particles)?;
        let rms_speed = SpeedMoments::of(&start.particles).mean_square.sqrt();
        let duration_s = config.duration_s.get();
        Ok(Self {
            container: Container {
                centre_m: config.centre_m.map(|axis| axis.get()),
                radius_m: config.radius_m.get(),
            },
            substance,
            speed_law: start.speed_law,
            speed_range_top: start.speed_law.range_top(rms_speed),
            propagator: match config.propagation {
                Propagation::Exact => {
                    Propagator::Exact(ExactClock::new(duration_s, start.particles.len()))
                }
                Propagation::Stepped { time_step_s } => {
                    Propagator::Stepped(StepClock::new(duration_s, time_step_s.get()))
                }
                Propagation::Literal { time_step_s } => Propagator::Literal {
                    clock: StepClock::new(duration_s, time_step_s.get()),
                    frozen: vec![false; start.particles.len()],
                },
            },
            particles: start.particles.clone(),
            start: start.particles,
            wall: WallLedger::default(),
            outside_at_last_frame: 0,
            reached: true,
        })
    }

    fn extent(&self) -> Extent {
        match &self.propagator {
            Propagator::Exact(clock) => Extent::Time(clock.duration_s),
            Propagator::Stepped(clock) | Propagator::Literal { clock, .. } => {
                Extent::Steps { total: clock.total, step: clock.time_step_s }
            }
        }
    }

    /// Exact propagation reaches a time in one call, whatever the budget.
    fn advance(&mut self, target: Target, at_most: u64) -> Result<Progress, Fault> {
        if self.reached {
            self.wall.open_window(self.time());
            self.outside_at_last_frame = self.particles_outside();
        }
        self.reached = match &self.propagator {
            Propagator::Exact(_) => self.jump(target)?,
            Propagator::Stepped(clock) | Propagator::Literal { clock, .. } => {
                let (wanted, done) = (clock.count_of(target), clock.done);
                let Some(missing) = wanted.checked_sub(done) else {
                    return Err(Fault(format!(
                        "step {wanted} was asked for after step {done}: frames must come in the order of time"
                    )));
                };
                for _ in 0..missing.min(at_most) {
                    self.step();
                }
                missing <= at_most
            }
        };
        Ok(if self.reached { Progress::Reached } else { Progress::Working })
    }

    /// Steps done; in exact propagation hits of the wall.
    fn count(&self) -> u64 {
        match &self.propagator {
            Propagator::Exact(_) => self.wall.total.hits,
            Propagator::Stepped(clock) | Propagator::Literal { clock, .. } => clock.done,
        }
    }

    fn time(&self) -> f64 {
        match &self.propagator {
            Propagator::Exact(clock) => clock.time_s,
            Propagator::Stepped(clock) | Propagator::Literal { clock, .. } => clock.time_s(),
        }
    }

    fn observe(&self, frame: &mut Frame) {
        self.fill(frame);
    }

    fn scenery(&self) -> Scenery {
        self.draw()
    }
}

impl Gas {
    /// Exact propagation to a target, which must be a time.
    fn jump(&mut self, target: Target) -> Result<bool, Fault> {
        let Propagator::Exact(clock) = &mut self.propagator else { return Ok(true) };
        let time = match target {
            Target::Time(time) if time >= clock.time_s => time,
            Target::Time(time) => {
                return Err(Fault(format!(
                    "{time} s was asked for after {} s: frames must come in the order of time",
                    clock.time_s
                )));
            }
            Target::Count(_) => {
                return Err(Fault(
                    "exact propagation counts no steps: ask for frames by time".to_owned(),
                ));
            }
        };
        let radius = self.container.radius_m;
        clock.jump_to(time, &self.start, radius, &mut self.particles, &mut self.wall);
        Ok(true)
    }

    /// One step of all particles, in the order of their ids.
    fn step(&mut self) {
        let Container { centre_m, radius_m } = self.container;
        match &mut self.propagator {
            Propagator::Exact(_) => {}
            Propagator::Stepped(clock) => {
                for particle in &mut self.particles {
                    let flight = stepped::step(*particle, radius_m, clock.time_step_s);
                    *particle = flight.particle;
                    self.wall.book(&flight);
                }
                clock.done += 1;
            }
            Propagator::Literal { clock, frozen } => {
                for (particle, frozen) in self.particles.iter_mut().zip(frozen) {
                    if *frozen {
                        continue;
                    }
                    let dt = clock.time_step_s;
                    let flight = literal::step_as_printed(*particle, centre_m, radius_m, dt);
                    if is_finite(&flight) {
                        *particle = flight.particle;
                        self.wall.book(&flight);
                    } else {
                        *frozen = true;
                    }
                }
                clock.done += 1;
            }
        }
    }
}

fn is_finite(flight: &Flight) -> bool {
    let Particle { position, velocity } = flight.particle;
    position.iter().chain(&velocity).all(|component| component.is_finite())
}
