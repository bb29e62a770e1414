//! Iterator over the frames of a recording, with only a few chunks in memory.

use crate::channels::{self, Channel as _, FrameClock};
use crate::container::{Broken, Fields, damaged};
use crate::data_section::{DataRecord, DataSection};
use crate::error::ReadError;
use crate::frame::{Level, LogLine};
use crate::frame_channels::{FrameChannels, is_drawing, is_one_group};
use crate::keyframe::KEYFRAME;
use crate::limits::{MAX_CHANNELS, MAX_CHUNK_MESSAGES, MAX_LOG_LINES};
use crate::log_text::split;
use crate::provenance::{HASHES_RECORD, OUTCOME_RECORD, Outcome};
use crate::record_kind as kind;
use crate::recorded_frame::{RecordedFrame, RecordedMessage, Topic};
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

/// The messages of a frame, not decoded yet.
struct RawFrame {
    messages: Vec<RecordedMessage>,
}

/// The messages of a block that were read before the chunk with its clocks.
#[derive(Default)]
struct OpenBlock {
    messages: Vec<RecordedMessage>,
    /// Size of the chunks with them.
    bytes: u64,
}

/// The frames of a recording in order. Every frame is complete and bitwise identical to the recorded one. If the file is
/// truncated or damaged, the last item is an error that reports what is lost.
///
/// Memory: with one thread, one chunk of the file and its content; with `n` threads, at most `2 n` chunks that were read
/// ahead, with at most 256 MiB together unless one alone is larger, and the block whose frames are being delivered. A recorded
/// block has 4 MiB of states and 8 MiB of drawings, or one frame if that is larger.
/// Uncompressed chunks are not read ahead. The threads end when this value is dropped.
pub struct Frames {
    data: DataSection,
    path: Arc<Path>,
    state_columns: Arc<[String]>,
    /// The constants of the particles, as recorded last.
    particles: Option<PointCloud>,
    /// Memory of states that were dropped.
    spare: SpareMemory<f64>,
    stored: StoredFrames,
    hashes: Vec<u8>,
    outcome: Option<Outcome>,
    outcome_seen: bool,
    schemas: BTreeMap<u16, String>,
    topics: BTreeMap<u16, Arc<Topic>>,
    channels: FrameChannels,
    open: OpenBlock,
    /// Chunks so far.
    chunks: u64,
    max_block_bytes: u64,
    has_drawings: bool,
    has_scalar_frames: bool,
    waiting: VecDeque<RawFrame>,
    delivered: u64,
    last_frame: Option<u64>,
    last_log_time: Option<u64>,
    /// Whether the line of the log that follows the last block was read.
    has_late_log: bool,
    /// Whether the last frame so far is complete.
    has_end: bool,
    /// Whether frames before the next one were skipped.
    after_gap: bool,
    /// Whether any frames were skipped.
    has_gaps: bool,
    ended: bool,
}

impl Frames {
    /// `data` is at the start of the file.
    pub(crate) fn new(
        data: DataSection,
        max_block_bytes: u64,
        path: Arc<Path>,
        state_columns: Arc<[String]>,
        stored: StoredFrames,
        outcome: Option<Outcome>,
    ) -> Self {
        Self {
            data,
            path,
            state_columns,
            particles: None,
            spare: SpareMemory::new(),
            stored,
            hashes: Vec::new(),
            outcome,
            outcome_seen: false,
            schemas: BTreeMap::new(),
            topics: BTreeMap::new(),
            channels: FrameChannels::default(),
            open: OpenBlock::default(),
            chunks: 0,
            max_block_bytes,
            has_drawings: true,
            has_scalar_frames: false,
            waiting: VecDeque::new(),
            delivered: 0,
            last_frame: None,
            last_log_time: None,
            has_late_log: false,
            has_end: true,
            after_gap: false,
            has_gaps: false,
            ended: false,
        }
    }

