//! The state as Foxglove scenes: discs to scale, arrows, force chains, container and color bar.
//!
//! Drawings are rounded and thinned; the exact state is on `/state` alone.

use crate::color::{self, ColorMap};
use crate::column::StateColumn;
use crate::disc_cylinders::{DrawnDisc, MAX_CYLINDER, Tail, Tails};
use crate::error::RecordError;
use crate::force_lines::{ContactLine, weakest_drawn};
use crate::playback::three_digits;
use crate::scenery::{DrawnRadius, GuideMeaning, Scenery, Wall};
use crate::trail::{PATHS, Trails};
use foxglove::messages::{
    Color, CubePrimitive, CylinderPrimitive, LinePrimitive, Point3, Pose, Quaternion, SceneEntity,
    SceneUpdate, TextPrimitive, Timestamp, Vector3, line_primitive,
};
use prost::Message as _;
use prost::encoding::{WireType, encode_key, encode_varint};
use std::f64::consts::TAU;
use std::num::NonZeroU32;

/// The one frame of reference of a recording.
pub(crate) const FRAME_ID: &str = "world";
/// Maximum number of contact forces drawn: more would cover a dense bed.
const MAX_CONTACTS: usize = 500;
/// Contact forces drawn at most, over the particles drawn at most: a disc of a dense bed has two or three contacts of its own.
const CONTACTS_OVER_PARTICLES: usize = 3;
/// Drawing coordinates are multiples of a power of two of about this fraction of the container: they pack well.
const GRID_OVER_CONTAINER: f64 = 1.0 / 4096.0;
/// Thickness of the drawing's layers over the container's longer side: discs, then arrows, then force chains above them.
const LAYER_OVER_EXTENT: f64 = 0.002;
/// Length of the arrow at the top speed over the container's longer side: a thousand arrows do not yet hide one another.
const ARROW_OVER_EXTENT: f64 = 0.06;
/// Line widths of weak, middling and strong contact forces, px.
const FORCE_WIDTHS_PX: [f64; 3] = [0.8, 1.8, 3.4];
/// Distance of a name from its particle over the container's longer side, along each axis.
const NAME_OVER_EXTENT: f64 = 0.025;
/// Height of texts, px.
const FONT_SIZE_PX: f64 = 16.0;
/// Corners of a circular wall.
const CIRCLE_CORNERS: usize = 128;
/// Cubes of the color bar.
const LEGEND_CUBES: usize = 40;

/// Tag of `foxglove.SceneUpdate.entities`.
const ENTITIES_TAG: u32 = 2;
/// Bytes of the key and the length of an entity.
const MAX_PREFIX: usize = 1 + 10;

/// An encoded `foxglove.SceneUpdate` of the discs. Its memory is reused from frame to frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct EncodedDiscs {
    bytes: Vec<u8>,
    start: usize,
}

impl EncodedDiscs {
    /// The message; empty if nothing is encoded.
    pub(crate) fn bytes(&self) -> &[u8] {
        &self.bytes[self.start..]
    }

    /// Empties the message; its memory is kept.
    pub(crate) fn clear(&mut self) {
        self.start = self.bytes.len();
    }
}

/// Which columns of the state are drawn.
#[derive(Clone, Debug)]
struct DrawnColumns {
    width: usize,
    position: [usize; 2],
    velocity: Vec<usize>,
    radius: Option<usize>,
}

impl DrawnColumns {
    fn new(columns: &[StateColumn], radius: DrawnRadius) -> Result<Self, RecordError> {
        let find = |name: &str| columns.iter().position(|column| column.name == name);
        let need = |name: &str| {
            find(name).ok_or_else(|| {
                RecordError::Declaration(format!("the drawing needs a state column \"{name}\""))
            })
        };
        Ok(Self {
            width: columns.len(),
            position: [need("x")?, need("y")?],
            velocity: ["vx", "vy", "vz"].into_iter().filter_map(find).collect(),
            radius: match radius {
                DrawnRadius::Column { .. } => Some(need("radius")?),
                DrawnRadius::Fixed(_) => None,
            },
        })
    }
}

