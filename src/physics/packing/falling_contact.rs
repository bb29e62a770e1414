//! The time at which a falling disc touches a fixed obstacle: the first root of a polynomial of fourth degree.
//!
//! Between two roots of its derivative, a polynomial is monotone and has at most one root, which bisection finds to the last digit. So the roots of
//! the derivatives are found one after the other, from the linear one on, without closed forms, which would cancel.

use super::motion::Vector;

/// Steps to a root at most: those of Newton's method, or half of the interval where they would leave it.
const MAX_STEPS: u32 = 100;

/// Number of coefficients.
const TERMS: usize = 5;

/// Time until a falling disc touches a fixed obstacle at the separation r, |r − v t + a t²/2| = s, or [`f64::MAX`] if it does not before `until`:
/// the first time at which |r|² − s² falls below zero. A disc that overlaps due to rounding touches now if it approaches, and else when it has
/// returned to the distance that it has now.
pub(super) fn time_to_obstacle(r: Vector, v: Vector, gravity: f64, s: f64, until: f64) -> f64 {
    let apart = r[0] * r[0] + r[1] * r[1];
    let approach = r[0] * v[0] + r[1] * v[1];
    let gap = apart - s * s;
    if gap <= 0.0 && approach > 0.0 {
        return 0.0;
    }
    let square = v[0] * v[0] + v[1] * v[1];
    let way = (square.sqrt() + 0.5 * gravity * until) * until;
    if s + way < apart.sqrt() {
        return f64::MAX;
    }
    let gap = if gap > 0.0 { gap } else { 0.0 };
    let distance =
        [gap, -2.0 * approach, square + gravity * r[1], -gravity * v[1], 0.25 * gravity * gravity];
    first_descent(distance, until)
}

/// The first time, up to an end, at which a polynomial that is not negative at 0 becomes negative; or [`f64::MAX`]. Coefficients are those of
/// ascending powers.
fn first_descent(polynomial: [f64; TERMS], end: f64) -> f64 {
    let mut derivatives = [[0.0; TERMS]; TERMS - 1];
    derivatives[0] = polynomial;
    for order in 1..TERMS - 1 {
        for power in 1..TERMS {
            derivatives[order][power - 1] = power as f64 * derivatives[order - 1][power];
        }
    }
    // Between neighboring nodes, the next lower derivative is monotone.
    let (mut nodes, mut count) = ([0.0, end, end, end, end, end], 2);
    for order in (1..TERMS - 1).rev() {
        let (mut next, mut found) = ([0.0; TERMS + 1], 1);
        for index in 1..count {
            let interval = [nodes[index - 1], nodes[index]];
            if let Some((root, _)) = root(&derivatives[order], interval) {
                (next[found], found) = (root, found + 1);
            }
        }
        next[found] = end;
        (nodes, count) = (next, found + 1);
    }
    let intervals = (1..count).map(|index| [nodes[index - 1], nodes[index]]);
    let mut roots = intervals.filter_map(|interval| root(&polynomial, interval));
    roots.find(|(_, falls)| *falls).map_or(f64::MAX, |(root, _)| root)
}

/// The root of a polynomial that is monotone in an interval, and whether it falls there; `None` without a change of the sign.
fn root(polynomial: &[f64; TERMS], [mut low, mut high]: [f64; 2]) -> Option<(f64, bool)> {
    let falls = value_and_slope(polynomial, low)[0] >= 0.0;
    if falls == (value_and_slope(polynomial, high)[0] >= 0.0) {
        return None;
    }
    let mut time = 0.5 * (low + high);
    for _ in 0..MAX_STEPS {
        let [value, slope] = value_and_slope(polynomial, time);
        (low, high) = if (value >= 0.0) == falls { (time, high) } else { (low, time) };
        let newton = time - value / slope;
        let is_inside = low < newton && newton < high;
        let next = if is_inside { newton } else { 0.5 * (low + high) };
        let step = (next - time).abs();
        time = next;
        if step <= f64::EPSILON * time {
            break;
        }
    }
    Some((time, falls))
}

fn value_and_slope(polynomial: &[f64; TERMS], time: f64) -> [f64; 2] {
    polynomial.iter().rev().fold([0.0; 2], |[value, slope], coefficient| {
        [value * time + coefficient, slope * time + value]
    })
}
