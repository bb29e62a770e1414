//! The Earth around the Sun: a body without mass of its own about a Sun fixed at the origin, in three dimensions, AU and days.
//! As an extension several bodies that attract each other.
//!
//! `motion` is the equation of motion, `tables` the methods, `step` how a table moves bodies, `kepler` the truth to compare with.

mod adaptive;
mod bodies;
pub mod dormand_prince;
pub mod elements;
mod forecast;
pub mod kepler;
pub mod motion;
pub mod phase;
mod planet;
pub mod step;
pub mod tables;
mod track;

use crate::model::{Extent, Model, ModelKind, Progress, SetupError, SimulationFault, Target};
use crate::random::Seed;
use bodies::Bodies;
use kinetoscope_manifest::model::{OrbitConfig, OrbitSummation};
use kinetoscope_recording::channels::{
    ChannelDeclaration, OrbitConserved, OrbitElements, OrbitEnergy,
};
use kinetoscope_recording::frame::{Frame, Level, StateColumn};
use kinetoscope_recording::scenery::Scenery;
use motion::State;
use planet::Planet;
use serde::{Deserialize, Serialize};
use tables::Integrator;
use track::{Lost, Scheme};

/// The start as the document prints it. It says "from the Sun's center", but the numbers are the Earth's place relative to
/// the barycenter of the solar system (2013-01-01 0h, ecliptic of J2000), so that the orbit's period is 362.073 days.
pub const DOCUMENT_START: State = State {
    position: [-1.813_068_419_866_209e-1, 9.642_197_733_507_97e-1, -6.850_809_238_551_276e-5],
    velocity: [-1.718_334_419_397_708e-2, -3.209_800_047_122_614e-3, 6.736_104_268_755_766e-9],
};

/// The Earth of the same instant relative to the Sun (ecliptic of J2000, from an ephemeris): period 364.898 days.
pub const HELIOCENTRIC_START: State = State {
    position: [-0.180_022_557_728, 0.966_674_933_247, -2.644_611e-5],
    velocity: [-0.017_189_490_082_1, -0.003_208_481_984_12, 1.372_135e-7],
};

/// One run, at one instant. See the module.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Orbit {
    scheme: Scheme,
    total_steps: u64,
    moving: Moving,
}

/// What moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum Moving {
    Planet(Planet),
    Bodies(Bodies),
}

const KIND: ModelKind = ModelKind {
    name: "orbit",
    physics_version: 2,
    time_unit: "d",
    state_columns: &[
        StateColumn { name: "x", unit: "AU" },
        StateColumn { name: "y", unit: "AU" },
        StateColumn { name: "z", unit: "AU" },
        StateColumn { name: "vx", unit: "AU/d" },
        StateColumn { name: "vy", unit: "AU/d" },
        StateColumn { name: "vz", unit: "AU/d" },
    ],
    channels: &[
        ChannelDeclaration::of::<OrbitEnergy>(),
        ChannelDeclaration::of::<OrbitElements>(),
        ChannelDeclaration::of::<OrbitConserved>(),
    ],
};

impl Model for Orbit {
    type Config = OrbitConfig;

