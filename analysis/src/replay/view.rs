//! The region that a replay shows.

use super::encoding::{ABSENT, LARGEST, quantized};
use serde::{Deserialize, Serialize};

/// Distance from the median position, in median distances, beyond which a position without walls is not in the view: after a
/// numerical blow-up, the others remain visible.
const MAX_MEDIAN_DISTANCES: f64 = 100.0;

/// Margin of a view on each side, in longer sides of what it shows.
const MARGIN: f64 = 0.08;
/// Distance of the place where walls are cut off from the border of a view, in longer sides.
const CUT: f64 = 0.015;
/// How far beyond its container a view reaches for positions outside, in longer sides of the container.
const MAX_OUTSIDE: f64 = 0.25;

/// A rectangle along the axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct View {
    /// Lower left and upper right corner.
    pub(super) corners: [[f64; 2]; 2],
}

impl View {
    /// The smallest view that contains these discs; `None` without a finite one.
    pub(super) fn containing(discs: impl Iterator<Item = [f64; 3]>) -> Option<Self> {
        let mut corners = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for [x, y, radius] in discs.filter(|disc| disc.iter().all(|part| part.is_finite())) {
            for (axis, center) in [x, y].into_iter().enumerate() {
                corners[0][axis] = corners[0][axis].min(center - radius);
                corners[1][axis] = corners[1][axis].max(center + radius);
            }
        }
        let [low, high] = corners;
        (high[0] >= low[0] && high[1] >= low[1]).then(|| Self { corners }.widened())
    }

    /// The view of particles without walls: all of them, except for those that are very far from the others.
    pub(super) fn of_particles(discs: &[[f64; 3]]) -> Option<Self> {
        let middle = [0, 1].map(|axis| median(discs.iter().map(|disc| disc[axis])));
        let [x, y] = [middle[0]?, middle[1]?];
        let distance = |disc: &[f64; 3]| libm::hypot(disc[0] - x, disc[1] - y);
        let limit = MAX_MEDIAN_DISTANCES * median(discs.iter().map(distance))?;
        let near = discs.iter().copied().filter(|disc| limit == 0.0 || distance(disc) <= limit);
        Self::containing(near)
    }

    /// The view with a height and a width of at least a tenth of the longer side, so that a line of particles is visible.
    fn widened(self) -> Self {
        let [low, high] = self.corners;
        let longer = (high[0] - low[0]).max(high[1] - low[1]);
        let least = if longer > 0.0 { longer / 10.0 } else { 1.0 };
        let grow = |axis: usize| ((least - (high[axis] - low[axis])) / 2.0).max(0.0);
        let grow = [grow(0), grow(1)];
        let corner =
            |corner: [f64; 2], sign: f64| [corner[0] + sign * grow[0], corner[1] + sign * grow[1]];
        Self { corners: [corner(low, -1.0), corner(high, 1.0)] }
    }

    /// The view of particles within a container: all of their positions, except for those far outside.
    pub(super) fn of_contained(
        discs: impl Iterator<Item = [f64; 3]>,
        container: Self,
    ) -> Option<Self> {
        let limits = container.grown(MAX_OUTSIDE * container.longer_side());
        Self::containing(discs.filter(|[x, y, _]| limits.contains([*x, *y])))
    }

    /// The view with a margin around what it shows.
    pub(super) fn with_margin(self) -> Self {
        self.grown(MARGIN * self.longer_side())
    }

    /// Where walls are cut off, within the margin.
    pub(super) fn cut(&self) -> Self {
        self.grown(-CUT * self.longer_side())
    }

    fn grown(&self, by: f64) -> Self {
        let [low, high] = self.corners;
        Self { corners: [low.map(|part| part - by), high.map(|part| part + by)] }
    }

    /// The part that is within another view.
    pub(super) fn within(self, other: Self) -> Self {
        let [low, high] = self.corners;
        let [least, most] = other.corners;
        let corners = [[0, 1].map(|k| low[k].max(least[k])), [0, 1].map(|k| high[k].min(most[k]))];
        Self { corners }
    }

    fn contains(&self, place: [f64; 2]) -> bool {
        let [low, high] = self.corners;
        (0..2).all(|axis| (low[axis]..=high[axis]).contains(&place[axis]))
    }

