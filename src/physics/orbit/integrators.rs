//! The methods as tables of numbers. How a table moves bodies: `single_step`. What it is called in a manifest: [`Integrator`].

use kinetoscope_manifest::model::OrbitIntegrator;
use serde::{Deserialize, Serialize};

/// The method by which bodies are moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Integrator {
    /// [`EXPLICIT_EULER`].
    ExplicitEuler,
    /// [`SEMI_IMPLICIT_EULER`].
    SemiImplicitEuler,
    /// [`VELOCITY_VERLET`].
    VelocityVerlet,
    /// [`RUNGE_KUTTA_4`].
    Rk4,
    /// [`YOSHIDA_4`].
    Yoshida4,
    /// `super::dormand_prince`, in steps that `super::adaptive` chooses.
    DormandPrince8,
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
            Self::DormandPrince8 => "dormand-prince8",
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
            OrbitIntegrator::DormandPrince8 => Self::DormandPrince8,
            OrbitIntegrator::Kepler => Self::Kepler,
        }
    }
}

/// One exact half of the motion, for a share of the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Substep {
    /// v += a(r) w h.
    Kick(f64),
    /// r += v w h.
    Drift(f64),
}
use Substep::{Drift, Kick};

/// A symplectic method: kicks and drifts in turn. Forces are asked for once after each drift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Splitting<const N: usize>(pub [Substep; N]);

/// A Runge–Kutta method for y = (r, v), y' = (v, a(r)): k_i = y'(y + h sum over j < i of `stages[i][j]` k_j), and the step is
/// y + (h / divisor) sum of `weights[i]` k_i. Sums run from the first slope to the last; coefficients of zero are left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tableau<const S: usize> {
    /// Row i: the weights of the slopes before it.
    pub stages: [[f64; S]; S],
    /// The weights of all slopes, times the divisor.
    pub weights: [f64; S],
    /// What makes the weights whole numbers.
    pub divisor: f64,
}

/// A row of a tableau: what is given, then zeros.
pub(super) const fn row<const GIVEN: usize, const S: usize>(given: [f64; GIVEN]) -> [f64; S] {
    let mut row = [0.0; S];
    let mut slope = 0;
    while slope < GIVEN {
        row[slope] = given[slope];
        slope += 1;
    }
    row
}

/// The orbit document's method, order 1: r(n+1) = r(n) + v(n) h (equation 15), v(n+1) = v(n) + a(r(n)) h (equation 16).
pub const EXPLICIT_EULER: Tableau<1> = Tableau { stages: [[0.0]], weights: [1.0], divisor: 1.0 };

/// The classical Runge–Kutta method, order 4 (Kutta 1901): y(n+1) = y(n) + (h/6) (k1 + 2 k2 + 2 k3 + k4).
pub const RUNGE_KUTTA_4: Tableau<4> = Tableau {
    stages: [row([]), row([0.5]), row([0.0, 0.5]), row([0.0, 0.0, 1.0])],
    weights: [1.0, 2.0, 2.0, 1.0],
    divisor: 6.0,
};

/// Symplectic Euler, order 1: v(n+1) = v(n) + a(r(n)) h, r(n+1) = r(n) + v(n+1) h.
pub const SEMI_IMPLICIT_EULER: Splitting<2> = Splitting([Kick(1.0), Drift(1.0)]);

/// Velocity Verlet, order 2 (Swope et al. 1982): half kick, drift, half kick. Symplectic and reversible in time.
pub const VELOCITY_VERLET: Splitting<3> = Splitting([Kick(0.5), Drift(1.0), Kick(0.5)]);

/// Yoshida's fourth-order symplectic method (Phys. Lett. A 150, 262, 1990, equations 2.11 and 2.12): Verlet steps of
/// w1 h, w0 h and w1 h.
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
