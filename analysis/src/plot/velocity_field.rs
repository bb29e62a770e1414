//! The velocity field of a state: one arrow per particle, to scale, with a key.

use super::drawing::{Drawing, segments_of};
use crate::number_text::short_number;
use kinetoscope_recording::drawing::{Rgb, Shape};

/// Maximum number of arrows; of more particles, every k-th has one.
const MAX_ARROWS: usize = 2000;
/// Length of the fastest arrow over the longer side of the drawing.
const LONGEST_OVER_SIDE: f64 = 0.08;
/// Length of a barb over that of its arrow, along and across.
const BARB: [f64; 2] = [0.25, 0.1];
/// Distance of the key from the drawing, and height of its letters, over the longer side.
const KEY_OVER_SIDE: f64 = 0.05;
/// Half the width of a letter over the longer side.
const HALF_LETTER: f64 = 0.0095;
/// Width of arrows, px.
const ARROW_WIDTH_PX: f64 = 1.3;
const ARROW_COLOR: Rgb = [0x1e, 0x50, 0x96];

/// The scale of arrows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ArrowScale {
    /// Length of an arrow over its speed.
    pub(crate) length_over_speed: f64,
    /// The speed of the key: 1, 2 or 5 times a power of ten, at most the highest speed.
    pub(crate) key_speed: f64,
}

impl ArrowScale {
    /// The scale for speeds up to this maximum in a drawing whose longer side is this; `None` for particles at rest.
    pub(crate) fn new(max_speed: f64, side: f64) -> Option<Self> {
        if !(max_speed > 0.0 && max_speed.is_finite() && side > 0.0 && side.is_finite()) {
            return None;
        }
        let unit = libm::pow(10.0, libm::log10(max_speed).floor());
        let multiple = [5.0, 2.0].into_iter().find(|multiple| multiple * unit <= max_speed);
        let length_over_speed = LONGEST_OVER_SIDE * side / max_speed;
        Some(Self { length_over_speed, key_speed: multiple.unwrap_or(1.0) * unit })
    }
}

/// Draws the velocities of particles, each given by its x, y, vx and vy, in front of these walls; `None` for particles at rest.
pub(crate) fn velocity_field(
    particles: &[[f64; 4]],
    walls: &[Shape],
    speed_unit: &str,
) -> Option<Drawing> {
    let positions = particles.iter().map(|&[x, y, ..]| [x, y]);
    let corners: Vec<[f64; 2]> = match segments_of(walls).flatten().collect::<Vec<_>>() {
        corners if corners.is_empty() => positions.collect(),
        corners => corners,
    };
    let bound = |axis: usize, of: fn(f64, f64) -> f64, start: f64| {
        corners.iter().fold(start, |bound, corner| of(bound, corner[axis]))
    };
    let low = [0, 1].map(|axis| bound(axis, f64::min, f64::INFINITY));
    let high = [0, 1].map(|axis| bound(axis, f64::max, f64::NEG_INFINITY));
    let side = (high[0] - low[0]).max(high[1] - low[1]);
    let max_speed = particles.iter().map(|[.., vx, vy]| libm::hypot(*vx, *vy)).fold(0.0, f64::max);
    let scale = ArrowScale::new(max_speed, side)?;
    let step = particles.len().div_ceil(MAX_ARROWS);
    let arrows = particles.iter().step_by(step).flat_map(|&[x, y, vx, vy]| {
        arrow([x, y], [vx, vy].map(|component| component * scale.length_over_speed))
    });
    let [x, y] = [low[0], low[1] - KEY_OVER_SIDE * side];
    let length = scale.key_speed * scale.length_over_speed;
    let text = format!("{} {speed_unit}", short_number(scale.key_speed));
    let half_width = HALF_LETTER * side * text.chars().count() as f64;
    let text = Shape::Text { center: [x + length + 0.02 * side + half_width, y], text };
    Some(Drawing {
        walls: walls.to_vec(),
        discs: vec![lines(arrows.collect())],
        legend: vec![lines(arrow([x, y], [length, 0.0]).to_vec()), text],
        ..Drawing::default()
    })
}

fn lines(segments: Vec<[[f64; 2]; 2]>) -> Shape {
    Shape::Segments { segments, width_px: ARROW_WIDTH_PX, color: ARROW_COLOR }
}

/// The shaft and the barbs of an arrow.
fn arrow([x, y]: [f64; 2], [along, up]: [f64; 2]) -> [[[f64; 2]; 2]; 3] {
    let tip = [x + along, y + up];
    let barb = |side: f64| {
        let [back, aside] = [BARB[0], side * BARB[1]];
        [tip, [tip[0] - back * along - aside * up, tip[1] - back * up + aside * along]]
    };
    [[[x, y], tip], barb(1.0), barb(-1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::drawing::rectangle;

    /// Guarantee: shafts begin at the particles, point along the velocities, and have one scale with the key.
    #[test]
    fn arrows_have_the_scale_of_the_key() {
        let walls = [rectangle([[0.0, 0.0], [10.0, 5.0]])];
        let particles = [[1.0, 2.0, 3.0, 0.0], [4.0, 4.0, 0.0, -1.5]];
        let drawing = velocity_field(&particles, &walls, "m/s").unwrap();
        let shafts: Vec<_> = segments_of(&drawing.discs).step_by(3).collect();
        assert_eq!(shafts.len(), 2);
        let length = LONGEST_OVER_SIDE * 10.0;
        for (shaft, to) in shafts.iter().zip([[1.0 + length, 2.0], [4.0, 4.0 - 0.5 * length]]) {
            assert!(libm::hypot(shaft[1][0] - to[0], shaft[1][1] - to[1]) < 1e-12, "{shaft:?}");
        }
        assert_eq!([shafts[0][0], shafts[1][0]], [[1.0, 2.0], [4.0, 4.0]]);
        let key = segments_of(&drawing.legend).next().unwrap();
        assert!((key[1][0] - key[0][0] - length * 2.0 / 3.0).abs() < 1e-12, "{key:?}");
        assert!(
            drawing
                .legend
                .iter()
                .any(|shape| { matches!(shape, Shape::Text { text, .. } if text == "2 m/s") })
        );
        // Control: particles at rest have no field.
        assert_eq!(velocity_field(&[[1.0, 2.0, 0.0, 0.0]], &walls, "m/s"), None);
    }

    #[test]
    fn key_speed_is_a_round_number_below_the_highest_speed() {
        for (max_speed, key) in [(1.0, 1.0), (1.99, 1.0), (2.0, 2.0), (0.074, 0.05), (430.0, 200.0)]
        {
            let found = ArrowScale::new(max_speed, 1.0).unwrap().key_speed;
            assert!((found / key - 1.0).abs() < 1e-12, "{max_speed}: {found}");
        }
        assert_eq!(ArrowScale::new(0.0, 1.0), None);
    }
}
