//! Exact solution of the two-body problem at any time from the state at the start, for every conic section.
//!
//! In the universal variable X with dX = dt / r, the motion is linear, and the functions `G_n(X)` solve it for ellipses, parabolas and
//! hyperbolas (Stumpff 1962; notation of Rein and Tamayo, MNRAS 452 (2015) 376, section 2).

use super::elements::Elements;
use super::motion::{State, dot, length};
use crate::constants::GM_SUN_AU3_PER_DAY2;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Exact motion from one start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Kepler {
    start: State,
    /// |r0|, AU.
    distance: f64,
    /// eta0 = r0 . v0, AU^2/day.
    eta: f64,
    /// beta = 2 GM / |r0| - v0^2 = GM / a, AU^2/day^2; positive for ellipses.
    beta: f64,
    /// zeta0 = GM - beta |r0|, AU^3/day^2.
    zeta: f64,
    /// |r0 x v0|, AU^2/day.
    angular_momentum: f64,
    /// Perihelion distance, AU.
    perihelion: f64,
    /// Period, days; only for ellipses.
    period: Option<f64>,
}

/// Exact motion at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeplerPoint {
    /// Position and velocity.
    pub state: State,
    /// Whole revolutions, to which `angle` is added.
    pub turns: i64,
    /// Angle around the Sun from the start, rad, in (-2 pi, 2 pi).
    pub angle: f64,
}

impl Kepler {
    /// Motion through `start`, whose position must not be zero or parallel to the velocity.
    #[must_use]
    pub fn from_start(start: State) -> Self {
        let elements = Elements::of(start);
        let distance = length(start.position);
        let beta = -2.0 * elements.energy;
        Self {
            start,
            distance,
            eta: dot(start.position, start.velocity),
            beta,
            zeta: GM_SUN_AU3_PER_DAY2 - beta * distance,
            angular_momentum: elements.angular_momentum,
            perihelion: elements.perihelion,
            period: elements.bound.map(|bound| bound.period),
        }
    }

    /// State at the start.
    #[must_use]
    pub fn start(&self) -> State {
        self.start
    }

    /// Motion at a time after the start, days; negative before the start.
    #[must_use]
    pub fn at(&self, time_days: f64) -> KeplerPoint {
        let (turns, rest) = match self.period {
            Some(period) => {
                let turns = (time_days / period + 0.5).floor();
                (turns as i64, time_days - turns * period)
            }
            None => (0, time_days),
        };
        let x = self.universal_variable(rest);
        KeplerPoint { state: self.state_at(x), turns, angle: self.angle_at(x) }
    }

    /// State by Lagrange's coefficients: r = f r0 + g v0, v = f' r0 + g' v0, with
    /// f = 1 - GM G2 / r0, g = r0 G1 + eta0 G2, f' = -GM G1 / (r r0), g' = 1 - GM G2 / r, r = r0 + eta0 G1 + zeta0 G2.
    fn state_at(&self, x: f64) -> State {
        let [_, g1, g2, _] = stumpff_functions(self.beta, x);
        let distance = self.distance + self.eta * g1 + self.zeta * g2;
        let f = 1.0 - GM_SUN_AU3_PER_DAY2 * g2 / self.distance;
        let g = self.distance * g1 + self.eta * g2;
        let f_rate = -GM_SUN_AU3_PER_DAY2 * g1 / (distance * self.distance);
        let g_rate = 1.0 - GM_SUN_AU3_PER_DAY2 * g2 / distance;
        let State { position, velocity } = self.start;
        State {
            position: std::array::from_fn(|axis| f * position[axis] + g * velocity[axis]),
            velocity: std::array::from_fn(|axis| f_rate * position[axis] + g_rate * velocity[axis]),
        }
    }

    /// Angle since the start: tan(angle / 2) = L G1(X/2) / (r0 G0(X/2) + eta0 G1(X/2)), which has no branch within a revolution. In
    /// Levi-Civita's coordinate u, a complex number whose square is the position in the orbital plane, the motion is linear:
    /// u(X) = (G0(X/2) + (eta0 + i L) G1(X/2) / r0) u(0).
    fn angle_at(&self, x: f64) -> f64 {
        let [g0, g1, ..] = stumpff_functions(self.beta, 0.5 * x);
        2.0 * libm::atan2(self.angular_momentum * g1, self.distance * g0 + self.eta * g1)
    }

