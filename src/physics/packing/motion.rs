//! How hard discs of mass 1 move: free flight, contact, and what a collision does to velocities. Pure functions.
//!
//! Symbols: r separation of two centers (second minus first), v relative velocity (second minus first), s contact
//! distance (the diameter), n unit vector along r, g = v . n, alpha coefficient of restitution. Lengths, times and
//! velocities are dimensionless.

pub(super) use crate::collision_time::time_to_contact;

/// Puts (0.75 s)^2 far from a power of two for radii that are powers of two, 1 and 0.5 among them, and keeps whole numbers exact.
const SCALE: f64 = 0.75;

/// A vector in the plane.
pub(super) type Vector = [f64; 2];

/// What a pair collision leads to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PairCollision {
    /// Velocities of the first and of the second disc afterward.
    pub(super) velocities: [Vector; 2],
    /// Magnitude of the momentum that was handed over along the line of centers.
    pub(super) normal_impulse: f64,
}

/// Free flight: x(t) = x + v t.
#[inline(always)]
pub(super) fn free_flight(position: Vector, velocity: Vector, duration: f64) -> Vector {
    [position[0] + velocity[0] * duration, position[1] + velocity[1] * duration]
}

/// Time until two growing discs touch, |r + v t| = s + a t, a the sum of the rates of their radii, or [`f64::MAX`].
///
/// CollisionPartner A = v^2 - a^2, B = r . v - a s, C = r^2 - s^2 the smaller root of A t^2 + 2 B t + C = 0 that is not negative, each
/// time in the form without cancellation (Lubachevsky and Stillinger, J. Stat. Phys. 60, 561, 1990):
///
/// t = C / (-B + sqrt(B^2 - A C)) where the surfaces approach (B < 0), else (B + sqrt(B^2 - A C)) / -A, if A < 0.
#[inline(always)]
pub(super) fn time_to_growing_contact(
    r: Vector,
    v: Vector,
    contact_distance: f64,
    growth: f64,
) -> f64 {
    let leading = v[0] * v[0] + v[1] * v[1] - growth * growth;
    let approach = r[0] * v[0] + r[1] * v[1] - growth * contact_distance;
    let gap = r[0] * r[0] + r[1] * r[1] - contact_distance * contact_distance;
    let discriminant = approach * approach - leading * gap;
    if approach < 0.0 {
        if gap <= 0.0 {
            return 0.0;
        }
        return if discriminant >= 0.0 { gap / (discriminant.sqrt() - approach) } else { f64::MAX };
    }
    if leading < 0.0 && discriminant >= 0.0 {
        (approach + discriminant.sqrt()) / -leading
    } else {
        f64::MAX
    }
}

/// Elastic collision of two growing discs: elastic for their surfaces, which part with a more than the centers,
/// g' = -g + 2 a (Lubachevsky and Stillinger, as above).
pub(super) fn growing_pair_collision(
    r: Vector,
    velocities: [Vector; 2],
    growth: f64,
) -> PairCollision {
    let [first, second] = velocities;
    let distance = (r[0] * r[0] + r[1] * r[1]).sqrt();
    let normal = [r[0] / distance, r[1] / distance];
    let g = (second[0] - first[0]) * normal[0] + (second[1] - first[1]) * normal[1];
    let impulse = g - growth;
    let change = [impulse * normal[0], impulse * normal[1]];
    PairCollision {
        velocities: [
            [first[0] + change[0], first[1] + change[1]],
            [second[0] - change[0], second[1] - change[1]],
        ],
        normal_impulse: impulse.abs(),
    }
}

/// Time until one coordinate reaches a line that it moves toward. Zero where rounding put it a little beyond.
/// The speed along the coordinate is not zero.
#[inline(always)]
pub(super) fn time_to_line(coordinate: f64, speed: f64, line: f64) -> f64 {
    let wait = (line - coordinate) / speed;
    if wait > 0.0 { wait } else { 0.0 }
}

/// Collision of two equal discs: the normal part g of the relative velocity becomes -alpha g, and each disc takes
/// (1 + alpha) g / 2. The tangential part and the momentum are kept.
///
/// v1' = v1 + (1 + alpha)/2 g n,   v2' = v2 - (1 + alpha)/2 g n
///
/// (packing document, `colisiona`.) CollisionPartner g n = (v . r) r / r^2 there is no root to round. Rounding must not lean to one
/// side: r^2 of many collisions lies within some roundings of s^2, and where that is a power of two, as for discs of radius
/// 1, the grain of numbers doubles there, which would heat elastic discs by 2e-12 in a hundred million collisions of a
/// thousand. So r^2 is taken of another length, [`SCALE`] r.
/// `restitution` is alpha as a function of the speed of approach -g.
#[inline(always)]
pub(super) fn pair_collision(
    r: Vector,
    velocities: [Vector; 2],
    restitution: impl Fn(f64) -> f64,
) -> PairCollision {
    let [first, second] = velocities;
    let scaled = [SCALE * r[0], SCALE * r[1]];
    let square = scaled[0] * scaled[0] + scaled[1] * scaled[1];
    let approach = (second[0] - first[0]) * scaled[0] + (second[1] - first[1]) * scaled[1];
    let distance = square.sqrt();
    let impulse = 0.5 * (1.0 + restitution(-approach / distance)) * approach;
    let change = [impulse * scaled[0] / square, impulse * scaled[1] / square];
    PairCollision {
        velocities: [
            [first[0] + change[0], first[1] + change[1]],
            [second[0] - change[0], second[1] - change[1]],
        ],
        normal_impulse: impulse.abs() / distance,
    }
}

