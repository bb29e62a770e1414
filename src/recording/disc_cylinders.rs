//! Protobuf bytes of drawn discs. They equal those of `foxglove.CylinderPrimitive`; a value of that type per disc, with five
//! messages inside it, would take longer than the compression of its bytes.

use crate::color::{ColorMap, STEPS};
use foxglove::messages::{Color, CylinderPrimitive};
use prost::Message as _;

/// Keys of fields: tag times 8, plus 1 for a double and 2 for a message.
mod key {
    /// `SceneEntity.cylinders`.
    pub(super) const CYLINDER: u8 = 10 << 3 | 2;
    /// `CylinderPrimitive.pose`, and `Pose.position` in it.
    pub(super) const POSE: u8 = 1 << 3 | 2;
    pub(super) const POSITION: u8 = 1 << 3 | 2;
    /// `CylinderPrimitive.size`.
    pub(super) const SIZE: u8 = 2 << 3 | 2;
    /// Coordinates of `Vector3`.
    pub(super) const X: u8 = 1 << 3 | 1;
    pub(super) const Y: u8 = 2 << 3 | 1;
    pub(super) const Z: u8 = 3 << 3 | 1;
}

/// `Pose.orientation` without rotation: its key, its length, and w = 1.
const ORIENTATION: [u8; 11] = [2 << 3 | 2, 9, 4 << 3 | 1, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f];
/// Bytes of a double with its key.
const DOUBLE: usize = 9;
/// Bytes of both scales and a color with its key and length.
const MAX_TAIL: usize = 2 * DOUBLE + 2 + 4 * DOUBLE;
/// Bytes of a cylinder with its key and length. Lengths are below 128, so each takes one byte.
pub(crate) const MAX_CYLINDER: usize =
    2 + 2 + 2 + 2 * DOUBLE + ORIENTATION.len() + 2 + 3 * DOUBLE + MAX_TAIL;
const _: () = assert!(MAX_CYLINDER - 2 < 128);

/// The last fields of a cylinder: its scales and its color.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tail {
    bytes: [u8; MAX_TAIL],
    length: usize,
}

impl Tail {
    /// Unset scales would make the disc invisible.
    pub(crate) fn of(color: Color) -> Self {
        let (bottom_scale, top_scale) = (1.0, 1.0);
        let primitive = CylinderPrimitive {
            pose: None,
            size: None,
            bottom_scale,
            top_scale,
            color: Some(color),
        };
        let encoded = primitive.encode_to_vec();
        let mut bytes = [0; MAX_TAIL];
        let length = encoded.len().min(MAX_TAIL);
        bytes[..length].copy_from_slice(&encoded[..length]);
        Self { bytes, length }
    }
}

/// The tails of all colors of speeds.
#[derive(Clone, Debug)]
pub(crate) struct Tails(Box<[Tail; STEPS]>);

impl Tails {
    pub(crate) fn new(colors: &ColorMap) -> Self {
        Self(Box::new(colors.all().map(Tail::of)))
    }

    /// The tail for a fraction of the top speed.
    pub(crate) fn at(&self, fraction: f64) -> &Tail {
        &self.0[ColorMap::step(fraction)]
    }
}

/// A disc to draw.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DrawnDisc {
    pub(crate) center: [f64; 2],
    pub(crate) radius: f64,
    pub(crate) thickness: f64,
}

impl DrawnDisc {
    /// Writes the disc as an element of `SceneEntity.cylinders`, and returns its length; the bytes behind it are undefined.
    #[inline]
    pub(crate) fn write_to(&self, bytes: &mut [u8; MAX_CYLINDER], tail: &Tail) -> usize {
        let diameter = 2.0 * self.radius;
        let mut cylinder = Fields { bytes, length: 0 };
        let all = cylinder.begin(key::CYLINDER);
        let pose = cylinder.begin(key::POSE);
        let position = cylinder.begin(key::POSITION);
        cylinder.double(key::X, self.center[0]);
        cylinder.double(key::Y, self.center[1]);
        cylinder.end(position);
        cylinder.append(&ORIENTATION, ORIENTATION.len());
        cylinder.end(pose);
        let size = cylinder.begin(key::SIZE);
        cylinder.double(key::X, diameter);
        cylinder.double(key::Y, diameter);
        cylinder.double(key::Z, self.thickness);
        cylinder.end(size);
        cylinder.append(&tail.bytes, tail.length);
        cylinder.end(all);
        cylinder.length
    }
}

/// The fields of a cylinder written so far.
struct Fields<'a> {
    bytes: &'a mut [u8; MAX_CYLINDER],
    length: usize,
}

impl Fields<'_> {
    /// Writes the key of a message. Returns the position of its length.
    #[inline(always)]
    fn begin(&mut self, key: u8) -> usize {
        self.bytes[self.length] = key;
        self.length += 2;
        self.length - 1
    }

    /// Writes the length of a message, of which everything behind `position` is part.
    #[inline(always)]
    fn end(&mut self, position: usize) {
        self.bytes[position] = (self.length - position - 1) as u8;
    }

    /// Writes a double. Zero is left out, as proto3 does: the next field overwrites it.
    #[inline(always)]
    fn double(&mut self, key: u8, value: f64) {
        self.bytes[self.length] = key;
        self.bytes[self.length + 1..][..8].copy_from_slice(&value.to_le_bytes());
        self.length += if value == 0.0 { 0 } else { DOUBLE };
    }

    /// Appends the first `length` of these bytes. All of them are copied: a copy of constant size is a few instructions.
    #[inline(always)]
    fn append<const N: usize>(&mut self, bytes: &[u8; N], length: usize) {
        self.bytes[self.length..][..N].copy_from_slice(bytes);
        self.length += length;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::YELLOW;
    use crate::scene::pose;
    use foxglove::messages::{SceneEntity, Vector3};

    /// Guarantee: the bytes are those of the schema's own encoder.
    ///
    /// Control: another radius gives other bytes.
    #[test]
    fn discs_are_encoded_as_prost_encodes_cylinders() {
        let values = [0.0, -0.0, 1.0, -0.25, 1e-300, f64::INFINITY, f64::NAN, 0.1];
        let colors = ColorMap::new();
        let tails = Tails::new(&colors);
        for (index, (x, y)) in values.iter().flat_map(|x| values.map(|y| (*x, y))).enumerate() {
            let (radius, thickness) = (values[index % 7], values[index % 5]);
            let fraction = index as f64 / 60.0 - 0.01;
            let is_central = index % 9 == 0;
            let primitive = CylinderPrimitive {
                pose: Some(pose([x, y, 0.0])),
                size: Some(Vector3 { x: 2.0 * radius, y: 2.0 * radius, z: thickness }),
                bottom_scale: 1.0,
                top_scale: 1.0,
                color: Some(if is_central { YELLOW } else { colors.at(fraction) }),
            };
            let entity = SceneEntity { cylinders: vec![primitive], ..SceneEntity::default() };
            let yellow = Tail::of(YELLOW);
            let tail = if is_central { &yellow } else { tails.at(fraction) };
            let bytes = |radius: f64| {
                let mut bytes = [0xff; MAX_CYLINDER];
                let disc = DrawnDisc { center: [x, y], radius, thickness };
                let length = disc.write_to(&mut bytes, tail);
                bytes[..length].to_vec()
            };
            assert_eq!(bytes(radius), entity.encode_to_vec(), "disc {index}");
            assert_ne!(bytes(radius + 3.0 + index as f64), bytes(2.0), "control {index}");
        }
    }
}
