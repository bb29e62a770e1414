//! How a particle moves in a circle: straight on at constant speed, mirrored at the wall (gas document, exercise
//! 14g1), and where it is a disc also by its collisions. Nothing here depends on anything but its arguments.
//!
//! Positions are relative to the container's center. Lengths in m, times in s, speeds in m/s.

use serde::{Deserialize, Serialize};

/// A point particle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Particle {
    /// Position p relative to the center, m.
    pub position: [f64; 2],
    /// Velocity v, m/s.
    pub velocity: [f64; 2],
}

/// What happened to a particle during some time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight {
    /// The particle at the end.
    pub particle: Particle,
    /// Hits of the wall.
    pub hits: u64,
    /// Normal impulse on the wall over the particle's mass, m/s.
    pub impulse_per_mass: f64,
}

impl Particle {
    /// Speed |v|, m/s: equation (1).
    #[must_use]
    pub fn speed(&self) -> f64 {
        dot(self.velocity, self.velocity).sqrt()
    }

    /// Angular momentum about the center over the mass, p x v = x vy - y vx, m^2/s.
    #[must_use]
    pub fn angular_momentum_per_mass(&self) -> f64 {
        cross(self.position, self.velocity)
    }
}

/// Free flight, p + v t: equation (7) of the gas document.
#[must_use]
#[inline(always)]
pub fn drifted(particle: Particle, time: f64) -> Particle {
    let Particle { position: [x, y], velocity: [vx, vy] } = particle;
    Particle { position: [x + time * vx, y + time * vy], velocity: [vx, vy] }
}

/// Time u >= 0 until a particle inside the wall meets it: the later root of (p + v u)^2 = R^2, equation (9) of the gas
/// document with c = 0. u is a time in (0, dt], not the share in (0, 1] of the document. Infinite for a particle at rest.
///
/// With b = p . v and D = b^2 + v^2 (R^2 - p^2): u = (sqrt(D) - b) / v^2 = (R^2 - p^2) / (sqrt(D) + b); of the two forms
/// the one without a difference of near equals is taken. Rounding may have put the particle a last bit outside; it then
/// counts as on the wall.
#[must_use]
#[inline(always)]
pub fn time_to_wall(particle: Particle, radius: f64) -> f64 {
    let Particle { position, velocity } = particle;
    let square = dot(velocity, velocity);
    let along = dot(position, velocity);
    let room = room_to_wall(position, radius);
    let root = (along * along + square * room).sqrt();
    let leaves = along > 0.0;
    let way = if leaves { room } else { root - along };
    let speed = if leaves { root + along } else { square };
    let time = way / speed;
    // At rest both are zero.
    if square > 0.0 { time } else { f64::INFINITY }
}

/// Specular reflection of a particle where it stands, v' = v - 2 (v . n) n with n = p / |p|: dividing by p^2
/// keeps the speed whatever the rounding of the place.
#[must_use]
#[inline(always)]
pub fn reflected(particle: Particle) -> Particle {
    let Particle { position, velocity } = particle;
    let twice = 2.0 * dot(velocity, position) / dot(position, position);
    let velocity = [velocity[0] - twice * position[0], velocity[1] - twice * position[1]];
    Particle { position, velocity }
}

/// What an elastic collision of two discs does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairImpact {
    /// Velocities afterward, m/s.
    pub velocities: [[f64; 2]; 2],
    /// Distance of the centers times the momentum handed over, in the unit of the masses times m^2/s: the pair's part of Clausius's
    /// virial.
    pub virial: f64,
}

