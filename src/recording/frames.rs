//! Iterator over the frames of a recording, with only a few chunks in memory.

use crate::channels::{self, Channel, FrameClock};
use crate::container::{Broken, Fields, damaged};
use crate::data_section::{DataRecord, DataSection};
use crate::error::ReadError;
use crate::frame::{Level, LogLine};
use crate::limits::{MAX_CHANNELS, MAX_CHUNK_MESSAGES, MAX_LOG_LINES};
use crate::log_text::split;
use crate::provenance::{HASHES_RECORD, OUTCOME_RECORD, Outcome};
use crate::record_kind as kind;
use crate::spare_memory::SpareMemory;
use crate::stored_frames::StoredFrames;
use crate::table::StateTable;
use foxglove::messages::{Log, PointCloud, log};
use prost::Message as _;
use prost::bytes::Bytes;
use std::collections::{BTreeMap, VecDeque};
use std::path::Path;
use std::sync::Arc;

const OTHER_OUTCOME: &str = "the outcome differs from the one in the index";

/// A channel as the file declares it.
#[derive(Debug, PartialEq, Eq)]
struct Topic {
    name: String,
    schema: String,
}

/// One message of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedMessage {
    topic: Arc<Topic>,
    log_time_ns: u64,
    payload: Bytes,
}

impl RecordedMessage {
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
    state: Option<StateTable>,
    log: Vec<LogLine>,
    messages: Vec<RecordedMessage>,
    path: Arc<Path>,
    byte: u64,
}

impl RecordedFrame {
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

/// The messages of a frame, not decoded yet.
struct RawFrame {
    messages: Vec<RecordedMessage>,
}

/// The frames of a recording in order. Every frame is complete and bitwise identical to the recorded one. If the file is
/// truncated or damaged, the last item is an error that reports what is lost.
///
/// Memory: with one thread, one chunk of the file and its content; with `n` threads, at most `2 n` chunks that were read
/// ahead, with at most 256 MiB together unless one alone is larger, and the chunk whose frames are being delivered. A recorded
/// chunk has 1 MiB, or one frame if that is larger.
/// Uncompressed chunks are not read ahead. The threads end when this value is dropped.
pub struct Frames {
    data: DataSection,
    path: Arc<Path>,
    state_columns: Arc<[String]>,
    /// Memory of states that were dropped.
    spare: SpareMemory<f64>,
    stored: StoredFrames,
    hashes: Vec<u8>,
    outcome: Option<Outcome>,
    outcome_seen: bool,
    schemas: BTreeMap<u16, String>,
    topics: BTreeMap<u16, Arc<Topic>>,
    waiting: VecDeque<RawFrame>,
    delivered: u64,
    last_frame: Option<u64>,
    last_log_time: Option<u64>,
    /// Whether frames before the next one were skipped.
    after_gap: bool,
    ended: bool,
}

impl Frames {
    /// `data` is at the start of the file.
    pub(crate) fn new(
        data: DataSection,
        path: Arc<Path>,
        state_columns: Arc<[String]>,
        stored: StoredFrames,
        outcome: Option<Outcome>,
    ) -> Self {
        Self {
            data,
            path,
            state_columns,
            spare: SpareMemory::new(),
            stored,
            hashes: Vec::new(),
            outcome,
            outcome_seen: false,
            schemas: BTreeMap::new(),
            topics: BTreeMap::new(),
            waiting: VecDeque::new(),
            delivered: 0,
            last_frame: None,
            last_log_time: None,
            after_gap: false,
            ended: false,
        }
    }

    /// The next chunk, packed, if a frame begins with it. The first chunk, which declares all channels, cannot be skipped.
    pub(crate) fn packed_chunk(&mut self) -> Option<&[u8]> {
        let is_between_chunks = self.waiting.is_empty() && !self.ended && !self.topics.is_empty();
        if is_between_chunks { self.data.packed_chunk() } else { None }
    }

    /// Skips that chunk, whose bytes have this checksum, and returns them.
    pub(crate) fn skip_chunk(&mut self, checksum: &crc32fast::Hasher) -> Option<Vec<u8>> {
        let body = self.data.take_packed(checksum)?;
        self.after_gap = true;
        Some(body)
    }