/// The fixed part of the drawing, and how rows of the state become scenes.
#[derive(Clone, Debug)]
pub(crate) struct SceneBuilder {
    scenery: Scenery,
    columns: DrawnColumns,
    colors: ColorMap,
    tails: Tails,
    grid: f64,
    // The container's longer side.
    extent: f64,
    drawn_at_most: usize,
}

impl SceneBuilder {
    /// `drawn_at_most` is a number of particles.
    pub(crate) fn new(
        scenery: &Scenery,
        columns: &[StateColumn],
        drawn_at_most: NonZeroU32,
    ) -> Result<Self, RecordError> {
        let extent = scenery.extent();
        let colors = ColorMap::new();
        Ok(Self {
            columns: DrawnColumns::new(columns, scenery.drawn_radius)?,
            tails: Tails::new(&colors),
            colors,
            grid: power_of_two_below(GRID_OVER_CONTAINER * extent),
            extent,
            drawn_at_most: drawn_at_most.get() as usize,
            scenery: scenery.clone(),
        })
    }

    /// An upper bound of the encoded discs of a state, without their names.
    pub(crate) fn max_drawing_bytes(&self, state: &[f64]) -> usize {
        self.drawn_discs(state).saturating_mul(MAX_CYLINDER)
    }

    /// Encodes all discs as flat cylinders of one entity, colored by speed; discs too small to be seen are enlarged.
    pub(crate) fn discs(&self, state: &[f64], time: Timestamp, encoded: &mut EncodedDiscs) {
        let smallest = self.scenery.min_drawn_radius();
        let central = Tail::of(color::YELLOW);
        let thickness = self.layer(1.0);
        let before = entity("discs", time).encode_to_vec();
        let room = before.len() + MAX_PREFIX;
        let EncodedDiscs { bytes, start } = encoded;
        // Room for all discs: their bytes are written in place. Those of the frame before need not be cleared.
        bytes.resize(room + self.drawn_discs(state) * MAX_CYLINDER, 0);
        let mut end = room;
        for (index, row) in self.drawn_rows(state) {
            let radius = match (self.columns.radius, self.scenery.drawn_radius) {
                (Some(column), _) => row[column],
                (None, DrawnRadius::Fixed(radius)) => radius,
                (None, DrawnRadius::Column { min }) => min,
            };
            let radius = if radius < smallest { smallest } else { radius };
            let tail = if self.scenery.central_particle == Some(index) {
                &central
            } else {
                self.tails.at(self.speed(row) / self.scenery.speed_range_top)
            };
            let Point3 { x, y, .. } = self.point(row);
            let disc = DrawnDisc { center: [x, y], radius, thickness };
            if let Some(place) = bytes[end..].first_chunk_mut() {
                end += disc.write_to(place, tail);
            }
        }
        bytes.truncate(end);
        // Texts have a larger tag than cylinders, so they follow.
        SceneEntity { texts: self.names(state), ..SceneEntity::default() }.encode_raw(bytes);
        let length = bytes.len() - room + before.len();
        let mut prefix = Vec::with_capacity(room);
        encode_key(ENTITIES_TAG, WireType::LengthDelimited, &mut prefix);
        encode_varint(length as u64, &mut prefix);
        prefix.extend_from_slice(&before);
        *start = room - prefix.len();
        bytes[*start..room].copy_from_slice(&prefix);
    }

    /// The names of the first particles, above and to the right of them.
    fn names(&self, state: &[f64]) -> Vec<TextPrimitive> {
        // Most runs have none.
        let is_named = |&(index, _): &(usize, &[f64])| index < self.scenery.names.len();
        let named = |(index, row): (usize, &[f64])| {
            let Point3 { x, y, .. } = self.point(row);
            let name = self.scenery.names.get(index).filter(|name| !name.is_empty())?;
            let offset = NAME_OVER_EXTENT * self.extent;
            Some(text_at([x + offset, y + offset], name.clone()))
        };
        self.drawn_rows(state).take_while(is_named).filter_map(named).collect()
    }

