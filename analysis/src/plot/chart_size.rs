//! Size of a chart on request: pixels, and the size of its letters.

use super::canvas::DrawingError;
use kinetoscope_console::Message;

/// Width of the report's charts, px.
pub(super) const WIDTH: i32 = 640;
/// Letters of legend and captions in the report, px: a chart with larger ones is laid out on a smaller canvas and enlarged.
const REPORT_FONT_PX: f64 = 16.0;
/// Height of the report's charts, with one row of the legend, over their width.
const HEIGHT_OVER_WIDTH: f64 = 490.0 / 640.0;
/// Minimum width over the size of the letters, so that tick labels do not overlap.
const MIN_WIDTH_OVER_FONT: f64 = 25.0;
/// Minimum height of the plotted area over the size of the letters.
const MIN_PLOT_HEIGHT_OVER_FONT: f64 = 8.0;

/// The size of a chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ChartSize {
    width_px: u32,
    /// `None` for the proportions of the report, or more if title and legend need it.
    height_px: Option<u32>,
    font_px: f64,
}

impl ChartSize {
    /// A chart of this size, by default with the proportions of the report's.
    ///
    /// # Errors
    /// A width that the letters do not fit, with the minimum.
    pub(crate) fn new(
        width_px: Option<u32>,
        height_px: Option<u32>,
        font_px: Option<f64>,
    ) -> Result<Self, Message> {
        let width_px = width_px.unwrap_or(WIDTH.unsigned_abs());
        let font_px = font_px.unwrap_or(REPORT_FONT_PX);
        let min = (MIN_WIDTH_OVER_FONT * font_px).ceil();
        if f64::from(width_px) < min {
            return Err(Message::new(
                format!(
                    "a width of {width_px} px is too small for letters of {font_px} px; must be at least {min} px"
                ),
                "increase --width or reduce --font-size",
            ));
        }
        Ok(Self { width_px, height_px, font_px })
    }

    /// The height before title and legend are known.
    fn usual_height(self) -> u32 {
        let usual = || libm::round(f64::from(self.width_px) * HEIGHT_OVER_WIDTH) as u32;
        self.height_px.unwrap_or_else(usual)
    }

    /// The number of pixels at a scale.
    pub(crate) fn pixels(self, scale: f64) -> f64 {
        f64::from(self.width_px) * f64::from(self.usual_height()) * scale * scale
    }

    fn laid_out(self, length_px: u32) -> i32 {
        libm::round(f64::from(length_px) * REPORT_FONT_PX / self.font_px) as i32
    }

    /// The width on which the chart is laid out with letters of the report's size.
    pub(super) fn layout_width(self) -> i32 {
        self.laid_out(self.width_px)
    }

    /// The height of the plotted area on that canvas, given the height of everything around it.
    ///
    /// # Errors
    /// A height that has no room for the plot.
    pub(super) fn plot_height(self, around: i32) -> Result<i32, DrawingError> {
        let plot_height = self.laid_out(self.usual_height()) - around;
        let min = (MIN_PLOT_HEIGHT_OVER_FONT * REPORT_FONT_PX) as i32;
        let Some(height_px) = self.height_px else { return Ok(plot_height.max(min)) };
        if plot_height < min {
            let min = (f64::from(around + min) * self.font_px / REPORT_FONT_PX).ceil();
            return Err(DrawingError(Message::new(
                format!(
                    "a height of {height_px} px is too small for title, legend and letters of {} px; must be at least {min} px",
                    self.font_px
                ),
                "increase --height or reduce --font-size",
            )));
        }
        Ok(plot_height)
    }

    /// The SVG in the requested size instead of the size of its layout.
    pub(super) fn shown(self, svg: &str, width: i32, height: i32) -> String {
        let width_px = self.width_px;
        let needed = || libm::round(f64::from(height) * self.font_px / REPORT_FONT_PX) as u32;
        let height_px = self.height_px.unwrap_or_else(needed);
        let laid_out = format!("width=\"{width}\" height=\"{height}\"");
        svg.replacen(&laid_out, &format!("width=\"{width_px}\" height=\"{height_px}\""), 1)
    }
}
