//! The first frame of a replay as a picture of 16:9 for the list of experiments: frame, view, colors, paths and the frame of reference are those of the
//! replay before a reader changes them.

use super::motion::{PathPart, path_part};
use super::poster::bed;
use super::still::{Point, Still};
use super::view::View;
use kinetoscope_manifest::ViewColor;
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
/// Number of the colors of a scale, as in the page and in the recording.
const STEPS: usize = 64;
/// Number of particles whose paths are drawn, as in the page.
const TRAILS: usize = 8;
/// Parts of a path between two frames in a rotating frame.
const PARTS: u32 = 3;

/// What the colors and lines of a picture depend on.
pub(super) struct PictureStyle<'a> {
    /// Speed at the upper end of the color scale.
    pub(super) top: f64,
    /// Spin at both ends of the color scale.
    pub(super) spin_top: f64,
    pub(super) has_trails: bool,
    pub(super) names: &'a [String],
    /// What the color of a particle means.
    pub(super) color: ViewColor,
    /// Number of the species, which particles have in turn by their numbers, and the distance of these.
    pub(super) species: usize,
    pub(super) every_particle: usize,
    /// Whether the first two of more particles stay where they are.
    pub(super) is_rotating: bool,
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
    style: &PictureStyle<'_>,
) -> String {
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{HEIGHT}\" viewBox=\"0 0 {WIDTH} {HEIGHT}\"><rect width=\"100%\" height=\"100%\" fill=\"{GROUND}\"/><g fill=\"none\" stroke-linecap=\"round\">"
    );
    let Some(still) = stills.get(poster) else { return svg + "</g></svg>\n" };
    let is_rotating = style.is_rotating && style.has_trails && still.points.len() > 2;
    let bed = if style.has_trails { None } else { bed(still, view, style.top) };
    let place = Place::of(bed.unwrap_or(view));
    if style.has_trails {
        let stills = &stills[..=poster];
        let path = if is_rotating { turned_trails(stills, &place) } else { trails(stills, &place) };
        // Writing to a String cannot fail.
        let _ = write!(svg, "<path stroke=\"#56b4e9\" d=\"{path}\"/>");
    }
    if !is_rotating {
        svg += &walls(still, view, &place);
    }
    for (([r, g, b], width), path) in dots(stills, poster, &place, style, is_rotating) {
        let width = f64::from(width) / 4.0;
        let _ = write!(
            svg,
            "<path stroke=\"#{r:02x}{g:02x}{b:02x}\" stroke-width=\"{width}\" d=\"{path}\"/>"
        );
    }
    svg + "</g></svg>\n"
}

/// The walls where the view cuts them off.
fn walls(still: &Still, view: View, place: &Place) -> String {
    let mut svg = String::new();
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
    svg
}

/// Discs as dots of wide lines: one path per color and diameter, in quarters of a pixel.
fn dots(
    stills: &[&Still],
    poster: usize,
    place: &Place,
    style: &PictureStyle<'_>,
    is_rotating: bool,
) -> BTreeMap<(Rgb, u32), String> {
    let still = stills[poster];
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
    for [x, y, radius] in still.lines.bodies.iter().filter(|_| !is_rotating) {
        add([*x, *y], *radius, YELLOW);
    }
    let place_of = |body: usize| at(still.points.get(body).copied().unwrap_or(Point::ABSENT));
    let axis = [0, 1].map(place_of);
    let colors = colors(stills, poster, style);
    for (point, color) in still.points.iter().zip(colors) {
        let center = [point.x, point.y];
        let center = if is_rotating { turned(center, axis) } else { center };
        add(center, f64::from(point.radius), color);
    }
    dots
}

fn at(point: Point) -> [f64; 2] {
    [point.x, point.y]
}

