//! How the equation of motion is discretised: one step of length h (days) of each method.
//!
//! The order of the operations is part of the results' bits. Nothing is fused.

use super::motion::{State, acceleration_over_position, add_scaled, scaled};
use kinetoscope_manifest::model::OrbitIntegrator;
use serde::{Deserialize, Serialize};

/// The method by which the body is moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Integrator {
    /// [`explicit_euler`].
    ExplicitEuler,
    /// [`SEMI_IMPLICIT_EULER`].
    SemiImplicitEuler,
    /// [`VELOCITY_VERLET`].
    VelocityVerlet,
    /// [`runge_kutta_4`].
    Rk4,
    /// [`YOSHIDA_4`].
    Yoshida4,
    /// No steps: the exact solution, `super::kepler`.
    Kepler,
}

impl Integrator {
    /// The name in the manifest.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::ExplicitEuler => "explicit-euler",
            Self::SemiImplicitEuler => "semi-implicit-euler",
            Self::VelocityVerlet => "velocity-verlet",
            Self::Rk4 => "rk4",
            Self::Yoshida4 => "yoshida4",
            Self::Kepler => "kepler",
        }
    }
}

impl From<OrbitIntegrator> for Integrator {
    fn from(integrator: OrbitIntegrator) -> Self {
        match integrator {
            OrbitIntegrator::ExplicitEuler => Self::ExplicitEuler,
            OrbitIntegrator::SemiImplicitEuler => Self::SemiImplicitEuler,
            OrbitIntegrator::VelocityVerlet => Self::VelocityVerlet,
            OrbitIntegrator::Rk4 => Self::Rk4,
            OrbitIntegrator::Yoshida4 => Self::Yoshida4,
            OrbitIntegrator::Kepler => Self::Kepler,
        }
    }
}

/// One exact half of the motion, for a share of the step; a symplectic method is a list of these.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Substep {
    /// v += a(r) w h.
    Kick(f64),
    /// r += v w h.
    Drift(f64),
}
use Substep::{Drift, Kick};

/// Symplectic Euler, order 1: v(n+1) = v(n) + a(r(n)) h, r(n+1) = r(n) + v(n+1) h.
pub const SEMI_IMPLICIT_EULER: [Substep; 2] = [Kick(1.0), Drift(1.0)];

/// Velocity Verlet, order 2 (Swope et al. 1982): half kick, drift, half kick. Symplectic and reversible in time.
pub const VELOCITY_VERLET: [Substep; 3] = [Kick(0.5), Drift(1.0), Kick(0.5)];

/// Yoshida's fourth-order symplectic method (Phys. Lett. A 150, 262, 1990, equations 2.11 and 2.12): Verlet steps of
/// w1 h, w0 h and w1 h.
pub const YOSHIDA_4: [Substep; 9] = [
    Kick(0.5 * YOSHIDA_W1),
    Drift(YOSHIDA_W1),
    Kick(0.5 * YOSHIDA_W1),
    Kick(0.5 * YOSHIDA_W0),
    Drift(YOSHIDA_W0),
    Kick(0.5 * YOSHIDA_W0),
    Kick(0.5 * YOSHIDA_W1),
    Drift(YOSHIDA_W1),
    Kick(0.5 * YOSHIDA_W1),
];
/// w1 = 1 / (2 - 2^(1/3)).
const YOSHIDA_W1: f64 = 1.0 / (2.0 - CUBE_ROOT_OF_2);
/// w0 = -2^(1/3) / (2 - 2^(1/3)), so that 2 w1 + w0 = 1 and 2 w1^3 + w0^3 = 0.
const YOSHIDA_W0: f64 = -CUBE_ROOT_OF_2 / (2.0 - CUBE_ROOT_OF_2);
const CUBE_ROOT_OF_2: f64 = 1.259_921_049_894_873_2;

/// One step of a composition of kicks and drifts.
#[inline]
#[must_use]
pub fn composed(substeps: &[Substep], start: State, h: f64) -> State {
    let State { mut position, mut velocity } = start;
    for &substep in substeps {
        match substep {
            Kick(share) => {
                let acceleration = acceleration(position);
                velocity = add_scaled(velocity, acceleration, share * h);
            }
            Drift(share) => position = add_scaled(position, velocity, share * h),
        }
    }
    State { position, velocity }
}

/// The orbit document's method, order 1: r(n+1) = r(n) + v(n) h (equation 15), v(n+1) = v(n) + a(r(n)) h (equation 16).
#[inline]
#[must_use]
pub fn explicit_euler(start: State, h: f64) -> State {
    let State { position, velocity } = start;
    State {
        position: add_scaled(position, velocity, h),
        velocity: add_scaled(velocity, acceleration(position), h),
    }
}

/// The classical Runge–Kutta method, order 4 (Kutta 1901):
/// y(n+1) = y(n) + (h/6) (k1 + 2 k2 + 2 k3 + k4) for y = (r, v), y' = (v, a(r)).
#[inline]
#[must_use]
pub fn runge_kutta_4(start: State, h: f64) -> State {
    let first = rate(start);
    let second = rate(moved(start, first, h / 2.0));
    let third = rate(moved(start, second, h / 2.0));
    let fourth = rate(moved(start, third, h));
    let total = |k1: [f64; 3], k2: [f64; 3], k3: [f64; 3], k4: [f64; 3]| {
        std::array::from_fn(|axis| k1[axis] + 2.0 * k2[axis] + 2.0 * k3[axis] + k4[axis])
    };
    let sum = State {
        position: total(first.position, second.position, third.position, fourth.position),
        velocity: total(first.velocity, second.velocity, third.velocity, fourth.velocity),
    };
    moved(start, sum, h / 6.0)
}

/// a(r), AU/day^2.
fn acceleration(position: [f64; 3]) -> [f64; 3] {
    scaled(position, acceleration_over_position(position))
}

/// (v, a(r)): what position and velocity change by in a day.
fn rate(state: State) -> State {
    State { position: state.velocity, velocity: acceleration(state.position) }
}

/// y + y' h.
fn moved(state: State, rate: State, h: f64) -> State {
    State {
        position: add_scaled(state.position, rate.position, h),
        velocity: add_scaled(state.velocity, rate.velocity, h),
    }
}
