//! Equations of motion of the gas (gas exercise 14g1): free flight, specular reflection at the wall, and elastic collisions of discs.
//! Every propagator calls these functions. They depend only on their arguments.
//!
//! Positions are relative to the center of the container. Lengths are in m, times in s, speeds in m/s.

use serde::{Deserialize, Serialize};

/// A point particle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Particle {
    /// Position p relative to the center, m.
    pub position: [f64; 2],
    /// Velocity v, m/s.
    pub velocity: [f64; 2],
}

/// Flight of a particle over a given time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight {
    /// The particle at the end.
    pub particle: Particle,
    /// Number of wall collisions.
    pub wall_collisions: u64,
    /// Normal impulse on the wall per mass of the particle, m/s.
    pub impulse_per_mass: f64,
}

impl Particle {
    /// Speed |v| = sqrt(vx^2 + vy^2), m/s (gas exercise, equation 1).
    #[must_use]
    pub fn speed(&self) -> f64 {
        dot(self.velocity, self.velocity).sqrt()
    }

    /// Angular momentum about the center per mass, p x v = x vy - y vx, m^2/s.
    #[must_use]
    pub fn angular_momentum_per_mass(&self) -> f64 {
        cross(self.position, self.velocity)
    }
}

/// Free flight: p(t) = p + v t, v(t) = v (gas exercise, equation 7). p in m, v in m/s, t in s.
#[must_use]
#[inline(always)]
pub fn drifted(particle: Particle, time: f64) -> Particle {
    let Particle { position: [x, y], velocity: [vx, vy] } = particle;
    Particle { position: [x + time * vx, y + time * vy], velocity: [vx, vy] }
}

/// Time u >= 0, s, until a particle inside the wall reaches it: the later root of (p + v u)^2 = R^2 (gas exercise, equation 9
/// with c = 0). u is a time in (0, dt], not a fraction in (0, 1] as printed. It is infinite for a particle at rest.
///
/// With b = p . v and D = b^2 + v^2 (R^2 - p^2): u = (sqrt(D) - b) / v^2 = (R^2 - p^2) / (sqrt(D) + b). The form without
/// cancellation is used. A particle that rounding has put outside the wall counts as on the wall.
#[must_use]
#[inline(always)]
pub fn time_to_wall(particle: Particle, radius: f64) -> f64 {
    let Particle { position, velocity } = particle;
    let square = dot(velocity, velocity);
    let along = dot(position, velocity);
    let room = room_to_wall(position, radius);
    let root = (along * along + square * room).sqrt();
    let is_outward = along > 0.0;
    let numerator = if is_outward { room } else { root - along };
    let denominator = if is_outward { root + along } else { square };
    let time = numerator / denominator;
    // For a particle at rest, both are zero.
    if square > 0.0 { time } else { f64::INFINITY }
}

/// Specular reflection at the current position p: v' = v - 2 (v . n) n, n = p / |p|. v in m/s.
///
/// Division by p^2 conserves the speed for any rounding error of the position.
#[must_use]
#[inline(always)]
pub fn reflected(particle: Particle) -> Particle {
    let Particle { position, velocity } = particle;
    let twice = 2.0 * dot(velocity, position) / dot(position, position);
    let velocity = [velocity[0] - twice * position[0], velocity[1] - twice * position[1]];
    Particle { position, velocity }
}

/// Outcome of an elastic collision of two discs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairCollision {
    /// Velocities after the collision, m/s.
    pub velocities: [[f64; 2]; 2],
    /// Contribution to Clausius's virial: distance of the centers times transferred momentum, in the unit of the masses times m^2/s.
    pub virial: f64,
}

/// Elastic collision of two frictionless discs in contact. It reverses the relative velocity along the line of centers r = p2 - p1:
///
/// v1' = v1 + 2 m2/(m1 + m2) (v . r) r / r^2,   v2' = v2 - 2 m1/(m1 + m2) (v . r) r / r^2,   v = v2 - v1
///
/// (Landau and Lifshitz, Mechanics, section 17). v in m/s, r in m, masses in any common unit. Division by r^2 conserves the energy
/// for any rounding error of the positions.
#[must_use]
pub fn elastic_collision(pair: [Particle; 2], masses: [f64; 2]) -> PairCollision {
    let [Particle { position: p1, velocity: v1 }, Particle { position: p2, velocity: v2 }] = pair;
    let r = [p2[0] - p1[0], p2[1] - p1[1]];
    let approach = dot([v2[0] - v1[0], v2[1] - v1[1]], r);
    let rate = approach / dot(r, r);
    let total = masses[0] + masses[1];
    let [first, second] = [2.0 * masses[1] / total * rate, 2.0 * masses[0] / total * rate];
    PairCollision {
        velocities: [
            [v1[0] + first * r[0], v1[1] + first * r[1]],
            [v2[0] - second * r[0], v2[1] - second * r[1]],
        ],
        virial: -2.0 * masses[0] * masses[1] / total * approach,
    }
}

