//! The protobuf schema of each topic.

use crate::channels::{self, ChannelDeclaration, FrameClock};
use crate::descriptor::file_descriptor_set;
use crate::error::RecordError;
use crate::keyframe;
use foxglove::Encode as _;
use foxglove::messages::{Log, PointCloud, SceneUpdate};

/// The schema of a topic, either declared by the model or common to all recordings.
pub(crate) fn schema_of(
    topic: &str,
    declared: &[ChannelDeclaration],
) -> Result<foxglove::Schema, RecordError> {
    let clock = [ChannelDeclaration::of::<FrameClock>()];
    if let Some(channel) = clock.iter().chain(declared).find(|channel| channel.topic == topic) {
        let set = file_descriptor_set(channel)?;
        return Ok(foxglove::Schema::new(channel.schema, "protobuf", set));
    }
    if topic == keyframe::KEYFRAME {
        let schema = keyframe::SCHEMA;
        return Ok(foxglove::Schema::new(schema, "protobuf", keyframe::descriptor()));
    }
    let schema = match topic {
        channels::PARTICLES | channels::STATE => PointCloud::get_schema(),
        channels::LOG => Log::get_schema(),
        _ => SceneUpdate::get_schema(),
    };
    schema.ok_or_else(|| RecordError::Declaration(format!("{topic} has no schema")))
}