    /// Velocities as lines from the discs' centers, all in one line list.
    pub(crate) fn velocity(&self, state: &[f64], time: Timestamp) -> SceneUpdate {
        let scale = ARROW_OVER_EXTENT * self.extent / self.scenery.speed_range_top;
        let mut points = Vec::new();
        if let [vx, vy, ..] = self.columns.velocity[..] {
            points.reserve_exact(2 * self.drawn_discs(state));
            for (_, row) in self.drawn_rows(state) {
                let [x, y] = self.columns.position.map(|column| row[column]);
                points.push(self.point(row));
                points.push(self.rounded([x + scale * row[vx], y + scale * row[vy]]));
            }
        }
        let lines = line_list(points, 1.0, self.layer(2.0), color::DARK_GRAY);
        update(SceneEntity { lines, ..entity("velocity", time) })
    }

    /// Contact forces as line lists of three widths, of very many the strongest. Without contacts the entity is empty, which
    /// removes the last ones.
    pub(crate) fn contacts(&self, contacts: &[ContactLine], time: Timestamp) -> SceneUpdate {
        let top = self.scenery.force_range_top.unwrap_or(f64::INFINITY);
        let weakest = weakest_drawn(contacts, self.contacts_at_most());
        let mut points: [Vec<Point3>; 3] = Default::default();
        for contact in contacts.iter().filter(|contact| contact.force.abs() >= weakest) {
            if contact.from.iter().chain(&contact.to).all(|coordinate| coordinate.is_finite()) {
                let class = (contact.force.abs() / top * 3.0) as usize;
                points[class.min(2)].extend([self.rounded(contact.from), self.rounded(contact.to)]);
            }
        }
        let lines = points
            .into_iter()
            .zip(FORCE_WIDTHS_PX)
            .flat_map(|(points, width)| line_list(points, width, self.layer(3.0), color::RED))
            .collect();
        update(SceneEntity { lines, ..entity("force_chains", time) })
    }

    /// Contact forces drawn at most, where no two are equal.
    pub(crate) fn contacts_at_most(&self) -> usize {
        MAX_CONTACTS.min(CONTACTS_OVER_PARTICLES.saturating_mul(self.drawn_at_most))
    }

    /// The paths so far as one line each, below the discs.
    pub(crate) fn trail(&self, trails: &Trails, time: Timestamp) -> SceneUpdate {
        let lines = trails.paths().map(|path| {
            let points: Vec<Point3> = path.map(|point| self.rounded(point)).collect();
            line(line_primitive::Type::LineStrip, points, 1.5, -self.layer(1.0), color::SKY)
        });
        update(SceneEntity { lines: lines.collect(), ..entity("trail", time) })
    }

    /// The container as it is at the start, and bodies at rest.
    pub(crate) fn walls_at_rest(&self, time: Timestamp) -> SceneUpdate {
        self.walls(&self.scenery.walls, time)
    }

    /// A container, and bodies at rest.
    pub(crate) fn walls(&self, drawn: &[Wall], time: Timestamp) -> SceneUpdate {
        let mut walls = entity("walls", time);
        for wall in drawn {
            let mut kind = line_primitive::Type::LineLoop;
            let corners = match *wall {
                Wall::Rectangle { min, max } => {
                    [min, [max[0], min[1]], max, [min[0], max[1]]].map(exact).to_vec()
                }
                Wall::Circle { center, radius } => arc(center, radius, [0.0, TAU])[1..].to_vec(),
                Wall::Arc { center, radius, angles_rad } => {
                    kind = line_primitive::Type::LineStrip;
                    arc(center, radius, angles_rad)
                }
                Wall::Segment { from, to } => [from, to].map(exact).to_vec(),
                Wall::Guide { center, axes, meaning } => {
                    let (width_px, color) = match meaning {
                        GuideMeaning::ExactSolution => (1.5, color::GREEN),
                        GuideMeaning::Mark => (1.0, color::DARK_GRAY),
                    };
                    let corners = ellipse(center, axes);
                    // Below the path so far and the discs.
                    walls.lines.push(line(kind, corners, width_px, -self.layer(2.0), color));
                    continue;
                }
                Wall::Label { center, text } => {
                    walls.texts.push(text_at(center, text.to_owned()));
                    continue;
                }
                Wall::Body { center, radius } => {
                    walls.cylinders.push(cylinder(
                        exact(center),
                        radius,
                        self.layer(1.0),
                        color::YELLOW,
                    ));
                    continue;
                }
            };
            walls.lines.push(line(kind, corners, 3.5, 0.0, color::GRAY));
        }
        update(walls)
    }

