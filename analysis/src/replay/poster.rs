//! The frame that a replay shows first, and what of it.

use super::still::{Point, Still};
use super::view::View;
use crate::models::contract::Extent;
use kinetoscope_manifest::ViewColor;

/// Fraction of the particles below which the last frame is not shown first: the others have left.
const FEWEST_AT_END: f64 = 0.34;
/// Displacement and speed below which a run ends at rest where it began, in longer sides of the view and in its largest mean speed.
const BACK_AT_START: f64 = 0.05;
const AT_REST: f64 = 0.02;

/// Number of particles from which a run is a bed, and its mean speed at rest in top speeds, as in the page.
const FEWEST_IN_BED: usize = 50;
const BED_AT_REST: f64 = 0.05;

/// The frame nearest to a time.
pub(super) fn nearest(stills: &[&Still], time: f64) -> usize {
    let distance = |frame: &usize| (stills[*frame].time - time).abs();
    let nearest = (0..stills.len()).min_by(|one, other| distance(one).total_cmp(&distance(other)));
    nearest.unwrap_or_default()
}

/// The box of a bed at rest with a margin, within the view, so that a pile is not a small part of its picture; `None` for other frames.
pub(super) fn bed(still: &Still, view: View, top_speed: f64) -> Option<View> {
    let points = || still.points.iter().filter(|point| point.x.is_finite());
    if still.points.len() < FEWEST_IN_BED || !is_at_rest(still, top_speed) {
        return None;
    }
    View::containing(points().map(Point::disc)).map(|found| found.with_margin().within(view))
}

/// What the color of a particle means unless the manifest requests it: of discs at rest, which all have one speed, their height at the start.
pub(super) fn usual_color(still: &Still, top_speed: f64, extent: &Extent) -> ViewColor {
    match is_at_rest(still, top_speed) && !extent.has_trails {
        true => ViewColor::Height,
        false => ViewColor::Speed,
    }
}

/// Whether several particles are at rest compared with the top speed.
fn is_at_rest(still: &Still, top_speed: f64) -> bool {
    let points = still.points.iter().filter(|point| point.x.is_finite());
    let speeds: f64 = points.map(|point| f64::from(point.speed)).sum();
    still.points.len() > 1 && speeds < BED_AT_REST * still.points.len() as f64 * top_speed
}

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

#[cfg(test)]
mod tests {
    use super::super::lines::Lines;
    use super::*;
    use std::sync::Arc;

    /// Frames of particles at these heights, with these speeds.
    fn frames(heights: &[&[f64]], speeds: &[f32]) -> Vec<Still> {
        let point = |y: f64, speed: f32| Point {
            y,
            x: 0.0,
            speed,
            velocity: [0.0; 2],
            radius: 0.1,
            spin: 0.0,
        };
        let still = |(number, (heights, speed)): (usize, (&&[f64], &f32))| Still {
            number: number as u64,
            time: number as f64,
            points: heights.iter().map(|y| point(*y, *speed)).collect(),
            lines: Arc::new(Lines::of(&[])),
            forces: Vec::new(),
        };
        heights.iter().zip(speeds).enumerate().map(still).collect()
    }

    fn first(heights: &[&[f64]], speeds: &[f32]) -> usize {
        let stills = frames(heights, speeds);
        let stills: Vec<&Still> = stills.iter().collect();
        let discs = stills.iter().flat_map(|still| &still.points).map(Point::disc);
        poster(&stills, View::containing(discs).unwrap())
    }

    #[test]
    fn first_picture_is_the_end_unless_another_frame_tells_more() {
        // A fall to rest.
        assert_eq!(first(&[&[9.0], &[5.0], &[0.0]], &[0.0, 3.0, 0.0]), 2);
        // A throw that ends at rest where it began: its top.
        assert_eq!(first(&[&[0.0], &[9.0], &[5.0], &[0.0]], &[3.0, 0.1, 2.0, 0.0]), 1);
        // Control: in motion, as an orbit, its end.
        assert_eq!(first(&[&[0.0], &[9.0], &[0.0]], &[3.0, 3.0, 3.0]), 2);
        // A container that empties: while half of the particles are left.
        let (four, two, none): (&[f64], &[f64], &[f64]) = (&[1.0, 2.0, 3.0, 4.0], &[1.0, 2.0], &[]);
        assert_eq!(first(&[four, two, none], &[1.0; 3]), 1);
        assert_eq!(first(&[four], &[1.0]), 0);
    }

    #[test]
    fn requested_frame_is_the_nearest_one() {
        let stills = frames(&[&[1.0], &[2.0], &[3.0]], &[1.0; 3]);
        let stills: Vec<&Still> = stills.iter().collect();
        assert_eq!([-1.0, 0.4, 0.6, 9.0].map(|time| nearest(&stills, time)), [0, 0, 1, 2]);
    }
}