/// Path of a particle in a circle, in closed form: chords of equal length, each rotated by the same angle from the one before.
///
/// With s = |v|, b0 = (p . v)/s and d = (p x v)/s, half a chord is C = sqrt(R^2 - d^2). Wall collisions occur at (C - b0)/s and then
/// every 2 C/s. Each rotates the path by beta = pi - 2 a, sin a = d/R (circular billiard: Berry, Eur. J. Phys. 2 (1981) 91).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChordPath {
    start: Particle,
    radius: f64,
    /// s
    pub(super) speed: f64,
    /// b0
    pub(super) along: f64,
    /// d
    pub(super) offset: f64,
    /// C
    pub(super) half_chord: f64,
}

impl ChordPath {
    /// Whether the path is that of a particle inside a unit circle, or on it up to rounding, that is not faster than `max_speed`.
    pub(super) fn is_in_unit_circle(&self, max_speed: f64) -> bool {
        let Particle { position, .. } = self.start;
        *self == Self::of(self.start, 1.0)
            && dot(position, position) <= 1.0 + 1e-6
            && self.speed <= max_speed
    }

    /// Computes the path of a particle that starts inside a circle of the given radius, or on it.
    #[must_use]
    pub fn of(start: Particle, radius: f64) -> Self {
        // Below this limit, the square of the speed has lost its digits and the distance traveled is negligible.
        let square = dot(start.velocity, start.velocity);
        let speed = if square > f64::MIN_POSITIVE { square.sqrt() } else { 0.0 };
        let (along, offset) = if speed > 0.0 {
            let direction = [start.velocity[0] / speed, start.velocity[1] / speed];
            (dot(start.position, direction), cross(start.position, direction))
        } else {
            (0.0, 0.0)
        };
        // C^2 = R^2 - d^2 = (R^2 - p^2) + b0^2 has no cancellation and is exact for a start on the wall.
        let half_chord = (room_to_wall(start.position, radius) + along * along).sqrt();
        Self { start, radius, speed, along, offset, half_chord }
    }

    /// Whether the chords are so flat that they differ from the wall by less than the rounding of R (C^2 / 2R < 2^-53 R). Wall
    /// collisions of such a path are not counted; their impulse is replaced by its limit.
    #[must_use]
    pub fn is_grazing(&self) -> bool {
        self.half_chord * self.half_chord < f64::EPSILON * self.radius * self.radius
    }

    /// Number of wall collisions in (0, t]: k = floor((b0 + s t + C) / (2 C)). A collision at the start counts as soon as t > 0.
    #[must_use]
    pub fn wall_collisions(&self, time: f64) -> u64 {
        if self.is_grazing() || time <= 0.0 {
            return 0;
        }
        let chords = (self.along + self.speed * time + self.half_chord) / (2.0 * self.half_chord);
        // The cast rounds toward zero: this is the floor of a positive number, and no collision has occurred for a negative one.
        chords as u64
    }

    /// Normal impulse on the wall per mass of the particle, m/s: 2 s C/R per collision; s^2 t/R for a grazing path.
    #[must_use]
    pub fn impulse_per_mass(&self, wall_collisions: u64, time: f64) -> f64 {
        if self.is_grazing() {
            self.speed * self.speed * time / self.radius
        } else {
            wall_collisions as f64 * (2.0 * self.speed * self.half_chord / self.radius)
        }
    }

    /// Flight of duration t >= 0 from the start:
    /// p(t) = Rot(k beta) [(b0 + s t - 2 C k) v^ - d n^], n^ = (-v^y, v^x), v(t) = Rot(k beta) v.
    #[must_use]
    pub fn flight(&self, time: f64) -> Flight {
        let wall_collisions = self.wall_collisions(time);
        Flight {
            particle: self.particle_after(wall_collisions, time),
            wall_collisions,
            impulse_per_mass: self.impulse_per_mass(wall_collisions, time),
        }
    }

    /// Time of wall collision j, counted from 1: (C - b0)/s + (j - 1) 2 C/s.
    #[must_use]
    pub fn time_of_collision(&self, number: u64) -> f64 {
        ((self.half_chord - self.along) + 2.0 * self.half_chord * (number as f64 - 1.0))
            / self.speed
    }

    /// Rotation per wall collision, rad: beta without whole turns, 2 atan2(C, |d|) with the sign of d. Exact for grazing collisions.
    #[must_use]
    pub fn rotation_per_collision(&self) -> f64 {
        let angle = 2.0 * libm::atan2(self.half_chord, self.offset.abs());
        if self.offset < 0.0 { -angle } else { angle }
    }

