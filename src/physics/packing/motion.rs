//! The rules of motion of hard discs. Each rule is one pure function, and these functions are the code that runs.
//!
//! | rule | function |
//! |---|---|
//! | free flight, and free fall in gravity | [`free_flight`], [`free_fall`] |
//! | time to the collision of two discs | [`time_to_contact`] |
//! | time to a wall or to the edge of a cell | [`time_to_line`]; in gravity [`time_to_rise`], [`time_to_fall`] |
//! | velocities after the collision of two discs | [`pair_collision`] |
//! | velocity after a wall collision, or one with an obstacle | [`wall_collision`], [`obstacle_collision`] |
//! | the same for discs that grow | [`time_to_growing_contact`], [`growing_pair_collision`], [`growing_wall_collision`] |
//!
//! Symbols: x position, v velocity, t time; r separation of the centers and g relative velocity of a pair (second minus
//! first), s contact distance (sum of the radii), n = r/|r|, α coefficient of restitution, φ angle of the wall noise (rad), a
//! gravity, toward smaller y. Two discs in free fall have the same acceleration, so that [`time_to_contact`] is exact for them.
//! The mass of a disc is 1. Lengths, times and velocities are dimensionless.

pub(super) use crate::collision_time::time_to_contact;

/// Scales the separation of colliding discs, whose square is then far from a power of two if the radius is one, as 1 and
/// 0.5 are. The product of the factor with an integer is exact.
const SCALE: f64 = 0.75;

/// A vector in the plane.
pub(super) type Vector = [f64; 2];

/// The effect of a collision of two discs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PairCollision {
    /// Velocities of the first and of the second disc after the collision.
    pub(super) velocities: [Vector; 2],
    /// Magnitude of the momentum transferred along the line of centers.
    pub(super) normal_impulse: f64,
}

/// Free flight: x(t) = x + v t.
#[inline(always)]
pub(super) fn free_flight(position: Vector, velocity: Vector, duration: f64) -> Vector {
    [position[0] + velocity[0] * duration, position[1] + velocity[1] * duration]
}

/// Position and velocity after free fall: x(t) = x + v t − a t²/2, v(t) = v − a t. Without gravity, the bits are those of
/// [`free_flight`].
#[inline(always)]
pub(super) fn free_fall(
    position: Vector,
    velocity: Vector,
    gravity: f64,
    duration: f64,
) -> (Vector, Vector) {
    let fall = gravity * duration;
    let [x, y] = free_flight(position, velocity, duration);
    ([x, y - 0.5 * fall * duration], [velocity[0], velocity[1] - fall])
}

/// Time until a disc reaches a line at a height h above it, h = v t − a t²/2, or [`f64::MAX`] if it turns before:
///
/// t = 2 h / (v + √(v² − 2 a h))
#[inline(always)]
pub(super) fn time_to_rise(height: f64, speed: f64, gravity: f64) -> f64 {
    let square = speed * speed - 2.0 * gravity * height;
    let time = 2.0 * height / (speed + square.sqrt());
    let time = if time > 0.0 { time } else { 0.0 };
    if (speed > 0.0) & (square >= 0.0) { time } else { f64::MAX }
}

/// Time until a disc falls to a line at a depth h below it, h = −v t + a t²/2, in the forms without cancellation:
///
/// t = (v + √(v² + 2 a h)) / a if it rises at first, else 2 h / (√(v² + 2 a h) − v)
#[inline(always)]
pub(super) fn time_to_fall(depth: f64, speed: f64, gravity: f64) -> f64 {
    let square = speed * speed + 2.0 * gravity * depth;
    let root = if square > 0.0 { square.sqrt() } else { 0.0 };
    let time = if speed > 0.0 { (speed + root) / gravity } else { 2.0 * depth / (root - speed) };
    if time > 0.0 { time } else { 0.0 }
}

/// Time until a coordinate reaches a line toward which it moves:
///
/// t = (line − x) / v
///
/// The time is 0 if rounding placed the coordinate slightly beyond the line. The speed is not 0.
#[inline(always)]
pub(super) fn time_to_line(coordinate: f64, speed: f64, line: f64) -> f64 {
    let time = (line - coordinate) / speed;
    if time > 0.0 { time } else { 0.0 }
}

