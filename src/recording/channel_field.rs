//! A field of a channel's message: its name, type and tag.

use prost_types::field_descriptor_proto::Type;

/// One field of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field {
    /// Name, its unit last.
    pub name: &'static str,
    /// Protobuf type, followed by `, repeated` for a series.
    pub kind: &'static str,
    /// Protobuf tag.
    pub tag: &'static str,
}

impl Field {
    /// Type of the values; `None` for a type that no channel has.
    pub(crate) fn value_type(&self) -> Option<Type> {
        match self.kind.split(',').next()? {
            "double" => Some(Type::Double),
            "uint64" => Some(Type::Uint64),
            "string" => Some(Type::String),
            _ => None,
        }
    }

    /// Whether the field is a series.
    pub(crate) fn is_series(&self) -> bool {
        self.kind.ends_with(", repeated")
    }
}
