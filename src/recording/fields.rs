//! The fields of a message by name, decoded without its Rust type, so that a comparison can name the differing fields.

use crate::channels::ChannelDeclaration;
use prost::bytes::Buf;
use prost::encoding::{DecodeContext, WireType, decode_key, decode_varint, skip_field};
use prost_types::field_descriptor_proto::Type;

/// The values of one field, in order; a field that is not a series has one.
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

/// Decodes all fields of a message in the order of their declaration. Fields that are absent on the wire have their default,
/// and unknown tags are skipped; `None` for bytes that are not a message of this channel.
#[must_use]
pub fn read_fields(channel: &ChannelDeclaration, payload: &[u8]) -> Option<Vec<FieldValues>> {
    let mut fields: Vec<FieldValues> = channel
        .fields
        .iter()
        .map(|field| FieldValues {
            name: field.name,
            series: field.is_series(),
            values: Vec::new(),
        })
        .collect();
    let mut rest = payload;
    while rest.has_remaining() {
        let (tag, wire_type) = decode_key(&mut rest).ok()?;
        let known = channel.fields.iter().position(|field| field.tag.parse() == Ok(tag));
        match known {
            Some(index) => {
                let kind = channel.fields[index].value_type()?;
                read(kind, wire_type, &mut rest, &mut fields[index].values)?;
            }
            None => skip_field(wire_type, tag, &mut rest, DecodeContext::default()).ok()?,
        }
    }
    for (field, declared) in fields.iter_mut().zip(channel.fields) {
        if !field.series && field.values.is_empty() {
            field.values.push(match declared.value_type()? {
                Type::Double => FieldValue::Number(0.0),
                Type::Uint64 => FieldValue::Count(0),
                _ => FieldValue::Text(String::new()),
            });
        }
    }
    Some(fields)
}

/// Reads one value, or a packed series of them.
fn read(
    kind: Type,
    wire_type: WireType,
    rest: &mut &[u8],
    into: &mut Vec<FieldValue>,
) -> Option<()> {
    into.push(match (kind, wire_type) {
        (Type::Double, WireType::SixtyFourBit) => FieldValue::Number(rest.try_get_f64_le().ok()?),
        (Type::Uint64, WireType::Varint) => FieldValue::Count(decode_varint(rest).ok()?),
        (Type::String, WireType::LengthDelimited) => {
            FieldValue::Text(String::from_utf8(delimited(rest)?.to_vec()).ok()?)
        }
        (Type::Double | Type::Uint64, WireType::LengthDelimited) => {
            let is_double = kind == Type::Double;
            let element = if is_double { WireType::SixtyFourBit } else { WireType::Varint };
            let mut packed = delimited(rest)?;
            while packed.has_remaining() {
                read(kind, element, &mut packed, into)?;
            }
            return Some(());
        }
        _ => return None,
    });
    Some(())
}

/// Bytes that follow their length.
fn delimited<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    let length = usize::try_from(decode_varint(rest).ok()?).ok()?;
    let (bytes, after) = rest.split_at_checked(length)?;
    *rest = after;
    Some(bytes)
}
