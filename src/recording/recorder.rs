//! Writer of a recording: frames to one MCAP file.
//!
//! Invariant: the bytes do not depend on the clock, the host, the threads, the path or the user.

pub use crate::header::{Compression, Header, Selection};
pub use crate::provenance::Outcome;
pub use crate::stored_frames::StoredFrames;
pub use resuming::RecorderState;

mod keyframes;
mod resuming;

use crate::channels::{self, Channel as _, FrameClock};
use crate::disc_drawing::DiscDrawing;
use crate::error::RecordError;
use crate::frame::{Frame, Level, LogLine};
use crate::log_text::joined;
use crate::observer::{ChannelList, FrameObserver};
use crate::playback::log_times;
use crate::provenance::{LIBRARY, MANIFEST_ATTACHMENT, OUTCOME_RECORD, PROVENANCE_RECORD};
use crate::scene::{EncodedDiscs, SceneBuilder};
use crate::schema::schema_of;
use crate::sink::CountingSink;
use crate::trail::Trails;
use foxglove::messages::{Log, Timestamp, log};
use keyframes::Unstored;
use mcap::records::{MessageHeader, Metadata};
use prost::Message;
use resuming::Resumable;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Write;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, LazyLock};

/// Size at which a chunk is closed, at the next end of a frame.
const CHUNK_PAYLOAD: u64 = 1 << 20;

/// Simulated time of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Number of steps or events since the start.
    pub count: u64,
    /// Time since the start, in the header's unit.
    pub time: f64,
}

/// Writes one recording. If it is dropped before [`Recorder::finish`], the file has complete chunks of complete frames and no
/// footer.
pub struct Recorder<W: Write> {
    header: Header,
    scenes: Arc<SceneBuilder>,
    trails: Trails,
    // Empty only while being dropped.
    writer: Option<mcap::Writer<CountingSink<W>>>,
    // In file order.
    recorded: Vec<&'static str>,
    channel_ids: BTreeMap<&'static str, u16>,
    frames: u64,
    unstored: Unstored,
    payload_in_chunk: u64,
    // Frames in closed chunks.
    closed_frames: u64,
    resumable: Option<Resumable>,
    // For an observer of the resumed run.
    first_log: Option<Vec<u8>>,
    observer: Option<Box<dyn FrameObserver>>,
    buffer: Vec<u8>,
    discs: EncodedDiscs,
    written: Arc<AtomicU64>,
}

impl<W: Write> Recorder<W> {
    /// Starts a recording: the manifest and the provenance go to the sink.
    ///
    /// # Errors
    /// A header that cannot be recorded, or a sink that fails.
    pub fn create(sink: W, header: &Header) -> Result<Self, RecordError> {
        header.check()?;
        let scenes =
            SceneBuilder::new(&header.scenery, header.state_columns, header.max_drawn_particles)?;
        let scenes = Arc::new(scenes);
        let written = Arc::new(AtomicU64::new(0));
        let sink = CountingSink::new(sink, Arc::clone(&written));
        let mut writer = write_options(header.compression).create(sink)?;
        writer.attach(&mcap::Attachment {
            log_time: 0,
            create_time: 0,
            name: MANIFEST_ATTACHMENT.to_owned(),
            media_type: "application/toml".to_owned(),
            data: Cow::Borrowed(header.manifest.as_bytes()),
        })?;
        writer.write_metadata(&Metadata {
            name: PROVENANCE_RECORD.to_owned(),
            metadata: header.provenance().to_metadata(),
        })?;
        // No channel exists yet, so this flush writes no chunk. A checkpoint counts on these bytes.
        writer.flush()?;
        Ok(Self {
            header: header.clone(),
            scenes,
            trails: Trails::new(),
            writer: Some(writer),
            recorded: header.topics().into_iter().filter(|topic| header.wants(topic)).collect(),
            channel_ids: BTreeMap::new(),
            frames: header.stored.first(),
            unstored: Unstored::default(),
            payload_in_chunk: 0,
            closed_frames: header.stored.first(),
            resumable: None,
            first_log: None,
            observer: None,
            buffer: Vec::new(),
            discs: EncodedDiscs::default(),
            written,
        })
    }

    /// Whether a topic, with its leading slash, is recorded.
    #[must_use]
    pub fn wants(&self, topic: &str) -> bool {
        self.recorded.contains(&topic)
    }

