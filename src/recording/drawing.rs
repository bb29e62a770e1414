//! A drawing decoded from a recording: the contents of its scenes in top view.

use crate::color;
use foxglove::messages::{Color, Pose, SceneUpdate, line_primitive};
use prost::Message;
use serde::{Deserialize, Serialize};

/// Red, green, blue.
pub type Rgb = [u8; 3];

/// Colors of discs from rest to the top speed, in equal steps.
pub const SPEED_COLORS: [Rgb; 9] = color::STOPS;

/// What a scene shows. Lengths are in the state's unit, widths of lines in pixels of the viewer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Shape {
    /// A filled disc.
    Disc {
        /// Its center.
        center: [f64; 2],
        /// Its radius.
        radius: f64,
        /// Its color.
        color: Rgb,
    },
    /// Straight segments.
    Segments {
        /// Their ends.
        segments: Vec<[[f64; 2]; 2]>,
        /// Their width, px.
        width_px: f64,
        /// Their color.
        color: Rgb,
    },
    /// A filled rectangle along the axes.
    Rectangle {
        /// Its center.
        center: [f64; 2],
        /// Width and height.
        size: [f64; 2],
        /// Its color.
        color: Rgb,
    },
    /// A line of text.
    Text {
        /// Its middle.
        center: [f64; 2],
        /// What it says.
        text: String,
    },
}

/// The shapes of a `foxglove.SceneUpdate` as the recorder writes them, in its order; `None` for bytes that are no such
/// message.
#[must_use]
pub fn read_shapes(payload: &[u8]) -> Option<Vec<Shape>> {
    let scene = SceneUpdate::decode(payload).ok()?;
    let mut shapes = Vec::new();
    for entity in scene.entities {
        for line in entity.lines {
            let [dx, dy] = position(line.pose.as_ref())?;
            let points: Vec<[f64; 2]> =
                line.points.iter().map(|point| [point.x + dx, point.y + dy]).collect();
            let color = rgb(line.color.as_ref());
            let kind = line_primitive::Type::try_from(line.r#type).ok()?;
            let segments = segments(kind, &points);
            shapes.push(Shape::Segments { segments, width_px: line.thickness, color });
        }
        for cylinder in entity.cylinders {
            let center = position(cylinder.pose.as_ref())?;
            let radius = cylinder.size.as_ref()?.x / 2.0;
            shapes.push(Shape::Disc { center, radius, color: rgb(cylinder.color.as_ref()) });
        }
        for cube in entity.cubes {
            let (center, size) = (position(cube.pose.as_ref())?, cube.size.as_ref()?);
            let (size, color) = ([size.x, size.y], rgb(cube.color.as_ref()));
            shapes.push(Shape::Rectangle { center, size, color });
        }
        for text in entity.texts {
            shapes.push(Shape::Text { center: position(text.pose.as_ref())?, text: text.text });
        }
    }
    Some(shapes)
}

fn segments(kind: line_primitive::Type, points: &[[f64; 2]]) -> Vec<[[f64; 2]; 2]> {
    let pairs = points.windows(2).map(|pair| [pair[0], pair[1]]);
    match kind {
        line_primitive::Type::LineStrip => pairs.collect(),
        line_primitive::Type::LineLoop => {
            let closing = points.last().zip(points.first()).map(|(last, first)| [*last, *first]);
            pairs.chain(closing).collect()
        }
        line_primitive::Type::LineList => {
            points.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect()
        }
    }
}

fn position(pose: Option<&Pose>) -> Option<[f64; 2]> {
    let position = pose?.position.as_ref()?;
    Some([position.x, position.y])
}

fn rgb(color: Option<&Color>) -> Rgb {
    // A cast from float saturates.
    color.map_or([0; 3], |color| {
        [color.r, color.g, color.b].map(|part| libm::round(part * 255.0) as u8)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::pose;
    use foxglove::messages::{
        CubePrimitive, CylinderPrimitive, LinePrimitive, Point3, SceneEntity, TextPrimitive,
        Vector3,
    };

    #[test]
    fn shapes_are_those_of_the_scene_seen_from_above() {
        let orange = Some(Color { r: 1.0, g: 128.0 / 255.0, b: 0.0, a: 1.0 });
        let size = Some(Vector3 { x: 3.0, y: 3.0, z: 0.1 });
        let line = |kind: line_primitive::Type| LinePrimitive {
            r#type: kind.into(),
            pose: Some(pose([10.0, 0.0, 7.0])),
            thickness: 2.5,
            points: [0.0, 1.0, 2.0, 3.0].map(|x| Point3 { x, y: x * x, z: 0.0 }).to_vec(),
            color: orange,
            ..LinePrimitive::default()
        };
        let kinds = [
            line_primitive::Type::LineStrip,
            line_primitive::Type::LineLoop,
            line_primitive::Type::LineList,
        ];
        let entity = SceneEntity {
            lines: kinds.map(line).to_vec(),
            cylinders: vec![CylinderPrimitive {
                pose: Some(pose([1.0, 2.0, 5.0])),
                size,
                color: orange,
                ..CylinderPrimitive::default()
            }],
            cubes: vec![CubePrimitive { pose: Some(pose([4.0, 5.0, 0.0])), size, color: orange }],
            texts: vec![TextPrimitive {
                pose: Some(pose([6.0, 7.0, 0.0])),
                text: "0 m/s".to_owned(),
                ..TextPrimitive::default()
            }],
            ..SceneEntity::default()
        };
        let scene = SceneUpdate { deletions: Vec::new(), entities: vec![entity] };
        let color = [255, 128, 0];
        let [a, b, c, d] = [[10.0, 0.0], [11.0, 1.0], [12.0, 4.0], [13.0, 9.0]];
        let segments = |segments: &[[[f64; 2]; 2]]| Shape::Segments {
            segments: segments.to_vec(),
            width_px: 2.5,
            color,
        };
        let shapes = [
            segments(&[[a, b], [b, c], [c, d]]),
            segments(&[[a, b], [b, c], [c, d], [d, a]]),
            segments(&[[a, b], [c, d]]),
            Shape::Disc { center: [1.0, 2.0], radius: 1.5, color },
            Shape::Rectangle { center: [4.0, 5.0], size: [3.0, 3.0], color },
            Shape::Text { center: [6.0, 7.0], text: "0 m/s".to_owned() },
        ];
        assert_eq!(read_shapes(&scene.encode_to_vec()), Some(shapes.to_vec()));
        assert_eq!(read_shapes(&[0xff; 7]), None);
    }
}