    /// Memory for the next chunk.
    pub(crate) fn reuse(&mut self, body: Vec<u8>) {
        self.data.reuse(body);
    }

    /// Delivers the frames of the last chunk that was skipped.
    pub(crate) fn deliver(&mut self, body: Vec<u8>) -> Result<(), ReadError> {
        let grouped = self.data.unpack(body).and_then(|content| self.group(&content));
        grouped.map_err(|broken| self.failed(broken))
    }

    /// Whether both files declare the same channels by the same numbers.
    pub(crate) fn declares_the_channels_of(&self, other: &Self) -> bool {
        self.topics == other.topics
    }

    /// The error after which no frame follows.
    fn failed(&mut self, broken: Broken) -> ReadError {
        self.ended = true;
        ReadError::new(&self.path, self.delivered, self.data.byte(), broken)
    }

    /// The next frame, or `None` after the file's end was checked.
    fn advance(&mut self) -> Result<Option<RecordedFrame>, Broken> {
        loop {
            if let Some(raw) = self.waiting.pop_front() {
                return self.decode(raw).map(Some);
            }
            match self.data.advance()? {
                DataRecord::Chunk(content) => self.group(&content)?,
                DataRecord::Metadata(name, entries) if name == OUTCOME_RECORD => {
                    self.outcome_seen = true;
                    // A file without an index may be cut off, which is found at its end.
                    if self.outcome.is_some() && Outcome::from_metadata(&entries) != self.outcome {
                        return Err(damaged(OTHER_OUTCOME));
                    }
                }
                DataRecord::Metadata(name, entries) if name == HASHES_RECORD => {
                    self.add_hashes(&entries)?;
                }
                DataRecord::Metadata(..) => {}
                DataRecord::End if self.outcome_seen && self.outcome.is_some() => return Ok(None),
                DataRecord::End if self.outcome_seen => return Err(damaged(OTHER_OUTCOME)),
                DataRecord::End => return Err(damaged("the recording has no outcome")),
            }
        }
    }

    /// After the last frame: the hashes of the frames after the last keyframe, which a run that failed has.
    #[must_use]
    pub fn remaining_hashes(&self) -> &[u8] {
        &self.hashes
    }

    fn add_hashes(&mut self, entries: &BTreeMap<String, String>) -> Result<(), Broken> {
        let text = entries.get("hashes").map_or("", String::as_str);
        let digits = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok();
        for pair in text.as_bytes().chunks(2) {
            let byte = digits(pair).ok_or_else(|| damaged("a hash is not hexadecimal"))?;
            self.hashes.push(byte);
        }
        Ok(())
    }

    /// Groups a chunk's messages into frames: chunks end where a frame ends, and a frame begins with its clock.
    fn group(&mut self, unpacked: &Bytes) -> Result<(), Broken> {
        let mut rest = Fields(unpacked);
        let mut messages = 0;
        while !rest.0.is_empty() {
            let (kind, length) = (rest.u8()?, rest.u64()?);
            let length = usize::try_from(length).map_err(|_| damaged("a record is too long"))?;
            let mut fields = Fields(rest.bytes(length)?);
            match kind {
                kind::SCHEMA => {
                    let (id, name) = (fields.u16()?, fields.string()?.to_owned());
                    self.schemas.insert(id, name);
                    if self.schemas.len() > MAX_CHANNELS {
                        return Err(damaged("the file has more schemas than any recording"));
                    }
                }
                kind::CHANNEL => self.declare(&mut fields)?,
                kind::MESSAGE => {
                    messages += 1;
                    if messages > MAX_CHUNK_MESSAGES {
                        return Err(damaged("a chunk has more messages than any recording"));
                    }
                    let (channel, _sequence) = (fields.u16()?, fields.u32()?);
                    let (log_time_ns, _publish_time) = (fields.u64()?, fields.u64()?);
                    let topic = self.topics.get(&channel).cloned();
                    let topic = topic.ok_or_else(|| damaged("a message has no channel"))?;
                    let payload = unpacked.slice_ref(fields.0);
                    self.join(RecordedMessage { topic, log_time_ns, payload })?;
                }
                _ => {
                    return Err(damaged(
                        "a chunk contains a record that does not belong in a chunk",
                    ));
                }
            }
        }
        Ok(())
    }

