//! The equation of motion of the oscillator and its integrator.

use serde::{Deserialize, Serialize};

/// Position, m, and velocity, m/s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct State {
    pub(super) position: f64,
    pub(super) velocity: f64,
}

/// Acceleration of a body on a spring, m/s^2: a = -omega^2 x (Hooke's law).
pub(super) fn acceleration(position: f64, angular_frequency: f64) -> f64 {
    -angular_frequency * angular_frequency * position
}

/// One step of semi-implicit Euler: v' = v + a(x) dt, x' = x + v' dt.
pub(super) fn step(state: State, angular_frequency: f64, step: f64) -> State {
    let velocity = state.velocity + acceleration(state.position, angular_frequency) * step;
    State { position: state.position + velocity * step, velocity }
}

/// Energy per unit mass, J/kg: v^2/2 + omega^2 x^2/2.
pub(super) fn specific_energy(state: State, angular_frequency: f64) -> f64 {
    let potential = angular_frequency * state.position;
    0.5 * (state.velocity * state.velocity + potential * potential)
}
