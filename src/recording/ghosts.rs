//! Drawings of a run as ghosts over those of another one.

use foxglove::messages::{Color, SceneUpdate, Timestamp};
use prost::{DecodeError, Message as _};

/// Colors of the ghosts, with their names: none is near a color of a speed.
pub(crate) const COLORS: [(&str, [u8; 3]); 6] = [
    ("orange", [0xf0, 0x7d, 0x0a]),
    ("magenta", [0xd4, 0x3d, 0xa0]),
    ("violet", [0x8a, 0x5c, 0xd6]),
    ("brown", [0x8c, 0x5a, 0x2b]),
    ("gray", [0x80, 0x80, 0x80]),
    ("pink", [0xf7, 0xa8, 0xc4]),
];
/// Opacity of a ghost: the first run is seen through it.
const OPACITY: f64 = 0.55;

/// The color of a ghost, from 0, as a viewer's settings write it.
pub(crate) fn hex(ghost: usize) -> String {
    let (_, [red, green, blue]) = COLORS[ghost % COLORS.len()];
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// The name of its color.
pub(crate) const fn name(ghost: usize) -> &'static str {
    COLORS[ghost % COLORS.len()].0
}

/// A drawing in the color of a ghost, half transparent, a little above the first run, and without names, which the first run has.
pub(crate) fn ghost(payload: &[u8], ghost: usize, log_time: u64) -> Result<Vec<u8>, DecodeError> {
    let [r, g, b] = COLORS[ghost % COLORS.len()].1.map(|value| f64::from(value) / 255.0);
    let color = Color { r, g, b, a: OPACITY };
    let nanoseconds = (log_time % 1_000_000_000) as u32;
    let time = Timestamp::new((log_time / 1_000_000_000) as u32, nanoseconds);
    let mut update = SceneUpdate::decode(payload)?;
    for entity in &mut update.entities {
        entity.timestamp = Some(time);
        entity.texts.clear();
        for cylinder in &mut entity.cylinders {
            let thickness = cylinder.size.as_ref().map_or(0.0, |size| size.z);
            if let Some(position) = cylinder.pose.as_mut().and_then(|pose| pose.position.as_mut()) {
                position.z += 0.5 * thickness * (ghost + 1) as f64;
            }
            cylinder.color = Some(color);
        }
        for line in &mut entity.lines {
            line.color = Some(color);
            line.colors.clear();
        }
        for cube in &mut entity.cubes {
            cube.color = Some(color);
        }
    }
    Ok(update.encode_to_vec())
}
