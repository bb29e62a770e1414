//! Orbit of the Earth around the Sun: a body of negligible mass around a Sun fixed at the origin, in three dimensions, in AU and days.
//! As an extension, several bodies that attract one another.
//!
//! `motion.rs` holds the equations of motion, `integrators.rs` the coefficients of the integrators, `single_step.rs` their application,
//! and `kepler.rs` the exact solution for comparison.

mod adaptive;
mod bodies;
pub mod dormand_prince;
pub mod elements;
mod encounters;
mod estimates;
mod guides;
pub mod integrators;
pub mod kepler;
pub mod motion;
pub mod orbital_plane;
mod path;
mod planet;
pub mod single_step;
mod starts;
mod trajectory;
mod twin;

pub use self::starts::{BARYCENTRIC_START, HELIOCENTRIC_START};

use self::bodies::Bodies;
use self::motion::{Phase, State};
use self::planet::Planet;
use self::trajectory::{Discretization, NotFinite, StepBudget};
use crate::model::{Extent, Model, ModelKind, Progress, SetupError, SimulationFault, Target};
use crate::random::Seed;
use kinetoscope_manifest::model::{MAX_STEPS, OrbitConfig, OrbitIntegrator, OrbitSummation};
use kinetoscope_recording::channels::{
    ChannelDeclaration, Divergence, OrbitClosestApproach, OrbitConserved, OrbitElements,
    OrbitEnergy,
};
use kinetoscope_recording::frame::{Frame, Level, StateColumn};
use kinetoscope_recording::scenery::Scenery;
use serde::{Deserialize, Serialize};

/// One run at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Orbit {
    discretization: Discretization,
    total_steps: u64,
    system: System,
}

/// The bodies that move.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum System {
    Planet(Planet),
    Bodies(Bodies),
}

const KIND: ModelKind = ModelKind {
    name: "orbit",
    physics_version: 5,
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
        ChannelDeclaration::of::<OrbitClosestApproach>(),
        ChannelDeclaration::opt_in::<Divergence>(),
    ],
};

impl Model for Orbit {
    type Config = OrbitConfig;

    fn kind() -> &'static ModelKind {
        &KIND
    }

    /// The model uses no random numbers and has no optional series, so `seed` and `per_collision` have no effect.
    fn prepare(
        config: &OrbitConfig,
        _seed: Seed,
        _per_collision: bool,
    ) -> Result<Self, SetupError> {
        let step = config.time_step_days.get();
        let duration = config.duration_days.get();
        let discretization = Discretization {
            integrator: config.integrator,
            summation: config.summation,
            step,
            tolerance: config.tolerance.get(),
        };
        let system = match &config.bodies {
            Some(bodies) => System::Bodies(Bodies::prepare(bodies, &discretization)?),
            None => System::Planet(Planet::prepare(&config.start, &discretization)?),
        };
        let least = match &system {
            System::Planet(planet) => planet.trajectory.phase.least_step(),
            System::Bodies(bodies) => bodies.trajectory.phase.least_step(),
        };
        check_step(step, duration, least)?;
        Ok(Self { discretization, total_steps: whole_steps(duration, step), system })
    }

    /// The constants are compared with those of a start, which takes no time to build.
    fn is_valid_for(&self, config: &OrbitConfig) -> bool {
        let Ok(start) = Self::prepare(config, Seed { seed: 0, replicate: 0 }, false) else {
            return false;
        };
        let has_its_system = match (&self.system, &start.system) {
            (System::Planet(planet), System::Planet(start)) => planet.is_valid_after(start),
            (System::Bodies(bodies), System::Bodies(start)) => bodies.is_valid_after(start),
            _ => false,
        };
        self.discretization == start.discretization
            && self.total_steps == start.total_steps
            && self.count() <= self.total_steps
            && has_its_system
    }

    fn channels(&self) -> &'static [ChannelDeclaration] {
        match &self.system {
            System::Planet(_) => {
                const {
                    &[
                        ChannelDeclaration::of::<OrbitEnergy>(),
                        ChannelDeclaration::of::<OrbitElements>(),
                    ]
                }
            }
            System::Bodies(_) => {
                const {
                    &[
                        ChannelDeclaration::of::<OrbitEnergy>(),
                        ChannelDeclaration::of::<OrbitConserved>(),
                        ChannelDeclaration::of::<OrbitClosestApproach>(),
                        ChannelDeclaration::opt_in::<Divergence>(),
                    ]
                }
            }
        }
    }

    fn extent(&self) -> Extent {
        Extent::Steps { total: self.total_steps, step: self.discretization.step }
    }

    fn advance(&mut self, target: Target, at_most: u64) -> Result<Progress, SimulationFault> {
        let goal = match target {
            Target::Count(count) => count,
            Target::Time(time) => whole_steps(time, self.discretization.step),
        };
        let attempts = at_most.max(1);
        let steps = goal.saturating_sub(self.count()).min(attempts);
        let budget = StepBudget { steps, attempts };
        let moved = match &mut self.system {
            System::Planet(planet) => planet.advance(&self.discretization, budget),
            System::Bodies(bodies) => bodies.advance(&self.discretization, budget),
        };
        moved.map_err(|NotFinite| self.fault())?;
        Ok(if self.count() >= goal { Progress::Reached } else { Progress::Working })
    }

    fn count(&self) -> u64 {
        match &self.system {
            System::Planet(planet) => planet.trajectory.count,
            System::Bodies(bodies) => bodies.trajectory.count,
        }
    }

    fn time(&self) -> f64 {
        self.discretization.time_at(self.count())
    }

    fn observe(&self, frame: &mut Frame) {
        match &self.system {
            System::Planet(planet) => planet.observe(self.time(), frame),
            System::Bodies(bodies) => bodies.observe(self.time(), frame),
        }
        if self.count() == 0 {
            self.log_start(frame);
        }
        if let System::Bodies(bodies) = &self.system
            && self.count() == self.total_steps
        {
            bodies.log_end(&self.discretization, self.time(), frame);
        }
    }

    fn scenery(&self) -> Scenery {
        match &self.system {
            System::Planet(planet) => {
                planet.scenery(&self.discretization, self.discretization.time_at(self.total_steps))
            }
            System::Bodies(bodies) => bodies.scenery(),
        }
    }
}