    /// Sends all messages from now on to an observer. That of a resumed run first receives the drawings and the log of the start.
    ///
    /// # Errors
    /// A channel without a schema: a defect of the program.
    pub fn show_to(&mut self, mut observer: Box<dyn FrameObserver>) -> Result<(), RecordError> {
        observer.begin(ChannelList::of(&self.header, &self.recorded)?);
        if self.frames > 0 {
            let start = Timestamp::new(0, 0);
            for (topic, drawn) in [
                (channels::WALLS, self.scenes.walls_at_rest(start)),
                (channels::LEGEND, self.scenes.legend(start)),
            ] {
                if self.wants(topic) {
                    observer.message(topic, 0, &drawn.encode_to_vec());
                }
            }
            if let Some(log) = &self.first_log {
                observer.message(channels::LOG, 0, log);
            }
        }
        self.observer = Some(observer);
        Ok(())
    }

    /// Whether an observer receives the messages.
    pub(crate) fn is_observed(&self) -> bool {
        self.observer.is_some()
    }

    /// The drawing of the discs, if they are recorded.
    pub(crate) fn disc_drawing(&self) -> Option<DiscDrawing> {
        let drawing = || DiscDrawing::new(Arc::clone(&self.scenes), self.header.playback_fps);
        self.wants(channels::DISCS).then(drawing)
    }

    /// An empty frame that keeps only the contact forces that this recording draws.
    #[must_use]
    pub fn empty_frame(&self) -> Frame {
        let draws = self.wants(channels::FORCE_CHAINS);
        Frame::drawing_contacts(if draws { self.scenes.contacts_at_most() } else { 0 })
    }

    /// Number of frames written.
    #[must_use]
    pub fn frames_written(&self) -> u64 {
        self.frames
    }

    /// Number of bytes written to the sink, without the open chunk.
    #[must_use]
    pub fn bytes_written(&self) -> u64 {
        self.written.load(Ordering::Relaxed)
    }

    /// Writes the next frame: `/frame` first, then the state, the model's channels, the drawing and the log.
    ///
    /// # Errors
    /// A frame that breaks the model's declaration, which is left out as a whole, or a sink that fails.
    pub fn write(&mut self, clock: Clock, frame: &mut Frame) -> Result<(), RecordError> {
        let (log_time, time) = self.times_of(self.frames)?;
        self.check_frame(frame)?;
        self.add_channels()?;
        self.begin_frame();
        // Usually, the drawing is only in this memory, not in that of each frame.
        let is_drawn = !frame.discs().is_empty();
        if !is_drawn {
            frame.make_nan_canonical();
        }
        if let Some(drawing) = self.disc_drawing().filter(|_| !is_drawn) {
            frame.swap_discs(&mut self.discs);
            drawing.encode(frame, self.frames);
        }
        self.expect(frame);
        let frame_clock = FrameClock {
            frame: self.frames,
            step_or_event_count: clock.count,
            time: clock.time,
            time_unit: self.header.time_unit.to_owned(),
        };
        self.message(FrameClock::TOPIC, log_time, &frame_clock)?;
        if self.wants(channels::STATE) {
            let message = frame.rows_mut().as_message(self.header.state_columns, time);
            self.payload(channels::STATE, log_time, message)?;
        }
        for channel in self.header.channels {
            let message = frame.message(channel.topic).filter(|_| self.wants(channel.topic));
            if let Some(message) = message {
                self.payload(channel.topic, log_time, message.payload)?;
            }
        }
        self.draw(frame, log_time, time)?;
        self.write_log(frame.log_lines(), log_time, time)?;
        self.write_keyframe(frame.model_mut(), log_time)?;
        self.end_frame()?;
        frame.state_and_discs().1.clear();
        if !is_drawn {
            frame.swap_discs(&mut self.discs);
        }
        if let Some(observer) = &mut self.observer {
            observer.end_of_frame();
        }
        Ok(())
    }

    fn end_frame(&mut self) -> Result<(), RecordError> {
        self.frames += 1;
        if self.is_end_of_keyframe() || self.payload_in_chunk >= CHUNK_PAYLOAD {
            self.writer()?.flush()?;
            self.payload_in_chunk = 0;
            self.closed_frames = self.frames;
            if let Some(Resumable { open, .. }) = &mut self.resumable {
                open.clear();
            }
        }
        Ok(())
    }

    /// If the state and the discs of a frame fill the chunk, the chunk is closed at the end of the frame, and its messages are not
    /// stored.
    fn expect(&mut self, frame: &Frame) {
        let drawn = frame.discs().len();
        let state = if self.wants(channels::STATE) { size_of_val(frame.state()) } else { 0 };
        if let Some(Resumable { open, .. }) = &mut self.resumable
            && (matches!(self.header.stored, StoredFrames::Keyframes(_))
                || self.payload_in_chunk + (state + drawn) as u64 >= CHUNK_PAYLOAD)
        {
            open.discard_until_closed();
        }
    }

