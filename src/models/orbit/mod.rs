//! The Earth around the Sun: a body without mass of its own about a Sun fixed at the origin, in three dimensions, AU and days.
//!
//! `motion` is the equation of motion, `step` how it is discretised, `kepler` the truth to compare with.

pub mod elements;
mod forecast;
pub mod kepler;
pub mod motion;
pub mod phase;
pub mod step;

use crate::model::{Extent, Fault, Model, Progress, Refusal, Target};
use crate::random::Seed;
use elements::Elements;
use kepler::Kepler;
use kinetoscope_manifest::model::{OrbitConfig, OrbitStart};
use kinetoscope_recording::channels::{ChannelDeclaration, OrbitElements, OrbitEnergy};
use kinetoscope_recording::frame::{Frame, Level, StateColumn};
use kinetoscope_recording::scenery::{DrawnRadius, Scenery, Wall};
use motion::{State, energy, kinetic_energy, length, potential_energy};
use phase::Plane;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use step::{Integrator, composed, explicit_euler, runge_kutta_4};

/// The start as the document prints it. It says "from the Sun's centre", but the numbers are the Earth's place relative to
/// the barycentre of the solar system (2013-01-01 0h, ecliptic of J2000), so that the orbit's period is 362.073 days.
pub const DOCUMENT_START: State = State {
    position: [-1.813_068_419_866_209e-1, 9.642_197_733_507_97e-1, -6.850_809_238_551_276e-5],
    velocity: [-1.718_334_419_397_708e-2, -3.209_800_047_122_614e-3, 6.736_104_268_755_766e-9],
};

/// The Earth of the same instant relative to the Sun (ecliptic of J2000, from an ephemeris): period 364.898 days.
pub const HELIOCENTRIC_START: State = State {
    position: [-0.180_022_557_728, 0.966_674_933_247, -2.644_611e-5],
    velocity: [-0.017_189_490_082_1, -0.003_208_481_984_12, 1.372_135e-7],
};

/// Drawn radius of the Sun, AU; its true one, 0.00465 AU, could hardly be seen.
const DRAWN_SUN_AU: f64 = 0.05;

/// Sine of the angle between position and velocity below which the motion counts as radial.
const RADIAL: f64 = 1e-12;

/// One run, at one instant. See the module.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Orbit {
    start: Start,
    integrator: Integrator,
    /// h, days.
    step: f64,
    total_steps: u64,
    exact: Kepler,
    plane: Plane,
    count: u64,
    state: State,
    /// Whole turns to add to the angle in the plane: followed step by step, so that looking does not change it.
    turns: i64,
}

/// Which start the manifest asked for; the log says what it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Start {
    Document,
    Heliocentric,
    Given,
}