    fn declare(&mut self, fields: &mut Fields<'_>) -> Result<(), Broken> {
        let (id, schema) = (fields.u16()?, fields.u16()?);
        let name = fields.string()?.to_owned();
        let schema = self.schemas.get(&schema).cloned();
        let schema = schema.ok_or_else(|| damaged("a channel has no schema"))?;
        self.topics.insert(id, Arc::new(Topic { name, schema }));
        if self.topics.len() > MAX_CHANNELS {
            return Err(damaged("the file has more channels than any recording"));
        }
        Ok(())
    }

    fn join(&mut self, message: RecordedMessage) -> Result<(), Broken> {
        if message.topic() == FrameClock::TOPIC {
            if self.last_log_time.is_some_and(|last| message.log_time_ns <= last) {
                return Err(damaged("the frames are not in order"));
            }
            self.last_log_time = Some(message.log_time_ns);
            self.waiting.push_back(RawFrame { messages: vec![message] });
            return Ok(());
        }
        let last = self.last_log_time.ok_or_else(|| damaged("a frame has no clock"))?;
        if message.log_time_ns != last {
            return Err(damaged("a message is outside of its frame"));
        }
        let Some(frame) = self.waiting.back_mut() else {
            // The log line of a fault, whose frame is in the previous chunk; the outcome has the same text.
            let remark = message.topic() == channels::LOG;
            return if remark {
                Ok(())
            } else {
                Err(damaged("a frame is split between two chunks"))
            };
        };
        // At most one message per channel, and a limited number of log lines.
        if frame.messages.len() >= MAX_CHANNELS + MAX_LOG_LINES {
            return Err(damaged("a frame has more log lines than any recording"));
        }
        let single = message.topic() != channels::LOG;
        if single && frame.messages.iter().any(|earlier| earlier.topic == message.topic) {
            return Err(damaged("a frame has two messages of one topic"));
        }
        frame.messages.push(message);
        Ok(())
    }

    fn decode(&mut self, raw: RawFrame) -> Result<RecordedFrame, Broken> {
        let undecodable =
            |error| Broken::Damaged(format!("a message is not valid protobuf ({error})"));
        let mut clock = FrameClock::default();
        let mut state = None;
        let mut log = Vec::new();
        for message in &raw.messages {
            let payload = message.payload.clone();
            match message.topic() {
                FrameClock::TOPIC => clock = FrameClock::decode(payload).map_err(undecodable)?,
                channels::STATE => {
                    let cloud = PointCloud::decode(payload).map_err(undecodable)?;
                    let table =
                        StateTable::from_point_cloud(&cloud, &self.state_columns, &self.spare);
                    state = Some(table.map_err(damaged)?);
                }
                channels::LOG => {
                    let line = log_line(Log::decode(payload).map_err(undecodable)?);
                    if self.delivered == 0 && log.is_empty() {
                        log = split(line);
                    } else {
                        log.push(line);
                    }
                }
                _ => {}
            }
        }
        if std::mem::take(&mut self.after_gap) {
            self.delivered = self.stored.count_before(clock.frame);
            self.last_frame = clock.frame.checked_sub(1);
        }
        if !self.stored.may_follow(clock.frame, self.delivered, self.last_frame) {
            return Err(damaged("the frames are not in order"));
        }
        self.last_frame = Some(clock.frame);
        self.delivered += 1;
        let (path, byte) = (Arc::clone(&self.path), self.data.byte());
        Ok(RecordedFrame { clock, state, log, messages: raw.messages, path, byte })
    }
}

impl Iterator for Frames {
    type Item = Result<RecordedFrame, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        match self.advance() {
            Ok(Some(frame)) => Some(Ok(frame)),
            Ok(None) => {
                self.ended = true;
                None
            }
            Err(broken) => Some(Err(self.failed(broken))),
        }
    }
}

fn log_line(message: Log) -> LogLine {
    let level = match message.level() {
        log::Level::Error | log::Level::Fatal => Level::Error,
        log::Level::Warning => Level::Warning,
        log::Level::Info | log::Level::Debug | log::Level::Unknown => Level::Info,
    };
    LogLine { level, text: message.message }
}
