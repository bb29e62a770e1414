//! The fields of a message by name, decoded without its Rust type, so that a comparison can name the differing fields.

use crate::channels::ChannelDeclaration;
use prost::bytes::Buf;
use prost::encoding::{DecodeContext, WireType, decode_key, decode_varint, skip_field};

/// The values of one field, in order; a field that is no series has one.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldValues {
    /// The field's name, its unit last.
    pub name: &'static str,
    /// Whether the field is a series.
    pub series: bool,
    /// Its values.
    pub values: Vec<FieldValue>,
}

/// One value of a message.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldValue {
    /// A number of type double.
    Number(f64),
    /// A count.
    Count(u64),
    /// A text.
    Text(String),
}

/// All fields of a message in the order of their declaration, those left out on the wire with their default; `None` for
/// bytes that are no message of this channel. Tags that the declaration does not know are passed over.
#[must_use]
pub fn read_fields(channel: &ChannelDeclaration, payload: &[u8]) -> Option<Vec<FieldValues>> {
    let mut fields: Vec<FieldValues> = channel
        .fields
        .iter()
        .map(|field| FieldValues {
            name: field.name,
            series: field.kind.ends_with("repeated"),
            values: Vec::new(),
        })
        .collect();
    let mut rest = payload;
    while rest.has_remaining() {
        let (tag, wire_type) = decode_key(&mut rest).ok()?;
        let known = channel.fields.iter().position(|field| field.tag.parse() == Ok(tag));
        match known {
            Some(index) => {
                let kind = Kind::of(channel.fields[index].kind)?;
                kind.read(wire_type, &mut rest, &mut fields[index].values)?;
            }
            None => skip_field(wire_type, tag, &mut rest, DecodeContext::default()).ok()?,
        }
    }
    for (field, declared) in fields.iter_mut().zip(channel.fields) {
        if !field.series && field.values.is_empty() {
            field.values.push(Kind::of(declared.kind)?.default_value());
        }
    }
    Some(fields)
}

/// The protobuf types that channels of ours use.
#[derive(Clone, Copy)]
enum Kind {
    Double,
    Unsigned,
    Text,
}

impl Kind {
    fn of(declared: &str) -> Option<Self> {
        match declared.split([',', ' ']).next()? {
            "double" => Some(Self::Double),
            "uint64" => Some(Self::Unsigned),
            "string" => Some(Self::Text),
            _ => None,
        }
    }

    fn default_value(self) -> FieldValue {
        match self {
            Self::Double => FieldValue::Number(0.0),
            Self::Unsigned => FieldValue::Count(0),
            Self::Text => FieldValue::Text(String::new()),
        }
    }

    /// Takes one value, or a packed series of them.
    fn read(self, wire_type: WireType, rest: &mut &[u8], into: &mut Vec<FieldValue>) -> Option<()> {
        match (self, wire_type) {
            (Self::Double, WireType::SixtyFourBit) => {
                into.push(FieldValue::Number(rest.try_get_f64_le().ok()?));
            }
            (Self::Unsigned, WireType::Varint) => {
                into.push(FieldValue::Count(decode_varint(rest).ok()?));
            }
            (Self::Text, WireType::LengthDelimited) => {
                let text = String::from_utf8(delimited(rest)?.to_vec()).ok()?;
                into.push(FieldValue::Text(text));
            }
            (Self::Double, WireType::LengthDelimited) => {
                let mut packed = delimited(rest)?;
                while packed.has_remaining() {
                    self.read(WireType::SixtyFourBit, &mut packed, into)?;
                }
            }
            (Self::Unsigned, WireType::LengthDelimited) => {
                let mut packed = delimited(rest)?;
                while packed.has_remaining() {
                    self.read(WireType::Varint, &mut packed, into)?;
                }
            }
            _ => return None,
        }
        Some(())
    }
}

/// Bytes with their length before them.
fn delimited<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    let length = usize::try_from(decode_varint(rest).ok()?).ok()?;
    let (bytes, after) = rest.split_at_checked(length)?;
    *rest = after;
    Some(bytes)
}
