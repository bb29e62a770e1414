//! `[model.orbit]`: the Earth around the Sun, in AU and days.

use crate::quantity::{Finite, Positive};

/// All physics of an orbit run. The Sun is fixed at the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct OrbitConfig {
    /// Where the Earth is and how it moves at the start.
    pub start: OrbitStart,
    /// How the equation of motion is discretised.
    pub integrator: OrbitIntegrator,
    /// Time step, days; below one day, by the source document.
    pub time_step_days: Positive,
    /// Simulated time, days.
    pub duration_days: Positive,
}

/// State at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OrbitStart {
    /// As printed in the source document: relative to the solar system's barycentre, 2013-01-01.
    Document,
    /// The same day relative to the Sun.
    Heliocentric,
    /// Written out; the position is not zero.
    Given {
        /// Position, AU.
        position_au: [Finite; 3],
        /// Velocity, AU/day.
        velocity_au_per_day: [Finite; 3],
    },
}

/// Time-stepping scheme of the orbit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum OrbitIntegrator {
    /// The source document's equations (15) and (16).
    ExplicitEuler,
    /// Kick, then drift.
    SemiImplicitEuler,
    /// Half kick, drift, half kick.
    VelocityVerlet,
    /// The classical fourth-order Runge–Kutta method.
    Rk4,
    /// Yoshida's fourth-order symplectic composition.
    Yoshida4,
    /// The exact solution of the two-body problem.
    Kepler,
}

impl Default for OrbitConfig {
    /// The document's start and method, a quarter of a day a step, one Julian year.
    fn default() -> Self {
        Self {
            start: OrbitStart::Document,
            integrator: OrbitIntegrator::ExplicitEuler,
            time_step_days: const { Positive::literal(0.25) },
            duration_days: const { Positive::literal(365.25) },
        }
    }
}
