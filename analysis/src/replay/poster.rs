//! The frame that a replay shows first.

use super::still::Still;
use super::view::View;

/// Fraction of the particles below which the last frame is not shown first: the others have left.
const FEWEST_AT_END: f64 = 0.34;
/// Displacement and speed below which a run ends at rest where it began, in longer sides of the view and in its largest mean speed.
const BACK_AT_START: f64 = 0.05;
const AT_REST: f64 = 0.02;

/// The most telling frame: the last one; the last one with half of the particles if most have left; and the one farthest from the start if the run ends at
/// rest where it began.
pub(super) fn poster(stills: &[&Still], view: View) -> usize {
    let count = |still: &&Still| still.points.iter().filter(|point| point.x.is_finite()).count();
    let counts: Vec<usize> = stills.iter().map(count).collect();
    let (last, most) =
        (stills.len().saturating_sub(1), counts.iter().copied().max().unwrap_or_default());
    if (counts.get(last).copied().unwrap_or_default() as f64) < FEWEST_AT_END * most as f64 {
        return counts.iter().rposition(|count| 2 * count >= most).unwrap_or(last);
    }
    let mean = |numbers: &mut dyn Iterator<Item = f64>| {
        let (sum, count) = numbers
            .filter(|number| number.is_finite())
            .fold((0.0, 0), |(sum, count), number| (sum + number, count + 1));
        sum / f64::from(count.max(1))
    };
    let speeds = stills
        .iter()
        .map(|still| mean(&mut still.points.iter().map(|point| f64::from(point.speed))));
    let speeds: Vec<f64> = speeds.collect();
    let displacement = |still: &&Still| {
        let pairs = still.points.iter().zip(&stills[0].points);
        mean(&mut pairs.map(|(point, start)| libm::hypot(point.x - start.x, point.y - start.y)))
    };
    let displacements: Vec<f64> = stills.iter().map(displacement).collect();
    let farthest = (0..stills.len())
        .max_by(|one, other| displacements[*one].total_cmp(&displacements[*other]));
    let is_back =
        displacements.get(last).is_some_and(|end| *end <= BACK_AT_START * view.longer_side());
    let top = speeds.iter().copied().fold(0.0, f64::max);
    let is_at_rest = speeds.get(last).is_some_and(|end| *end <= AT_REST * top);
    if is_back && is_at_rest { farthest.unwrap_or(last) } else { last }
}