    /// The same frames, of which only the first one has its drawings: their chunks are not decompressed once the channels are known.
    #[must_use]
    pub fn with_first_drawing_only(self) -> Self {
        Self { has_drawings: false, ..self }
    }

    /// Also the frames between keyframes, of which only scalars are stored.
    #[must_use]
    pub fn with_scalar_frames(self) -> Self {
        Self { has_scalar_frames: true, ..self }
    }

    /// The next chunk, packed, and whether it ends a block. The first block, which declares all channels, cannot be skipped, nor can a
    /// chunk with particles that later states need: their channel is the first one of its group. Each keyframe has its own.
    pub(crate) fn packed_chunk(&mut self) -> Option<(&[u8], bool)> {
        let is_between_blocks = self.waiting.is_empty() && self.open.messages.is_empty();
        if !is_between_blocks || self.ended || self.topics.is_empty() {
            return None;
        }
        let (body, channel) = self.data.packed_chunk()?;
        let topic = self.topics.get(&channel?)?;
        let has_keyframes = matches!(self.stored, StoredFrames::Keyframes(_));
        let is_needed = topic.name == channels::PARTICLES && !has_keyframes;
        (!is_needed).then_some((body, topic.name == FrameClock::TOPIC))
    }

    /// Skips that chunk, whose bytes have this checksum, and returns them.
    pub(crate) fn skip_chunk(&mut self, checksum: &crc32fast::Hasher) -> Option<Vec<u8>> {
        let body = self.data.take_packed(checksum)?;
        (self.after_gap, self.has_gaps) = (true, true);
        Some(body)
    }

    /// Memory for the next chunk.
    pub(crate) fn reuse(&mut self, body: Vec<u8>) {
        self.data.reuse(body);
    }

