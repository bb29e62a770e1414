//! Plots as SVG: charts with axes, and pictures of a state to scale.

mod axis;
mod canvas;
mod chart;
pub mod drawing;
mod error;
pub(crate) mod page;
mod picture;
pub(crate) mod shapes_svg;

pub use axis::{Axis, Scale, short_number, three_digits};
pub use chart::{Chart, Curve, CurveStyle, Point, thinned};
pub use error::DrawingError;
pub use picture::Picture;

use serde::{Deserialize, Serialize};

/// A plot with its file name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Plot {
    /// Curves and points over two axes.
    Chart(Chart),
    /// A picture of particles in their container, to scale.
    Picture(Picture),
}

impl Plot {
    /// The file name without its extension.
    #[must_use]
    pub fn stem(&self) -> &str {
        match self {
            Self::Chart(chart) => &chart.stem,
            Self::Picture(picture) => &picture.stem,
        }
    }

    /// The title.
    #[must_use]
    pub fn title(&self) -> &str {
        match self {
            Self::Chart(chart) => &chart.title,
            Self::Picture(picture) => &picture.title,
        }
    }

    /// Appends the run to the title.
    pub fn add_to_title(&mut self, run: &str) {
        let title = match self {
            Self::Chart(chart) => &mut chart.title,
            Self::Picture(picture) => &mut picture.title,
        };
        if !run.is_empty() {
            *title = format!("{title}: {run}");
        }
    }

    /// The plot as an SVG document; `None` if it is empty.
    ///
    /// # Errors
    /// An error of the drawing library.
    pub fn svg(&self) -> Result<Option<String>, DrawingError> {
        match self {
            Self::Chart(chart) => chart.svg(),
            Self::Picture(picture) => Ok(picture.svg()),
        }
    }
}
