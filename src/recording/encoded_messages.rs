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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::channels::{DemDiscForces, DemTemperature};
    use prost::Message as _;

    #[test]
    fn messages_have_the_bytes_that_each_has_alone_also_in_memory_that_is_used_again() {
        let temperature =
            DemTemperature { granular_temperature_m2_per_s2: 2.0, ..DemTemperature::default() };
        let forces = DemDiscForces { force_x_n: vec![1.5; KEPT], ..DemDiscForces::default() };
        let mut messages = EncodedMessages::default();
        for _ in 0..2 {
            messages.push(&temperature);
            messages.push(&forces);
            messages.push(&DemTemperature::default());
            let expected = [
                (DemTemperature::TOPIC, temperature.encode_to_vec()),
                (DemDiscForces::TOPIC, forces.encode_to_vec()),
                (DemTemperature::TOPIC, Vec::new()),
            ];
            let found = messages.iter().map(|message| (message.topic, message.payload.to_vec()));
            assert!(found.eq(expected));
            assert_eq!(
                messages.bytes(),
                messages.iter().map(|one| one.payload.len()).sum::<usize>()
            );
            messages.clear();
            assert_eq!((messages.iter().count(), messages.bytes()), (0, 0));
            assert!(messages.bytes.capacity() <= KEPT, "memory of large messages is given back");
        }
    }
}