impl Orbit {
    /// State of the body around the Sun; `None` for several bodies.
    #[must_use]
    pub fn state(&self) -> Option<State> {
        match &self.system {
            System::Planet(planet) => Some(planet.trajectory.phase),
            System::Bodies(_) => None,
        }
    }

    fn bodies_phase(&self) -> Option<&Phase<Vec<f64>>> {
        match &self.system {
            System::Planet(_) => None,
            System::Bodies(bodies) => Some(&bodies.trajectory.phase),
        }
    }

    /// SimulationFault of a step whose result is not finite.
    fn fault(&self) -> SimulationFault {
        let cause = match self.system {
            System::Planet(_) => "the body passed too close to the Sun",
            System::Bodies(_) => "two bodies came too close to each other",
        };
        let (reason, help) = match (&self.system, self.discretization.integrator) {
            (System::Planet(_), _) => ("", "reduce time_step_days, or set integrator = \"kepler\""),
            (_, OrbitIntegrator::Dop853) => {
                ("; colliding points have no further motion", "reduce duration_days")
            }
            _ => ("", "reduce time_step_days, or set integrator = \"dop853\""),
        };
        let what = format!(
            "the step after {} d gives no finite position: {cause} for steps of {} d{reason}",
            self.time(),
            self.discretization.step
        );
        SimulationFault::new(what, help)
    }

    /// Explains steps of a day or more: any length is allowed, and the error depends on the method.
    fn explanation_of_long_steps(&self) -> String {
        let Discretization { integrator, step, .. } = self.discretization;
        let total = self.discretization.time_at(self.total_steps);
        let grown = match &self.system {
            System::Planet(planet) => planet.grown_by_euler(&self.discretization, total),
            System::Bodies(_) => None,
        };
        let effect = match (integrator, grown) {
            (OrbitIntegrator::ExplicitEuler, Some([before, after])) => format!(
                "explicit Euler adds energy in proportion to the step, so the orbit grows from a = {before:.4} AU to about {after:.4} AU \
                 in {total} d; a shorter step or \"velocity-verlet\" reduces the growth"
            ),
            (OrbitIntegrator::ExplicitEuler, None) => {
                "explicit Euler adds energy in proportion to the step, so orbits grow; \"velocity-verlet\" has no such drift".to_owned()
            }
            (OrbitIntegrator::Dop853 | OrbitIntegrator::Kepler, _) => {
                "its error does not depend on the step".to_owned()
            }
            _ => "halve the step to see its effect on the result".to_owned(),
        };
        format!("time step {step} d: the orbit exercise requires less than 1 d; {effect}")
    }

    /// Describes the run in the log of the first frame.
    fn log_start(&self, frame: &mut Frame) {
        let Discretization { integrator, summation, step, tolerance } = self.discretization;
        let sums = match summation {
            OrbitSummation::Compensated => ", compensated sums",
            OrbitSummation::Plain => "",
        };
        let adaptive = match integrator {
            OrbitIntegrator::Dop853 => {
                format!(" with adaptive steps, tolerance {tolerance:e}")
            }
            _ => String::new(),
        };
        frame.log(
            Level::Info,
            format!(
                "integrator {}{adaptive}{sums}, time step {step} d, {} steps, total {} d",
                integrator.word(),
                self.total_steps,
                self.discretization.time_at(self.total_steps)
            ),
        );
        match &self.system {
            System::Planet(planet) => planet.log_start(&self.discretization, frame),
            System::Bodies(bodies) => bodies.log_start(&self.discretization, frame),
        }
        if step >= 1.0 {
            frame.log(Level::Warning, self.explanation_of_long_steps());
        }
    }
}

/// N = floor(T / h + 1e-9): a duration of N steps is recognized if rounding has made it slightly shorter.
fn whole_steps(duration: f64, step: f64) -> u64 {
    (duration / step + 1e-9).floor() as u64
}

/// Rejects a run without a step, steps that change no position, and more steps than can be counted. `least` is the shortest step, days,
/// that changes a position.
fn check_step(step: f64, duration: f64, least: f64) -> Result<(), SetupError> {
    let countable = duration / MAX_STEPS;
    let shortest = if least > countable { least } else { countable };
    let (what, help) = if duration < least {
        let longer = if step > least { step } else { least };
        (
            format!(
                "duration_days is {duration:e}, in which no position changes by its last digit"
            ),
            format!("increase it to at least {longer:e}, and time_step_days to at least {least:e}"),
        )
    } else if whole_steps(duration, step) == 0 {
        (
            format!("time_step_days is {step:e}, longer than the run"),
            format!(
                "reduce it to at most {duration:e}, or increase duration_days to at least {step:e}"
            ),
        )
    } else if step < shortest {
        let why = if step < least {
            "in which no position changes by its last digit"
        } else {
            "which gives more steps than can be counted"
        };
        (
            format!("time_step_days is {step:e}, {why}"),
            format!("increase it to at least {shortest:e}"),
        )
    } else {
        return Ok(());
    };
    Err(SetupError::new(what, help))
}
