//! Laws of an orbit around a fixed Sun: exact, and as modified by integrators.

use crate::metric::law::laws;
use crate::metric::{Quantity, Violation};
use kinetoscope_manifest::model::{IntegratorSteps, ModelConfig, OrbitConfig};
use std::f64::consts::{PI, TAU};

/// Gravitational constant times the Sun's mass, AU^3/day^2 (orbit exercise 14to4).
pub(crate) const GM_SUN_AU3_PER_DAY2: f64 = 2.959_122_082_322_128e-4;

laws! {
    EULER_ENERGY: "E/E_0 = (1 + 6 Δt ω^2 t)^(-1/3)", "orbit average of the first-order modified equation, small eccentricity", range "ε up to 0.05, ω Δt up to 0.02, at least one revolution", accuracy 0.02, named "the first-order theory of explicit Euler";
    EULER_ENERGY_PER_REVOLUTION: "4 pi ω Δt of |E_0| at the start", "orbit average of the first-order modified equation, small eccentricity", range "ε up to 0.05, ω Δt up to 0.02, at least one revolution", accuracy 0.02, named "the first-order theory of explicit Euler";
    EULER_AXIS: "a/a_0 = (1 + 6 Δt ω^2 t)^(1/3)", "orbit average of the first-order modified equation, small eccentricity", range "ε up to 0.05, ω Δt up to 0.02, at least one revolution", accuracy 0.02, named "the first-order theory of explicit Euler";
    EULER_ANGULAR_MOMENTUM: "L/L_0 = (1 + 6 Δt ω^2 t)^(1/6)", "orbit average of the step from L to L (1 + Δt^2 GM/|r|^3), small eccentricity", range "ε up to 0.05, ω Δt up to 0.02, at least one revolution", accuracy 0.02, named "the first-order theory of explicit Euler";
    ENERGY: "constant", "conservation of energy", conserves "energy";
    ANGULAR_MOMENTUM: "constant", "kicks along r and drifts along v keep L = r × v", conserves "angular momentum";
    MUTUAL_ANGULAR_MOMENTUM: "constant", "the forces of a pair are opposite and along its line", conserves "angular momentum";
    KEPLERS_THIRD: "4 pi^2 over GM, times the cube of the semi-major axis, over the square of the period, is 1", "Kepler's third law, in Newton's form", named "Kepler's third law";
    SYMPLECTIC_ENERGY: "about ω Δt ε (1 + sin u_0) for semi-implicit Euler, (ω Δt)^2 ε for velocity Verlet", "first term of the modified Hamiltonian", range "ε up to 0.1, ω Δt up to 0.02, for semi-implicit Euler up to ε (1 + sin u_0)/6, at least one revolution with 20 frames or more", accuracy 0.1, named "the theory of symplectic methods";
    EXACT: "0 for the exact solution", "Kepler's ellipse is fixed";
    CONVERGENCE: "error of position proportional to Δt^order", "order of the method";
    ENERGY_CONVERGENCE: "largest energy error proportional to Δt^order", "order of the method; 5 for RK4: its error of order Δt^4 only shifts the phase of a nearly circular orbit, while the radius shrinks by (ω Δt)^6/144 per step, which is Δt^5 per unit of time";
}

/// Order of the position error of a run around the Sun; `None` without one.
pub(crate) fn position_order(model: &ModelConfig) -> Option<f64> {
    orders(model).map(|[position, _]| position)
}

/// Order of the energy error of a run around the Sun; `None` without one.
pub(crate) fn energy_order(model: &ModelConfig) -> Option<f64> {
    orders(model).map(|[_, energy]| energy)
}

/// Orders of the errors of position and energy; `None` for the exact solution, for adaptive steps, and for several bodies.
fn orders(model: &ModelConfig) -> Option<[f64; 2]> {
    let ModelConfig::Orbit(OrbitConfig { bodies: None, integrator, .. }) = model else {
        return None;
    };
    match integrator.properties().steps {
        IntegratorSteps::Fixed { position_order, energy_order } => {
            Some([position_order, energy_order])
        }
        IntegratorSteps::Adaptive | IntegratorSteps::Exact => None,
    }
}

/// Why a run is outside the range of Euler's laws, which average over revolutions of a nearly circular orbit.
pub(crate) fn outside_euler_range(
    time_step_days: f64,
    orbit: &KeplerOrbit,
    time_days: f64,
) -> Option<Violation> {
    let step = time_step_days * orbit.mean_motion_rad_per_day;
    (Quantity::Eccentricity.at_most(orbit.eccentricity(), 0.05))
        .or_else(|| Quantity::StepAngle.at_most(step, 0.02))
        .or_else(|| Quantity::Revolutions.at_least(time_days / orbit.period_days(), 1.0))
}

