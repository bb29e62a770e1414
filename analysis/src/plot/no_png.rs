//! Builds without the feature `png` draw no pixels.

use super::canvas::DrawingError;
use kinetoscope_console::Message;
use kinetoscope_recording::drawing::Rgb;

/// A picture, which such a build does not draw.
pub(crate) struct Raster {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) pixels: Vec<Rgb>,
}

/// A renderer that rejects every document.
pub(crate) struct SvgRenderer;

impl SvgRenderer {
    pub(crate) const fn new() -> Self {
        Self
    }

    #[expect(clippy::unused_self, reason = "the signature is that of the other build")]
    pub(crate) fn raster(&self, _: &str, _: f64) -> Result<Raster, DrawingError> {
        Err(DrawingError(Message::new("this build cannot write .png", "name a .svg")))
    }
}

pub(crate) fn png(svg: &str, scale: f64) -> Result<Vec<u8>, DrawingError> {
    SvgRenderer::new().raster(svg, scale).map(|_| Vec::new())
}