    /// Adds a line to the log of the last frame, such as the reason for the end of the run. No effect before the first frame.
    ///
    /// # Errors
    /// A sink that fails.
    pub fn remark(&mut self, line: LogLine) -> Result<(), RecordError> {
        let Some(last) = self.last_stored() else { return Ok(()) };
        let (log_time, time) = self.times_of(last)?;
        self.unstored.is_now = false;
        self.write_log(&[line], log_time, time)
    }

    /// Ends the recording with its outcome and returns the sink, flushed but not synced.
    ///
    /// # Errors
    /// A sink that fails; the recording is then torn.
    pub fn finish(mut self, outcome: &Outcome) -> Result<W, RecordError> {
        self.write_remaining_hashes()?;
        let writer = self.writer()?;
        writer.write_metadata(&Metadata {
            name: OUTCOME_RECORD.to_owned(),
            metadata: outcome.to_metadata(),
        })?;
        writer.finish()?;
        match self.writer.take() {
            Some(writer) => Ok(writer.into_inner().into_inner()?),
            None => Err(RecordError::Container("the recording is closed".to_owned())),
        }
    }

    fn writer(&mut self) -> Result<&mut mcap::Writer<CountingSink<W>>, RecordError> {
        let closed = || RecordError::Container("the recording is closed".to_owned());
        self.writer.as_mut().ok_or_else(closed)
    }

    /// Log time of a frame, ns and as a timestamp.
    fn times_of(&self, frame: u64) -> Result<(u64, Timestamp), RecordError> {
        let rate = self.header.playback_fps;
        log_times(frame, rate).ok_or(RecordError::Playback { frame, rate })
    }

    fn check_frame(&self, frame: &Frame) -> Result<(), RecordError> {
        let defect = |what: String| {
            Err(RecordError::Declaration(format!("model {}: {what}", self.header.model)))
        };
        let columns = self.header.state_columns.len();
        if !frame.state().len().is_multiple_of(columns) {
            return defect(format!("{} values do not fill rows of {columns}", frame.state().len()));
        }
        for (index, message) in frame.messages().enumerate() {
            if !self.header.channels.iter().any(|channel| channel.topic == message.topic) {
                return defect(format!("{} is not among its channels", message.topic));
            }
            if frame.messages().take(index).any(|earlier| earlier.topic == message.topic) {
                return defect(format!("{} has two messages in one frame", message.topic));
            }
        }
        Ok(())
    }

    /// Declares all channels at the first frame: a record between a channel and its first message would make mcap 0.26 write
    /// an empty chunk with times (0, 0), and with it a wrong time range.
    fn add_channels(&mut self) -> Result<(), RecordError> {
        if !self.channel_ids.is_empty() {
            return Ok(());
        }
        for topic in self.recorded.clone() {
            let schema = schema_of(topic, self.header.channels)?;
            let writer = self.writer()?;
            let schema_id = writer.add_schema(&schema.name, &schema.encoding, &schema.data)?;
            let id = writer.add_channel(schema_id, topic, "protobuf", &BTreeMap::new())?;
            self.channel_ids.insert(topic, id);
        }
        Ok(())
    }

    fn draw(&mut self, frame: &Frame, log_time: u64, time: Timestamp) -> Result<(), RecordError> {
        let is_first = self.is_first();
        for topic in self.recorded.clone() {
            let scene = match topic {
                channels::DISCS => {
                    self.payload(topic, log_time, frame.discs())?;
                    continue;
                }
                channels::VELOCITY => self.scenes.velocity(frame.state(), time),
                channels::FORCE_CHAINS => self.scenes.contacts(frame.contacts(), time),
                channels::TRAIL => {
                    if let Some(positions) = self.scenes.traced(frame.state()) {
                        self.trails.push(self.frames, positions);
                    }
                    self.scenes.trail(&self.trails, time)
                }
                channels::WALLS if !frame.walls().is_empty() => {
                    self.scenes.walls(frame.walls(), time)
                }
                channels::WALLS if is_first => self.scenes.walls_at_rest(time),
                channels::LEGEND if is_first => self.scenes.legend(time),
                _ => continue,
            };
            self.message(topic, log_time, &scene)?;
        }
        Ok(())
    }

