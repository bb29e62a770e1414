//! Pictures of a state: particles in their container, to scale, colored by speed.

use super::DrawingError;
use super::axis::{short_number, three_digits};
use super::canvas::{Canvas, INK, draw, failure, fine, stroke, text_style};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use serde::{Deserialize, Serialize};

/// A drawn particle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DrawnParticle {
    /// The center, in the picture's length unit.
    pub center: [f64; 2],
    /// The radius; `None` for a point, drawn as a dot.
    pub radius: Option<f64>,
    /// The speed, which determines the color.
    pub speed: f64,
}

/// The outer walls.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Container {
    /// A rectangle from its lower left to its upper right corner.
    Rectangle([f64; 2], [f64; 2]),
    /// A circle by center and radius.
    Circle([f64; 2], f64),
}

/// A wall inside the container.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum InnerWall {
    /// A segment between two points.
    Segment([f64; 2], [f64; 2]),
    /// A circle by center and radius.
    Circle([f64; 2], f64),
}

/// Particles in their container.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Picture {
    /// The file name without its extension.
    pub stem: String,
    /// The title.
    pub title: String,
    /// The caption below the title, such as "N = 1000, r = 1 m".
    pub caption: String,
    /// The unit of lengths; empty for dimensionless lengths.
    pub length_unit: String,
    /// The unit of speeds; empty for dimensionless speeds.
    pub speed_unit: String,
    /// The container.
    pub container: Container,
    /// Walls inside the container; their parts outside are not drawn.
    pub inner_walls: Vec<InnerWall>,
    /// The particles, limited to the first [`MAX_DRAWN_PARTICLES`].
    pub bodies: Vec<DrawnParticle>,
}

/// Maximum number of drawn particles; with more, the file would be too large for a viewer.
pub const MAX_DRAWN_PARTICLES: usize = 10_000;

const WIDTH: i32 = 620;
const HEADER: i32 = 66;
const SIDE: i32 = 34;
const BAR_ROOM: i32 = 110;
const LARGEST: i32 = 470;

/// Transformation from lengths to the canvas.
struct View {
    left: f64,
    top: f64,
    low: [f64; 2],
    height: f64,
    scale: f64,
}

impl View {
    /// Fits the container into the canvas; also returns the height of the canvas.
    fn new(container: Container) -> (Self, i32) {
        let (low, high) = match container {
            Container::Rectangle(low, high) => (low, high),
            Container::Circle(center, radius) => {
                let reach = |sign: f64| [center[0] + sign * radius, center[1] + sign * radius];
                (reach(-1.0), reach(1.0))
            }
        };
        let (width, height) = (high[0] - low[0], high[1] - low[1]);
        let most = f64::from(fine(LARGEST));
        let scale = (most / width).min(most / height);
        let free = (most - width * scale) / 2.0;
        let left = f64::from(fine(SIDE)) + free;
        let view = Self { left, top: f64::from(fine(HEADER)), low, height, scale };
        let sheet = HEADER + (height * scale).ceil() as i32 / fine(1) + SIDE;
        (view, sheet)
    }

    fn place(&self, point: [f64; 2]) -> (i32, i32) {
        let right = (point[0] - self.low[0]) * self.scale + self.left;
        let down = (self.height - (point[1] - self.low[1])) * self.scale + self.top;
        (right.round() as i32, down.round() as i32)
    }

    fn length(&self, length: f64) -> i32 {
        (length * self.scale).round() as i32
    }
}

impl Picture {
    /// An empty container.
    #[must_use]
    pub fn empty(container: Container, length_unit: &str, speed_unit: &str) -> Self {
        Self {
            stem: String::new(),
            title: String::new(),
            caption: String::new(),
            length_unit: length_unit.to_owned(),
            speed_unit: speed_unit.to_owned(),
            container,
            inner_walls: Vec::new(),
            bodies: Vec::new(),
        }
    }

    /// The picture as an SVG document.
    ///
    /// # Errors
    /// An error of the drawing library.
    pub fn svg(&self) -> Result<String, DrawingError> {
        let (view, height) = View::new(self.container);
        let fastest = self.bodies.iter().map(|body| body.speed).fold(0.0, f64::max);
        draw(WIDTH, height, |sheet| {
            let middle = fine(SIDE + LARGEST / 2);
            let (seen, outside) = self.seen(&view);
            let caption = match outside {
                0 => self.caption.clone(),
                outside => format!("{}; {outside} far outside", self.caption),
            };
            for (text, size, down) in [(&self.title, 18, 20), (&caption, 15, 46)] {
                let style = text_style(size, HPos::Center, VPos::Center);
                sheet
                    .draw(&Text::new(text.clone(), (middle, fine(down)), style))
                    .map_err(failure)?;
            }
            for body in seen {
                let share = if fastest > 0.0 { body.speed / fastest } else { 0.0 };
                let radius = body.radius.map_or(fine(5) / 2, |radius| view.length(radius));
                let disc =
                    Circle::new(view.place(body.center), radius, speed_color(share).filled());
                sheet.draw(&disc).map_err(failure)?;
            }
            self.draw_container(sheet, &view)?;
            let below = (middle, fine(height - SIDE / 2));
            let style = text_style(14, HPos::Center, VPos::Center);
            sheet.draw(&Text::new(self.size_text(), below, style)).map_err(failure)?;
            self.draw_color_bar(sheet, height, fastest)
        })
    }

