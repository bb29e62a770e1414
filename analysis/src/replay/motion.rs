//! How a particle moves between two frames, for the paths of pictures; the script of the report (`film.js`) does the same for motion.
//!
//! With velocities, the path is the cubic that has the positions and velocities of both frames (Hermite), unless these contradict each other, because of a
//! contact, an event, or a frame that is too long. Without velocities it is a line, if the path turns by at most 30 degrees at both ends.

use super::still::Point;

/// Largest difference of the displacement from the mean of the velocities, over the displacement: that of an arc of 82 degrees.
const MOST_MISSED: f64 = 0.17;
/// Largest turn of a path without velocities, radians.
const MOST_TURN: f64 = std::f64::consts::PI / 6.0;
/// Largest estimated error of a path, in longer sides of the view.
const MAX_ERROR: f64 = 1.0 / 400.0;

/// A part of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PathPart {
    /// A straight line.
    Line,
    /// A cubic with these displacements per frame at its ends.
    Curve([[f64; 2]; 2]),
}

impl PathPart {
    /// The place at a fraction of the way from one position to the next.
    pub(super) fn at(self, [from, to]: [[f64; 2]; 2], fraction: f64) -> [f64; 2] {
        let axis = |axis: usize| {
            let way = to[axis] - from[axis];
            let [a, b] = match self {
                Self::Line => [way; 2],
                Self::Curve(slopes) => slopes.map(|slope| slope[axis]),
            };
            let rest = fraction * (a + b - 2.0 * way);
            from[axis] + fraction * (a + fraction * (3.0 * way - 2.0 * a - b + rest))
        };
        [axis(0), axis(1)]
    }
}

/// The path of a particle from one frame to the next; `None` if it is not known. Lengths are in longer sides of the view.
pub(super) fn path_part(
    pair: [&Point; 2],
    around: [Option<&Point>; 2],
    seconds: f64,
    side: f64,
) -> Option<PathPart> {
    let [from, to] = pair;
    if !(from.x.is_finite() && from.y.is_finite() && to.x.is_finite() && to.y.is_finite()) {
        return None;
    }
    let slopes = pair.map(|point| point.velocity.map(|part| f64::from(part) * seconds));
    if slopes.iter().flatten().any(|part| !part.is_finite()) {
        let turn = |one: &Point, middle: &Point, other: &Point| {
            let (a, b) =
                ([middle.x - one.x, middle.y - one.y], [other.x - middle.x, other.y - middle.y]);
            libm::atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]).abs()
        };
        let before = around[0].map_or(0.0, |before| turn(before, from, to));
        let after = around[1].map_or(0.0, |after| turn(from, to, after));
        // Comparisons with NaN are false.
        return (before <= MOST_TURN && after <= MOST_TURN).then_some(PathPart::Line);
    }
    let [first, last] = slopes;
    let length = libm::hypot(first[0], first[1]).max(libm::hypot(last[0], last[1]));
    let miss = libm::hypot(
        to.x - from.x - (first[0] + last[0]) / 2.0,
        to.y - from.y - (first[1] + last[1]) / 2.0,
    );
    // On an arc of the angle a, the mean of the velocities misses the displacement by a²/12 of it, and the cubic misses the arc by a³/384.
    let error =
        if length > 0.0 { length * libm::pow(12.0 * miss / length, 1.5) / 384.0 } else { 0.0 };
    // A turn by more than a right angle may be a bounce, which has the same ends as a throw.
    let is_smooth = first[0] * last[0] + first[1] * last[1] >= 0.0;
    let is_known =
        is_smooth && miss <= MOST_MISSED * length + 1e-9 * side && error <= MAX_ERROR * side;
    is_known.then_some(PathPart::Curve(slopes))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A point on the unit circle.
    fn on_circle(angle: f64, has_velocity: bool) -> Point {
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        let velocity = if has_velocity { [-sin as f32, cos as f32] } else { [f32::NAN; 2] };
        Point { x: cos, y: sin, speed: 1.0, velocity, radius: 0.0, spin: 0.0 }
    }

    /// Guarantee: a drawn part of a circle is within 0.5 % of the picture's width of the circle, and parts that would miss it by more are not drawn. Control: a
    /// chord of 30 degrees with velocities misses it by more.
    #[test]
    fn drawn_parts_of_a_circle_are_on_it() {
        let mut drawn = 0;
        for degrees in 1..=720 {
            let angle = f64::from(degrees).to_radians();
            let [from, to] = [on_circle(0.0, true), on_circle(angle, true)];
            let Some(part) = path_part([&from, &to], [None; 2], angle, 2.0) else { continue };
            assert!(part != PathPart::Line, "a line of {degrees} degrees");
            drawn = drawn.max(degrees);
            for step in 0..=20 {
                let ends = [[from.x, from.y], [to.x, to.y]];
                let [x, y] = part.at(ends, f64::from(step) / 20.0);
                assert!((libm::hypot(x, y) - 1.0).abs() <= 0.005 * 2.0, "{degrees} degrees");
            }
        }
        assert!((40..90).contains(&drawn), "{drawn}");
        let chord_misses_by = 1.0 - libm::cos(libm::asin(0.5));
        assert!(chord_misses_by > 0.005 * 2.0);
    }

    #[test]
    fn paths_without_velocities_are_lines_that_hardly_turn() {
        for (degrees, is_drawn) in [(10.0_f64, true), (29.0, true), (31.0, false), (150.0, false)] {
            let points: Vec<Point> = (0..4)
                .map(|index| on_circle(f64::from(index) * degrees.to_radians(), false))
                .collect();
            let part =
                path_part([&points[1], &points[2]], [Some(&points[0]), Some(&points[3])], 1.0, 2.0);
            assert_eq!(part, is_drawn.then_some(PathPart::Line), "{degrees} degrees");
        }
    }

    /// A particle that bounces between two frames.
    #[test]
    fn path_through_a_contact_is_not_drawn() {
        let point = |x: f64, velocity: f32| Point {
            x,
            y: 0.0,
            speed: 1.0,
            velocity: [velocity, 0.0],
            radius: 0.0,
            spin: 0.0,
        };
        assert_eq!(path_part([&point(0.5, 1.0), &point(0.5, -1.0)], [None; 2], 1.0, 2.0), None);
        assert!(path_part([&point(0.0, 1.0), &point(1.0, 1.0)], [None; 2], 1.0, 2.0).is_some());
    }
}
