//! The encoded messages of a frame, in one piece of memory: in small runs, a piece for each message would take as long as its encoding.

use crate::channels::Channel;

/// Memory for the messages of most frames, bytes.
const MOST_FRAMES: usize = 1 << 10;
/// Memory that is kept for the next frame, bytes. More is given back, so that a frame which waits to be filled takes little.
const KEPT: usize = 64 << 10;

/// One encoded message of a Kinetoscope channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EncodedMessage<'a> {
    /// Its topic.
    pub topic: &'static str,
    /// Its protobuf bytes.
    pub payload: &'a [u8],
}

/// The messages, in the order in which they were added.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct EncodedMessages {
    /// The topic of each message, and the end of its bytes.
    topics: Vec<(&'static str, usize)>,
    bytes: Vec<u8>,
}

impl EncodedMessages {
    pub(crate) fn push<C: Channel>(&mut self, message: &C) {
        let length = message.encoded_len();
        self.bytes.reserve_exact(Ord::max(length, MOST_FRAMES.saturating_sub(self.bytes.len())));
        message.encode_raw(&mut self.bytes);
        self.topics.push((C::TOPIC, self.bytes.len()));
    }

    pub(crate) fn clear(&mut self) {
        self.topics.clear();
        self.bytes.clear();
        self.bytes.shrink_to(KEPT);
    }

    /// Size of all messages in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.bytes.len()
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = EncodedMessage<'_>> {
        let mut begin = 0;
        self.topics.iter().map(move |&(topic, end)| {
            let payload = &self.bytes[std::mem::replace(&mut begin, end)..end];
            EncodedMessage { topic, payload }
        })
    }
}