    /// The part of a segment that is inside; `None` if there is none. Liang and Barsky, ACM Transactions on Graphics 3 (1984) 1.
    pub(super) fn clipped(&self, [from, to]: [[f64; 2]; 2]) -> Option<[[f64; 2]; 2]> {
        let [low, high] = self.corners;
        let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
        for axis in 0..2 {
            let length = to[axis] - from[axis];
            let ends = [low[axis] - from[axis], high[axis] - from[axis]];
            if length == 0.0 {
                if ends[0] > 0.0 || ends[1] < 0.0 {
                    return None;
                }
                continue;
            }
            let [first, last] = ends.map(|distance| distance / length);
            enters = enters.max(first.min(last));
            leaves = leaves.min(first.max(last));
        }
        let at = |share: f64| match share {
            0.0 => from,
            1.0 => to,
            _ => [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis])),
        };
        (enters <= leaves).then(|| [at(enters), at(leaves)])
    }

    /// The longer side.
    pub(super) fn longer_side(&self) -> f64 {
        let [low, high] = self.corners;
        (high[0] - low[0]).max(high[1] - low[1])
    }
}

/// The median of the finite numbers.
fn median(numbers: impl Iterator<Item = f64>) -> Option<f64> {
    let mut numbers: Vec<f64> = numbers.filter(|number| number.is_finite()).collect();
    let middle = numbers.len() / 2;
    if numbers.is_empty() {
        return None;
    }
    Some(*numbers.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// The stored coordinates.
pub(super) struct Range {
    /// Position of the coordinates 0.
    pub(super) origin: [f64; 2],
    /// Length of a step.
    pub(super) step: f64,
}

impl Range {
    /// The view and half of its longer side on all sides.
    pub(super) fn around(view: View) -> Self {
        let side = view.longer_side();
        let origin = view.corners[0].map(|low| low - side / 2.0);
        Self { origin, step: 2.0 * side / f64::from(LARGEST) }
    }

    /// The coordinates of a position; absent outside of the range.
    pub(super) fn stored(&self, [x, y]: [f64; 2]) -> [u16; 2] {
        let stored =
            [quantized(x - self.origin[0], self.step), quantized(y - self.origin[1], self.step)];
        if stored.contains(&ABSENT) { [ABSENT; 2] } else { stored }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn view_of_a_pile_is_its_part_of_the_container_and_cuts_walls_off() {
        let container = View { corners: [[0.0, 0.0], [100.0, 100.0]] };
        let pile = [[10.0, 1.0, 1.0], [29.0, 9.0, 1.0], [200.0, 1.0, 1.0]];
        let view = View::of_contained(pile.into_iter(), container).unwrap();
        assert_eq!(view.corners, [[9.0, 0.0], [30.0, 10.0]]);
        let view = view.with_margin();
        assert_eq!(view.corners, [[9.0 - 1.68, -1.68], [30.0 + 1.68, 11.68]]);
        let cut = view.cut();
        let floor = cut.clipped([[0.0, 0.0], [100.0, 0.0]]).unwrap();
        assert_eq!(floor, [[cut.corners[0][0], 0.0], [cut.corners[1][0], 0.0]]);
        assert_eq!(cut.clipped([[0.0, 50.0], [100.0, 50.0]]), None);
        let inside = [[10.0, 1.0], [12.0, 3.0]];
        assert_eq!(cut.clipped(inside), Some(inside));
    }

    #[test]
    fn view_contains_the_particles_but_not_one_that_blew_up() {
        let mut discs: Vec<[f64; 3]> = (0..100_i32).map(|x| [f64::from(x), 7.0, 0.5]).collect();
        discs.push([1e30, 1.0, 0.5]);
        discs.push([f64::NAN, 1.0, 0.5]);
        let view = View::of_particles(&discs).unwrap();
        assert_eq!(view.corners, [[-0.5, 2.0], [99.5, 12.0]]);
        assert_eq!(view.longer_side(), 100.0);
        assert_eq!(View::of_particles(&[]), None);
        assert!(View::of_particles(&[[3.0, 4.0, 0.0]]).unwrap().longer_side() > 0.0);
    }
}