/// Velocities after the collision of two equal discs with restitution:
///
/// v1' = v1 + (1 + α)/2 (g·n) n,   v2' = v2 − (1 + α)/2 (g·n) n
///
/// The normal component g·n of the relative velocity becomes −α g·n; the tangential component and the momentum are
/// conserved. `restitution` returns α for the approach speed −g·n. Source: packing exercise, `colisiona`; Allen and
/// Tildesley, Computer Simulation of Liquids (2017), section 3.7.
///
/// Rounding: (g·n) n is written as (g·r) r / r², which needs no square root. In many collisions r² differs from s² by a few
/// rounding errors. If s² is a power of two, the spacing of numbers doubles there, and the biased rounding would heat elastic
/// discs by 2e-12 in 1e8 collisions of 1e3 discs. Therefore r is replaced by [`SCALE`] r.
#[inline(always)]
pub(super) fn pair_collision(
    r: Vector,
    velocities: [Vector; 2],
    restitution: impl Fn(f64) -> f64,
) -> PairCollision {
    let [first, second] = velocities;
    let scaled = [SCALE * r[0], SCALE * r[1]];
    let square = scaled[0] * scaled[0] + scaled[1] * scaled[1];
    let g_dot_r = (second[0] - first[0]) * scaled[0] + (second[1] - first[1]) * scaled[1];
    let distance = square.sqrt();
    let impulse = 0.5 * (1.0 + restitution(-g_dot_r / distance)) * g_dot_r;
    let change = [impulse * scaled[0] / square, impulse * scaled[1] / square];
    PairCollision {
        velocities: [
            [first[0] + change[0], first[1] + change[1]],
            [second[0] - change[0], second[1] - change[1]],
        ],
        normal_impulse: impulse.abs() / distance,
    }
}

/// Velocity of a disc after a collision with a fixed obstacle, magnitude of its impulse and change of its energy: that of one of two discs that
/// collide with opposite velocities.
///
/// v' = v − (1 + α) (v·n) n
///
/// Nothing changes if rounding lets the disc part from the obstacle already.
pub(super) fn obstacle_collision(
    r: Vector,
    velocity: Vector,
    restitution: impl Fn(f64) -> f64,
) -> (Vector, f64, f64) {
    if velocity[0] * r[0] + velocity[1] * r[1] <= 0.0 {
        return (velocity, 0.0, 0.0);
    }
    let both = [velocity, velocity.map(|component| -component)];
    let restitution = |relative_speed: f64| restitution(0.5 * relative_speed);
    let found = pair_collision(r, both, restitution);
    (found.velocities[0], found.normal_impulse, 0.5 * energy_gain(r, both, restitution))
}

/// Change of the kinetic energy of two discs in a collision with restitution, −(1 − α²)/4 (g·n)².
pub(super) fn energy_gain(
    r: Vector,
    [first, second]: [Vector; 2],
    restitution: impl Fn(f64) -> f64,
) -> f64 {
    let g_dot_r = (second[0] - first[0]) * r[0] + (second[1] - first[1]) * r[1];
    let square = r[0] * r[0] + r[1] * r[1];
    let alpha = restitution(-g_dot_r / square.sqrt());
    -0.25 * (1.0 - alpha * alpha) * g_dot_r * g_dot_r / square
}

/// Velocity after a collision with a wall normal to `axis`: specular reflection, then rotation by φ (counterclockwise).
/// Returns `None` if the rotated velocity points into the wall.
///
/// v' = (|v| / |R u|) R u,   R = [[cos φ, −sin φ], [sin φ, cos φ]],   u the specular reflection of v
///
/// Source: packing exercise, equation 1. The factor |v| / |R u| is 1 up to rounding; without it, rounding errors of the
/// speed would accumulate.
pub(super) fn wall_collision(velocity: Vector, axis: usize, angle: f64) -> Option<Vector> {
    let mut reflected = velocity;
    reflected[axis] = -reflected[axis];
    if angle == 0.0 {
        return Some(reflected);
    }
    let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
    let rotated =
        [reflected[0] * cosine - reflected[1] * sine, reflected[1] * cosine + reflected[0] * sine];
    let factor = speed(velocity) / speed(rotated);
    let outgoing = [rotated[0] * factor, rotated[1] * factor];
    // The sign, because the product of two small numbers is 0.
    (outgoing[axis] * reflected[axis].signum() > 0.0).then_some(outgoing)
}

