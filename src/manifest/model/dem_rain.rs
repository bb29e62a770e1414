//! Discs that fall into a DEM run while it runs.

use crate::diagnostics::Diagnostic;
use crate::keys::{Keys, Reader};
use crate::quantity::{Finite, NonNegative, Positive};
use crate::tree::{Node, Value};
use crate::value::{TomlValue, refuse, table_schema};
use serde_json::{Value as Json, json};
use std::num::NonZeroU32;

/// Discs that enter one after the other, in the order of their ids, somewhere on a line where there is room.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DemRain {
    /// How many enter, besides those of the start.
    pub discs: NonZeroU32,
    /// How many are due in a second; they come later where there is no room.
    pub discs_per_s: Positive,
    /// One end of the line that their centers enter on, m.
    pub from_m: [Finite; 2],
    /// The other, m.
    pub to_m: [Finite; 2],
    /// Their velocity, m/s; not zero.
    pub velocity_m_per_s: [Finite; 2],
    /// When the first is due, s.
    pub starts_s: NonNegative,
}

impl TomlValue for DemRain {
    fn read(node: &Node, name: &str, errors: &mut Vec<Diagnostic>) -> Option<Self> {
        let Value::Table(table) = &node.value else {
            let expected = "a table { discs, discs_per_s, from_m, to_m, velocity_m_per_s }";
            refuse(node, name, expected, errors);
            return None;
        };
        let mut reader = Reader::new(name, table, errors);
        let discs: Option<NonZeroU32> = reader.required("discs", node.span);
        let discs_per_s: Option<Positive> = reader.required("discs_per_s", node.span);
        let from_m: Option<[Finite; 2]> = reader.required("from_m", node.span);
        let to_m: Option<[Finite; 2]> = reader.required("to_m", node.span);
        let velocity: Option<[Finite; 2]> = reader.required("velocity_m_per_s", node.span);
        let starts_s = reader.optional("starts_s", "", "", None);
        let rests = velocity.is_some_and(|velocity| velocity.iter().all(|v| v.get() == 0.0));
        if rests {
            let title = "discs that enter at rest stand in each other's way";
            reader.refuse(&["velocity_m_per_s"], title, "must not be [0, 0]");
        }
        let sound = reader.is_sound() && !rests;
        reader.finish();
        let (discs, discs_per_s) = discs.zip(discs_per_s).filter(|_| sound)?;
        let (from_m, to_m) = from_m.zip(to_m)?;
        Some(Self {
            discs,
            discs_per_s,
            from_m,
            to_m,
            velocity_m_per_s: velocity?,
            starts_s: starts_s.unwrap_or(NonNegative::literal(0.0)),
        })
    }

    fn write(&self) -> String {
        format!(
            "{{ discs = {}, discs_per_s = {}, from_m = {}, to_m = {}, velocity_m_per_s = {}, starts_s = {} }}",
            self.discs,
            self.discs_per_s.write(),
            self.from_m.write(),
            self.to_m.write(),
            self.velocity_m_per_s.write(),
            self.starts_s.write()
        )
    }

    fn schema() -> Json {
        let pair = <[Finite; 2]>::schema();
        let properties = json!({
            "discs": NonZeroU32::schema(),
            "discs_per_s": Positive::schema(),
            "from_m": pair,
            "to_m": pair,
            "velocity_m_per_s": pair,
            "starts_s": NonNegative::schema()
        });
        let required = ["discs", "discs_per_s", "from_m", "to_m", "velocity_m_per_s"];
        table_schema(&properties, &required)
    }
}
