//! Somebody who watches a run: sees the messages of its recording while they are recorded, and changes none of them.

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

/// What there will be to see.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelList {
    /// The channels, in file order.
    pub channels: Vec<ChannelInfo>,
    /// Frames a second of playback.
    pub playback_fps: f64,
    /// Log time of the last frame, ns, where the number of frames is known.
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

/// Sees every message, in the recording's order. What takes long in here delays the run; nothing changes its bytes.
pub trait FrameObserver: Send {
    /// The show begins. It may begin in the middle of a run that is gone on with.
    fn begin(&mut self, channel_list: ChannelList);

    /// A message, as it is recorded.
    fn message(&mut self, topic: &'static str, log_time_ns: u64, payload: &[u8]);

    /// The frame of the last message is whole. A line of the log may still follow.
    fn end_of_frame(&mut self);
}
