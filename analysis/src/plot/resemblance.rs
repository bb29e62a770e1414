//! Whether two plots of the same kind look the same, so that the second one gives no information.

use super::chart::{Chart, Curve, CurveStyle};
use super::drawing::Drawing;
use super::{Axis, Picture, Plot, PlotContent, Scale, extremes};
use kinetoscope_recording::drawing::Shape;

/// Largest distance between two plots that look the same, over the size of the plot: about the width of a line.
const TOLERANCE: f64 = 0.005;
/// Largest difference of a part of a color, of 255.
const COLOR_TOLERANCE: u8 = 8;
/// Points of a curve that are compared, evenly spaced.
const MAX_COMPARED: usize = 256;

impl Plot {
    /// Whether the plot looks like another one: all curves, or all shapes, are within a line's width of those of the other.
    pub(crate) fn resembles(&self, other: &Self) -> bool {
        match (&self.content, &other.content) {
            (PlotContent::Chart(one), PlotContent::Chart(two)) => charts_resemble(one, two),
            (PlotContent::Picture(one), PlotContent::Picture(two)) => pictures_resemble(one, two),
            _ => false,
        }
    }
}

fn charts_resemble(one: &Chart, two: &Chart) -> bool {
    let is_same_kind = |a: &Curve, b: &Curve| a.name == b.name && a.style == b.style;
    if one.x != two.x || one.y != two.y || one.curves.len() != two.curves.len() {
        return false;
    }
    if !one.curves.iter().zip(&two.curves).all(|(a, b)| is_same_kind(a, b)) {
        return false;
    }
    let all = || one.curves.iter().chain(&two.curves).flat_map(|curve| &curve.points);
    let Some(across) = Ruler::new(&one.x, all().map(|point| point.x)) else { return false };
    let ends = all().flat_map(|point| {
        let error = point.error.unwrap_or(0.0);
        [point.y - error, point.y + error]
    });
    let Some(up) = Ruler::new(&one.y, ends) else { return false };
    let place = |curve: &Curve| -> Vec<[f64; 2]> {
        let ends = curve.points.iter().flat_map(|point| {
            let error = point.error.unwrap_or(0.0);
            [point.y - error, point.y + error].map(|y| [across.place(point.x), up.place(y)])
        });
        ends.filter(|place| place.iter().all(|part| part.is_finite())).collect()
    };
    one.curves.iter().zip(&two.curves).all(|(a, b)| {
        let is_line = a.style != CurveStyle::Data;
        let (a, b) = (place(a), place(b));
        is_near(&a, &b, is_line) && is_near(&b, &a, is_line)
    })
}

/// Places on an axis from 0 to 1.
struct Ruler<'a> {
    axis: &'a Axis,
    low: f64,
    length: f64,
}

impl<'a> Ruler<'a> {
    fn new(axis: &'a Axis, values: impl Iterator<Item = f64>) -> Option<Self> {
        let places = values.map(|value| scaled(axis, value)).filter(|place| place.is_finite());
        let (low, high) = extremes(places)?;
        let length = if high > low { high - low } else { 1.0 };
        Some(Self { axis, low, length })
    }

    fn place(&self, value: f64) -> f64 {
        (scaled(self.axis, value) - self.low) / self.length
    }
}

fn scaled(axis: &Axis, value: f64) -> f64 {
    match axis.scale {
        Scale::Linear => value,
        Scale::Logarithmic => libm::log10(value),
    }
}

/// Whether each of these points is near a point of the others, or near the line through them.
fn is_near(points: &[[f64; 2]], others: &[[f64; 2]], is_line: bool) -> bool {
    let stride = points.len().div_ceil(MAX_COMPARED).max(1);
    points.iter().step_by(stride).all(|point| {
        let is_close = |distance: f64| distance <= TOLERANCE;
        others.iter().any(|other| is_close(distance(*point, [*other, *other])))
            || is_line
                && others.windows(2).any(|ends| is_close(distance(*point, [ends[0], ends[1]])))
    })
}

/// Distance of a point from a segment.
fn distance([x, y]: [f64; 2], [from, to]: [[f64; 2]; 2]) -> f64 {
    let (along, up) = (to[0] - from[0], to[1] - from[1]);
    let square = along * along + up * up;
    let part = ((x - from[0]) * along + (y - from[1]) * up) / square;
    let part = if square > 0.0 { part.clamp(0.0, 1.0) } else { 0.0 };
    libm::hypot(x - from[0] - part * along, y - from[1] - part * up)
}

fn pictures_resemble(one: &Picture, two: &Picture) -> bool {
    let layers = |drawing: &Drawing| drawing.shapes().cloned().collect::<Vec<_>>();
    let (a, b) = (layers(&one.drawing), layers(&two.drawing));
    let xs = a.iter().chain(&b).flat_map(points_of);
    let Some((left, right)) = extremes(xs.map(|point| point[0])) else { return false };
    let ys = a.iter().chain(&b).flat_map(points_of);
    let Some((bottom, top)) = extremes(ys.map(|point| point[1])) else { return false };
    let tolerance = TOLERANCE * (right - left).max(top - bottom);
    one.size == two.size
        && a.len() == b.len()
        && a.iter().zip(&b).all(|(a, b)| shapes_resemble(a, b, tolerance))
}