    /// The color bar below the container: the 3D panel has none of its own.
    pub(crate) fn legend(&self, time: Timestamp) -> SceneUpdate {
        let [low, high] = self.scenery.view;
        let center = (low[0] + high[0]) / 2.0;
        let (width, y) = (self.extent / 2.0, low[1] - 0.07 * self.extent);
        let cube_width = width / LEGEND_CUBES as f64;
        let cubes = (0..LEGEND_CUBES)
            .map(|cube| {
                let fraction = (cube as f64 + 0.5) / LEGEND_CUBES as f64;
                CubePrimitive {
                    pose: Some(pose([center + (fraction - 0.5) * width, y, 0.0])),
                    size: Some(Vector3 {
                        x: cube_width,
                        y: 0.03 * self.extent,
                        z: self.layer(1.0),
                    }),
                    color: Some(self.colors.at(fraction)),
                }
            })
            .collect();
        let unit = self.scenery.speed_unit;
        let text = |text: String, side: f64| {
            text_at([center + side * (width / 2.0 + 0.11 * self.extent), y], text)
        };
        let top = format!("{} {unit}", three_digits(self.scenery.speed_range_top));
        // Without a unit, which viewers' fonts make hard to read after a zero.
        let texts = vec![text("speed 0".to_owned(), -1.0), text(top.trim_end().to_owned(), 1.0)];
        update(SceneEntity { cubes, texts, ..entity("legend", time) })
    }

    /// Positions of the first particles, whose paths are drawn; `None` if one of them blew up.
    pub(crate) fn traced(&self, state: &[f64]) -> Option<Vec<[f64; 2]>> {
        let rows = state.chunks_exact(self.columns.width).take(PATHS);
        let positions: Vec<[f64; 2]> =
            rows.map(|row| self.columns.position.map(|column| row[column])).collect();
        let all_finite = positions.iter().flatten().all(|coordinate| coordinate.is_finite());
        all_finite.then_some(positions)
    }

    /// Maximum number of discs that are drawn of a state.
    fn drawn_discs(&self, state: &[f64]) -> usize {
        Ord::min(state.len() / self.columns.width, self.drawn_at_most)
    }

    /// Every k-th row, k so that no more are drawn than the manifest allows, with its index; rows that blew up are left out.
    fn drawn_rows<'a>(&'a self, state: &'a [f64]) -> impl Iterator<Item = (usize, &'a [f64])> {
        let rows = state.len() / self.columns.width;
        let every = rows.div_ceil(self.drawn_at_most).max(1);
        let rows = state.chunks_exact(self.columns.width).enumerate();
        rows.step_by(every).filter(|(_, row)| {
            let drawn = self.columns.position.iter().chain(&self.columns.velocity);
            drawn.into_iter().all(|&column| row[column].is_finite())
        })
    }

    fn speed(&self, row: &[f64]) -> f64 {
        self.columns.velocity.iter().map(|&column| row[column] * row[column]).sum::<f64>().sqrt()
    }

    fn layer(&self, layers: f64) -> f64 {
        layers * LAYER_OVER_EXTENT * self.extent
    }

    fn point(&self, row: &[f64]) -> Point3 {
        self.rounded(self.columns.position.map(|column| row[column]))
    }

    fn rounded(&self, point: [f64; 2]) -> Point3 {
        // Adding zero turns -0.0 into 0.0, which protobuf does not store.
        exact(point.map(|coordinate| nearest_integer(coordinate / self.grid) * self.grid + 0.0))
    }
}

/// `libm::round`, up to the sign of a zero. That one is a call.
#[inline]
fn nearest_integer(number: f64) -> f64 {
    // The number before 0.5: the sum of it and a number just below a half does not round to 1.
    const HALF: f64 = 0.499_999_999_999_999_94;
    if number.abs() < 1e15 {
        (number + HALF.copysign(number)) as i64 as f64
    } else {
        libm::round(number)
    }
}

/// The largest power of two that is not above a positive number.
fn power_of_two_below(value: f64) -> f64 {
    f64::from_bits(value.to_bits() & 0x7ff0_0000_0000_0000)
}