/// The colors of all particles.
fn colors(stills: &[&Still], poster: usize, style: &PictureStyle<'_>) -> Vec<Rgb> {
    let points = &stills[poster].points;
    let last = STEPS - 1;
    // A cast from float saturates.
    let step = |share: f64| share.is_finite().then(|| ((share * STEPS as f64) as usize).min(last));
    let steps: Vec<Option<usize>> = match style.color {
        ViewColor::Height => at_start(stills, points.len(), 1).into_iter().map(step).collect(),
        ViewColor::Side => at_start(stills, points.len(), 0).into_iter().map(step).collect(),
        ViewColor::Species if style.species > 1 => {
            let species = |index: usize| index * style.every_particle % style.species;
            let share = |index: usize| species(index) as f64 / (style.species - 1) as f64;
            let step = |index: usize| Some(libm::round(share(index) * last as f64) as usize);
            (0..points.len()).map(step).collect()
        }
        ViewColor::Spin => {
            let share = |point: &Point| (f64::from(point.spin) / style.spin_top + 1.0) / 2.0;
            points.iter().map(|point| step(share(point))).collect()
        }
        ViewColor::Species | ViewColor::Speed => {
            points.iter().map(|point| step(f64::from(point.speed) / style.top)).collect()
        }
    };
    let color = |(index, step): (usize, Option<usize>)| match style.names.get(index) {
        Some(name) if name == "Sun" => YELLOW,
        _ => step.map_or(UNKNOWN, color_of_step),
    };
    steps.into_iter().enumerate().map(color).collect()
}

/// The first position of each particle on an axis, from 0 to 1 within that of all; NaN for a particle without one.
fn at_start(stills: &[&Still], particles: usize, axis: usize) -> Vec<f64> {
    let first = |particle: usize| {
        let mut places =
            stills.iter().filter_map(|still| Some(at(*still.points.get(particle)?)[axis]));
        places.find(|place| place.is_finite()).unwrap_or(f64::NAN)
    };
    let firsts: Vec<f64> = (0..particles).map(first).collect();
    let finite = || firsts.iter().copied().filter(|place| place.is_finite());
    let (low, high) = (finite().fold(f64::MAX, f64::min), finite().fold(f64::MIN, f64::max));
    let range = if high > low { high - low } else { 1.0 };
    firsts.iter().map(|place| (place - low) / range).collect()
}

/// A color of the scale, of which the page and the recording have the same steps.
fn color_of_step(step: usize) -> Rgb {
    let position = step as f64 / (STEPS - 1) as f64 * (SPEED_COLORS.len() - 1) as f64;
    let low = (position as usize).min(SPEED_COLORS.len() - 2);
    let part = position - low as f64;
    std::array::from_fn(|channel| {
        let [from, to] = [low, low + 1].map(|stop| f64::from(SPEED_COLORS[stop][channel]));
        libm::round(from + part * (to - from)) as u8
    })
}

/// A place in the frame that rotates with the second body about the first one, which is at the origin; the second one is to its right.
fn turned([x, y]: [f64; 2], [sun, planet]: [[f64; 2]; 2]) -> [f64; 2] {
    let (a, b) = (planet[0] - sun[0], planet[1] - sun[1]);
    let (u, v) = (x - sun[0], y - sun[1]);
    let size = libm::hypot(a, b);
    [(a * u + b * v) / size, (a * v - b * u) / size]
}

/// The path of a particle up to a frame; `None` if it is not known.
fn part_before(
    stills: &[&Still],
    frame: usize,
    particle: usize,
    side: f64,
) -> Option<(PathPart, [[f64; 2]; 2])> {
    let point = |frame: usize| stills.get(frame).and_then(|still| still.points.get(particle));
    let (from, to) = (point(frame.checked_sub(1)?)?, point(frame)?);
    let around = [frame.checked_sub(2).and_then(point), point(frame + 1)];
    let passed = stills[frame].time - stills[frame - 1].time;
    let part = path_part([from, to], around, passed, side)?;
    Some((part, [at(*from), at(*to)]))
}

