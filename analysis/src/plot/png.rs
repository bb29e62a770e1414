//! Charts as PNG: the SVG document is drawn with the program's own font, so that the pixels do not depend on installed fonts.

use super::canvas::DrawingError;
use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};
use std::sync::Arc;

/// A subset of DejaVu Sans; its license is next to it.
const FONT: &[u8] = include_bytes!("font/KinetoscopeSans.ttf");
/// The name of the font in its file.
const FAMILY: &str = "Kinetoscope Sans";

/// Draws an SVG document on white, enlarged by `scale`.
///
/// # Errors
/// The message of the drawing library.
pub(crate) fn png(svg: &str, scale: f64) -> Result<Vec<u8>, DrawingError> {
    let mut fonts = fontdb::Database::new();
    fonts.load_font_data(FONT.to_vec());
    fonts.set_sans_serif_family(FAMILY);
    let options =
        Options { font_family: FAMILY.to_owned(), fontdb: Arc::new(fonts), ..Options::default() };
    let tree = Tree::from_str(svg, &options).map_err(failure)?;
    let size = tree.size();
    let side = |length: f32| (f64::from(length) * scale).round() as u32;
    let (width, height) = (side(size.width()), side(size.height()));
    let mut pixels = Pixmap::new(width, height)
        .ok_or_else(|| DrawingError(format!("there is no image of {width} × {height} px")))?;
    pixels.fill(Color::WHITE);
    let scaled = Transform::from_scale(width as f32 / size.width(), height as f32 / size.height());
    resvg::render(&tree, scaled, &mut pixels.as_mut());
    encoded(&pixels)
}

/// Encodes an opaque image.
fn encoded(pixels: &Pixmap) -> Result<Vec<u8>, DrawingError> {
    let rgb: Vec<u8> =
        pixels.pixels().iter().flat_map(|it| [it.red(), it.green(), it.blue()]).collect();
    let mut bytes = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut bytes, pixels.width(), pixels.height());
    encoder.set_color(::png::ColorType::Rgb);
    encoder.set_depth(::png::BitDepth::Eight);
    encoder.set_compression(::png::Compression::High);
    let mut writer = encoder.write_header().map_err(failure)?;
    writer.write_image_data(&rgb).map_err(failure)?;
    writer.finish().map_err(failure)?;
    Ok(bytes)
}

fn failure(error: impl std::fmt::Display) -> DrawingError {
    DrawingError(error.to_string())
}
