//! Coefficients of the fixed-step integrators, and the list of those that a manifest can name. `single_step.rs` applies them.

use super::single_step::Substep::{Drift, Kick};
use super::single_step::{Method, Splitting, Tableau, row};
use kinetoscope_manifest::model::OrbitIntegrator;

/// An action that is generic over the fixed-step integrators.
pub(super) trait MethodVisitor {
    /// Result of the action.
    type Output;

    /// Executes the action with an integrator.
    fn visit(self, method: &impl Method) -> Self::Output;
}

macro_rules! fixed_step_integrators {
    ($($name:ident: $method:expr,)+ => not $($other:ident),+) => {
        /// Executes an action with the integrator of the manifest; `None` if it has no fixed steps.
        pub(super) fn with_fixed_steps<V: MethodVisitor>(
            integrator: OrbitIntegrator,
            visitor: V,
        ) -> Option<V::Output> {
            match integrator {
                $(OrbitIntegrator::$name => Some(visitor.visit(&$method)),)+
                $(OrbitIntegrator::$other)|+ => None,
            }
        }
    };
}

// One row per fixed-step integrator: its value in the manifest and its coefficients.
fixed_step_integrators! {
    ExplicitEuler: EXPLICIT_EULER,
    SemiImplicitEuler: SEMI_IMPLICIT_EULER,
    VelocityVerlet: VELOCITY_VERLET,
    Rk4: RUNGE_KUTTA_4,
    Yoshida4: YOSHIDA_4,
    => not Dop853, Kepler
}

/// Explicit Euler, order 1 (orbit exercise, equations 15 and 16): r(n+1) = r(n) + v(n) h, v(n+1) = v(n) + a(r(n)) h.
pub const EXPLICIT_EULER: Tableau<1> = Tableau { stages: [[0.0]], weights: [1.0], divisor: 1.0 };

/// Classical Runge–Kutta method, order 4 (Kutta, Z. Math. Phys. 46 (1901) 435): y(n+1) = y(n) + (h/6) (k1 + 2 k2 + 2 k3 + k4).
pub const RUNGE_KUTTA_4: Tableau<4> = Tableau {
    stages: [row([]), row([0.5]), row([0.0, 0.5]), row([0.0, 0.0, 1.0])],
    weights: [1.0, 2.0, 2.0, 1.0],
    divisor: 6.0,
};

/// Semi-implicit (symplectic) Euler, order 1: v(n+1) = v(n) + a(r(n)) h, r(n+1) = r(n) + v(n+1) h.
pub const SEMI_IMPLICIT_EULER: Splitting<2> = Splitting([Kick(1.0), Drift(1.0)]);

/// Velocity Verlet, order 2 (Swope et al., J. Chem. Phys. 76 (1982) 637): half kick, drift, half kick. Symplectic and time-reversible.
pub const VELOCITY_VERLET: Splitting<3> = Splitting([Kick(0.5), Drift(1.0), Kick(0.5)]);

/// Yoshida's symplectic method, order 4 (Yoshida, Phys. Lett. A 150 (1990) 262, equations 2.11 and 2.12): Verlet steps of w1 h, w0 h
/// and w1 h.
pub const YOSHIDA_4: Splitting<9> = Splitting([
    Kick(0.5 * YOSHIDA_W1),
    Drift(YOSHIDA_W1),
    Kick(0.5 * YOSHIDA_W1),
    Kick(0.5 * YOSHIDA_W0),
    Drift(YOSHIDA_W0),
    Kick(0.5 * YOSHIDA_W0),
    Kick(0.5 * YOSHIDA_W1),
    Drift(YOSHIDA_W1),
    Kick(0.5 * YOSHIDA_W1),
]);
/// w1 = 1 / (2 - 2^(1/3)).
const YOSHIDA_W1: f64 = 1.0 / (2.0 - CUBE_ROOT_OF_2);
/// w0 = -2^(1/3) / (2 - 2^(1/3)), so that 2 w1 + w0 = 1 and 2 w1^3 + w0^3 = 0.
const YOSHIDA_W0: f64 = -CUBE_ROOT_OF_2 / (2.0 - CUBE_ROOT_OF_2);
const CUBE_ROOT_OF_2: f64 = 1.259_921_049_894_873_2;