/// The paths of the first particles, where they are known.
fn trails(stills: &[&Still], place: &Place) -> String {
    let mut path = String::new();
    let particles = stills.first().map_or(0, |still| still.points.len().min(TRAILS));
    let side = place.view.longer_side();
    for particle in 0..particles {
        let mut is_down = false;
        for frame in 1..stills.len() {
            let Some((part, ends)) = part_before(stills, frame, particle, side) else {
                is_down = false;
                continue;
            };
            let [[x0, y0], [x1, y1]] = ends.map(|end| place.at(end));
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

/// The paths in the rotating frame, as chords of parts between frames.
fn turned_trails(stills: &[&Still], place: &Place) -> String {
    let mut path = String::new();
    let particles = stills.first().map_or(0, |still| still.points.len().min(TRAILS));
    let side = place.view.longer_side();
    for particle in 1..particles {
        let mut is_down = false;
        for frame in 1..stills.len() {
            let parts = [particle, 0, 1].map(|body| part_before(stills, frame, body, side));
            for step in 0..=PARTS {
                let fraction = f64::from(step) / f64::from(PARTS);
                let places = parts.map(|part| part.map(|(part, ends)| part.at(ends, fraction)));
                let [Some(own), Some(sun), Some(planet)] = places else {
                    is_down = false;
                    continue;
                };
                let [x, y] = place.at(turned(own, [sun, planet]));
                let _ = write!(path, "{}{x:.1} {y:.1}", if is_down { 'L' } else { 'M' });
                is_down = true;
            }
        }
    }
    path
}

#[cfg(test)]
mod tests {
    use super::super::lines::Lines;
    use super::*;
    use std::sync::Arc;

    fn still(places: &[[f64; 2]]) -> Still {
        let point = |&[x, y]: &[f64; 2]| Point {
            x,
            y,
            speed: 1.0,
            velocity: [0.0; 2],
            radius: 0.0,
            spin: 0.0,
        };
        let points = places.iter().map(point).collect();
        Still { number: 0, time: 0.0, points, lines: Arc::new(Lines::of(&[])), forces: Vec::new() }
    }

    fn style(color: ViewColor) -> PictureStyle<'static> {
        let (top, has_trails, is_rotating) = (2.0, true, true);
        PictureStyle {
            top,
            spin_top: 2.0,
            has_trails,
            names: &[],
            color,
            species: 2,
            every_particle: 1,
            is_rotating,
        }
    }

    /// Guarantee: in the rotating frame, the first body is at the origin and the second one to its right. Control: three bodies elsewhere in the fixed frame.
    #[test]
    fn planet_is_to_the_right_of_the_sun() {
        let still = still(&[[0.0, 0.0], [0.0, 1.0], [-1.0, 0.0]]);
        let view = View { corners: [[-2.0, -2.0], [2.0, 2.0]] };
        let drawn = |is_rotating: bool| {
            let style = PictureStyle { is_rotating, ..style(ViewColor::Speed) };
            picture(&[&still], 0, view, &style)
        };
        // 54 px per unit, from the middle at (192, 108).
        for place in ["M192.0 108.0h0", "M246.0 108.0h0", "M192.0 54.0h0"] {
            assert!(drawn(true).contains(place), "{}", drawn(true));
        }
        assert!(drawn(false).contains("M138.0 108.0h0"), "control");
        assert!(!drawn(false).contains("M246.0 108.0h0"), "control");
    }

    /// Guarantee: colors mean what is requested, as in the page: the species alternate between the ends of the scale, and heights are those of the first
    /// frame.
    #[test]
    fn colors_mean_what_is_requested() {
        let (start, end) = (still(&[[0.0, 5.0], [0.0, 1.0]]), still(&[[0.0, 1.0], [0.0, 5.0]]));
        let of = |color: ViewColor| colors(&[&start, &end], 1, &style(color));
        let [low, high] = [0, STEPS - 1].map(color_of_step);
        assert_eq!(of(ViewColor::Species), [low, high]);
        assert_eq!(of(ViewColor::Height), [high, low]);
        assert_eq!(of(ViewColor::Speed), [color_of_step(STEPS / 2); 2]);
    }
}