/// 6 h n^2 t in the energy law of explicit Euler.
fn euler_growth(time_step_days: f64, orbit: &KeplerOrbit, time_days: f64) -> f64 {
    6.0 * time_step_days * orbit.mean_motion_rad_per_day * orbit.mean_motion_rad_per_day * time_days
}

/// (E - E0) / |E0| of explicit Euler, nearly circular.
pub(crate) fn euler_energy_drift(time_step_days: f64, orbit: &KeplerOrbit, time_days: f64) -> f64 {
    1.0 - libm::pow(1.0 + euler_growth(time_step_days, orbit, time_days), -1.0 / 3.0)
}

/// (L - L0) / L0 of explicit Euler, nearly circular.
pub(crate) fn euler_angular_momentum_drift(
    time_step_days: f64,
    orbit: &KeplerOrbit,
    time_days: f64,
) -> f64 {
    libm::pow(1.0 + euler_growth(time_step_days, orbit, time_days), 1.0 / 6.0) - 1.0
}

/// dE/|E0| per revolution of explicit Euler on a nearly circular orbit: 8 pi^2 h / P.
pub(crate) fn euler_energy_drift_per_revolution(time_step_days: f64, orbit: &KeplerOrbit) -> f64 {
    8.0 * PI * PI * time_step_days / orbit.period_days()
}

/// A Kepler ellipse around the Sun, given by its state at time 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KeplerOrbit {
    position: [f64; 3],
    velocity: [f64; 3],
    radius: f64,
    /// Semi-major axis, AU.
    pub(crate) semi_major_axis_au: f64,
    /// Mean motion, rad/day.
    pub(crate) mean_motion_rad_per_day: f64,
    /// Eccentricity times the cosine of the eccentric anomaly at time 0.
    e_cos: f64,
    /// Eccentricity times its sine.
    e_sin: f64,
}

impl KeplerOrbit {
    /// The orbit through a state, AU and AU/day; `None` if it is not an ellipse.
    pub(crate) fn through(position: [f64; 3], velocity: [f64; 3]) -> Option<Self> {
        let radius = norm(position);
        let square = dot(velocity, velocity);
        let inverse_axis = 2.0 / radius - square / GM_SUN_AU3_PER_DAY2;
        if !(inverse_axis > 0.0 && radius > 0.0) {
            return None;
        }
        let semi_major_axis_au = 1.0 / inverse_axis;
        let area = (GM_SUN_AU3_PER_DAY2 * semi_major_axis_au).sqrt();
        Some(Self {
            position,
            velocity,
            radius,
            semi_major_axis_au,
            mean_motion_rad_per_day: area / (semi_major_axis_au * semi_major_axis_au),
            e_cos: 1.0 - radius * inverse_axis,
            e_sin: dot(position, velocity) / area,
        })
    }

    /// Orbital period, days.
    pub(crate) fn period_days(&self) -> f64 {
        TAU / self.mean_motion_rad_per_day
    }

    /// Eccentricity.
    pub(crate) fn eccentricity(&self) -> f64 {
        libm::hypot(self.e_cos, self.e_sin)
    }

    /// Sine of the eccentric anomaly at time 0; 0 for a circle.
    pub(crate) fn sine_of_anomaly_at_start(&self) -> f64 {
        let eccentricity = self.eccentricity();
        if eccentricity > 0.0 { self.e_sin / eccentricity } else { 0.0 }
    }

    /// Position at a time, AU, by Kepler's equation for the change x of the eccentric anomaly,
    /// n t = x - e cos E0 sin x + e sin E0 (1 - cos x), and the f and g functions (Danby, section 6.3).
    pub(crate) fn position_au(&self, time_days: f64) -> [f64; 3] {
        let period = self.period_days();
        // Whole revolutions are subtracted first, because sines of large angles lose digits.
        let time = time_days - period * libm::round(time_days / period);
        let target = self.mean_motion_rad_per_day * time;
        let change = self.anomaly_change(target);
        let (sine, cosine) = libm::sincos(change);
        let f = 1.0 - self.semi_major_axis_au / self.radius * (1.0 - cosine);
        let g = time - (change - sine) / self.mean_motion_rad_per_day;
        std::array::from_fn(|axis| f * self.position[axis] + g * self.velocity[axis])
    }

