//! A frame of a replay as a picture of 16:9 for the list of experiments: the colors, the view and the paths are those of the replay.

use super::motion::{PathPart, path_part};
use super::still::Still;
use super::view::View;
use kinetoscope_recording::drawing::{Rgb, SPEED_COLORS};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Size of the picture, px.
const WIDTH: f64 = 384.0;
const HEIGHT: f64 = 216.0;
/// The ground of pictures, in both themes.
const GROUND: &str = "#101418";
/// Color of bodies at rest, and of the Sun.
const YELLOW: Rgb = [0xf0, 0xc8, 0x3c];
/// Color of a particle without a speed.
const UNKNOWN: Rgb = [154; 3];
/// Number of particles whose paths are drawn, as in the page.
const TRAILS: usize = 8;

/// What the colors and lines of a picture depend on.
pub(super) struct PictureStyle<'a> {
    /// Speed at the upper end of the color scale.
    pub(super) top: f64,
    pub(super) has_trails: bool,
    pub(super) names: &'a [String],
}

/// The place of a view in the picture.
struct Place {
    view: View,
    scale: f64,
}

impl Place {
    fn of(view: View) -> Self {
        let [low, high] = view.corners;
        let scale = (WIDTH / (high[0] - low[0])).min(HEIGHT / (high[1] - low[1]));
        Self { view, scale }
    }

    fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [low, high] = self.view.corners;
        let middle = [(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0];
        let at = [
            WIDTH / 2.0 + (x - middle[0]) * self.scale,
            HEIGHT / 2.0 + (middle[1] - y) * self.scale,
        ];
        // Far outside, which no picture shows, numbers become long.
        at.map(|pixel| pixel.clamp(-9999.0, 9999.0))
    }
}

/// The picture as SVG.
pub(super) fn picture(
    stills: &[&Still],
    poster: usize,
    view: View,
    picture_style: &PictureStyle<'_>,
) -> String {
    let place = Place::of(view);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{HEIGHT}\" viewBox=\"0 0 {WIDTH} {HEIGHT}\"><rect width=\"100%\" height=\"100%\" fill=\"{GROUND}\"/><g fill=\"none\" stroke-linecap=\"round\">"
    );
    let Some(still) = stills.get(poster) else { return svg + "</g></svg>\n" };
    if picture_style.has_trails {
        let path = trails(&stills[..=poster], &place);
        // Writing to a String cannot fail.
        let _ = write!(svg, "<path stroke=\"#56b4e9\" d=\"{path}\"/>");
    }
    for (ends, style) in still.lines.clipped(view.cut()).chunks_exact(2).zip(&still.lines.styles) {
        let ([x0, y0], [x1, y1]) = (place.at(ends[0]), place.at(ends[1]));
        let (color, width) = style.described();
        if x0.is_finite() && x1.is_finite() {
            let width = (0.45 * width).max(0.7);
            let _ = write!(
                svg,
                "<path stroke=\"{color}\" stroke-width=\"{width:.1}\" d=\"M{x0:.1} {y0:.1}L{x1:.1} {y1:.1}\"/>"
            );
        }
    }
    for (([r, g, b], width), path) in dots(still, &place, picture_style) {
        let width = f64::from(width) / 4.0;
        let _ = write!(
            svg,
            "<path stroke=\"#{r:02x}{g:02x}{b:02x}\" stroke-width=\"{width}\" d=\"{path}\"/>"
        );
    }
    svg + "</g></svg>\n"
}

/// Discs as dots of wide lines: one path per color and diameter, in quarters of a pixel.
fn dots(
    still: &Still,
    place: &Place,
    picture_style: &PictureStyle<'_>,
) -> BTreeMap<(Rgb, u32), String> {
    let smallest = match still.points.len() {
        2001.. => 1.2,
        51.. => 2.4,
        _ => 5.0,
    };
    let mut dots: BTreeMap<(Rgb, u32), String> = BTreeMap::new();
    let mut add = |center: [f64; 2], radius: f64, color: Rgb| {
        let [x, y] = place.at(center);
        if x.is_finite() && y.is_finite() {
            let diameter = (2.0 * radius * place.scale).clamp(smallest, 2.0 * WIDTH);
            let path = dots.entry((color, libm::round(4.0 * diameter) as u32)).or_default();
            let _ = write!(path, "M{x:.1} {y:.1}h0");
        }
    };
    for [x, y, radius] in &still.lines.bodies {
        add([*x, *y], *radius, YELLOW);
    }
    for (index, point) in still.points.iter().enumerate() {
        let share = f64::from(point.speed) / picture_style.top;
        let color = match picture_style.names.get(index) {
            Some(name) if name == "Sun" => YELLOW,
            _ if !share.is_finite() => UNKNOWN,
            _ => speed_color(share),
        };
        add([point.x, point.y], f64::from(point.radius), color);
    }
    dots
}

/// The color of a share of the top speed, in the 64 steps of the page and of the recording.
fn speed_color(share: f64) -> Rgb {
    // A cast from float saturates.
    let step = ((share * 64.0) as usize).min(63);
    let position = step as f64 / 63.0 * (SPEED_COLORS.len() - 1) as f64;
    let low = (position as usize).min(SPEED_COLORS.len() - 2);
    let part = position - low as f64;
    std::array::from_fn(|channel| {
        let [from, to] = [low, low + 1].map(|stop| f64::from(SPEED_COLORS[stop][channel]));
        libm::round(from + part * (to - from)) as u8
    })
}

/// The paths of the first particles, where they are known.
fn trails(stills: &[&Still], place: &Place) -> String {
    let mut path = String::new();
    let particles = stills.first().map_or(0, |still| still.points.len().min(TRAILS));
    let side = place.view.longer_side();
    for particle in 0..particles {
        let point = |frame: usize| stills.get(frame).and_then(|still| still.points.get(particle));
        let mut is_down = false;
        for frame in 1..stills.len() {
            let (Some(from), Some(to)) = (point(frame - 1), point(frame)) else { continue };
            let around = [frame.checked_sub(2).and_then(point), point(frame + 1)];
            let passed = stills[frame].time - stills[frame - 1].time;
            let Some(part) = path_part([from, to], around, passed, side) else {
                is_down = false;
                continue;
            };
            let ([x0, y0], [x1, y1]) = (place.at([from.x, from.y]), place.at([to.x, to.y]));
            if !is_down {
                let _ = write!(path, "M{x0:.1} {y0:.1}");
                is_down = true;
            }
            let _ = match part {
                PathPart::Line => write!(path, "L{x1:.1} {y1:.1}"),
                PathPart::Curve([a, b]) => {
                    let third = place.scale / 3.0;
                    let (x2, y2) = (x0 + a[0] * third, y0 - a[1] * third);
                    let (x3, y3) = (x1 - b[0] * third, y1 + b[1] * third);
                    write!(path, "C{x2:.1} {y2:.1} {x3:.1} {y3:.1} {x1:.1} {y1:.1}")
                }
            };
        }
    }
    path
}