/// Elastic collision of two smooth discs that touch: along the line of centers r = p2 - p1 the relative velocity turns about,
///
/// v1' = v1 + 2 m2/(m1 + m2) (v . r) r / r^2,   v2' = v2 - 2 m1/(m1 + m2) (v . r) r / r^2,   v = v2 - v1
///
/// (Landau and Lifshitz, Mechanics, section 17). Dividing by r^2 keeps the energy whatever the rounding of the places.
#[must_use]
pub fn elastic_impact(pair: [Particle; 2], masses: [f64; 2]) -> PairImpact {
    let [Particle { position: p1, velocity: v1 }, Particle { position: p2, velocity: v2 }] = pair;
    let r = [p2[0] - p1[0], p2[1] - p1[1]];
    let approach = dot([v2[0] - v1[0], v2[1] - v1[1]], r);
    let turned = approach / dot(r, r);
    let total = masses[0] + masses[1];
    let [first, second] = [2.0 * masses[1] / total * turned, 2.0 * masses[0] / total * turned];
    PairImpact {
        velocities: [
            [v1[0] + first * r[0], v1[1] + first * r[1]],
            [v2[0] - second * r[0], v2[1] - second * r[1]],
        ],
        virial: -2.0 * masses[0] * masses[1] / total * approach,
    }
}

/// The whole path of a particle in a circle, in closed form: chords of one length, each turned against the last by one
/// angle.
///
/// With s = |v|, b0 = (p . v)/s, d = (p x v)/s: half a chord is C = sqrt(R^2 - d^2), hits come at (C - b0)/s and then
/// every 2 C/s, and each turns the path by beta = pi - 2 a, sin a = d/R (Berry, Eur. J. Phys. 2, 91 (1981): the circular
/// billiard).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Chords {
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

impl Chords {
    /// The path that starts with this particle, inside a circle of this radius or on it.
    #[must_use]
    pub fn of(start: Particle, radius: f64) -> Self {
        // Below this the square of the speed has lost its digits, and the way in any time of ours is nothing.
        let square = dot(start.velocity, start.velocity);
        let speed = if square > f64::MIN_POSITIVE { square.sqrt() } else { 0.0 };
        let (along, offset) = if speed > 0.0 {
            let direction = [start.velocity[0] / speed, start.velocity[1] / speed];
            (dot(start.position, direction), cross(start.position, direction))
        } else {
            (0.0, 0.0)
        };
        // C^2 = R^2 - d^2 = (R^2 - p^2) + b0^2: without cancellation, and exact for a start on the wall.
        let half_chord = (room_to_wall(start.position, radius) + along * along).sqrt();
        Self { start, radius, speed, along, offset, half_chord }
    }

    /// Whether the path slides along the wall: its chords are so flat that they differ from the wall by less than the
    /// rounding of R (C^2 / 2R < 2^-53 R). Single hits have no meaning then and are not counted; the limit of their
    /// impulse is.
    #[must_use]
    pub fn slides(&self) -> bool {
        self.half_chord * self.half_chord < f64::EPSILON * self.radius * self.radius
    }

    /// Hits in (0, t], k = floor((b0 + s t + C) / (2 C)); a hit at the start itself counts as soon as t > 0.
    #[must_use]
    pub fn hits(&self, time: f64) -> u64 {
        if self.slides() || time <= 0.0 {
            return 0;
        }
        let chords = (self.along + self.speed * time + self.half_chord) / (2.0 * self.half_chord);
        // The cast rounds toward zero: at or above zero that is the floor, and below zero nothing was hit yet.
        chords as u64
    }

    /// Normal impulse on the wall over the particle's mass, m/s: 2 s C/R a hit; for a path that slides s^2 t/R.
    #[must_use]
    pub fn impulse_per_mass(&self, hits: u64, time: f64) -> f64 {
        if self.slides() {
            self.speed * self.speed * time / self.radius
        } else {
            hits as f64 * (2.0 * self.speed * self.half_chord / self.radius)
        }
    }

    /// The flight of this time t >= 0 from the start:
    /// p(t) = Rot(k beta) [(b0 + s t - 2 C k) v^ - d n^], n^ = (-v^y, v^x), v(t) = Rot(k beta) v.
    #[must_use]
    pub fn flight(&self, time: f64) -> Flight {
        let hits = self.hits(time);
        let impulse_per_mass = self.impulse_per_mass(hits, time);
        Flight { particle: self.after(hits, time), hits, impulse_per_mass }
    }

    /// Time of a hit, counted from 1: (C - b0)/s + (j - 1) 2 C/s.
    #[must_use]
    pub fn time_of_hit(&self, hit: u64) -> f64 {
        ((self.half_chord - self.along) + 2.0 * self.half_chord * (hit as f64 - 1.0)) / self.speed
    }