/// Collision with a wall across `axis`: that component changes sign, then the outgoing direction is turned by `angle`
/// (counter-clockwise, rad); `None` where this would turn the disc back into the wall.
///
/// w = (|u| / |T u'|) T u',   T = [[cos phi, -sin phi], [sin phi, cos phi]],   u' the reflection of u
///
/// (packing document, equation 1.) The factor is 1 up to rounding: it keeps rounding from adding up over many walls.
pub(super) fn wall_collision(velocity: Vector, axis: usize, angle: f64) -> Option<Vector> {
    let mut reflected = velocity;
    reflected[axis] = -reflected[axis];
    if angle == 0.0 {
        return Some(reflected);
    }
    let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
    let turned =
        [reflected[0] * cosine - reflected[1] * sine, reflected[1] * cosine + reflected[0] * sine];
    let factor = speed(velocity) / speed(turned);
    let leaving = [turned[0] * factor, turned[1] * factor];
    (leaving[axis] * reflected[axis] > 0.0).then_some(leaving)
}

/// A coordinate of a periodic box that is centered on the origin, brought back into it.
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

/// Second vector minus the first.
pub(super) fn difference(first: Vector, second: Vector) -> Vector {
    [second[0] - first[0], second[1] - first[1]]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Law: the outgoing direction is the reflected one plus phi, and the speed is the incoming one.
    /// Source: packing document, equation 3. Tolerance: 4 grains of 1. Control: the document's program, which turns vy
    /// with the vx that it has just turned, would be off by phi sin(phi) in vy, 0.01 at phi = 0.1.
    #[test]
    fn a_wall_turns_by_exactly_the_angle() {
        for (speed_in, theta, phi) in [(1.0, 0.7, 0.1), (3e-5, 1.1, -0.4), (2e7, 0.3, 0.9)] {
            let incoming = [speed_in * libm::cos(theta), speed_in * libm::sin(theta)];
            // The right wall: the reflected direction is pi - theta.
            let out = wall_collision(incoming, 0, phi).unwrap();
            let direction = std::f64::consts::PI - theta + phi;
            let expected = [speed_in * libm::cos(direction), speed_in * libm::sin(direction)];
            for axis in 0..2 {
                assert!((out[axis] - expected[axis]).abs() < 4.0 * f64::EPSILON * speed_in);
            }
            assert!((speed(out) / speed_in - 1.0).abs() < 4.0 * f64::EPSILON);
        }
        assert_eq!(wall_collision([1.0, 0.1], 0, 1.7), None, "this would go back into the wall");
    }

    /// Law: |r + v t| = s. Source: closed form, for a relative velocity along x: t = x - sqrt(s^2 - y^2). Setup: a distance
    /// of 1e6 diameters, nearly grazing. Tolerance: 4 grains of t; the discriminant as (r . v)^2 - v^2 (r^2 - s^2) would be
    /// off by 1e-4.
    #[test]
    fn far_and_grazing_discs_meet_in_time() {
        for offset in [0.0, 1.0, 1.9, 1.999] {
            let expected = 2e6 - (4.0_f64 - offset * offset).sqrt();
            let time = time_to_contact([2e6, offset], [-1.0, 0.0], 2.0);
            assert!((time - expected).abs() < 4.0 * 2e6 * f64::EPSILON, "offset {offset}: {time}");
        }
    }

    /// Law: near contact t = (r^2 - s^2) / (-2 r . v), however small the gap is. Setup: gaps of some grains of a number, in
    /// directions all round. Tolerance: 1e-9 relative; -r . v - sqrt(…) would leave no digit and may be below 0.
    #[test]
    fn a_gap_of_a_few_grains_is_closed_in_its_time() {
        for step in 0..1000 {
            let angle = 0.01 * f64::from(step);
            let distance = 2.0 * (1.0 + 3.0 * f64::EPSILON);
            let r = [distance * libm::cos(angle), distance * libm::sin(angle)];
            let v = [-0.7 * r[0] + 0.2 * r[1], -0.7 * r[1] - 0.2 * r[0]];
            let gap = r[0] * r[0] + r[1] * r[1] - 4.0;
            let time = time_to_contact(r, v, 2.0);
            let expected = if gap > 0.0 { gap / (2.0 * 0.7 * 4.0) } else { 0.0 };
            assert!((time - expected).abs() <= 1e-9 * expected, "{time:e} and {expected:e}");
        }
    }
}
