//! The encoded messages of a frame. They share one piece of memory: in small runs, one piece for each message takes as long as the encoding.

use crate::channels::Channel;

/// Size of the messages of most frames: at least so much memory is reserved.
const USUAL_BYTES: usize = 1 << 10;
/// Memory that an empty frame keeps. More is given back, because up to a thousand empty frames wait to be filled again.
const KEPT_BYTES: usize = 4 << 10;

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
        let canonical = message.with_canonical_nan();
        let message = canonical.as_ref().unwrap_or(message);
        let length = message.encoded_len();
        self.bytes.reserve_exact(Ord::max(length, USUAL_BYTES.saturating_sub(self.bytes.len())));
        message.encode_raw(&mut self.bytes);
        self.topics.push((C::TOPIC, self.bytes.len()));
    }

    pub(crate) fn clear(&mut self) {
        self.topics.clear();
        self.bytes.clear();
        self.bytes.shrink_to(KEPT_BYTES);
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
        let forces = DemDiscForces { force_x_n: vec![1.5; KEPT_BYTES], ..DemDiscForces::default() };
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
            assert!(
                messages.bytes.capacity() <= KEPT_BYTES,
                "memory of large messages is given back"
            );
        }
    }
}
