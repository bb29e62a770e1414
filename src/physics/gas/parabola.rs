//! Flight in uniform gravity: the parabola of a point particle and its exact time of collision with a circular wall.
//!
//! Positions are relative to the center of the container. Lengths are in m, times in s, speeds in m/s.

use super::motion::{Particle, dot};

/// Distance of p^2 from R^2 over R^2 below which a particle is on the wall: a few roundings.
const ON_WALL: f64 = 1e-15;

/// Flight in uniform gravity: p(t) = p + v t + a t^2/2, v(t) = v + a t, a = (0, -g). p in m, v in m/s, t in s, g in m/s^2.
#[must_use]
#[inline]
pub fn flown(particle: Particle, gravity: f64, time: f64) -> Particle {
    let Particle { position: [x, y], velocity: [vx, vy] } = particle;
    Particle {
        position: [x + time * vx, y + time * (vy - gravity * time / 2.0)],
        velocity: [vx, vy - gravity * time],
    }
}

/// Energy per mass above that of a particle at rest at the bottom of the container: v^2/2 + g (y + R), m^2/s^2.
#[must_use]
#[inline]
pub fn energy_per_mass(particle: Particle, gravity: f64, radius: f64) -> f64 {
    dot(particle.velocity, particle.velocity) / 2.0 + gravity * (particle.position[1] + radius)
}

/// Time u >= 0, s, until a particle inside the wall reaches it: the first root at which p(u)^2 - R^2 becomes positive. It is infinite
/// for a particle at rest without gravity.
///
/// p(u)^2 - R^2 = c0 + c1 u + c2 u^2 + c3 u^3 + c4 u^4 with c0 = p^2 - R^2, c1 = 2 p . v, c2 = v^2 + p . a, c3 = v . a, c4 = a^2/4.
/// The roots of its second derivative separate those of the first one, and these separate its own. Each is found by bisection between
/// two bounds, so that no root is missed and the number of operations is limited.
#[must_use]
pub fn time_to_wall_in_gravity(particle: Particle, gravity: f64, radius: f64) -> f64 {
    let Particle { position: [x, y], velocity: [vx, vy] } = particle;
    let latest = latest_collision(particle, gravity, radius);
    let distance = dot([x, y], [x, y]).sqrt();
    let room = (radius - distance) * (radius + distance);
    let c0 = if room > ON_WALL * radius * radius { -room } else { 0.0 };
    let c1 = 2.0 * (x * vx + y * vy);
    if !latest.is_finite() || (c0 == 0.0 && c1 > 0.0) {
        return if latest.is_finite() { 0.0 } else { latest };
    }
    let (c2, c3, c4) = (vx * vx + vy * vy - gravity * y, -gravity * vy, gravity * gravity / 4.0);
    let value = |u: f64| c0 + u * (c1 + u * (c2 + u * (c3 + u * c4)));
    let slope = |u: f64| c1 + u * (2.0 * c2 + u * (3.0 * c3 + u * 4.0 * c4));
    let mut extrema = [latest; 3];
    let mut found = 0;
    let mut from = 0.0;
    for to in inflections(c2, c3, c4, latest).into_iter().chain([latest]) {
        if (slope(from) < 0.0) != (slope(to) < 0.0) && found < extrema.len() {
            extrema[found] = root(&slope, from, to);
            found += 1;
        }
        from = to;
    }
    let mut from = 0.0;
    for to in extrema.into_iter().chain([latest]) {
        if value(from) <= 0.0 && value(to) > 0.0 {
            return root(&value, from, to);
        }
        from = to;
    }
    latest
}

/// A time at which the particle has certainly reached the wall, s: when it is as low as the bottom of the circle, or as far to the side
/// as its edge, whichever is earlier.
fn latest_collision(particle: Particle, gravity: f64, radius: f64) -> f64 {
    let Particle { position: [x, y], velocity: [vx, vy] } = particle;
    let height = if y + radius > 0.0 { y + radius } else { 0.0 };
    let root = (vy * vy + 2.0 * gravity * height).sqrt();
    // Both forms are the later root; each is used where it has no cancellation.
    let fall = if vy >= 0.0 { (vy + root) / gravity } else { 2.0 * height / (root - vy) };
    let side = if vx < 0.0 { x + radius } else { radius - x };
    let drift = (if side > 0.0 { side } else { 0.0 }) / vx.abs();
    // A comparison with 0/0 is false.
    match (fall >= 0.0, drift >= 0.0) {
        (true, true) if drift < fall => drift,
        (true, _) => fall,
        (false, true) => drift,
        (false, false) => f64::INFINITY,
    }
}

/// Roots of half the second derivative, c2 + 3 c3 u + 6 c4 u^2, clamped to [0, latest], in rising order.
fn inflections(c2: f64, c3: f64, c4: f64, latest: f64) -> [f64; 2] {
    let square = 9.0 * c3 * c3 - 24.0 * c4 * c2;
    if square <= 0.0 || c4 == 0.0 {
        return [0.0; 2];
    }
    let clamped = |u: f64| {
        if u > 0.0 && u < latest {
            u
        } else if u >= latest {
            latest
        } else {
            0.0
        }
    };
    let half_width = square.sqrt();
    let lower = (-3.0 * c3 - half_width) / (12.0 * c4);
    let upper = (-3.0 * c3 + half_width) / (12.0 * c4);
    [clamped(lower), clamped(upper)]
}

/// Root of a function with different signs at two bounds: regula falsi with the Illinois rule, and bisection whenever three steps have
/// not halved the interval. It ends when the bounds are adjacent to rounding.
fn root(function: &impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let (mut at_low, mut at_high) = (function(low), function(high));
    let sign = at_low < 0.0 || (at_low == 0.0 && at_high > 0.0);
    let (mut width, mut side) = (high - low, 0_i8);
    for step in 0..MAX_ROOT_STEPS {
        let secant = (low * at_high - high * at_low) / (at_high - at_low);
        let is_inside = secant > low && secant < high;
        let is_slow = step % 3 == 2 && {
            let is_slow = high - low > width / 2.0;
            width = high - low;
            is_slow
        };
        let middle = low + (high - low) / 2.0;
        let next = if is_inside && !is_slow { secant } else { middle };
        if next <= low || next >= high || high - low <= f64::EPSILON * high {
            break;
        }
        let at_next = function(next);
        if at_next == 0.0 {
            return next;
        }
        if (at_next < 0.0) == sign {
            (low, at_low) = (next, at_next);
            if side == -1 {
                at_high /= 2.0;
            }
            side = -1;
        } else {
            (high, at_high) = (next, at_next);
            if side == 1 {
                at_low /= 2.0;
            }
            side = 1;
        }
    }
    high
}

/// Maximum number of steps of a root: three per halving of 64 bits.
const MAX_ROOT_STEPS: u32 = 200;
