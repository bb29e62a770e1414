//! Plots as SVG: charts with axes, and pictures of a state to scale.

mod axis;
mod canvas;
mod chart;
pub(crate) mod drawing;
pub(crate) mod page;
mod picture;
pub(crate) mod shapes_svg;

pub(crate) use axis::{Axis, Scale, extremes, short_number, three_digits};
pub(crate) use chart::{Chart, Curve, CurveStyle, Point, thinned};
pub(crate) use picture::Picture;

use serde::{Deserialize, Serialize};

/// A plot that could not be drawn, with the message of the drawing library.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub(crate) struct DrawingError(pub(crate) String);

/// A plot with its title and its file name without the extension.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Plot {
    pub(crate) stem: String,
    pub(crate) title: String,
    pub(crate) content: PlotContent,
}

/// What a plot shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum PlotContent {
    /// Curves and points over two axes.
    Chart(Chart),
    /// A picture of particles in their container, to scale.
    Picture(Picture),
}

impl Plot {
    /// A chart with unequal axes.
    pub(crate) fn chart(
        stem: impl Into<String>,
        title: impl Into<String>,
        [x, y]: [Axis; 2],
        curves: Vec<Curve>,
    ) -> Self {
        let content = PlotContent::Chart(Chart { x, y, equal_aspect: false, curves });
        Self { stem: stem.into(), title: title.into(), content }
    }

    /// The plot as an SVG document; `None` if it is empty.
    pub(crate) fn svg(&self) -> Result<Option<String>, DrawingError> {
        match &self.content {
            PlotContent::Chart(chart) => chart.svg(&self.title),
            PlotContent::Picture(picture) => Ok(picture.svg(&self.title)),
        }
    }
}
