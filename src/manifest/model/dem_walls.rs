//! Walls of a DEM run besides the box's own: straight pieces and drums, at rest or moving.

use crate::diagnostics::Diagnostic;
use crate::keys::{Keys, Reader};
use crate::quantity::{Finite, NonNegative, Positive};
use crate::tree::{Node, Value};
use crate::value::{TomlValue, joined, refuse, table_schema};
use serde_json::{Value as Json, json};

/// One wall with its motion: displacement at the time t is u t + A sin(2 pi f t), where the clock t runs within `moves_s` only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DemWall {
    /// Its shape at the start.
    pub shape: DemWallShape,
    /// Constant velocity u, m/s.
    pub velocity_m_per_s: [Finite; 2],
    /// Amplitude A of an oscillation, m.
    pub amplitude_m: [Finite; 2],
    /// Frequency f of the oscillation, Hz.
    pub frequency_hz: NonNegative,
    /// When its motion, a drum's turning included, begins and ends, s; `None` for all the time.
    pub moves_s: Option<[NonNegative; 2]>,
}

/// The shape of a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DemWallShape {
    /// A straight piece with two ends; discs may touch either side.
    Segment {
        /// One end, m.
        from_m: [Finite; 2],
        /// The other, m.
        to_m: [Finite; 2],
    },
    /// A circle with the discs inside.
    Drum {
        /// Its center, m.
        center_m: [Finite; 2],
        /// Its radius, m.
        radius_m: Positive,
        /// Its angular velocity, rad/s.
        spin_rad_per_s: Finite,
    },
}

impl DemWall {
    /// Whether nothing of it moves.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        let is_zero = |pair: [Finite; 2]| pair.iter().all(|value| value.get() == 0.0);
        let turns = match self.shape {
            DemWallShape::Drum { spin_rad_per_s, .. } => spin_rad_per_s.get() != 0.0,
            DemWallShape::Segment { .. } => false,
        };
        let oscillates = !is_zero(self.amplitude_m) && self.frequency_hz.get() > 0.0;
        !turns && !oscillates && is_zero(self.velocity_m_per_s)
    }
}

impl TomlValue for DemWall {
    fn read(node: &Node, name: &str, errors: &mut Vec<Diagnostic>) -> Option<Self> {
        let Value::Table(table) = &node.value else {
            refuse(node, name, "a table { from_m, to_m } or { center_m, radius_m }", errors);
            return None;
        };
        let zero = [Finite::literal(0.0); 2];
        let mut reader = Reader::new(name, table, errors);
        let shape = if reader.has("center_m") || reader.has("radius_m") {
            let center: Option<[Finite; 2]> = reader.required("center_m", node.span);
            let radius: Option<Positive> = reader.required("radius_m", node.span);
            let spin = optional(&mut reader, "spin_rad_per_s", Finite::literal(0.0));
            center.zip(radius).map(|(center_m, radius_m)| DemWallShape::Drum {
                center_m,
                radius_m,
                spin_rad_per_s: spin,
            })
        } else {
            let from: Option<[Finite; 2]> = reader.required("from_m", node.span);
            let to: Option<[Finite; 2]> = reader.required("to_m", node.span);
            let ends = from.zip(to);
            if ends.is_some_and(|(from, to)| from == to) {
                let title = format!("`{name}` has a wall without length");
                reader.refuse(&["from_m", "to_m"], &title, "the two ends must differ");
            }
            ends.filter(|(from, to)| from != to)
                .map(|(from_m, to_m)| DemWallShape::Segment { from_m, to_m })
        };
        let velocity = optional(&mut reader, "velocity_m_per_s", zero);
        let amplitude = optional(&mut reader, "amplitude_m", zero);
        let frequency = optional(&mut reader, "frequency_hz", NonNegative::literal(0.0));
        let moves: Option<[NonNegative; 2]> = reader.optional("moves_s", "", "", None);
        let is_ordered = moves.is_none_or(|[begin, end]| begin < end);
        if !is_ordered {
            reader.refuse(&["moves_s"], "a motion ends before it begins", "must be [begin, end]");
        }
        let sound = reader.is_sound() && is_ordered;
        reader.finish();
        shape.filter(|_| sound).map(|shape| Self {
            shape,
            velocity_m_per_s: velocity,
            amplitude_m: amplitude,
            frequency_hz: frequency,
            moves_s: moves,
        })
    }

    fn write(&self) -> String {
        let shape = match &self.shape {
            DemWallShape::Segment { from_m, to_m } => {
                format!("from_m = {}, to_m = {}", from_m.write(), to_m.write())
            }
            DemWallShape::Drum { center_m, radius_m, spin_rad_per_s } => format!(
                "center_m = {}, radius_m = {}, spin_rad_per_s = {}",
                center_m.write(),
                radius_m.write(),
                spin_rad_per_s.write()
            ),
        };
        let moves =
            self.moves_s.map_or_else(String::new, |moves| format!(", moves_s = {}", moves.write()));
        format!(
            "{{ {shape}, velocity_m_per_s = {}, amplitude_m = {}, frequency_hz = {}{moves} }}",
            self.velocity_m_per_s.write(),
            self.amplitude_m.write(),
            self.frequency_hz.write()
        )
    }

    fn schema() -> Json {
        let pair = <[Finite; 2]>::schema();
        let motion = json!({
            "velocity_m_per_s": pair,
            "amplitude_m": pair,
            "frequency_hz": NonNegative::schema(),
            "moves_s": <[NonNegative; 2]>::schema()
        });
        let table =
            |own: &Json, required: &[&str]| table_schema(&joined(motion.clone(), own), required);
        let segment = json!({ "from_m": pair, "to_m": pair });
        let drum = json!({
            "center_m": pair, "radius_m": Positive::schema(), "spin_rad_per_s": Finite::schema()
        });
        json!({ "anyOf": [table(&segment, &["from_m", "to_m"]), table(&drum, &["center_m", "radius_m"])] })
    }
}

/// A key's value where it stands in the table, else its default.
fn optional<T: TomlValue>(reader: &mut Reader<'_>, key: &'static str, default: T) -> T {
    reader.optional(key, "", "", None).unwrap_or(default)
}
