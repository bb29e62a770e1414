//! The messages of the open chunk, which is not on the disk yet.

use serde::{Deserialize, Serialize};

/// Messages in file order, their payloads in one run of bytes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct OpenChunk {
    heads: Vec<Head>,
    payloads: Vec<u8>,
    /// The chunk will be closed before anybody asks: nothing is kept until then.
    is_forgetful: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Head {
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
        if self.is_forgetful {
            return;
        }
        self.heads.push(Head { channel_id, frame, log_time, length: payload.len() as u64 });
        self.payloads.extend_from_slice(payload);
    }

    /// The chunk is closed: its messages are in the file.
    pub(crate) fn clear(&mut self) {
        self.heads.clear();
        self.payloads.clear();
        self.is_forgetful = false;
    }

    /// Keeps nothing until the chunk is closed.
    pub(crate) fn forget_until_closed(&mut self) {
        self.clear();
        self.is_forgetful = true;
    }

    /// The messages; as many as their payloads have bytes for.
    pub(crate) fn messages(&self) -> impl Iterator<Item = OpenMessage<'_>> {
        let mut rest = self.payloads.as_slice();
        self.heads.iter().map_while(move |head| {
            let (payload, behind) = rest.split_at_checked(usize::try_from(head.length).ok()?)?;
            rest = behind;
            let Head { channel_id, frame, log_time, .. } = *head;
            Some(OpenMessage { channel_id, frame, log_time, payload })
        })
    }
}
