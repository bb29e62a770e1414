//! The protobuf schema of each topic.

use crate::channels::{self, Channel as _, ChannelDeclaration, FrameClock};
use crate::descriptor::file_descriptor_set;
use crate::error::RecordError;
use foxglove::Encode as _;
use foxglove::messages::{Log, PointCloud, SceneUpdate};

/// The schema of a topic, either declared by the model or common to all recordings.
pub(crate) fn schema_of(
    topic: &str,
    declared: &[ChannelDeclaration],
) -> Result<foxglove::Schema, RecordError> {
    if topic == FrameClock::TOPIC {
        return own_schema(&ChannelDeclaration::of::<FrameClock>());
    }
    if let Some(channel) = declared.iter().find(|channel| channel.topic == topic) {
        return own_schema(channel);
    }
    let schema = match topic {
        channels::STATE => PointCloud::get_schema(),
        channels::LOG => Log::get_schema(),
        _ => SceneUpdate::get_schema(),
    };
    schema.ok_or_else(|| RecordError::Declaration(format!("{topic} has no schema")))
}

fn own_schema(channel: &ChannelDeclaration) -> Result<foxglove::Schema, RecordError> {
    Ok(foxglove::Schema::new(channel.schema, "protobuf", file_descriptor_set(channel)?))
}
