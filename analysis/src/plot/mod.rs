//! Plots as SVG: curves with axes, and pictures of a state to scale.

mod axis;
mod canvas;
mod chart;
mod picture;

pub use axis::{Axis, Scale, short_number, three_digits};
pub use chart::{Chart, Curve, CurveStyle, Point, thinned};
pub use picture::{Container, DrawnParticle, InnerWall, MOST_BODIES, Picture};

use serde::{Deserialize, Serialize};

/// A plot, and the file that it goes to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Plot {
    /// Curves and points over two axes.
    Chart(Chart),
    /// Particles in their container, to scale.
    Picture(Picture),
}

/// A plot that could not be drawn, with the message of the drawing library.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct DrawingError(pub String);

impl Plot {
    /// The file's name without its ending.
    #[must_use]
    pub fn stem(&self) -> &str {
        match self {
            Self::Chart(chart) => &chart.stem,
            Self::Picture(picture) => &picture.stem,
        }
    }

    /// What is shown.
    #[must_use]
    pub fn title(&self) -> &str {
        match self {
            Self::Chart(chart) => &chart.title,
            Self::Picture(picture) => &picture.title,
        }
    }

    /// Says in the title which run it is about.
    pub fn add_to_title(&mut self, run: &str) {
        let title = match self {
            Self::Chart(chart) => &mut chart.title,
            Self::Picture(picture) => &mut picture.title,
        };
        if !run.is_empty() {
            *title = format!("{title}: {run}");
        }
    }

    /// The plot as an SVG document; `None` where there is nothing to show.
    ///
    /// # Errors
    /// What the drawing library could not draw.
    pub fn svg(&self) -> Result<Option<String>, DrawingError> {
        match self {
            Self::Chart(chart) => chart.svg(),
            Self::Picture(picture) => picture.svg().map(Some),
        }
    }
}
