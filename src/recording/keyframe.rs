//! Keyframes: the state of the model, from which a run continues, and hashes of the states that are not stored.
//!
//! Drawings have no hash, because they follow from the state of the model; of a frame that is not stored, none is made.

use crate::channels;
use crate::error::RecordError;
use prost::Message;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};
use sha2::{Digest as _, Sha256};

/// Topic of the keyframes, the last one of each stored frame.
pub const KEYFRAME: &str = "/keyframe";
/// Full name of the schema.
pub(crate) const SCHEMA: &str = "kinetoscope.Keyframe";
/// Size of a message's hash.
pub const HASH_BYTES: usize = 16;
/// Ends the hashes of a frame, in the place of a channel.
const END_OF_FRAME: u8 = u8::MAX;

/// Whether a topic is that of a drawing.
#[must_use]
pub fn is_drawing(topic: &str) -> bool {
    use channels::{DISCS, FORCE_CHAINS, LEGEND, TRAIL, VELOCITY, WALLS};
    [DISCS, WALLS, LEGEND, VELOCITY, FORCE_CHAINS, TRAIL].contains(&topic)
}

/// The message of [`KEYFRAME`].
#[derive(Clone, PartialEq, Message)]
pub struct Keyframe {
    /// The state of the model, in the encoding of checkpoints.
    #[prost(bytes = "vec", tag = "1")]
    pub model: Vec<u8>,
    /// The hashes of the frames since the previous keyframe: of each, the state and the columns that are recorded on request.
    #[prost(bytes = "vec", tag = "2")]
    pub hashes: Vec<u8>,
}

impl Keyframe {
    /// Decodes a message; `None` if it is damaged.
    #[must_use]
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        Self::decode(bytes).ok()
    }

    /// Whether these are the bytes that a recorder writes for this keyframe. Other bytes may be decoded to the same values.
    #[must_use]
    pub fn is_written_as(&self, bytes: &[u8]) -> bool {
        self.encode_to_vec() == bytes
    }
}

/// The schema as a serialized `FileDescriptorSet`.
pub(crate) fn descriptor() -> Vec<u8> {
    let field = |name: &str, number| FieldDescriptorProto {
        name: Some(name.to_owned()),
        number: Some(number),
        label: Some(Label::Optional.into()),
        r#type: Some(Type::Bytes.into()),
        ..FieldDescriptorProto::default()
    };
    let file = FileDescriptorProto {
        name: Some("kinetoscope/Keyframe.proto".to_owned()),
        package: Some("kinetoscope".to_owned()),
        message_type: vec![DescriptorProto {
            name: Some("Keyframe".to_owned()),
            field: vec![field("model", 1), field("hashes", 2)],
            ..DescriptorProto::default()
        }],
        syntax: Some("proto3".to_owned()),
        ..FileDescriptorProto::default()
    };
    FileDescriptorSet { file: vec![file] }.encode_to_vec()
}

/// The hash of one message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MessageHash {
    /// Position of its channel in the list of recorded channels.
    pub channel: u8,
    /// The first half of the SHA-256 of log time and payload.
    pub hash: [u8; HASH_BYTES],
}

impl MessageHash {
    /// Hashes a message of a topic. The particles have no time, because when they are recorded depends on which frames are stored.
    ///
    /// # Errors
    /// More channels than any recording has: a defect of the program.
    pub fn of(
        topic: &str,
        channel: usize,
        log_time_ns: u64,
        payload: &[u8],
    ) -> Result<Self, RecordError> {
        let log_time_ns = if topic == channels::PARTICLES { 0 } else { log_time_ns };
        let channel = u8::try_from(channel).ok().filter(|channel| *channel != END_OF_FRAME);
        let channel =
            channel.ok_or_else(|| RecordError::Container("too many channels".to_owned()))?;
        let whole = Sha256::new().chain_update(log_time_ns.to_le_bytes()).chain_update(payload);
        let mut hash = [0; HASH_BYTES];
        hash.copy_from_slice(&whole.finalize()[..HASH_BYTES]);
        Ok(Self { channel, hash })
    }

    pub(crate) fn append_to(self, bytes: &mut Vec<u8>) {
        bytes.push(self.channel);
        bytes.extend(self.hash);
    }
}

/// Ends the hashes of a frame.
pub(crate) fn end_frame(bytes: &mut Vec<u8>) {
    bytes.push(END_OF_FRAME);
}

/// The hashes of the frames in these bytes, decoded frame by frame: a frame without messages takes one byte, so that a list of
/// all frames of a damaged recording would take many times the memory of the recording.
#[derive(Debug, Default)]
pub struct FrameHashes {
    bytes: Vec<u8>,
    /// Position of the next frame.
    at: usize,
}

/// Hashes that cannot be decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DamagedHashes;

impl FrameHashes {
    /// The frames in these bytes.
    #[must_use]
    pub fn new(bytes: Vec<u8>) -> Self {
        Self { bytes, at: 0 }
    }
}

impl Iterator for FrameHashes {
    type Item = Result<Vec<MessageHash>, DamagedHashes>;

    fn next(&mut self) -> Option<Self::Item> {
        let mut rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let mut frame = Vec::new();
        while let Some((&channel, after)) = rest.split_first() {
            if channel == END_OF_FRAME {
                self.at = self.bytes.len() - after.len();
                return Some(Ok(frame));
            }
            let Some((hash, after)) = after.split_first_chunk() else { break };
            frame.push(MessageHash { channel, hash: *hash });
            rest = after;
        }
        self.at = self.bytes.len();
        Some(Err(DamagedHashes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Control: a byte less is damage.
    #[test]
    fn hashes_survive_their_encoding() {
        let one = MessageHash::of("/state", 3, 40, b"payload").unwrap();
        let other = MessageHash::of("/state", 3, 41, b"payload").unwrap();
        assert_ne!(one, other);
        let mut bytes = Vec::new();
        one.append_to(&mut bytes);
        end_frame(&mut bytes);
        end_frame(&mut bytes);
        other.append_to(&mut bytes);
        one.append_to(&mut bytes);
        end_frame(&mut bytes);
        let decoded = |bytes: &[u8]| FrameHashes::new(bytes.to_vec()).collect::<Vec<_>>();
        assert_eq!(decoded(&bytes), [Ok(vec![one]), Ok(vec![]), Ok(vec![other, one])]);
        let cut = decoded(&bytes[..bytes.len() - 1]);
        assert_eq!(cut, [Ok(vec![one]), Ok(vec![]), Err(DamagedHashes)]);
        assert!(MessageHash::of("/state", 255, 0, b"").is_err());
    }
}
