//! The protobuf schemas of Kinetoscope's messages, as serialized `FileDescriptorSet`s for readers in other languages.

use crate::channels::{ChannelDeclaration, Field};
use crate::error::RecordError;
use prost::Message as _;
use prost_types::field_descriptor_proto::Label;
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};

/// Package of all our messages.
const PACKAGE: &str = "kinetoscope";

/// The descriptor set of one channel: one proto3 file with one message.
///
/// # Errors
/// A field of a kind that is not known here: a defect of `channels.rs`.
pub(crate) fn file_descriptor_set(channel: &ChannelDeclaration) -> Result<Vec<u8>, RecordError> {
    let defect = |what: String| RecordError::Declaration(format!("{}: {what}", channel.schema));
    let message_name = channel
        .schema
        .strip_prefix("kinetoscope.")
        .ok_or_else(|| defect("the schema is not in package kinetoscope".to_owned()))?;
    let mut fields = Vec::with_capacity(channel.fields.len());
    for field in channel.fields {
        let descriptor = field_descriptor(field)
            .ok_or_else(|| defect(format!("field {} is of no known kind", field.name)))?;
        fields.push(descriptor);
    }
    let file = FileDescriptorProto {
        name: Some(format!("{PACKAGE}/{message_name}.proto")),
        package: Some(PACKAGE.to_owned()),
        message_type: vec![DescriptorProto {
            name: Some(message_name.to_owned()),
            field: fields,
            ..DescriptorProto::default()
        }],
        syntax: Some("proto3".to_owned()),
        ..FileDescriptorProto::default()
    };
    Ok(FileDescriptorSet { file: vec![file] }.encode_to_vec())
}

fn field_descriptor(field: &Field) -> Option<FieldDescriptorProto> {
    let label = if field.is_series() { Label::Repeated } else { Label::Optional };
    Some(FieldDescriptorProto {
        name: Some(field.name.to_owned()),
        number: Some(field.tag.parse().ok()?),
        label: Some(label.into()),
        r#type: Some(field.value_type()?.into()),
        ..FieldDescriptorProto::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::channels::ALL;

    #[test]
    fn every_channel_has_a_descriptor_with_all_its_fields() {
        for channel in ALL {
            let bytes = file_descriptor_set(channel).unwrap();
            let set = FileDescriptorSet::decode(bytes.as_slice()).unwrap();
            let message = &set.file[0].message_type[0];
            assert_eq!(format!("kinetoscope.{}", message.name()), channel.schema);
            assert_eq!(message.field.len(), channel.fields.len());
            for (described, declared) in message.field.iter().zip(channel.fields) {
                assert_eq!(described.name(), declared.name);
                assert_eq!(described.number().to_string(), declared.tag);
            }
        }
    }
}
