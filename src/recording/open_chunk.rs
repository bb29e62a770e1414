//! A chunk that is being filled, and one that waits for its compression.

use crate::container::PREFIX;
use crate::record_bytes::PutFields as _;
use crate::record_kind as kind;
use crate::spare_memory::{Lent, SpareMemory};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Bytes of a message's record before its payload: kind, length, channel, sequence number and two times.
const MESSAGE_HEAD_BYTES: usize = 31;

/// Writes a message's record up to its payload.
pub(crate) fn put_message_head(
    content: &mut Vec<u8>,
    channel: u16,
    sequence: u32,
    log_time: u64,
    payload_bytes: usize,
) {
    content.push(kind::MESSAGE);
    content.put_u64((MESSAGE_HEAD_BYTES - PREFIX as usize + payload_bytes) as u64);
    content.put_u16(channel);
    content.put_u32(sequence);
    content.put_u64(log_time);
    // The time of publication.
    content.put_u64(log_time);
}

/// The messages of a group of channels since the last chunk of the group.
#[derive(Debug)]
pub(crate) struct OpenChunk {
    content: Lent<u8>,
    memory: SpareMemory<u8>,
    /// For each channel, the index of its messages: log time and place of each.
    index: BTreeMap<u16, Vec<u8>>,
    times: Option<[u64; 2]>,
    frames: u64,
}

/// A chunk to which nothing is added any more.
#[derive(Clone, Debug)]
pub(crate) struct ClosedChunk {
    /// Its records, which a recorder that can be resumed keeps as well.
    pub(crate) content: Arc<Lent<u8>>,
    /// For each channel, the entries of the record that indexes its messages.
    pub(crate) index: BTreeMap<u16, Vec<u8>>,
    /// Log times of the first and the last message.
    pub(crate) times: [u64; 2],
    /// Number of frames with messages.
    pub(crate) frames: u64,
}

impl ClosedChunk {
    /// Size of an entry of an index.
    pub(crate) const INDEX_ENTRY_BYTES: usize = 16;
}

impl OpenChunk {
    pub(crate) fn new() -> Self {
        let memory = SpareMemory::new();
        let (index, times) = (BTreeMap::new(), None);
        Self { content: memory.take(), memory, index, times, frames: 0 }
    }

    /// Adds the record of a schema or a channel.
    pub(crate) fn declare(&mut self, record: &[u8]) {
        self.content.vector.extend_from_slice(record);
    }

    /// Adds a message.
    pub(crate) fn push(&mut self, channel: u16, sequence: u32, log_time: u64, payload: &[u8]) {
        let content = &mut self.content.vector;
        let entries = self.index.entry(channel).or_default();
        entries.put_u64(log_time);
        entries.put_u64(content.len() as u64);
        content.reserve(MESSAGE_HEAD_BYTES + payload.len());
        put_message_head(content, channel, sequence, log_time, payload.len());
        content.extend_from_slice(payload);
        let [first, last] = self.times.unwrap_or([log_time; 2]);
        self.frames += u64::from(self.times.is_none() || log_time != last);
        self.times = Some([first.min(log_time), last.max(log_time)]);
    }

    /// Whether it has no message.
    pub(crate) fn has_no_message(&self) -> bool {
        self.times.is_none()
    }

    /// Takes its declarations, if it has no message.
    pub(crate) fn take_declarations(&mut self) -> Lent<u8> {
        std::mem::replace(&mut self.content, self.memory.take())
    }

    /// Size of its records.
    pub(crate) fn bytes(&self) -> usize {
        self.content.len()
    }

    /// Its records.
    pub(crate) fn content(&self) -> &[u8] {
        &self.content
    }

    /// Closes the chunk and opens the next one; `None` without messages, whose chunk would have no times.
    pub(crate) fn close(&mut self) -> Option<ClosedChunk> {
        let times = self.times.take()?;
        let content = Arc::new(std::mem::replace(&mut self.content, self.memory.take()));
        let (index, frames) = (std::mem::take(&mut self.index), std::mem::take(&mut self.frames));
        Some(ClosedChunk { content, index, times, frames })
    }
}