    /// The particles on the canvas, and the number of those outside.
    fn seen(&self, view: &View) -> (Vec<&DrawnParticle>, usize) {
        let [least, most] = [0.0, f64::from(fine(WIDTH - BAR_ROOM))];
        let on_sheet = |body: &&DrawnParticle| {
            let reach = body.radius.unwrap_or(0.0) * view.scale;
            let across = (body.center[0] - view.low[0]) * view.scale + view.left;
            let up = (body.center[1] - view.low[1]) * view.scale;
            let room = f64::from(fine(SIDE));
            across - reach >= least
                && across + reach <= most
                && up - reach >= -room
                && up + reach <= view.height * view.scale + room
        };
        let seen: Vec<&DrawnParticle> = self.bodies.iter().filter(on_sheet).collect();
        let outside = self.bodies.len() - seen.len();
        (seen, outside)
    }

    /// Formats the size of the container.
    fn size_text(&self) -> String {
        let unit = if self.length_unit.is_empty() {
            String::new()
        } else {
            format!(" {}", self.length_unit)
        };
        match self.container {
            Container::Rectangle(low, high) => {
                let sides = [0, 1].map(|axis| short_number(high[axis] - low[axis]));
                format!("box of {}{unit} × {}{unit}", sides[0], sides[1])
            }
            Container::Circle(_, radius) => {
                format!("circle of radius {}{unit}", short_number(radius))
            }
        }
    }

    fn draw_container(&self, sheet: &Canvas<'_>, view: &View) -> Result<(), DrawingError> {
        let line = stroke(INK, 3);
        match self.container {
            Container::Rectangle(low, high) => {
                let corners = [low, [high[0], low[1]], high, [low[0], high[1]], low];
                sheet.draw(&PathElement::new(corners.map(|corner| view.place(corner)), line))
            }
            Container::Circle(center, radius) => {
                sheet.draw(&Circle::new(view.place(center), view.length(radius), line))
            }
        }
        .map_err(failure)?;
        let line = stroke(INK, 2);
        for wall in &self.inner_walls {
            match *wall {
                InnerWall::Segment(from, to) => {
                    let Some(ends) = self.within(from, to) else { continue };
                    sheet.draw(&PathElement::new(ends.map(|end| view.place(end)), line))
                }
                InnerWall::Circle(center, radius) => {
                    sheet.draw(&Circle::new(view.place(center), view.length(radius), line))
                }
            }
            .map_err(failure)?;
        }
        Ok(())
    }

    /// The part of a segment inside the rectangle (Liang and Barsky 1984).
    fn within(&self, from: [f64; 2], to: [f64; 2]) -> Option<[[f64; 2]; 2]> {
        let Container::Rectangle(low, high) = self.container else { return Some([from, to]) };
        let (mut first, mut last) = (0.0_f64, 1.0_f64);
        for axis in 0..2 {
            let along = to[axis] - from[axis];
            if along == 0.0 {
                if from[axis] < low[axis] || from[axis] > high[axis] {
                    return None;
                }
                continue;
            }
            let shares = [low[axis], high[axis]].map(|edge| (edge - from[axis]) / along);
            first = first.max(shares[0].min(shares[1]));
            last = last.min(shares[0].max(shares[1]));
        }
        let at =
            |share: f64| [0, 1].map(|axis: usize| from[axis] + share * (to[axis] - from[axis]));
        (first < last).then(|| [at(first), at(last)])
    }

    fn draw_color_bar(
        &self,
        sheet: &Canvas<'_>,
        height: i32,
        fastest: f64,
    ) -> Result<(), DrawingError> {
        const STEPS: i32 = 40;
        let left = WIDTH - BAR_ROOM + 14;
        let (top, bottom) = (HEADER + 26, height - SIDE);
        let unit = if self.speed_unit.is_empty() {
            "speed".to_owned()
        } else {
            format!("speed ({})", self.speed_unit)
        };
        let caption = text_style(14, HPos::Center, VPos::Center);
        let above = (fine(left + 28), fine(HEADER + 8));
        sheet.draw(&Text::new(unit, above, caption)).map_err(failure)?;
        for step in 0..STEPS {
            let edge = |step: i32| fine(bottom) - fine(bottom - top) * step / STEPS;
            // Steps overlap, so that no seam is visible.
            let corners =
                [(fine(left), edge((step + 2).min(STEPS))), (fine(left + 16), edge(step))];
            let share = (f64::from(step) + 0.5) / f64::from(STEPS);
            sheet.draw(&Rectangle::new(corners, speed_color(share).filled())).map_err(failure)?;
        }
        for (share, down) in [(1.0, top), (0.5, (top + bottom) / 2), (0.0, bottom)] {
            let text = three_digits(share * fastest);
            let style = text_style(14, HPos::Left, VPos::Center);
            sheet.draw(&Text::new(text, (fine(left + 22), fine(down)), style)).map_err(failure)?;
        }
        Ok(())
    }
}

/// Color scale from dark blue (at rest) to orange (fastest), with uniform brightness on white.
fn speed_color(share: f64) -> RGBColor {
    const STOPS: [[f64; 3]; 4] =
        [[40.0, 44.0, 120.0], [30.0, 130.0, 170.0], [120.0, 180.0, 90.0], [240.0, 150.0, 30.0]];
    let place = share.clamp(0.0, 1.0) * 3.0;
    let stop = (place as usize).min(2);
    let along = place - stop as f64;
    let channel = |index: usize| {
        (STOPS[stop][index] + along * (STOPS[stop + 1][index] - STOPS[stop][index])).round() as u8
    };
    RGBColor(channel(0), channel(1), channel(2))
}
