//! The replay of a run in its report: positions and speeds of evenly spaced frames, small enough for a page.
//!
//! The collector takes frames in while the run is analyzed, in bounded memory. At the end, the frames become 16-bit numbers that the
//! script of the report draws. The replay is made from the recorded state and walls; a model only adds its `Extent`.

mod collector;
mod encoding;
mod lines;
mod speeds;
mod view;

pub(crate) use collector::ReplayCollector;

use crate::plot::three_digits;
use kinetoscope_console::text::visible;
use kinetoscope_recording::drawing::SPEED_COLORS;
use lines::LineStyle;
use serde::{Deserialize, Serialize};
use serde_json::json;
use view::View;

/// The replay of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Replay {
    /// What is shown and what was left out, in whole sentences.
    pub(crate) note: String,
    /// The pictures; `None` if nothing can be drawn, for the reason in the note.
    pub(crate) film: Option<Film>,
}

/// The frames of a replay, encoded. Lengths are in the unit of the state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Film {
    /// Number of frames.
    pub(crate) frames: usize,
    /// Number of particles; one that is absent from a frame has no position there.
    pub(crate) particles: usize,
    /// Each particle stands for the ones before the next one: particle `i` is number `i * every_particle` of the state.
    every_particle: u64,
    /// The region that is shown.
    view: View,
    /// Position of the coordinates 0, and the length of one step of a coordinate.
    origin: [f64; 2],
    step: f64,
    /// The orders of the differences in time that x and y are stored as.
    orders: [u8; 2],
    /// Length of one step of a radius.
    radius_step: f64,
    /// Whether radii are stored for each frame rather than once.
    has_growing_particles: bool,
    /// Speed of the largest stored value, and the speed at the upper end of the color scale.
    speed_max: f64,
    speed_top: f64,
    /// The largest component of a velocity, and the length of one step of a component; 0 without velocities.
    velocity_top: f64,
    velocity_step: f64,
    /// Number of ends of wall segments, two per segment, and whether they are stored for each frame.
    wall_points: usize,
    has_moving_walls: bool,
    /// How the segments are drawn.
    line_styles: Vec<LineStyle>,
    /// Bodies at rest: x, y and radius.
    bodies: Vec<[f64; 3]>,
    /// Texts with their middles.
    labels: Vec<([f64; 2], String)>,
    /// Whether the path of each particle is drawn.
    has_trails: bool,
    /// Frames per second of the replay at normal speed.
    fps: f64,
    /// Units of length, speed and time; empty for dimensionless ones.
    units: [String; 3],
    /// The numbers: raw DEFLATE of the layout in `encoding`.
    data: Vec<u8>,
}

impl Film {
    /// What the script needs to decode and draw the data, as JSON.
    pub(crate) fn description(&self) -> String {
        let colors = SPEED_COLORS.map(|[r, g, b]| format!("#{r:02x}{g:02x}{b:02x}"));
        let [low, high] = self.view.corners;
        let labels: Vec<_> = self.labels.iter().map(|(at, text)| (at, visible(text))).collect();
        json!({
            "frames": self.frames,
            "particles": self.particles,
            "every": self.every_particle,
            "view": [low[0], low[1], high[0], high[1]],
            "origin": self.origin,
            "step": self.step,
            "orders": self.orders,
            "radiusStep": self.radius_step,
            "growing": self.has_growing_particles,
            "speedMax": self.speed_max,
            "speedTop": self.speed_top,
            "speedTopText": three_digits(self.speed_top),
            "velocityTop": self.velocity_top,
            "velocityStep": self.velocity_step,
            "wallPoints": self.wall_points,
            "movingWalls": self.has_moving_walls,
            "lineStyles": self.line_styles.iter().map(LineStyle::described).collect::<Vec<_>>(),
            "bodies": self.bodies,
            "labels": labels,
            "trails": self.has_trails,
            "fps": self.fps,
            "units": self.units,
            "colors": colors,
        })
        .to_string()
    }

    /// The data as base64.
    pub(crate) fn base64(&self) -> String {
        encoding::base64(&self.data)
    }
}

/// Bytes that base64 makes of so many.
pub(crate) const fn base64_bytes(bytes: usize) -> usize {
    bytes.div_ceil(3) * 4
}