    /// Delivers the messages of a chunk that was skipped; of several, in their order.
    pub(crate) fn deliver(&mut self, body: Vec<u8>) -> Result<(), ReadError> {
        let grouped = self.data.unpack(body).and_then(|content| self.group(&content, None));
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
                let frame = self.decode(raw)?;
                if frame.is_complete || self.has_scalar_frames {
                    self.delivered += 1;
                    return Ok(Some(frame));
                }
                continue;
            }
            match self.data.advance()? {
                DataRecord::Chunk(content, indexed) => self.group(&content, indexed)?,
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
                DataRecord::End(counts) => return self.check_end(&counts).map(|()| None),
            }
        }
    }

    /// Checks the end of the file, whose summary states these numbers of messages.
    fn check_end(&mut self, counts: &BTreeMap<u16, u64>) -> Result<(), Broken> {
        let is_complete = self.outcome == Some(Outcome::Complete);
        if !self.open.messages.is_empty() {
            return Err(damaged("a message is outside of its frame"));
        }
        // The last frame of a run that did not fail is a keyframe.
        if !self.has_end && is_complete {
            return Err(damaged("the last frame has no keyframe"));
        }
        if !self.outcome_seen {
            return Err(damaged("the recording has no outcome"));
        }
        if self.outcome.is_none() {
            return Err(damaged(OTHER_OUTCOME));
        }
        let is_read = |channel: u16| {
            let topic = self.topics.get(&channel);
            self.has_drawings || topic.is_some_and(|topic| !is_drawing(topic))
        };
        let other = || damaged("its chunks have other messages than its summary states");
        if !self.has_gaps && !self.channels.have_counts(counts, is_read) {
            return Err(other());
        }
        // Without frames, no chunk declares the states. Otherwise, all of them are missing, and no frame is complete.
        let is_declared = |channel| self.topics.contains_key(channel);
        if self.delivered > 0 && !self.has_gaps && !counts.keys().all(is_declared) {
            self.delivered = 0;
            return Err(other());
        }
        Ok(())
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

    /// Adds a chunk's messages to the open block. The chunk with the clocks of its frames ends it. The chunk has `indexed` as the first channel
    /// in its indexes, if they were read.
    fn group(&mut self, unpacked: &Bytes, indexed: Option<u16>) -> Result<(), Broken> {
        let mut rest = Fields(unpacked);
        let mut messages: Vec<RecordedMessage> = Vec::new();
        self.chunks += 1;
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
                    if messages.len() + self.open.messages.len() >= MAX_CHUNK_MESSAGES {
                        return Err(damaged("a chunk has more messages than any recording"));
                    }
                    let (channel, _sequence) = (fields.u16()?, fields.u32()?);
                    let (log_time_ns, _publish_time) = (fields.u64()?, fields.u64()?);
                    let topic = self.topics.get(&channel).cloned();
                    let Some(topic) = topic else {
                        // The first chunk of its group is missing, with messages of earlier frames.
                        self.delivered = 0;
                        return Err(damaged("a message has no channel"));
                    };
                    if messages.first().is_some_and(|first| !is_one_group(&first.topic, &topic)) {
                        return Err(damaged("a chunk has messages of two groups"));
                    }
                    self.channels.count(channel);
                    let payload = unpacked.slice_ref(fields.0);
                    messages.push(RecordedMessage { topic, log_time_ns, payload });
                }
                _ => {
                    return Err(damaged(
                        "a chunk contains a record that does not belong in a chunk",
                    ));
                }
            }
        }
        let indexed = indexed.and_then(|channel| self.topics.get(&channel));
        if let (Some(indexed), Some(first)) = (indexed, messages.first())
            && !is_one_group(indexed, &first.topic)
        {
            return Err(damaged("the index of a chunk is that of another group"));
        }
        self.open.bytes = self.open.bytes.saturating_add(unpacked.len() as u64);
        if self.open.bytes > self.max_block_bytes {
            return Err(damaged("a block claims a size that no recording has"));
        }
        let is_scalars = |message: &RecordedMessage| {
            [FrameClock::TOPIC, channels::LOG].contains(&message.topic())
        };
        if !messages.iter().any(is_scalars) {
            self.open.messages.append(&mut messages);
            return Ok(());
        }
        self.end_block(messages)
    }

    /// Divides the messages of a block into frames.
    fn end_block(&mut self, scalars: Vec<RecordedMessage>) -> Result<(), Broken> {
        let OpenBlock { messages, .. } = std::mem::take(&mut self.open);
        let mut frames = Vec::new();
        for message in scalars {
            self.begin_or_join(&mut frames, message)?;
        }
        for message in messages {
            let time = |frame: &RawFrame| frame.messages.first().map(|clock| clock.log_time_ns);
            let place = frames.binary_search_by_key(&Some(message.log_time_ns), time);
            let frame = place.ok().and_then(|place| frames.get_mut(place));
            add(frame.ok_or_else(|| damaged("a message is outside of its frame"))?, message)?;
        }
        let is_first_block = self.last_frame.is_none();
        for (index, frame) in frames.iter_mut().enumerate() {
            let is_drawn = self.has_drawings || (is_first_block && index == 0);
            frame.messages.retain(|message| is_drawn || !is_drawing(&message.topic));
            frame.messages.sort_by_key(|message| message.topic.id);
        }
        self.waiting.extend(frames);
        if !self.has_drawings {
            let drawings = self.topics.values().filter(|topic| is_drawing(topic));
            self.data.leave_out(drawings.map(|topic| topic.id));
        }
        Ok(())
    }

    fn declare(&mut self, fields: &mut Fields<'_>) -> Result<(), Broken> {
        let (id, schema) = (fields.u16()?, fields.u16()?);
        let name = fields.string()?.to_owned();
        let schema = self.schemas.get(&schema).cloned();
        let schema = schema.ok_or_else(|| damaged("a channel has no schema"))?;
        let topic = Arc::new(Topic { id, declared_in: self.chunks, name, schema });
        self.channels.declare(&topic);
        self.topics.insert(id, topic);
        if self.topics.len() > MAX_CHANNELS {
            return Err(damaged("the file has more channels than any recording"));
        }
        Ok(())
    }

    /// Begins a frame with its clock, or adds a message of the chunk with the clocks to the last frame.
    fn begin_or_join(
        &mut self,
        frames: &mut Vec<RawFrame>,
        message: RecordedMessage,
    ) -> Result<(), Broken> {
        if message.topic() == FrameClock::TOPIC {
            if self.has_late_log {
                return Err(damaged("a frame is split between two blocks"));
            }
            if self.last_log_time.is_some_and(|last| message.log_time_ns <= last) {
                return Err(damaged("the frames are not in order"));
            }
            self.last_log_time = Some(message.log_time_ns);
            frames.push(RawFrame { messages: vec![message] });
            return Ok(());
        }
        let last = self.last_log_time.ok_or_else(|| damaged("a frame has no clock"))?;
        if message.log_time_ns != last {
            return Err(damaged("a message is outside of its frame"));
        }
        match frames.last_mut() {
            Some(frame) => add(frame, message),
            // The log line of a fault, whose frame is in the previous block; the outcome has the same text.
            None if message.topic() == channels::LOG => {
                self.has_late_log = true;
                Ok(())
            }
            None => Err(damaged("a frame is split between two blocks")),
        }
    }

    fn decode(&mut self, raw: RawFrame) -> Result<RecordedFrame, Broken> {
        let undecodable =
            |error| Broken::Damaged(format!("a message is not valid protobuf ({error})"));
        let mut clock = FrameClock::default();
        let mut state = None;
        let mut log = Vec::new();
        let particles = raw.messages.iter().find(|message| message.topic() == channels::PARTICLES);
        if let Some(message) = particles {
            let cloud = PointCloud::decode(message.payload.clone()).map_err(undecodable)?;
            self.particles = Some(cloud);
        }
        for message in &raw.messages {
            let payload = message.payload.clone();
            match message.topic() {
                FrameClock::TOPIC => clock = FrameClock::decode(payload).map_err(undecodable)?,
                channels::STATE => {
                    let cloud = PointCloud::decode(payload).map_err(undecodable)?;
                    let (particles, columns) = (self.particles.as_ref(), &self.state_columns);
                    let table = StateTable::joined(&cloud, particles, columns, &self.spare);
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
        let is_complete = match self.stored {
            StoredFrames::Keyframes(_) => raw.messages.iter().any(|one| one.topic() == KEYFRAME),
            StoredFrames::All | StoredFrames::From(_) => true,
        };
        if !is_complete && self.stored.has(clock.frame, None) {
            return Err(damaged("a frame has no keyframe"));
        }
        // Each keyframe can be read alone.
        let is_keyframe = is_complete && matches!(self.stored, StoredFrames::Keyframes(_));
        if is_keyframe && self.particles.is_some() && particles.is_none() {
            return Err(damaged("a keyframe has no particles"));
        }
        self.channels.check(&raw.messages, is_complete)?;
        let has_state = || self.topics.values().any(|topic| topic.name == channels::STATE);
        if is_complete && state.is_none() && has_state() {
            return Err(damaged("a frame has no state"));
        }
        if std::mem::take(&mut self.after_gap) {
            self.delivered = self.stored.count_before(clock.frame);
            self.last_frame = clock.frame.checked_sub(1);
        }
        if !self.stored.may_follow(clock.frame, self.last_frame) {
            return Err(damaged("the frames are not in order"));
        }
        self.last_frame = Some(clock.frame);
        self.has_end = is_complete;
        let (path, byte) = (Arc::clone(&self.path), self.data.byte());
        Ok(RecordedFrame { clock, state, log, is_complete, messages: raw.messages, path, byte })
    }
}

/// Adds a message to its frame: at most one per channel, and a limited number of log lines.
fn add(frame: &mut RawFrame, message: RecordedMessage) -> Result<(), Broken> {
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
