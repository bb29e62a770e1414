//! A frame of a recording and its messages, as a reader delivers them.

use crate::channels::{Channel, FrameClock};
use crate::container::Broken;
use crate::error::ReadError;
use crate::frame::LogLine;
use crate::table::StateTable;
use prost::bytes::Bytes;
use std::path::Path;
use std::sync::Arc;

/// A channel as the file declares it.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Topic {
    /// Its number, which increases in the order of the messages of a frame.
    pub(crate) id: u16,
    /// The chunk that declares it, counted from 0: the messages of its group have chunks of their own.
    pub(crate) declared_in: u64,
    pub(crate) name: String,
    pub(crate) schema: String,
}

/// One message of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedMessage {
    pub(crate) topic: Arc<Topic>,
    pub(crate) log_time_ns: u64,
    pub(crate) payload: Bytes,
}

impl RecordedMessage {
    /// The group of its channel.
    pub(crate) fn group(&self) -> u64 {
        self.topic.declared_in
    }

    /// Its topic, with the leading slash.
    #[must_use]
    pub fn topic(&self) -> &str {
        &self.topic.name
    }

    /// Full name of its schema.
    #[must_use]
    pub fn schema(&self) -> &str {
        &self.topic.schema
    }

    /// Its log time, ns.
    #[must_use]
    pub fn log_time_ns(&self) -> u64 {
        self.log_time_ns
    }

    /// Its protobuf bytes.
    #[must_use]
    pub fn payload(&self) -> &[u8] {
        &self.payload
    }
}

/// All messages of one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedFrame {
    /// Index and simulated time of the frame.
    pub clock: FrameClock,
    pub(crate) state: Option<StateTable>,
    pub(crate) log: Vec<LogLine>,
    pub(crate) is_complete: bool,
    pub(crate) messages: Vec<RecordedMessage>,
    pub(crate) path: Arc<Path>,
    pub(crate) byte: u64,
}

impl RecordedFrame {
    /// Whether all channels of the frame are stored, not only its scalars.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.is_complete
    }

    /// The exact state; `None` if it was not recorded.
    #[must_use]
    pub fn state(&self) -> Option<&StateTable> {
        self.state.as_ref()
    }

    /// Takes the exact state out of the frame, without a copy.
    pub fn take_state(&mut self) -> Option<StateTable> {
        self.state.take()
    }

    /// The lines of the log.
    #[must_use]
    pub fn log_lines(&self) -> &[LogLine] {
        &self.log
    }

    /// All messages, drawings included, in file order.
    #[must_use]
    pub fn messages(&self) -> &[RecordedMessage] {
        &self.messages
    }

    /// The error of a frame that contains what no recording does.
    pub(crate) fn read_error(&self, broken: Broken) -> ReadError {
        ReadError::new(&self.path, self.clock.frame, self.byte, broken)
    }

    /// The message of one channel; `None` if this frame has none.
    ///
    /// # Errors
    /// Bytes that are not a message of this channel, or columns of different lengths.
    pub fn get<C: Channel>(&self) -> Result<Option<C>, ReadError> {
        let found = self
            .messages
            .iter()
            .find(|message| message.topic.name == C::TOPIC && message.topic.schema == C::SCHEMA);
        let Some(message) = found else { return Ok(None) };
        let damaged = |why: &dyn std::fmt::Display| {
            let what = format!("frame {}, {}: {why}", self.clock.frame, C::TOPIC);
            self.read_error(Broken::Damaged(what))
        };
        let decoded = C::decode(message.payload.clone()).map_err(|error| damaged(&error))?;
        if decoded.has_equal_columns() {
            Ok(Some(decoded))
        } else {
            Err(damaged(&"its columns have different lengths"))
        }
    }
}
