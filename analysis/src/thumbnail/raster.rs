//! Rasterization of a drawing. The coverage of a pixel follows from the distance of its center to the edge of the
//! shape.

use super::glyphs;
use crate::plot::drawing::Drawing;
use crate::plot::page::PageLayout;
use kinetoscope_recording::drawing::{Rgb, Shape};

/// Dark gray, for text.
const INK: Rgb = [0x20, 0x20, 0x20];

/// Number of coverage levels: few, so that the colors of a drawing fit a palette.
const RIM_STEPS: f64 = 8.0;

/// A picture, row by row from the upper left corner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Raster {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) pixels: Vec<Rgb>,
}

impl Raster {
    /// Draws on a white background.
    pub(super) fn of(page: &PageLayout, drawing: &Drawing) -> Self {
        let (width, height) = (page.width, page.height);
        let pixels = vec![[0xff; 3]; width as usize * height as usize];
        let mut raster = Self { width, height, pixels };
        for shape in drawing.shapes() {
            raster.draw(page, shape);
        }
        raster
    }

    fn draw(&mut self, page: &PageLayout, shape: &Shape) {
        match shape {
            Shape::Disc { center, radius, color } => {
                let (center, radius) = (page.position(*center), page.length(*radius));
                self.fill(*color, [center, center], radius, |point| {
                    radius - libm::hypot(point[0] - center[0], point[1] - center[1])
                });
            }
            Shape::Segments { segments, width_px, color } => {
                let half_width = page.line_width(*width_px) / 2.0;
                for [from, to] in segments {
                    self.segment([page.position(*from), page.position(*to)], half_width, *color);
                }
            }
            Shape::Rectangle { center, size, color } => {
                let center = page.position(*center);
                let [width, height] = size.map(|length| page.length(length) / 2.0);
                // Neighbors overlap slightly, so that no seam is visible.
                let half = [width + 0.5, height];
                let reach = half[0].max(half[1]);
                self.fill(*color, [center, center], reach, |point| {
                    let inside = |axis: usize| half[axis] - (point[axis] - center[axis]).abs();
                    inside(0).min(inside(1))
                });
            }
            Shape::Text { center, text } => {
                let height = page.text_height();
                for segment in glyphs::strokes(text, page.position(*center), height) {
                    self.segment(segment, (height / 14.0).max(0.55), INK);
                }
            }
        }
    }

    /// A line with round ends.
    fn segment(&mut self, [from, to]: [[f64; 2]; 2], half_width: f64, color: Rgb) {
        let along = [to[0] - from[0], to[1] - from[1]];
        let length_squared = along[0] * along[0] + along[1] * along[1];
        self.fill(color, [from, to], half_width, |point| {
            let off = [point[0] - from[0], point[1] - from[1]];
            let fraction = if length_squared > 0.0 {
                ((off[0] * along[0] + off[1] * along[1]) / length_squared).clamp(0.0, 1.0)
            } else {
                0.0
            };
            half_width - libm::hypot(off[0] - fraction * along[0], off[1] - fraction * along[1])
        });
    }

    /// Blends a color into the pixels of a box around two points. `depth` is the distance of a point from the edge of
    /// the shape, px, positive inside.
    fn fill(
        &mut self,
        color: Rgb,
        around: [[f64; 2]; 2],
        reach: f64,
        depth: impl Fn([f64; 2]) -> f64,
    ) {
        // A cast from float saturates, so parts outside the picture and NaN are not drawn.
        let span = |axis: usize, end: u32| {
            let low = around[0][axis].min(around[1][axis]) - reach - 1.0;
            let high = around[0][axis].max(around[1][axis]) + reach + 1.0;
            (low.floor() as u32).min(end)..(high.ceil() as u32).min(end)
        };
        for y in span(1, self.height) {
            for x in span(0, self.width) {
                let fraction =
                    (depth([f64::from(x) + 0.5, f64::from(y) + 0.5]) + 0.5).clamp(0.0, 1.0);
                let fraction = (fraction * RIM_STEPS).round() / RIM_STEPS;
                if fraction > 0.0 {
                    let pixel = &mut self.pixels[(y * self.width + x) as usize];
                    *pixel = mixed(*pixel, color, fraction);
                }
            }
        }
    }
}

fn mixed(under: Rgb, over: Rgb, fraction: f64) -> Rgb {
    std::array::from_fn(|part| {
        let (under, over) = (f64::from(under[part]), f64::from(over[part]));
        (under + fraction * (over - under)).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Law: the total coverage of a disc is pi r^2. Tolerance: 1 % for a radius of 20 px, because edges are straight
    /// within each pixel.
    #[test]
    fn a_disc_covers_its_area() {
        let container = Shape::Segments {
            segments: vec![[[0.0, 0.0], [1.0, 1.0]]],
            width_px: 1.0,
            color: [0xff; 3],
        };
        let black = [0; 3];
        let disc = Shape::Disc { center: [0.43, 0.52], radius: 0.2, color: black };
        let drawing = Drawing { walls: vec![container], discs: vec![disc], ..Drawing::default() };
        let page =
            PageLayout::new(std::slice::from_ref(&drawing), 106.try_into().unwrap()).unwrap();
        let raster = Raster::of(&page, &drawing);
        let covered: f64 =
            raster.pixels.iter().map(|pixel| 1.0 - f64::from(pixel[0]) / 255.0).sum();
        let radius = page.length(0.2);
        let area = std::f64::consts::PI * radius * radius;
        assert!((covered / area - 1.0).abs() < 0.01, "{covered} px of {area}");
    }
}