    /// The particle at time t, after the given number of wall collisions.
    pub(super) fn particle_after(&self, wall_collisions: u64, time: f64) -> Particle {
        let Particle { position, velocity } = self.start;
        let sense = if self.offset < 0.0 { -1.0 } else { 1.0 };
        if self.is_grazing() {
            let rotation = Rotation::by(sense * (self.speed * time / self.radius));
            return Particle { position: rotation.of(position), velocity: rotation.of(velocity) };
        }
        if wall_collisions == 0 {
            return drifted(self.start, time);
        }
        let rotation = Rotation::by(wall_collisions as f64 * self.rotation_per_collision());
        let along = self.along + self.speed * time - 2.0 * self.half_chord * wall_collisions as f64;
        let direction = [velocity[0] / self.speed, velocity[1] / self.speed];
        let unrotated = [
            along * direction[0] + self.offset * direction[1],
            along * direction[1] - self.offset * direction[0],
        ];
        Particle { position: rotation.of(unrotated), velocity: rotation.of(velocity) }
    }
}

/// Circular wall whose radius changes at a constant rate, R(t) = R0 + u t; u = 0 for a wall at rest.
///
/// In lengths scaled by R(t) and in the time tau = integral of dt/R^2 = t/(R0 R(t)), the wall is a unit circle at rest and particles
/// move in straight lines. With q = p/R and w = dq/dtau = R v - u p, free flight conserves w, and the reflection at the moving wall,
/// v_n -> 2u - v_n, becomes w_n -> -w_n (Berry and Klein, J. Phys. A 17 (1984) 1805). Therefore, every path has a closed form, and
/// |R v - u p| and p x v = q x w are conserved.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Circle {
    /// Radius R0 at time 0, m.
    pub radius: f64,
    /// Speed u of the wall, positive outward, m/s.
    pub wall_speed: f64,
}

impl Circle {
    /// R(t) = R0 + u t, m.
    #[must_use]
    #[inline(always)]
    pub fn radius_at(&self, time: f64) -> f64 {
        self.radius + self.wall_speed * time
    }

    /// tau(t) = t / (R0 R(t)), s/m^2.
    #[must_use]
    pub fn scaled_time(&self, time: f64) -> f64 {
        time / (self.radius * self.radius_at(time))
    }

    /// t(tau) = R0^2 tau / (1 - R0 u tau), s.
    #[must_use]
    pub fn time_of(&self, scaled_time: f64) -> f64 {
        let product = self.radius * scaled_time;
        self.radius * product / (1.0 - self.wall_speed * product)
    }

    /// Scaled position and velocity (q, w) of a particle at time t: q = p/R, w = R v - u p.
    #[must_use]
    pub fn scaled(&self, particle: Particle, time: f64) -> Particle {
        let radius = self.radius_at(time);
        let Particle { position: [x, y], velocity: [vx, vy] } = particle;
        Particle {
            position: [x / radius, y / radius],
            velocity: [radius * vx - self.wall_speed * x, radius * vy - self.wall_speed * y],
        }
    }

    /// The particle with scaled state (q, w) at time t: p = R q, v = w/R + u q.
    #[must_use]
    pub fn unscaled(&self, scaled: Particle, time: f64) -> Particle {
        let radius = self.radius_at(time);
        let Particle { position: [x, y], velocity: [wx, wy] } = scaled;
        Particle {
            position: [radius * x, radius * y],
            velocity: [wx / radius + self.wall_speed * x, wy / radius + self.wall_speed * y],
        }
    }

    /// The same wall with the present radius as its radius at time 0.
    #[must_use]
    pub fn restarted_at(&self, time: f64) -> Self {
        Self { radius: self.radius_at(time), ..*self }
    }

    /// Impulse on the wall per mass, m/s, of one collision with scaled normal velocity w_n: 2 (v_n - u) = 2 w_n / R, where
    /// 1/R = 1/R0 - u tau.
    #[must_use]
    pub fn impulse_of_collision(&self, normal: f64, scaled_time: f64) -> f64 {
        2.0 * normal * (1.0 / self.radius - self.wall_speed * scaled_time)
    }
}

/// Counterclockwise rotation.
struct Rotation {
    sin: f64,
    cos: f64,
}

impl Rotation {
    fn by(angle: f64) -> Self {
        let (sin, cos) = libm::sincos(angle);
        Self { sin, cos }
    }

    fn of(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.cos * x - self.sin * y, self.sin * x + self.cos * y]
    }
}

/// R^2 - p^2, m^2; zero for a particle that rounding has put outside.
#[inline(always)]
fn room_to_wall(position: [f64; 2], radius: f64) -> f64 {
    let distance = dot(position, position).sqrt();
    if distance < radius { (radius - distance) * (radius + distance) } else { 0.0 }
}

/// a . b (gas exercise, equation 5).
#[must_use]
#[inline(always)]
pub fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// a x b, the component perpendicular to the plane.
#[must_use]
pub fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}
