//! Drawings of a state: the recorded scenes of a frame, or equivalent shapes for a state that was recorded without scenes.

use kinetoscope_recording::drawing::{Rgb, Shape, read_shapes};
use kinetoscope_recording::reader::{RecordedFrame, StateTable};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Maximum number of particles that are drawn from a state; with more, the file would be too large for a viewer.
const MAX_DRAWN_PARTICLES: usize = 10_000;
/// Color of walls.
const GRAY: Rgb = [0x8c; 3];
/// Line width of walls, px.
const WALL_WIDTH_PX: f64 = 3.5;
/// Corners of a circular wall.
const CIRCLE_CORNERS: u32 = 128;

/// A recorded scene that cannot be decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{topic} of frame {frame} is no drawing")]
pub(crate) struct InvalidScene {
    topic: &'static str,
    frame: u64,
}

/// The shapes of a state, layer by layer. Arrows and force chains are left out, because they would cover the particles.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Drawing {
    /// Paths so far.
    pub(crate) trail: Vec<Shape>,
    /// The container and bodies at rest.
    pub(crate) walls: Vec<Shape>,
    /// The particles.
    pub(crate) discs: Vec<Shape>,
    /// The color bar.
    pub(crate) legend: Vec<Shape>,
}

impl Drawing {
    /// Replaces the layers that a frame has scenes of; the others stay.
    ///
    /// # Errors
    /// A scene that cannot be decoded.
    pub(crate) fn update(&mut self, frame: &RecordedFrame) -> Result<(), InvalidScene> {
        for (topic, layer) in [
            ("/trail", &mut self.trail),
            ("/walls", &mut self.walls),
            ("/discs", &mut self.discs),
            ("/legend", &mut self.legend),
        ] {
            let message = frame.messages().iter().find(|message| message.topic() == topic);
            if let Some(message) = message {
                let invalid = InvalidScene { topic, frame: frame.clock.frame };
                *layer = read_shapes(message.payload()).ok_or(invalid)?;
            }
        }
        Ok(())
    }

    /// All shapes, the lowest first.
    pub(crate) fn shapes(&self) -> impl Iterator<Item = &Shape> {
        [&self.trail, &self.walls, &self.discs, &self.legend].into_iter().flatten()
    }

    /// Draws the particles of a state without scenes, colored by their speed relative to the fastest; nothing without
    /// positions. `radius` applies to states without radii.
    pub(crate) fn draw_state(&mut self, state: &StateTable, radius: f64) {
        let index = |name: &str| state.index(name);
        let (Some(x), Some(y)) = (index("x"), index("y")) else { return };
        let (velocity, radii) = (index("vx").zip(index("vy")), index("radius"));
        let speed = |row: &[f64]| velocity.map_or(0.0, |(vx, vy)| libm::hypot(row[vx], row[vy]));
        let rows = || (0..state.rows().min(MAX_DRAWN_PARTICLES)).map(|row| state.row(row));
        let max_speed = rows().map(speed).fold(f64::MIN_POSITIVE, f64::max);
        let disc = |row: &[f64]| Shape::Disc {
            center: [row[x], row[y]],
            radius: radii.map_or(radius, |column| row[column]),
            color: speed_color(speed(row) / max_speed),
        };
        self.discs = rows().map(disc).collect();
    }
}

/// The segments of all lines.
pub(crate) fn segments_of(shapes: &[Shape]) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
    shapes
        .iter()
        .flat_map(|shape| match shape {
            Shape::Segments { segments, .. } => segments.as_slice(),
            _ => &[],
        })
        .copied()
}

/// Whether a shape is a wall: lines for comparison have other colors.
pub(crate) fn is_container(shape: &Shape) -> bool {
    matches!(shape, Shape::Segments { color: GRAY, .. })
}

/// The outline of a rectangle between two corners.
pub(crate) fn rectangle([low, high]: [[f64; 2]; 2]) -> Shape {
    let corners = [low, [high[0], low[1]], high, [low[0], high[1]], low];
    wall(corners.windows(2).map(|pair| [pair[0], pair[1]]).collect())
}

/// The outline of a circle.
pub(crate) fn circle(center: [f64; 2], radius: f64) -> Shape {
    let corner = |index: u32| {
        let angle = TAU * f64::from(index) / f64::from(CIRCLE_CORNERS);
        [center[0] + radius * libm::cos(angle), center[1] + radius * libm::sin(angle)]
    };
    wall((0..CIRCLE_CORNERS).map(|index| [corner(index), corner(index + 1)]).collect())
}

/// A wall of these segments.
pub(crate) fn wall(segments: Vec<[[f64; 2]; 2]>) -> Shape {
    Shape::Segments { segments, width_px: WALL_WIDTH_PX, color: GRAY }
}

/// Color scale from dark blue (at rest) to orange (fastest), with uniform brightness on white.
fn speed_color(fraction: f64) -> Rgb {
    const STOPS: [[f64; 3]; 4] =
        [[40.0, 44.0, 120.0], [30.0, 130.0, 170.0], [120.0, 180.0, 90.0], [240.0, 150.0, 30.0]];
    let position = fraction.clamp(0.0, 1.0) * 3.0;
    let stop = (position as usize).min(2);
    let along = position - stop as f64;
    std::array::from_fn(|part| {
        libm::round(STOPS[stop][part] + along * (STOPS[stop + 1][part] - STOPS[stop][part])) as u8
    })
}