    /// beta without whole turns, 2 atan2(C, |d|) with the sign of d: exact where hits are grazing.
    #[must_use]
    pub fn turn_of_a_hit(&self) -> f64 {
        let turn = 2.0 * libm::atan2(self.half_chord, self.offset.abs());
        if self.offset < 0.0 { -turn } else { turn }
    }

    /// Where the particle is at this time, after this many hits.
    pub(super) fn after(&self, hits: u64, time: f64) -> Particle {
        let Particle { position, velocity } = self.start;
        let sense = if self.offset < 0.0 { -1.0 } else { 1.0 };
        if self.slides() {
            let turn = Rotation::by(sense * (self.speed * time / self.radius));
            return Particle { position: turn.of(position), velocity: turn.of(velocity) };
        }
        if hits == 0 {
            return drifted(self.start, time);
        }
        let turn = Rotation::by(hits as f64 * self.turn_of_a_hit());
        let run = self.along + self.speed * time - 2.0 * self.half_chord * hits as f64;
        let direction = [velocity[0] / self.speed, velocity[1] / self.speed];
        let unturned = [
            run * direction[0] + self.offset * direction[1],
            run * direction[1] - self.offset * direction[0],
        ];
        Particle { position: turn.of(unturned), velocity: turn.of(velocity) }
    }
}

/// A circle whose radius changes evenly, R(t) = R0 + u t; for u = 0 the container at rest.
///
/// Seen in lengths of R(t) and in the time tau = integral of dt/R^2 = t/(R0 R(t)) it is a unit circle at rest, in which particles fly
/// straight: with q = p/R and w = dq/dtau = R v - u p, free flight keeps w, and the wall's mirror v_n -> 2u - v_n becomes
/// w_n -> -w_n (Berry and Klein, J. Phys. A 17, 1805 (1984)). So every path in it has a closed form, and |R v - u p| and
/// p x v = q x w stay for ever.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Circle {
    /// Radius R0 at time 0, m.
    pub radius: f64,
    /// Speed u of the wall, outwards, m/s.
    pub wall_speed: f64,
}

impl Circle {
    /// R(t), m.
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
        let way = self.radius * scaled_time;
        self.radius * way / (1.0 - self.wall_speed * way)
    }

    /// (q, w) of a particle at this time.
    #[must_use]
    pub fn scaled(&self, particle: Particle, time: f64) -> Particle {
        let radius = self.radius_at(time);
        let Particle { position: [x, y], velocity: [vx, vy] } = particle;
        Particle {
            position: [x / radius, y / radius],
            velocity: [radius * vx - self.wall_speed * x, radius * vy - self.wall_speed * y],
        }
    }

    /// The particle of (q, w) at this time: p = R q, v = w/R + u q.
    #[must_use]
    pub fn unscaled(&self, scaled: Particle, time: f64) -> Particle {
        let radius = self.radius_at(time);
        let Particle { position: [x, y], velocity: [wx, wy] } = scaled;
        Particle {
            position: [radius * x, radius * y],
            velocity: [wx / radius + self.wall_speed * x, wy / radius + self.wall_speed * y],
        }
    }

    /// Impulse on the wall over the mass, m/s, of one hit with the normal component w_n: 2 (v_n - u) = 2 w_n / R, and
    /// 1/R = 1/R0 - u tau.
    #[must_use]
    pub fn impulse_of_hit(&self, normal: f64, scaled_time: f64) -> f64 {
        2.0 * normal * (1.0 / self.radius - self.wall_speed * scaled_time)
    }
}

/// Rot(angle), anticlockwise.
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

/// R^2 - p^2, and zero for a particle that rounding put outside.
#[inline(always)]
fn room_to_wall(position: [f64; 2], radius: f64) -> f64 {
    let distance = dot(position, position).sqrt();
    if distance < radius { (radius - distance) * (radius + distance) } else { 0.0 }
}

/// a . b, equation (5) of the gas document.
#[must_use]
#[inline(always)]
pub fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// a x b, the component across the plane.
#[must_use]
pub fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}
