//! The messages of the open chunk, which is not on the disk yet.

use serde::{Deserialize, Serialize};

/// Messages in file order, their payloads concatenated.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct OpenChunk {
    headers: Vec<MessageHeader>,
    payloads: Vec<u8>,
    /// Nothing is stored until the chunk is closed, which happens before the next checkpoint.
    is_discarding: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct MessageHeader {
    channel_id: u16,
    frame: u64,
    log_time: u64,
    length: u64,
}

/// One of the messages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OpenMessage<'a> {
    pub(crate) channel_id: u16,
    pub(crate) frame: u64,
    pub(crate) log_time: u64,
    pub(crate) payload: &'a [u8],
}

impl OpenChunk {
    pub(crate) fn push(&mut self, channel_id: u16, frame: u64, log_time: u64, payload: &[u8]) {
        if self.is_discarding {
            return;
        }
        self.headers.push(MessageHeader {
            channel_id,
            frame,
            log_time,
            length: payload.len() as u64,
        });
        self.payloads.extend_from_slice(payload);
    }

    /// Removes all messages after the chunk was closed.
    pub(crate) fn clear(&mut self) {
        self.headers.clear();
        self.payloads.clear();
        self.is_discarding = false;
    }

    /// Stores nothing until the chunk is closed.
    pub(crate) fn discard_until_closed(&mut self) {
        self.clear();
        self.is_discarding = true;
    }

    /// The messages whose payloads are complete.
    pub(crate) fn messages(&self) -> impl Iterator<Item = OpenMessage<'_>> {
        let mut rest = self.payloads.as_slice();
        self.headers.iter().map_while(move |header| {
            let (payload, behind) = rest.split_at_checked(usize::try_from(header.length).ok()?)?;
            rest = behind;
            let MessageHeader { channel_id, frame, log_time, .. } = *header;
            Some(OpenMessage { channel_id, frame, log_time, payload })
        })
    }
}