    fn write_log(
        &mut self,
        lines: &[LogLine],
        log_time: u64,
        time: Timestamp,
    ) -> Result<(), RecordError> {
        if !self.is_first() {
            return lines.iter().try_for_each(|line| self.log_message(line, log_time, time));
        }
        let facts = self.drawing_facts();
        match joined(&[&facts, lines].concat()) {
            Some(line) => self.log_message(&line, log_time, time),
            None => Ok(()),
        }
    }

    fn log_message(
        &mut self,
        line: &LogLine,
        log_time: u64,
        time: Timestamp,
    ) -> Result<(), RecordError> {
        let message = Log {
            timestamp: Some(time),
            level: log_level(line.level).into(),
            message: line.text.clone(),
            name: self.header.model.to_owned(),
            ..Log::default()
        };
        self.message(channels::LOG, log_time, &message)
    }

    /// The scale of the playback, and that of discs which are drawn enlarged.
    fn drawing_facts(&self) -> Vec<LogLine> {
        let scale = self.header.simulated_per_second();
        let scale = scale.map(|simulated| format!("1 s of playback = {simulated} simulated"));
        let enlarged = self.header.scenery.enlargement().filter(|_| self.wants(channels::DISCS));
        let facts = scale.into_iter().chain(enlarged);
        facts.map(|text| LogLine { level: Level::Info, text }).collect()
    }

    fn message(
        &mut self,
        topic: &'static str,
        log_time: u64,
        message: &impl Message,
    ) -> Result<(), RecordError> {
        let mut buffer = std::mem::take(&mut self.buffer);
        buffer.clear();
        // Encoding into a growing vector cannot run out of space.
        message.encode_raw(&mut buffer);
        let written = self.payload(topic, log_time, &buffer);
        self.buffer = buffer;
        written
    }

    fn payload(
        &mut self,
        topic: &'static str,
        log_time: u64,
        payload: &[u8],
    ) -> Result<(), RecordError> {
        let Some(&channel_id) = self.channel_ids.get(topic) else {
            return Err(RecordError::Container(format!("{topic} has no channel")));
        };
        if self.unstored.is_now {
            return self.hash(topic, log_time, payload);
        }
        let header = MessageHeader {
            channel_id,
            // The frame's index; protobuf and MCAP have 32 bits for it, and readers go by `/frame`.
            sequence: self.frames as u32,
            log_time,
            publish_time: log_time,
        };
        self.writer()?.write_to_known_channel(&header, payload)?;
        self.payload_in_chunk += payload.len() as u64;
        if topic == channels::LOG && self.is_first() {
            self.first_log.get_or_insert_with(|| payload.to_vec());
        }
        if let Some(Resumable { open, .. }) = &mut self.resumable {
            open.push(channel_id, self.frames, log_time, payload);
        }
        if let Some(observer) = &mut self.observer {
            observer.message(topic, log_time, payload);
        }
        Ok(())
    }
}

impl<W: Write> Drop for Recorder<W> {
    fn drop(&mut self) {
        // mcap's own drop would close the recording, with a frame cut short and errors swallowed.
        if let Some(writer) = self.writer.take() {
            drop(writer.into_inner());
        }
    }
}

/// Sets every option, so that the bytes do not depend on defaults of a release or of the machine.
pub(crate) fn write_options(compression: Compression) -> mcap::WriteOptions {
    /// For its defaults, the crate counts the processors, which reads a file of the system.
    static DEFAULTS: LazyLock<mcap::WriteOptions> = LazyLock::new(mcap::WriteOptions::new);
    DEFAULTS
        .clone()
        .profile("")
        .library(LIBRARY)
        .compression(match compression {
            Compression::Zstd | Compression::Zstd3 => Some(mcap::Compression::Zstd),
            Compression::Lz4 => Some(mcap::Compression::Lz4),
            Compression::None => None,
        })
        .compression_level(if compression == Compression::Zstd3 { 3 } else { 1 })
        .compression_threads(0)
        .chunk_size(None)
        .use_chunks(true)
        // Chunks are packed in memory and go out whole: the sink only ever grows at its end.
        .disable_seeking(true)
        .emit_summary_records(true)
        .emit_summary_offsets(true)
        .emit_message_indexes(true)
        .calculate_chunk_crcs(true)
        .calculate_data_section_crc(true)
        .calculate_summary_section_crc(true)
        .calculate_attachment_crcs(true)
}

fn log_level(level: Level) -> log::Level {
    match level {
        Level::Info => log::Level::Info,
        Level::Warning => log::Level::Warning,
        Level::Error => log::Level::Error,
    }
}
