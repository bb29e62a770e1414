//! A drawing as an SVG document.

use super::Drawing;
use super::sheet::PageLayout;
use kinetoscope_recording::drawing::{Rgb, Shape};
use std::fmt::Write;

/// Draws on a white background.
pub(super) fn document(sheet: &PageLayout, drawing: &Drawing) -> String {
    let (width, height) = (sheet.width, sheet.height);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
    );
    for shape in drawing.iter().flatten() {
        // Writing to a String cannot fail.
        let _ = write_shape(&mut svg, sheet, shape);
    }
    svg + "</svg>\n"
}

fn write_shape(svg: &mut String, sheet: &PageLayout, shape: &Shape) -> std::fmt::Result {
    match shape {
        Shape::Disc { center, radius, color } => {
            let ([x, y], radius) = (sheet.place(*center), sheet.length(*radius));
            let fill = hexadecimal(*color);
            writeln!(svg, "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius:.2}\" fill=\"{fill}\"/>")
        }
        Shape::Rectangle { center, size, color } => {
            let corner = [center[0] - size[0] / 2.0, center[1] + size[1] / 2.0];
            let ([x, y], [width, height]) =
                (sheet.place(corner), size.map(|length| sheet.length(length)));
            // Neighbors overlap slightly, so that no seam is visible.
            let (width, fill) = (width + 0.3, hexadecimal(*color));
            writeln!(
                svg,
                "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" fill=\"{fill}\"/>"
            )
        }
        Shape::Segments { segments, width_px, color } => {
            let (width, stroke) = (sheet.line_width(*width_px), hexadecimal(*color));
            write!(
                svg,
                "<path fill=\"none\" stroke-linecap=\"round\" stroke-width=\"{width:.2}\" stroke=\"{stroke}\" d=\""
            )?;
            for [from, to] in segments {
                let ([x0, y0], [x1, y1]) = (sheet.place(*from), sheet.place(*to));
                write!(svg, "M{x0:.2} {y0:.2}L{x1:.2} {y1:.2}")?;
            }
            writeln!(svg, "\"/>")
        }
        Shape::Text { center, text } => {
            let ([x, y], size) = (sheet.place(*center), 1.4 * sheet.text_height());
            let baseline = y + sheet.text_height() / 2.0;
            writeln!(
                svg,
                "<text x=\"{x:.2}\" y=\"{baseline:.2}\" font-size=\"{size:.1}\" font-family=\"sans-serif\" text-anchor=\"middle\" fill=\"#202020\">{}</text>",
                escaped(text)
            )
        }
    }
}

fn hexadecimal([red, green, blue]: Rgb) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}