/// Corners of an ellipse with two conjugate half diameters.
fn ellipse(center: [f64; 2], axes: [[f64; 2]; 2]) -> Vec<Point3> {
    let corner = |corner: usize| {
        let (sine, cosine) = libm::sincos(TAU * corner as f64 / CIRCLE_CORNERS as f64);
        exact([0, 1].map(|axis| center[axis] + axes[0][axis] * cosine + axes[1][axis] * sine))
    };
    (0..CIRCLE_CORNERS).map(corner).collect()
}

/// Corners of a part of a circle, its ends among them.
fn arc(center: [f64; 2], radius: f64, [from, to]: [f64; 2]) -> Vec<Point3> {
    let corner = |corner: usize| {
        let angle = from + (to - from) * corner as f64 / CIRCLE_CORNERS as f64;
        exact([center[0] + radius * libm::cos(angle), center[1] + radius * libm::sin(angle)])
    };
    (0..=CIRCLE_CORNERS).map(corner).collect()
}

fn exact(point: [f64; 2]) -> Point3 {
    Point3 { x: point[0], y: point[1], z: 0.0 }
}

/// A position without rotation.
pub(crate) fn pose(position: [f64; 3]) -> Pose {
    let [x, y, z] = position;
    Pose {
        position: Some(Vector3 { x, y, z }),
        orientation: Some(Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }),
    }
}

/// A disc: `size` is the diameter, and unset scales would make it invisible.
fn cylinder(center: Point3, radius: f64, thickness: f64, color: Color) -> CylinderPrimitive {
    CylinderPrimitive {
        pose: Some(pose([center.x, center.y, 0.0])),
        size: Some(Vector3 { x: 2.0 * radius, y: 2.0 * radius, z: thickness }),
        bottom_scale: 1.0,
        top_scale: 1.0,
        color: Some(color),
    }
}

/// A line of text around a point, upright in the viewer and of constant size.
fn text_at([x, y]: [f64; 2], text: String) -> TextPrimitive {
    TextPrimitive {
        pose: Some(pose([x, y, 0.0])),
        billboard: true,
        font_size: FONT_SIZE_PX,
        scale_invariant: true,
        color: Some(color::WHITE),
        text,
    }
}

/// Separate segments, or nothing where there is no point.
fn line_list(points: Vec<Point3>, width_px: f64, z: f64, color: Color) -> Vec<LinePrimitive> {
    if points.is_empty() {
        return Vec::new();
    }
    vec![line(line_primitive::Type::LineList, points, width_px, z, color)]
}

/// A line whose points lie at height `z`; the height stands once in the pose, so that points cost two coordinates.
fn line(
    kind: line_primitive::Type,
    points: Vec<Point3>,
    width_px: f64,
    z: f64,
    color: Color,
) -> LinePrimitive {
    LinePrimitive {
        r#type: kind.into(),
        pose: Some(pose([0.0, 0.0, z])),
        thickness: width_px,
        scale_invariant: true,
        points,
        color: Some(color),
        colors: Vec::new(),
        indices: Vec::new(),
    }
}

/// An empty entity: the same id replaces what the last frame drew.
fn entity(id: &str, time: Timestamp) -> SceneEntity {
    SceneEntity {
        timestamp: Some(time),
        frame_id: FRAME_ID.to_owned(),
        id: id.to_owned(),
        ..SceneEntity::default()
    }
}

fn update(entity: SceneEntity) -> SceneUpdate {
    SceneUpdate { deletions: Vec::new(), entities: vec![entity] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Guarantee: numbers are rounded as by `libm::round`. Control: truncation gives other numbers.
    #[test]
    fn nearest_integers_are_those_of_round() {
        let mut truncated = 0;
        for exponent in 960..2040_u64 {
            for step in 0..64 {
                let number = (1.0 + f64::from(step) / 64.0) * f64::from_bits(exponent << 52);
                for number in [number, number.next_down(), number.next_up()] {
                    for number in [number, -number, number + 0.5, 0.5 - number] {
                        assert_eq!(nearest_integer(number), libm::round(number), "{number:e}");
                        truncated += u32::from(number.trunc() != libm::round(number));
                    }
                }
            }
        }
        assert!(truncated > 1000, "{truncated}");
        for number in [0.0, -0.0, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(nearest_integer(number), number);
        }
        assert!(nearest_integer(f64::NAN).is_nan());
    }
}