    /// Solves Kepler's equation in universal form for X: r0 X + eta0 G2 + zeta0 G3 = t, |t| at most half a period.
    ///
    /// The derivative of the left side is r, which is at least the perihelion distance q, so the left side increases and |X| <= |t| / q.
    /// Newton's method is used; where a step would leave the bracket, the bracket is halved, and also for a large step after
    /// [`MAX_NEWTON_STEPS`], because the method can alternate between two points within the bracket for ever.
    fn universal_variable(&self, time_days: f64) -> f64 {
        // Motion backward in time is motion forward with the opposite velocity.
        let (time, eta) =
            if time_days < 0.0 { (-time_days, -self.eta) } else { (time_days, self.eta) };
        let (mut low, mut high) = (0.0, time / self.perihelion);
        if self.beta > 0.0 {
            // In half a period, the eccentric anomaly changes by less than a revolution.
            let revolution = TAU / self.beta.sqrt();
            high = if high < revolution { high } else { revolution };
        }
        // Starts from the solution for a circle if it is in the bracket.
        let circle = time / self.distance;
        let mut x = if circle <= high { circle } else { 0.5 * high };
        for iteration in 0..MAX_ITERATIONS {
            let [_, g1, g2, g3] = stumpff_functions(self.beta, x);
            let excess = self.distance * x + eta * g2 + self.zeta * g3 - time;
            // An excess that is not a number is beyond the solution.
            if excess < 0.0 {
                low = x
            } else {
                high = x
            }
            let newton = x - excess / (self.distance + eta * g1 + self.zeta * g2);
            let alternates = iteration >= MAX_NEWTON_STEPS && (newton - x).abs() > SMALL_STEP * x;
            let is_inside = newton >= low && newton <= high && !alternates;
            let next = if is_inside { newton } else { 0.5 * (low + high) };
            let change = (next - x).abs();
            x = next;
            if change <= f64::EPSILON * x {
                break;
            }
        }
        if time_days < 0.0 { -x } else { x }
    }
}

/// Maximum number of iterations. Newton's method takes about 5; halving takes one per bit and, from a bracket that is too wide, one per
/// factor of 2 of its width.
const MAX_ITERATIONS: u32 = 400;

/// Number of iterations after which a large step halves the bracket.
const MAX_NEWTON_STEPS: u32 = 100;
/// Relative size of a step that is not large: near the solution, the method can alternate between neighboring numbers.
const SMALL_STEP: f64 = 1e-6;

/// `G_n(X)` = `X^n c_n(beta X^2)` for n = 0 to 3 with Stumpff's functions `c_n(z)` = sum over k of (-z)^k / (n + 2 k)!:
/// d`G_n`/dX = `G_(n-1)`, and `G_0` = cos(sqrt(beta) X) where beta > 0.
fn stumpff_functions(beta: f64, x: f64) -> [f64; 4] {
    let z = beta * x * x;
    let [c0, c1, c2, c3] = if z.abs() < 1.0 {
        small_stumpff(z)
    } else if z > 0.0 {
        let angle = z.sqrt();
        let half_sine = libm::sin(0.5 * angle);
        let sine = libm::sin(angle);
        let c2 = 2.0 * half_sine * half_sine / z;
        [libm::cos(angle), sine / angle, c2, (angle - sine) / (angle * z)]
    } else {
        let angle = (-z).sqrt();
        let half_sine = libm::sinh(0.5 * angle);
        let sine = libm::sinh(angle);
        let c2 = 2.0 * half_sine * half_sine / -z;
        [libm::cosh(angle), sine / angle, c2, (angle - sine) / (angle * z)]
    };
    [c0, x * c1, x * x * c2, x * x * x * c3]
}

/// Stumpff's functions for |z| < 1 by their nested series, with a truncation error below 1e-24.
fn small_stumpff(z: f64) -> [f64; 4] {
    let (mut c2, mut c3) = (1.0, 1.0);
    for k in (2..=12).rev() {
        let even = 2.0 * f64::from(k);
        c2 = 1.0 - z * c2 / ((even - 1.0) * even);
        c3 = 1.0 - z * c3 / (even * (even + 1.0));
    }
    let (c2, c3) = (c2 / 2.0, c3 / 6.0);
    [1.0 - z * c2, 1.0 - z * c3, c2, c3]
}