impl Model for Orbit {
    type Config = OrbitConfig;
    const NAME: &'static str = "orbit";
    const PHYSICS_VERSION: u32 = 1;
    const TIME_UNIT: &'static str = "d";
    const STATE_COLUMNS: &'static [StateColumn] = &[
        StateColumn { name: "x", unit: "AU" },
        StateColumn { name: "y", unit: "AU" },
        StateColumn { name: "z", unit: "AU" },
        StateColumn { name: "vx", unit: "AU/d" },
        StateColumn { name: "vy", unit: "AU/d" },
        StateColumn { name: "vz", unit: "AU/d" },
    ];
    const CHANNELS: &'static [ChannelDeclaration] =
        &[ChannelDeclaration::of::<OrbitEnergy>(), ChannelDeclaration::of::<OrbitElements>()];

    /// Nothing here is random and no series is opt-in: `seed` and `per_collision` have no effect.
    fn prepare(config: &OrbitConfig, _seed: Seed, _per_collision: bool) -> Result<Self, Refusal> {
        let (start, state) = match config.start {
            OrbitStart::Document => (Start::Document, DOCUMENT_START),
            OrbitStart::Heliocentric => (Start::Heliocentric, HELIOCENTRIC_START),
            OrbitStart::Given { position_au, velocity_au_per_day } => {
                let position = position_au.map(|component| component.get());
                let velocity = velocity_au_per_day.map(|component| component.get());
                (Start::Given, State { position, velocity })
            }
        };
        check_start(state)?;
        let step = config.time_step_days.get();
        let duration = config.duration_days.get();
        let total_steps = whole_steps(duration, step);
        if total_steps == 0 {
            return Err(Refusal(format!(
                "time_step_days = {step} is longer than duration_days = {duration}: there is no step to do. \
                 Make the time step smaller or the duration longer."
            )));
        }
        Ok(Self {
            start,
            integrator: config.integrator.into(),
            step,
            total_steps,
            exact: Kepler::from_start(state),
            plane: Plane::of(state),
            count: 0,
            state,
            turns: 0,
        })
    }

    fn extent(&self) -> Extent {
        Extent::Steps { total: self.total_steps, step: self.step }
    }

    fn advance(&mut self, target: Target, at_most: u64) -> Result<Progress, Fault> {
        let goal = match target {
            Target::Count(count) => count,
            Target::Time(time) => whole_steps(time, self.step),
        };
        let steps = goal.saturating_sub(self.count).min(at_most);
        match self.integrator {
            Integrator::ExplicitEuler => self.walk(steps, explicit_euler),
            Integrator::SemiImplicitEuler => {
                self.walk(steps, |state, h| composed(&step::SEMI_IMPLICIT_EULER, state, h))
            }
            Integrator::VelocityVerlet => {
                self.walk(steps, |state, h| composed(&step::VELOCITY_VERLET, state, h))
            }
            Integrator::Rk4 => self.walk(steps, runge_kutta_4),
            Integrator::Yoshida4 => {
                self.walk(steps, |state, h| composed(&step::YOSHIDA_4, state, h))
            }
            Integrator::Kepler => self.leap(steps),
        }?;
        Ok(if self.count >= goal { Progress::Reached } else { Progress::Working })
    }

    fn count(&self) -> u64 {
        self.count
    }

    fn time(&self) -> f64 {
        self.time_at(self.count)
    }

    fn observe(&self, frame: &mut Frame) {
        let State { position: [x, y, z], velocity: [vx, vy, vz] } = self.state;
        frame.push_state(&[x, y, z, vx, vy, vz]);
        frame.push(&self.energy_message());
        frame.push(&self.elements_message());
        if self.count == 0 {
            self.announce(frame);
        }
    }

    fn scenery(&self) -> Scenery {
        let duration = self.time_at(self.total_steps);
        let reach = forecast::reach(&self.exact, self.integrator, self.step, duration);
        Scenery {
            walls: vec![Wall::Body { centre: [0.0, 0.0], radius: DRAWN_SUN_AU }],
            view: [[-reach, -reach], [reach, reach]],
            drawn_radius: DrawnRadius::Fixed(0.02 * (2.0 * reach)),
            speed_range_top: 1.5 * length(self.exact.start().velocity),
            speed_unit: "AU/d",
            arrows: true,
            force_range_top: None,
            trail: true,
        }
    }
}

impl Orbit {
    /// So many steps of a method. A step that leads to no number is not taken.
    fn walk(&mut self, steps: u64, method: impl Fn(State, f64) -> State) -> Result<(), Fault> {
        for _ in 0..steps {
            let next = method(self.state, self.step);
            if !next.is_finite() {
                return Err(self.lost());
            }
            self.turns += self.plane.turns_between(self.state.position, next.position);
            self.state = next;
            self.count += 1;
        }
        Ok(())
    }

    /// The exact solution so many steps later, from the start and in one go.
    fn leap(&mut self, steps: u64) -> Result<(), Fault> {
        let point = self.exact.at(self.time_at(self.count + steps));
        if !point.state.is_finite() {
            return Err(self.lost());
        }
        self.state = point.state;
        self.count += steps;
        let beyond = point.angle - self.plane.angle(point.state.position);
        self.turns = point.turns + (beyond / TAU + 0.5).floor() as i64;
        Ok(())
    }

    fn lost(&self) -> Fault {
        Fault(format!(
            "the step after {} d gives no finite position: the body passed too near the Sun for steps of {} d. \
             Take a smaller time_step_days, or integrator = \"kepler\".",
            self.time(),
            self.step
        ))
    }

    fn time_at(&self, count: u64) -> f64 {
        count as f64 * self.step
    }

    fn energy_message(&self) -> OrbitEnergy {
        let start = energy(self.exact.start());
        let total = energy(self.state);
        OrbitEnergy {
            kinetic_au2_per_day2: kinetic_energy(self.state.velocity),
            potential_au2_per_day2: potential_energy(self.state.position),
            total_au2_per_day2: total,
            drift_ppm: (total - start) / start.abs() * 1e6,
        }
    }

