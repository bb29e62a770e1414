//! The lines of a frame: the container, lines for comparison, bodies at rest, and texts.

use super::view::View;
use crate::plot::drawing::is_container;
use kinetoscope_recording::drawing::{Rgb, Shape};
use serde::{Deserialize, Serialize};

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct LineStyle {
    color: Rgb,
    width_px: f64,
}

impl LineStyle {
    /// The color and the width in the notation of the script.
    pub(super) fn described(&self) -> (String, f64) {
        let [r, g, b] = self.color;
        (format!("#{r:02x}{g:02x}{b:02x}"), self.width_px)
    }
}

/// Color of the exact orbit in the recordings, and in `report/replay.js`.
const EXACT_ORBIT: Rgb = [0x2e, 0x9e, 0x5b];

/// The lines of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Lines {
    /// The two ends of each segment.
    pub(super) ends: Vec<[f64; 2]>,
    /// The style of each segment.
    pub(super) styles: Vec<LineStyle>,
    /// Bodies at rest: x, y and radius.
    pub(super) bodies: Vec<[f64; 3]>,
    /// Texts with their middles.
    pub(super) labels: Vec<([f64; 2], String)>,
    /// Ends of the segments of the container.
    container: Vec<[f64; 2]>,
}

impl Lines {
    pub(super) fn of(shapes: &[Shape]) -> Self {
        let mut lines = Self::default();
        for shape in shapes {
            match shape {
                Shape::Segments { segments, width_px, color } => {
                    let style = LineStyle { color: *color, width_px: *width_px };
                    lines.styles.extend(segments.iter().map(|_| style));
                    lines.ends.extend(segments.iter().flatten());
                    if is_container(shape) {
                        lines.container.extend(segments.iter().flatten());
                    }
                }
                Shape::Disc { center: [x, y], radius, .. } => lines.bodies.push([*x, *y, *radius]),
                Shape::Text { center, text } => lines.labels.push((*center, text.clone())),
                Shape::Rectangle { .. } => {}
            }
        }
        lines
    }

    /// The ends of each segment where it is cut off; not numbers for a segment that is outside.
    pub(super) fn clipped(&self, region: View) -> Vec<[f64; 2]> {
        let segments = self.ends.chunks_exact(2).map(|ends| region.clipped([ends[0], ends[1]]));
        segments.flat_map(|segment| segment.unwrap_or([[f64::NAN; 2]; 2])).collect()
    }

    /// What the paths and the lines for comparison of an orbit are.
    pub(super) fn key_of_trails(&self) -> String {
        let is_exact = |style: &LineStyle| style.color == EXACT_ORBIT;
        let exact = if self.styles.iter().any(is_exact) { ", green the exact orbit" } else { "" };
        let mut circles = self.labels.iter().filter(|(_, text)| text.ends_with(" AU"));
        let circle = circles.next().map(|(_, text)| format!(", gray a circle of {text}"));
        format!(" Blue is the path{exact}{}.", circle.unwrap_or_default())
    }

    /// What the container extends over, as discs of no size.
    pub(super) fn container(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        self.container.iter().map(|[x, y]| [*x, *y, 0.0])
    }

    /// What the other lines and the bodies extend over, as discs.
    pub(super) fn extent(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        self.ends.iter().map(|[x, y]| [*x, *y, 0.0]).chain(self.bodies.iter().copied())
    }
}

/// The texts of a scene, in its order.
pub(super) fn texts(shapes: &[Shape]) -> Vec<String> {
    let text = |shape: &Shape| match shape {
        Shape::Text { text, .. } => Some(text.clone()),
        _ => None,
    };
    shapes.iter().filter_map(text).collect()
}

/// The different styles of all frames, in the order of their first use.
pub(super) fn styles<'a>(frames: impl Iterator<Item = &'a Lines>) -> Vec<LineStyle> {
    let mut styles = Vec::new();
    for style in frames.flat_map(|lines| &lines.styles) {
        if !styles.contains(style) {
            styles.push(*style);
        }
    }
    styles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_keep_their_colors_and_only_walls_are_the_container() {
        let wall = Shape::Segments {
            segments: vec![[[0.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [1.0, 2.0]]],
            width_px: 3.5,
            color: [0x8c; 3],
        };
        let orbit = Shape::Segments {
            segments: vec![[[5.0, 5.0], [6.0, 6.0]]],
            width_px: 1.5,
            color: [0x2e, 0x9e, 0x5b],
        };
        let label = Shape::Text { center: [3.0, 4.0], text: "Sun".to_owned() };
        let lines = Lines::of(&[wall, orbit, label]);
        let styles = styles([&lines, &lines].into_iter());
        let described: Vec<_> = styles.iter().map(LineStyle::described).collect();
        assert_eq!(described, [("#8c8c8c".to_owned(), 3.5), ("#2e9e5b".to_owned(), 1.5)]);
        assert_eq!(lines.styles, [styles[0], styles[0], styles[1]]);
        assert_eq!(lines.ends.len(), 6);
        assert_eq!(lines.container().count(), 4);
        assert_eq!(lines.labels, [([3.0, 4.0], "Sun".to_owned())]);
    }
}
