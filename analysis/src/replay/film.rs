//! The encoded frames of a replay, and their description for the script of the report.

use super::encoding::base64;
use super::flights::DrawnFlights;
use super::lines::LineStyle;
use super::view::View;
use crate::number_text::three_digits;
use kinetoscope_console::text::visible;
use kinetoscope_recording::drawing::SPEED_COLORS;
use serde::{Deserialize, Serialize};
use serde_json::json;

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
    pub(super) every_particle: u64,
    /// The region that is shown.
    pub(super) view: View,
    /// Where walls are cut off.
    pub(super) cut: View,
    /// The frame that is shown first.
    pub(super) poster: usize,
    /// That frame as an SVG document.
    pub(crate) picture: String,
    /// What the color of a particle means there, as in the manifest.
    pub(crate) color: String,
    /// Names of the first particles; may be empty.
    pub(super) names: Vec<String>,
    /// Position of the coordinates 0, and the length of one step of a coordinate.
    pub(super) origin: [f64; 2],
    pub(super) step: f64,
    /// The orders of the differences in time that x and y are stored as.
    pub(super) orders: [u8; 2],
    /// Length of one step of a radius.
    pub(super) radius_step: f64,
    /// Whether radii are stored for each frame rather than once.
    pub(super) has_growing_particles: bool,
    /// Speed of the largest stored value, and the speed at the upper end of the color scale.
    pub(super) speed_max: f64,
    pub(super) speed_top: f64,
    /// The largest component of a velocity, and the length of one step of a component; 0 without velocities.
    pub(super) velocity_top: f64,
    pub(super) velocity_step: f64,
    /// The spin of the largest stored value; 0 without spins.
    pub(super) spin_top: f64,
    /// Number of ends of wall segments, two per segment, and whether they are stored for each frame.
    pub(super) wall_points: usize,
    pub(super) has_moving_walls: bool,
    /// Number of contact forces per frame, at most; 0 if they are not requested.
    pub(super) force_lines: usize,
    /// The force of a line of the full width, N.
    pub(super) force_top: f64,
    /// How the segments are drawn.
    pub(super) line_styles: Vec<LineStyle>,
    /// Bodies at rest: x, y and radius.
    pub(super) bodies: Vec<[f64; 3]>,
    /// Texts with their middles.
    pub(super) labels: Vec<([f64; 2], String)>,
    /// Whether the path of each particle is drawn.
    pub(crate) has_trails: bool,
    /// Frames per second of the replay at normal speed.
    pub(super) fps: f64,
    /// Units of length, speed and time; empty for dimensionless ones.
    pub(crate) units: [String; 3],
    /// The paths between frames; `None` without recorded collisions.
    pub(super) flights: Option<DrawnFlights>,
    /// The numbers: raw DEFLATE of the layout in `encoding`.
    pub(super) data: Vec<u8>,
}

impl Film {
    /// Whether collisions give the motion between frames.
    pub(crate) fn has_flights(&self) -> bool {
        self.flights.is_some()
    }

    /// What the script needs to decode and draw the data, as JSON.
    pub(crate) fn description(&self) -> String {
        let colors = SPEED_COLORS.map(|[r, g, b]| format!("#{r:02x}{g:02x}{b:02x}"));
        let sides = |view: &View| {
            let [low, high] = view.corners;
            [low[0], low[1], high[0], high[1]]
        };
        let names: Vec<_> = self.names.iter().map(|name| visible(name)).collect();
        let labels: Vec<_> = self.labels.iter().map(|(at, text)| (at, visible(text))).collect();
        let mut description = json!({
            "frames": self.frames,
            "particles": self.particles,
            "every": self.every_particle,
            "view": sides(&self.view),
            "cut": sides(&self.cut),
            "poster": self.poster,
            "names": names,
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
            "spinTop": self.spin_top,
            "spinTopText": three_digits(self.spin_top),
            "wallPoints": self.wall_points,
            "movingWalls": self.has_moving_walls,
            "forceLines": self.force_lines,
            "forceTop": self.force_top,
            "lineStyles": self.line_styles.iter().map(LineStyle::described).collect::<Vec<_>>(),
            "bodies": self.bodies,
            "labels": labels,
            "trails": self.has_trails,
            "fps": self.fps,
            "units": self.units,
            "colors": colors,
        });
        if let Some(DrawnFlights { corners, intervals, fall }) = self.flights {
            description["flights"] = json!([corners, intervals, fall]);
        }
        description.to_string()
    }

    /// The data as base64.
    pub(crate) fn base64(&self) -> String {
        base64(&self.data)
    }
}