    fn elements_message(&self) -> OrbitElements {
        let now = Elements::of(self.state);
        let start = Elements::of(self.exact.start());
        let exact = self.exact.at(self.time());
        let angle = self.plane.angle(self.state.position);
        let error = motion::add_scaled(self.state.position, exact.state.position, -1.0);
        OrbitElements {
            radius_au: length(self.state.position),
            semi_major_axis_au: now.semi_major_axis,
            eccentricity: now.eccentricity,
            angular_momentum_au2_per_day: now.angular_momentum,
            angular_momentum_drift_ppm: (now.angular_momentum - start.angular_momentum)
                / start.angular_momentum
                * 1e6,
            position_error_au: length(error),
            // Whole turns first: their difference is exact.
            phase_error_rad: (self.turns - exact.turns) as f64 * TAU + (angle - exact.angle),
            revolutions: self.turns as f64 + angle / TAU,
        }
    }

    /// The log of the start: what is run, and what to expect of it.
    fn announce(&self, frame: &mut Frame) {
        let elements = Elements::of(self.exact.start());
        frame.log(
            Level::Info,
            format!(
                "integrator {}, time step {} d, {} steps, {} d in all",
                self.integrator.name(),
                self.step,
                self.total_steps,
                self.time_at(self.total_steps)
            ),
        );
        let orbit = match elements.bound {
            Some(bound) => format!(
                "a = {:.5} AU, e = {:.5}, period {:.3} d",
                elements.semi_major_axis, elements.eccentricity, bound.period
            ),
            None => format!(
                "an open path, e = {:.5}, perihelion {:.5} AU",
                elements.eccentricity, elements.perihelion
            ),
        };
        let origin = match self.start {
            Start::Document => {
                "\"document\": as printed in exercise 14to4. These numbers are relative to the barycentre of the solar \
                 system (2013-01-01), not to the Sun, so the period is no year; start = \"heliocentric\" gives the \
                 same day relative to the Sun (a = 0.99935 AU, period 364.898 d)"
            }
            Start::Heliocentric => "\"heliocentric\": the Earth relative to the Sun, 2013-01-01",
            Start::Given => "given in the manifest",
        };
        frame.log(Level::Info, format!("start {origin}; {orbit}"));
        if let (Integrator::ExplicitEuler, Some(bound)) = (self.integrator, elements.bound) {
            let gain =
                forecast::euler_energy_gain_per_revolution(&elements, bound.period, self.step);
            frame.log(
                Level::Info,
                format!(
                    "explicit Euler adds energy at every step, at first {:.3} % of it a revolution: the orbit widens. \
                     \"semi-implicit-euler\" costs the same and does not drift",
                    100.0 * gain
                ),
            );
        }
        if self.step >= 1.0 {
            frame.log(
                Level::Warning,
                format!("time step {} d: the document asks for less than 1 d", self.step),
            );
        }
    }
}

/// N = floor(T / h + 1e-9): a duration that is a multiple of the step but for rounding is run in full.
fn whole_steps(duration: f64, step: f64) -> u64 {
    (duration / step + 1e-9).floor() as u64
}

/// Refuses a start that leads through the Sun or beyond what floating point can hold.
fn check_start(start: State) -> Result<(), Refusal> {
    let distance = length(start.position);
    let speed = length(start.velocity);
    let elements = Elements::of(start);
    if !motion::acceleration_over_position(start.position).is_normal()
        || !elements.energy.is_finite()
    {
        return Err(Refusal(format!(
            "start: at a distance of {distance} AU and a speed of {speed} AU/day the equation of motion overflows. \
             Give a position away from the Sun (the origin), in AU, and a velocity in AU/day."
        )));
    }
    if elements.angular_momentum <= RADIAL * distance * speed {
        return Err(Refusal(
            "start: the velocity is zero or points along the position, so the path is a straight line through the Sun. \
             Give velocity_au_per_day a part across position_au; a circle needs sqrt(GM / r), 0.0172 AU/day at 1 AU."
                .to_owned(),
        ));
    }
    if elements.energy == 0.0 {
        return Err(Refusal(
            "start: the energy is exactly zero (a parabola), so its drift has nothing to be compared with. \
             Change the last digit of the velocity."
                .to_owned(),
        ));
    }
    Ok(())
}
