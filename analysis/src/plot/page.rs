//! Transformation from lengths to pixels of a picture.

use super::drawing::Drawing;
use kinetoscope_recording::drawing::Shape;
use std::num::NonZeroU32;

/// Margin over the width of the drawing.
const MARGIN: f64 = 0.03;
/// Maximum ratio of height to width; taller drawings are cut off at the top.
const MAX_HEIGHT_OVER_WIDTH: f64 = 2.0;
/// Height of letters over the picture's width.
const TEXT_HEIGHT: f64 = 0.019;
/// Width of a letter over its height.
const LETTER: f64 = 1.0;
/// Width of a viewer's panel that recorded line widths refer to, px.
const PANEL_WIDTH: f64 = 800.0;

/// Page of a picture, or of all pictures of an animation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PageLayout {
    /// Width, px.
    pub(crate) width: u32,
    /// Height, px.
    pub(crate) height: u32,
    /// Pixels per length unit.
    scale: f64,
    left: f64,
    top: f64,
}

impl PageLayout {
    /// Creates a page for the walls and the color bar; without walls drawn as lines, for everything in these drawings.
    /// `None` for an empty drawing.
    pub(crate) fn new(drawings: &[Drawing], width: NonZeroU32) -> Option<Self> {
        let width = width.get();
        let is_line = |shape: &Shape| matches!(shape, Shape::Segments { .. });
        let mut bounds = Bounds::NOTHING;
        for Drawing { trail, walls, discs, legend } in drawings {
            let enclosed = walls.iter().any(is_line);
            let beyond = trail.iter().chain(discs).filter(|_| !enclosed);
            walls.iter().chain(legend).chain(beyond).for_each(|shape| bounds.include(shape));
        }
        let letter = LETTER * TEXT_HEIGHT * (bounds.high[0] - bounds.low[0]);
        for shape in drawings.iter().flat_map(Drawing::shapes) {
            if let Shape::Text { center, text } = shape {
                bounds.include_box(*center, [text.chars().count() as f64 * letter / 2.0, 0.0]);
            }
        }
        let [low, high] = [bounds.low, bounds.high];
        let [across, up] = [high[0] - low[0], high[1] - low[1]];
        if !(across > 0.0 && up > 0.0 && across.is_finite() && up.is_finite()) {
            return None;
        }
        let margin = MARGIN * across;
        let scale = f64::from(width) / (across + 2.0 * margin);
        let height =
            (scale * (up + 2.0 * margin)).ceil().min(MAX_HEIGHT_OVER_WIDTH * f64::from(width));
        Some(Self {
            width,
            height: height as u32,
            scale,
            left: low[0] - margin,
            // The lower edge stays in place if the top is cut off.
            top: low[1] - margin + height / scale,
        })
    }

    /// Position of a point from the upper left corner, px.
    pub(super) fn position(&self, point: [f64; 2]) -> [f64; 2] {
        [(point[0] - self.left) * self.scale, (self.top - point[1]) * self.scale]
    }

    /// Whether a disc is at least partly on the page; other shapes are always drawn.
    pub(super) fn shows(&self, shape: &Shape) -> bool {
        let Shape::Disc { center, radius, .. } = shape else { return true };
        let (position, radius) = (self.position(*center), self.length(*radius));
        // Comparisons with NaN are false.
        [self.width, self.height].into_iter().zip(position).all(|(side, coordinate)| {
            coordinate + radius >= 0.0 && coordinate - radius <= f64::from(side)
        })
    }

    /// Converts a length to px.
    pub(super) fn length(&self, length: f64) -> f64 {
        length * self.scale
    }

    /// Converts a line width to px.
    pub(super) fn line_width(&self, width_px: f64) -> f64 {
        (width_px * f64::from(self.width) / PANEL_WIDTH).max(1.0)
    }

    /// Height of letters, px.
    pub(super) fn text_height(&self) -> f64 {
        TEXT_HEIGHT * f64::from(self.width)
    }
}

struct Bounds {
    low: [f64; 2],
    high: [f64; 2],
}

impl Bounds {
    const NOTHING: Self = Self { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };

    fn include(&mut self, shape: &Shape) {
        match shape {
            Shape::Disc { center, radius, .. } => self.include_box(*center, [*radius; 2]),
            Shape::Rectangle { center, size, .. } => {
                self.include_box(*center, size.map(|length| length / 2.0));
            }
            Shape::Text { center, .. } => self.include_box(*center, [0.0; 2]),
            Shape::Segments { segments, .. } => {
                for point in segments.iter().flatten() {
                    self.include_box(*point, [0.0; 2]);
                }
            }
        }
    }

    fn include_box(&mut self, center: [f64; 2], reach: [f64; 2]) {
        for axis in 0..2 {
            self.low[axis] = self.low[axis].min(center[axis] - reach[axis]);
            self.high[axis] = self.high[axis].max(center[axis] + reach[axis]);
        }
    }
}
