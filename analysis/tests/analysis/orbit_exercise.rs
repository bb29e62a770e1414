//! The orbit exercise (14to4), integrated without the physics package.
#![allow(clippy::disallowed_methods, reason = "closed forms need std's maths")]

use kinetoscope_manifest::model::OrbitIntegrator;

/// Gravitational constant times the Sun's mass, AU^3/day^2.
const GM: f64 = 2.959_122_082_322_128e-4;
/// State at the start, AU and AU/day.
pub(crate) const START: [f64; 6] = [
    -1.813_068_419_866_209e-1,
    9.642_197_733_507_97e-1,
    -6.850_809_238_551_276e-5,
    -1.718_334_419_397_708e-2,
    -3.209_800_047_122_614e-3,
    6.736_104_268_755_766e-9,
];

fn slope(state: &[f64; 6]) -> [f64; 6] {
    let radius = (state[0] * state[0] + state[1] * state[1] + state[2] * state[2]).sqrt();
    let factor = -GM / (radius * radius * radius);
    [state[3], state[4], state[5], factor * state[0], factor * state[1], factor * state[2]]
}

fn shifted(state: &[f64; 6], slope: &[f64; 6], h: f64) -> [f64; 6] {
    std::array::from_fn(|axis| state[axis] + h * slope[axis])
}

fn verlet(state: &mut [f64; 6], h: f64) {
    for half in [true, false] {
        let kick = slope(state);
        for axis in 0..3 {
            state[axis + 3] += kick[axis + 3] * h / 2.0;
            if half {
                state[axis] += state[axis + 3] * h;
            }
        }
    }
}

/// Advances the state by one step of `h` days.
pub(crate) fn step(integrator: OrbitIntegrator, state: &mut [f64; 6], h: f64) {
    match integrator {
        OrbitIntegrator::ExplicitEuler => *state = shifted(state, &slope(state), h),
        OrbitIntegrator::VelocityVerlet => verlet(state, h),
        OrbitIntegrator::Yoshida4 => {
            let outer = 1.0 / (2.0 - 2.0_f64.cbrt());
            for weight in [outer, 1.0 - 2.0 * outer, outer] {
                verlet(state, weight * h);
            }
        }
        _ => {
            let first = slope(state);
            let second = slope(&shifted(state, &first, h / 2.0));
            let third = slope(&shifted(state, &second, h / 2.0));
            let fourth = slope(&shifted(state, &third, h));
            let sum: [f64; 6] = std::array::from_fn(|axis| {
                first[axis] + 2.0 * (second[axis] + third[axis]) + fourth[axis]
            });
            *state = shifted(state, &sum, h / 6.0);
        }
    }
}