    /// Solves Kepler's equation by Newton's method safeguarded by bisection; its left side is monotonic.
    fn anomaly_change(&self, target: f64) -> f64 {
        let (mut low, mut high) = (target - 2.0, target + 2.0);
        let mut x = target;
        for _ in 0..100 {
            let (sine, cosine) = libm::sincos(x);
            let excess = x - self.e_cos * sine + self.e_sin * (1.0 - cosine) - target;
            if excess > 0.0 {
                high = x;
            } else {
                low = x;
            }
            let newton = x - excess / (1.0 - self.e_cos * cosine + self.e_sin * sine);
            let next = if newton > low && newton < high { newton } else { (low + high) / 2.0 };
            if next == x || high - low < 1e-16 {
                break;
            }
            x = next;
        }
        x
    }
}

/// Scalar product.
pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Norm of a vector.
pub(crate) fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// Difference of two vectors.
pub(crate) fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

/// The unit vector along a vector.
pub(crate) fn unit(a: [f64; 3]) -> [f64; 3] {
    a.map(|component| component / norm(a))
}

/// Vector product.
pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    const POSITION: [f64; 3] =
        [-1.813_068_419_866_209e-1, 9.642_197_733_507_97e-1, -6.850_809_238_551_276e-5];
    const VELOCITY: [f64; 3] =
        [-1.718_334_419_397_708e-2, -3.209_800_047_122_614e-3, 6.736_104_268_755_766e-9];

    /// Source: the state of the orbit exercise in 50-digit arithmetic: elements, and positions after a Julian year and
    /// a century.
    #[test]
    fn kepler_orbit_agrees_with_50_digits() {
        let orbit = KeplerOrbit::through(POSITION, VELOCITY).unwrap();
        assert!((orbit.semi_major_axis_au - 0.994_180_472_778_547_7).abs() < 1e-14);
        assert!((orbit.eccentricity() - 0.013_193_509_473_113_574).abs() < 1e-14);
        assert!((orbit.period_days() - 362.073_107_968_315_9).abs() < 1e-11);
        for (time, exact, tolerance) in [
            (
                365.25,
                [-0.235_581_131_349_202_78, 0.952_503_897_764_050_9, -6.837_841_885_922_25e-5],
                1e-14,
            ),
            (
                36525.0,
                [0.558_531_684_740_465_3, 0.810_190_907_330_808_9, -4.871_892_065_661_585e-5],
                1e-12,
            ),
        ] {
            let position = orbit.position_au(time);
            for axis in 0..3 {
                let error = (position[axis] - exact[axis]).abs();
                assert!(error < tolerance, "t = {time}, axis {axis}: {error:e}");
            }
        }
    }

    #[test]
    fn a_very_eccentric_orbit_closes_and_keeps_its_energy() {
        let position = [0.1, 0.0, 0.0];
        // Perihelion speed for e = 0.95.
        let speed = (GM_SUN_AU3_PER_DAY2 * 1.95 / 0.1).sqrt();
        let orbit = KeplerOrbit::through(position, [0.0, speed, 0.0]).unwrap();
        assert!((orbit.eccentricity() - 0.95).abs() < 1e-13);
        let aphelion = orbit.position_au(orbit.period_days() / 2.0);
        assert!((aphelion[0] + 3.9).abs() < 1e-11 && aphelion[1].abs() < 1e-9, "{aphelion:?}");
        assert!(KeplerOrbit::through(position, [0.0, 2.0 * speed, 0.0]).is_none());
    }

    /// Source: orbit exercise; explicit Euler with dt = 0.25 d gains 0.0495 of |E| per year. Tolerance: the law holds
    /// for small eccentricity.
    #[test]
    fn euler_drift_law_is_near_the_reference() {
        let orbit = KeplerOrbit::through(POSITION, VELOCITY).unwrap();
        let drift = euler_energy_drift(0.25, &orbit, 365.25);
        assert!((drift / 0.049_542_352_767_0 - 1.0).abs() < 0.01, "{drift}");
        let growth = euler_angular_momentum_drift(0.25, &orbit, 365.25);
        assert!((growth / 0.025_740_601_586_7 - 1.0).abs() < 0.01, "{growth}");
        let rate = euler_energy_drift_per_revolution(1.0, &orbit);
        assert!((rate / 0.218_07 - 1.0).abs() < 1e-4, "{rate}");
    }
}