fn points_of(shape: &Shape) -> Vec<[f64; 2]> {
    match shape {
        Shape::Disc { center, .. }
        | Shape::Rectangle { center, .. }
        | Shape::Text { center, .. } => vec![*center],
        Shape::Segments { segments, .. } => segments.iter().flatten().copied().collect(),
    }
}

fn shapes_resemble(one: &Shape, two: &Shape, tolerance: f64) -> bool {
    let (a, b) = (points_of(one), points_of(two));
    let are_near = |(a, b): (&[f64; 2], &[f64; 2])| {
        (a[0] - b[0]).abs() <= tolerance && (a[1] - b[1]).abs() <= tolerance
    };
    let are_alike =
        |a: &[u8; 3], b: &[u8; 3]| a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) <= COLOR_TOLERANCE);
    let is_same_kind = match (one, two) {
        (
            Shape::Disc { radius: a, color: of_a, .. },
            Shape::Disc { radius: b, color: of_b, .. },
        ) => (a - b).abs() <= tolerance && are_alike(of_a, of_b),
        (Shape::Text { text: a, .. }, Shape::Text { text: b, .. }) => a == b,
        (Shape::Segments { color: a, .. }, Shape::Segments { color: b, .. })
        | (Shape::Rectangle { color: a, .. }, Shape::Rectangle { color: b, .. }) => a == b,
        _ => false,
    };
    is_same_kind && a.len() == b.len() && a.iter().zip(&b).all(are_near)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn ellipse(width: f64, height: f64, points: u32) -> Plot {
        let at = |index: u32| {
            let angle = TAU * f64::from(index) / f64::from(points);
            (width * libm::cos(angle), height * libm::sin(angle))
        };
        let axes = [Axis::linear("x", "AU"), Axis::linear("y", "AU")];
        Plot::chart("orbit", "Orbit", axes, vec![Curve::line("path", 0, (0..=points).map(at))])
    }

    /// Guarantee: a near-identical circle resembles the first one, whatever its number of points. Control: circles of another
    /// size or shape, and curves with other names or axes, do not.
    #[test]
    fn near_identical_circles_resemble_each_other() {
        let circle = ellipse(1.0, 1.0, 200);
        assert!(ellipse(1.001, 0.999, 333).resembles(&circle));
        for other in [ellipse(1.05, 1.05, 200), ellipse(1.0, 0.97, 200), ellipse(2.5, 2.5, 200)] {
            assert!(!other.resembles(&circle));
        }
        let axes = |x: &str| [Axis::linear(x, "AU"), Axis::linear("y", "AU")];
        let line = |x: &str, name: &str| {
            Plot::chart("a", "a", axes(x), vec![Curve::line(name, 0, [(0.0, 0.0), (1.0, 1.0)])])
        };
        assert!(line("x", "a").resembles(&line("x", "a")));
        assert!(!line("x", "b").resembles(&line("x", "a")));
        assert!(!line("z", "a").resembles(&line("x", "a")));
    }

    #[test]
    fn points_with_other_errors_or_places_do_not_resemble_each_other() {
        let plot = |y: f64, error: f64| {
            let points = [(0.0, 1.0), (1.0, y)].map(|(x, y)| super::super::Point {
                x,
                y,
                error: Some(error),
            });
            let curve = Curve {
                name: String::new(),
                style: CurveStyle::Data,
                color: 0,
                points: points.to_vec(),
            };
            Plot::chart("a", "a", [Axis::linear("x", ""), Axis::linear("y", "")], vec![curve])
        };
        assert!(plot(2.0, 0.1).resembles(&plot(2.001, 0.1)));
        assert!(!plot(2.0, 0.1).resembles(&plot(2.1, 0.1)));
        assert!(!plot(2.0, 0.1).resembles(&plot(2.0, 0.2)));
    }

    #[test]
    fn pictures_of_other_states_or_speeds_do_not_resemble_each_other() {
        let picture = |x: f64, color: [u8; 3]| {
            let disc = |x| Shape::Disc { center: [x, 0.0], radius: 0.1, color };
            let drawing = Drawing { discs: vec![disc(0.0), disc(x)], ..Drawing::default() };
            let (caption, size) = (format!("x = {x}"), String::new());
            let content = PlotContent::Picture(Picture { caption, size, drawing });
            Plot { stem: "a".to_owned(), title: "a".to_owned(), content }
        };
        assert!(picture(1.001, [9; 3]).resembles(&picture(1.0, [9; 3])));
        assert!(!picture(1.1, [9; 3]).resembles(&picture(1.0, [9; 3])));
        assert!(!picture(1.0, [99; 3]).resembles(&picture(1.0, [9; 3])));
    }
}
