//! The canvas of plots: size, colors, text, and the legend above the axes.

use super::palette::ON_WHITE;
use kinetoscope_console::Message;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// A plot that could not be drawn, with the message of the drawing library.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", .0.what)]
pub(crate) struct DrawingError(pub(crate) Message);

/// Enlargement of the drawing, because the drawing library rounds to whole pixels; the document is shown smaller by the
/// same factor.
pub(super) const FINENESS: i32 = 8;

/// A canvas in fine pixels.
pub(super) type Canvas<'a> = DrawingArea<SVGBackend<'a>, Shift>;

pub(super) const INK: RGBColor = RGBColor(38, 38, 38);
pub(super) const PALE: RGBColor = RGBColor(222, 222, 222);

/// The color of a curve by its index.
pub(super) const fn curve_color(index: usize) -> RGBColor {
    let [red, green, blue] = ON_WHITE[index % ON_WHITE.len()];
    RGBColor(red, green, blue)
}

/// Lengths of the dashes of a theory and of the gaps between them, in shown pixels: dots for the second round of colors.
pub(super) const fn dashes(color: usize) -> [i32; 2] {
    if color < ON_WHITE.len() { [7, 4] } else { [2, 4] }
}

/// Converts a length from shown pixels to fine pixels.
pub(super) const fn fine(length: i32) -> i32 {
    length * FINENESS
}

/// Text of this size in shown pixels.
pub(super) fn text_style(size: i32, horizontal: HPos, vertical: VPos) -> TextStyle<'static> {
    TextStyle::from(("sans-serif", fine(size))).color(&INK).pos(Pos::new(horizontal, vertical))
}

/// A line of this width in shown half pixels.
pub(super) fn stroke(color: RGBColor, half_pixels: u32) -> ShapeStyle {
    ShapeStyle {
        color: color.to_rgba(),
        filled: false,
        stroke_width: half_pixels * FINENESS.unsigned_abs() / 2,
    }
}

/// Estimated maximum width of a text in shown pixels; the reader's font is unknown.
pub(super) fn text_width(text: &str, size: i32) -> i32 {
    let characters = i32::try_from(text.chars().count()).unwrap_or(i32::MAX / 100);
    characters * size / 2
}

/// Draws on a white canvas of this size in shown pixels and returns the document.
pub(super) fn draw<F>(width: i32, height: i32, content: F) -> Result<String, DrawingError>
where
    F: FnOnce(&Canvas<'_>) -> Result<(), DrawingError>,
{
    let size = (fine(width).unsigned_abs(), fine(height).unsigned_abs());
    let mut document = String::new();
    {
        let sheet = SVGBackend::with_string(&mut document, size).into_drawing_area();
        sheet.fill(&WHITE).map_err(failure)?;
        content(&sheet)?;
        sheet.present().map_err(failure)?;
    }
    let drawn = format!("width=\"{}\" height=\"{}\"", size.0, size.1);
    Ok(document.replacen(&drawn, &format!("width=\"{width}\" height=\"{height}\""), 1))
}

/// Converts an error of the drawing library.
pub(super) fn failure<E: std::error::Error>(error: E) -> DrawingError {
    DrawingError(error.to_string().into())
}
