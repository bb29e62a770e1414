//! The integrators of the orbit model, and the properties from which laws, estimates and plots follow.

use crate::value::words;

words! {
    /// Time-stepping scheme of the orbit.
    #[derive(PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
    pub enum OrbitIntegrator {
        /// The orbit exercise's equations (15) and (16).
        ExplicitEuler = "explicit-euler",
        /// Kick, then drift.
        SemiImplicitEuler = "semi-implicit-euler",
        /// Half kick, drift, half kick.
        VelocityVerlet = "velocity-verlet",
        /// The classical fourth-order Runge–Kutta method.
        Rk4 = "rk4",
        /// Yoshida's fourth-order symplectic composition.
        Yoshida4 = "yoshida4",
        /// Dormand and Prince's method of order 8 with adaptive steps.
        Dop853 = "dop853",
        /// The exact solution of the two-body problem.
        Kepler = "kepler",
    }
}

/// What an integrator does to errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntegratorProperties {
    /// How its errors depend on the time step.
    pub steps: IntegratorSteps,
    /// Whether the angular momentum of a body around the Sun stays constant: kicks along r and drifts along v keep r × v, and the errors of
    /// exact and adaptive steps are those of rounding.
    pub conserves_angular_momentum: bool,
}

/// How the errors of an integrator depend on the time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IntegratorSteps {
    /// Errors are proportional to powers of a fixed time step.
    Fixed {
        /// Order of the position error.
        position_order: f64,
        /// Order of the energy error.
        energy_order: f64,
    },
    /// The method chooses its steps, so that its errors are dominated by rounding.
    Adaptive,
    /// The exact solution, without steps.
    Exact,
}

impl OrbitIntegrator {
    /// The properties of the integrator.
    #[must_use]
    pub const fn properties(self) -> IntegratorProperties {
        match self {
            Self::ExplicitEuler => of_order(1.0, false),
            Self::SemiImplicitEuler => of_order(1.0, true),
            Self::VelocityVerlet => of_order(2.0, true),
            Self::Rk4 => {
                // The error of order 4 only shifts the phase of a nearly circular orbit.
                let steps = IntegratorSteps::Fixed { position_order: 4.0, energy_order: 5.0 };
                IntegratorProperties { steps, conserves_angular_momentum: false }
            }
            Self::Yoshida4 => of_order(4.0, true),
            Self::Dop853 => without_order(IntegratorSteps::Adaptive),
            Self::Kepler => without_order(IntegratorSteps::Exact),
        }
    }
}

/// A method whose position and energy errors have the same order.
const fn of_order(order: f64, conserves_angular_momentum: bool) -> IntegratorProperties {
    let steps = IntegratorSteps::Fixed { position_order: order, energy_order: order };
    IntegratorProperties { steps, conserves_angular_momentum }
}

/// A method whose errors are those of rounding.
const fn without_order(steps: IntegratorSteps) -> IntegratorProperties {
    IntegratorProperties { steps, conserves_angular_momentum: true }
}