/// Time until two growing discs touch, |r + g t| = s + a t with a the sum of the growth rates of their radii, or
/// [`f64::MAX`] if they never do.
///
/// With A = g² − a², B = r·g − a s and C = r² − s², this is the smaller non-negative root of A t² + 2 B t + C = 0 in the
/// form without cancellation (Lubachevsky and Stillinger, J. Stat. Phys. 60 (1990) 561):
///
/// t = C / (−B + √(B² − A C)) if the surfaces approach (B < 0), else (B + √(B² − A C)) / −A if A < 0
#[inline(always)]
pub(super) fn time_to_growing_contact(
    r: Vector,
    g: Vector,
    contact_distance: f64,
    growth_rate: f64,
) -> f64 {
    let a = g[0] * g[0] + g[1] * g[1] - growth_rate * growth_rate;
    let b = r[0] * g[0] + r[1] * g[1] - growth_rate * contact_distance;
    let c = r[0] * r[0] + r[1] * r[1] - contact_distance * contact_distance;
    let discriminant = b * b - a * c;
    if b < 0.0 {
        if c <= 0.0 {
            return 0.0;
        }
        return if discriminant >= 0.0 { c / (discriminant.sqrt() - b) } else { f64::MAX };
    }
    if a < 0.0 && discriminant >= 0.0 { (b + discriminant.sqrt()) / -a } else { f64::MAX }
}

/// Velocities after the collision of two growing discs, elastic with respect to their surfaces. The sum of the growth rates
/// of the radii is a:
///
/// g'·n = −g·n + 2 a
///
/// Source: Lubachevsky and Stillinger, J. Stat. Phys. 60 (1990) 561.
pub(super) fn growing_pair_collision(
    r: Vector,
    velocities: [Vector; 2],
    growth_rate: f64,
) -> PairCollision {
    let [first, second] = velocities;
    let distance = (r[0] * r[0] + r[1] * r[1]).sqrt();
    let normal = [r[0] / distance, r[1] / distance];
    let g_dot_n = (second[0] - first[0]) * normal[0] + (second[1] - first[1]) * normal[1];
    let impulse = g_dot_n - growth_rate;
    let change = [impulse * normal[0], impulse * normal[1]];
    PairCollision {
        velocities: [
            [first[0] + change[0], first[1] + change[1]],
            [second[0] - change[0], second[1] - change[1]],
        ],
        normal_impulse: impulse.abs(),
    }
}

/// Velocity after a collision of a growing disc with the lower or upper wall normal to `axis`, elastic with respect to the
/// disc's surface, with b the growth rate of the radius and m the wall's normal into the box:
///
/// v'·m = −v·m + 2 b
pub(super) fn growing_wall_collision(
    velocity: Vector,
    axis: usize,
    is_upper: bool,
    growth_rate: f64,
) -> Vector {
    let gain = 2.0 * growth_rate;
    let mut outgoing = velocity;
    outgoing[axis] = -velocity[axis] + if is_upper { -gain } else { gain };
    outgoing
}

/// A coordinate of a periodic box that is centered on the origin, wrapped into the box.
pub(super) fn wrapped(coordinate: f64, side: f64) -> f64 {
    if coordinate >= 0.5 * side {
        coordinate - side
    } else if coordinate < -0.5 * side {
        coordinate + side
    } else {
        coordinate
    }
}

/// |v|.
pub(super) fn speed(velocity: Vector) -> f64 {
    (velocity[0] * velocity[0] + velocity[1] * velocity[1]).sqrt()
}

/// The second vector minus the first.
pub(super) fn difference(first: Vector, second: Vector) -> Vector {
    [second[0] - first[0], second[1] - first[1]]
}
