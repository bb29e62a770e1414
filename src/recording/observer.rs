//! Observer of a run: receives the messages of the recording while they are written.

use crate::error::RecordError;
use crate::header::Header;
use crate::playback::log_time_ns;
use crate::schema::schema_of;

/// A channel as the recording declares it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChannelInfo {
    /// Its topic, with the leading slash.
    pub topic: &'static str,
    /// Name of the schema, such as `foxglove.SceneUpdate`.
    pub schema_name: String,
    /// The schema: a serialized protobuf `FileDescriptorSet`, which every channel has.
    pub schema: Vec<u8>,
}

/// The channels and the playback of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelList {
    /// The channels, in file order.
    pub channels: Vec<ChannelInfo>,
    /// Frames per second of playback.
    pub playback_fps: f64,
    /// Log time of the last frame, ns, if the number of frames is known.
    pub end_ns: Option<u64>,
}

impl ChannelList {
    pub(crate) fn of(header: &Header, topics: &[&'static str]) -> Result<Self, RecordError> {
        let shown = |topic: &&'static str| {
            let schema = schema_of(topic, header.channels)?;
            Ok(ChannelInfo { topic, schema_name: schema.name, schema: schema.data.into_owned() })
        };
        let playback_fps = header.playback_fps;
        let last = header.frames_expected.and_then(|frames| frames.checked_sub(1));
        Ok(Self {
            channels: topics.iter().map(shown).collect::<Result<_, RecordError>>()?,
            playback_fps,
            end_ns: last.and_then(|last| log_time_ns(last, playback_fps)),
        })
    }
}

/// Receives every message in the order of the recording. A slow observer delays the run; none can change its bytes.
pub trait FrameObserver: Send {
    /// Called once before the first message. A resumed run starts in the middle of the recording.
    fn begin(&mut self, channel_list: ChannelList);

    /// Called for each recorded message.
    fn message(&mut self, topic: &'static str, log_time_ns: u64, payload: &[u8]);

    /// Called before the end of a frame for which the run has encoded the state of its model, such as a keyframe.
    fn model_state(&mut self, _state: &[u8]) {}

    /// Called after the last message of a frame. A line of the log may still follow.
    fn end_of_frame(&mut self);
}
