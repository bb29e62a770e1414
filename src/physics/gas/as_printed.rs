//! The gas document's step as printed, kept to show what it does. Use `stepped` or the closed form for physics.
//!
//! What is wrong with it:
//! 1. u of (9) is sought in (0, 1], although p + v u makes it a time in (0, dt];
//! 2. step 4(b) scales v to the LENGTH 1 - u: after a hit a particle stands 1 - u meters from the hit, perhaps outside;
//! 3. step 3(a) projects the point p1 instead of p1 - c: with a center off the origin the mirror image is wrong;
//! 4. a radial hit scales the zero vector, 0/0, and a start on the wall has no root above zero;
//! 5. one reflection a step.
//!
//! Where (9) has no root in (0, 1] (on the wall, or outside and flying away) the document says nothing: the particle then
//! flies on. A particle that 0/0 leaves without a place counts as lost and stays where it last was.

use super::motion::{Flight, Particle, dot, drifted};

/// One step of a particle, equations (7) to (10) and steps 1 to 4 as printed. Positions are relative to the center
/// but for p1 in step 3(a), which is the document's. The result may be outside, and it may not be finite.
#[must_use]
pub fn step_as_printed(
    particle: Particle,
    center: [f64; 2],
    radius: f64,
    time_step: f64,
) -> Flight {
    let free = drifted(particle, time_step);
    let missed = Flight { particle: free, hits: 0, impulse_per_mass: 0.0 };
    // (8)
    if length(free.position) <= radius {
        return missed;
    }
    // (9), (10)
    let Some(u) = positive_root(particle, radius) else { return missed };
    let Particle { position: p1, velocity: v } = particle;
    let pc = drifted(particle, u).position;
    // 3(a) to 3(c)
    let vp = difference(add(p1, center), projection(add(p1, center), pc));
    let mirrored = add(p1, scale(vp, 2.0 * length(vp)));
    let v2 = scale(difference(pc, mirrored), length(v));
    // 4(a), 4(b)
    let position = add(pc, scale(v2, 1.0 - u));
    let impulse_per_mass = dot(difference(v2, v), pc) / radius;
    Flight { particle: Particle { position, velocity: v2 }, hits: 1, impulse_per_mass }
}

/// The larger root u of (9) if it lies in (0, 1].
fn positive_root(particle: Particle, radius: f64) -> Option<f64> {
    let Particle { position, velocity } = particle;
    let a = dot(velocity, velocity);
    let b = 2.0 * dot(position, velocity);
    let c = dot(position, position) - radius * radius;
    let u = (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);
    (u > 0.0 && u <= 1.0).then_some(u)
}

/// (1)
fn length(v: [f64; 2]) -> f64 {
    (v[0] * v[0] + v[1] * v[1]).sqrt()
}

/// (2): 0/0 for the zero vector.
fn scale(v: [f64; 2], s: f64) -> [f64; 2] {
    [v[0] / length(v) * s, v[1] / length(v) * s]
}

/// (3): from the first point to the second.
fn difference(from: [f64; 2], to: [f64; 2]) -> [f64; 2] {
    [to[0] - from[0], to[1] - from[1]]
}

/// (4)
fn add(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

/// (6)
fn projection(p: [f64; 2], v: [f64; 2]) -> [f64; 2] {
    let share = dot(p, v) / dot(v, v);
    [share * v[0], share * v[1]]
}