    fn kind() -> &'static ModelKind {
        &KIND
    }

    /// Nothing here is random and no series is opt-in: `seed` and `per_collision` have no effect.
    fn prepare(
        config: &OrbitConfig,
        _seed: Seed,
        _per_collision: bool,
    ) -> Result<Self, SetupError> {
        let step = config.time_step_days.get();
        let duration = config.duration_days.get();
        let total_steps = whole_steps(duration, step);
        if total_steps == 0 {
            return Err(SetupError(format!(
                "time_step_days = {step} is longer than duration_days = {duration}: there is no step to do. \
                 Make the time step smaller or the duration longer."
            )));
        }
        let scheme = Scheme {
            integrator: config.integrator.into(),
            compensated: config.summation == OrbitSummation::Compensated,
            step,
            tolerance: config.tolerance.get(),
        };
        let moving = match &config.bodies {
            Some(bodies) => Moving::Bodies(Bodies::prepare(bodies, &scheme)?),
            None => Moving::Planet(Planet::prepare(&config.start, &scheme)?),
        };
        Ok(Self { scheme, total_steps, moving })
    }

    fn channels(&self) -> &'static [ChannelDeclaration] {
        match &self.moving {
            Moving::Planet(_) => {
                const {
                    &[
                        ChannelDeclaration::of::<OrbitEnergy>(),
                        ChannelDeclaration::of::<OrbitElements>(),
                    ]
                }
            }
            Moving::Bodies(_) => {
                const {
                    &[
                        ChannelDeclaration::of::<OrbitEnergy>(),
                        ChannelDeclaration::of::<OrbitConserved>(),
                    ]
                }
            }
        }
    }

    fn extent(&self) -> Extent {
        Extent::Steps { total: self.total_steps, step: self.scheme.step }
    }

    fn advance(&mut self, target: Target, at_most: u64) -> Result<Progress, SimulationFault> {
        let goal = match target {
            Target::Count(count) => count,
            Target::Time(time) => whole_steps(time, self.scheme.step),
        };
        let steps = goal.saturating_sub(self.count()).min(at_most);
        let moved = match &mut self.moving {
            Moving::Planet(planet) => planet.advance(&self.scheme, steps),
            Moving::Bodies(bodies) => bodies.advance(&self.scheme, steps),
        };
        moved.map_err(|Lost| self.lost())?;
        Ok(if self.count() >= goal { Progress::Reached } else { Progress::Working })
    }

    fn count(&self) -> u64 {
        match &self.moving {
            Moving::Planet(planet) => planet.track.count,
            Moving::Bodies(bodies) => bodies.track.count,
        }
    }

    fn time(&self) -> f64 {
        self.scheme.time_at(self.count())
    }

    fn observe(&self, frame: &mut Frame) {
        match &self.moving {
            Moving::Planet(planet) => planet.observe(self.time(), frame),
            Moving::Bodies(bodies) => bodies.observe(frame),
        }
        if self.count() == 0 {
            self.announce(frame);
        }
    }

    fn scenery(&self) -> Scenery {
        match &self.moving {
            Moving::Planet(planet) => {
                planet.scenery(&self.scheme, self.scheme.time_at(self.total_steps))
            }
            Moving::Bodies(bodies) => bodies.scenery(),
        }
    }
}

impl Orbit {
    /// Where the one body about the Sun is; `None` of several.
    #[must_use]
    pub fn state(&self) -> Option<State> {
        match &self.moving {
            Moving::Planet(planet) => Some(planet.track.phase),
            Moving::Bodies(_) => None,
        }
    }

    fn lost(&self) -> SimulationFault {
        let what = match self.moving {
            Moving::Planet(_) => "the body passed too near the Sun",
            Moving::Bodies(_) => "two bodies came too near each other",
        };
        let cure = match (&self.moving, self.scheme.integrator) {
            (Moving::Planet(_), _) => "Take a smaller time_step_days, or integrator = \"kepler\".",
            (_, Integrator::DormandPrince8) => {
                "Points that collide have no motion beyond: end the run before."
            }
            _ => "Take a smaller time_step_days, or integrator = \"dormand-prince8\".",
        };
        SimulationFault(format!(
            "the step after {} d gives no finite position: {what} for steps of {} d. {cure}",
            self.time(),
            self.scheme.step
        ))
    }

    /// The log of the start: what is run, and what to expect of it.
    fn announce(&self, frame: &mut Frame) {
        let Scheme { integrator, compensated, step, tolerance } = self.scheme;
        let sums = if compensated { ", compensated sums" } else { "" };
        let own = match integrator {
            Integrator::DormandPrince8 => format!(" in steps of its own, each to {tolerance:e}"),
            _ => String::new(),
        };
        frame.log(
            Level::Info,
            format!(
                "integrator {}{own}{sums}, time step {step} d, {} steps, {} d in all",
                integrator.name(),
                self.total_steps,
                self.scheme.time_at(self.total_steps)
            ),
        );
        match &self.moving {
            Moving::Planet(planet) => planet.announce(&self.scheme, frame),
            Moving::Bodies(bodies) => bodies.announce(frame),
        }
        if step >= 1.0 {
            frame.log(
                Level::Warning,
                format!("time step {step} d: the document asks for less than 1 d"),
            );
        }
    }
}

/// N = floor(T / h + 1e-9): a duration that is a multiple of the step but for rounding is run in full.
fn whole_steps(duration: f64, step: f64) -> u64 {
    (duration / step + 1e-9).floor() as u64
}
