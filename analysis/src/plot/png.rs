//! SVG documents as pixels: they are drawn with the program's own font, so that no pixel depends on installed fonts.

use super::canvas::DrawingError;
use kinetoscope_recording::drawing::Rgb;
use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};
use std::sync::Arc;

/// A subset of DejaVu Sans; its license is next to it.
const FONT: &[u8] = include_bytes!("font/KinetoscopeSans.ttf");
/// The name of the font in its file.
const FAMILY: &str = "Kinetoscope Sans";

/// An opaque picture, row by row from the upper left corner.
pub(crate) struct Raster {
    /// Width, px.
    pub(crate) width: u32,
    /// Height, px.
    pub(crate) height: u32,
    /// Colors.
    pub(crate) pixels: Vec<Rgb>,
}

/// Draws SVG documents. The font is loaded once.
pub(crate) struct SvgRenderer {
    options: Options<'static>,
}

impl SvgRenderer {
    /// A renderer with the program's own font.
    pub(crate) fn new() -> Self {
        let mut fonts = fontdb::Database::new();
        fonts.load_font_data(FONT.to_vec());
        fonts.set_sans_serif_family(FAMILY);
        let (font_family, fontdb) = (FAMILY.to_owned(), Arc::new(fonts));
        Self { options: Options { font_family, fontdb, ..Options::default() } }
    }

    /// Draws a document on white, enlarged by `scale`.
    ///
    /// # Errors
    /// The message of the drawing library.
    pub(crate) fn raster(&self, svg: &str, scale: f64) -> Result<Raster, DrawingError> {
        let tree = Tree::from_str(svg, &self.options).map_err(failure)?;
        let size = tree.size();
        let side = |length: f32| libm::round(f64::from(length) * scale) as u32;
        let (width, height) = (side(size.width()), side(size.height()));
        let mut pixels = Pixmap::new(width, height).ok_or_else(|| {
            DrawingError(format!("there is no image of {width} × {height} px").into())
        })?;
        pixels.fill(Color::WHITE);
        let scaled =
            Transform::from_scale(width as f32 / size.width(), height as f32 / size.height());
        resvg::render(&tree, scaled, &mut pixels.as_mut());
        let colors = pixels.pixels().iter().map(|it| [it.red(), it.green(), it.blue()]);
        Ok(Raster { width, height, pixels: colors.collect() })
    }
}

/// Draws an SVG document on white, enlarged by `scale`, as a PNG file.
///
/// # Errors
/// The message of the drawing library.
pub(crate) fn png(svg: &str, scale: f64) -> Result<Vec<u8>, DrawingError> {
    encoded(&SvgRenderer::new().raster(svg, scale)?)
}

fn encoded(raster: &Raster) -> Result<Vec<u8>, DrawingError> {
    let mut bytes = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut bytes, raster.width, raster.height);
    encoder.set_color(::png::ColorType::Rgb);
    encoder.set_depth(::png::BitDepth::Eight);
    encoder.set_compression(::png::Compression::High);
    let mut writer = encoder.write_header().map_err(failure)?;
    writer.write_image_data(raster.pixels.as_flattened()).map_err(failure)?;
    writer.finish().map_err(failure)?;
    Ok(bytes)
}

fn failure(error: impl std::fmt::Display) -> DrawingError {
    DrawingError(error.to_string().into())
}
