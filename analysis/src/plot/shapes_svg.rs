//! Drawings as SVG elements.

use super::drawing::Drawing;
use super::page::PageLayout;
use kinetoscope_console::text::xml;
use kinetoscope_recording::drawing::{Rgb, Shape};
use std::fmt::Write;

/// A whole document on a white background.
pub(crate) fn document(page: &PageLayout, drawing: &Drawing) -> String {
    let (width, height) = (page.width, page.height);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">\n<rect width=\"100%\" height=\"100%\" fill=\"#FFFFFF\"/>\n"
    );
    write_shapes(&mut svg, page, drawing);
    svg + "</svg>\n"
}

/// Writes the shapes of a drawing as SVG elements, without discs outside the page.
pub(super) fn write_shapes(svg: &mut String, page: &PageLayout, drawing: &Drawing) {
    for shape in drawing.shapes().filter(|shape| page.shows(shape)) {
        // Writing to a String cannot fail.
        let _ = write_shape(svg, page, shape);
    }
}

fn write_shape(svg: &mut String, page: &PageLayout, shape: &Shape) -> std::fmt::Result {
    match shape {
        Shape::Disc { center, radius, color } => {
            let ([x, y], radius) = (page.position(*center), page.length(*radius));
            let fill = hexadecimal(*color);
            writeln!(svg, "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius:.2}\" fill=\"{fill}\"/>")
        }
        Shape::Rectangle { center, size, color } => {
            let corner = [center[0] - size[0] / 2.0, center[1] + size[1] / 2.0];
            let ([x, y], [width, height]) =
                (page.position(corner), size.map(|length| page.length(length)));
            // No seam is visible between neighbors, at any scale: they overlap slightly, and their edges are not blended with the paper.
            let (width, fill) = (width + 0.3, hexadecimal(*color));
            writeln!(
                svg,
                "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" shape-rendering=\"crispEdges\" fill=\"{fill}\"/>"
            )
        }
        Shape::Segments { segments, width_px, color } => {
            let (width, stroke) = (page.line_width(*width_px), hexadecimal(*color));
            write!(
                svg,
                "<path fill=\"none\" stroke-linecap=\"round\" stroke-width=\"{width:.2}\" stroke=\"{stroke}\" d=\""
            )?;
            for [from, to] in segments {
                let ([x0, y0], [x1, y1]) = (page.position(*from), page.position(*to));
                write!(svg, "M{x0:.2} {y0:.2}L{x1:.2} {y1:.2}")?;
            }
            writeln!(svg, "\"/>")
        }
        Shape::Text { center, text } => {
            let ([x, y], size) = (page.position(*center), 1.4 * page.text_height());
            let baseline = y + page.text_height() / 2.0;
            writeln!(
                svg,
                "<text x=\"{x:.2}\" y=\"{baseline:.2}\" font-size=\"{size:.1}\" font-family=\"sans-serif\" text-anchor=\"middle\" fill=\"#262626\">{}</text>",
                xml(text)
            )
        }
    }
}

fn hexadecimal([red, green, blue]: Rgb) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}
