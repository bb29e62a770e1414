//! Writer of a recording: frames to one MCAP file.
//!
//! Invariant: the bytes do not depend on the clock, the host, the threads, the path or the user.

pub use crate::header::{Compression, Header, Selection};
pub use crate::provenance::Outcome;
pub use crate::stored_frames::StoredFrames;
pub use resuming::RecorderState;

mod keyframes;
mod resuming;

use crate::block_writer::{BlockWriter, Group, MessageHead};
use crate::channels::{self, Channel as _, FrameClock};
use crate::disc_drawing::DiscDrawing;
use crate::error::RecordError;
use crate::file::Syncer;
use crate::frame::{Frame, Level, LogLine};
use crate::last_particles::LastParticles;
use crate::log_text::joined;
use crate::observer::{ChannelList, FrameObserver};
use crate::payload::Payload;
use crate::playback::log_times;
use crate::provenance::{MANIFEST_ATTACHMENT, OUTCOME_RECORD, PROVENANCE_RECORD};
use crate::scene::{EncodedDiscs, SceneBuilder};
use crate::schema::schema_of;
use crate::sink::CountingSink;
use crate::stored_frames::DrawnFrames;
use crate::trail::Trails;
use foxglove::messages::{Log, SceneUpdate, Timestamp, log};
use keyframes::Unstored;
use prost::Message;
use std::collections::BTreeMap;
use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

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
    writer: BlockWriter<W>,
    // In file order.
    recorded: Vec<&'static str>,
    // For each channel, its group and its number.
    channel_ids: BTreeMap<&'static str, (Group, u16)>,
    frames: u64,
    unstored: Unstored,
    // Frames in complete blocks.
    closed_frames: u64,
    // Syncs the file of a recorder that can be resumed.
    syncer: Option<Syncer>,
    // For an observer of the resumed run.
    first_log: Option<Vec<u8>>,
    observer: Option<Box<dyn FrameObserver>>,
    buffer: Vec<u8>,
    discs: EncodedDiscs,
    particles: LastParticles,
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
        let mut writer = BlockWriter::create(sink, header.compression)?;
        writer.attach(MANIFEST_ATTACHMENT, "application/toml", header.manifest.as_bytes())?;
        writer.metadata(PROVENANCE_RECORD, &header.provenance().to_metadata())?;
        // A checkpoint counts on these bytes.
        writer.flush()?;
        Ok(Self {
            header: header.clone(),
            scenes,
            trails: Trails::new(),
            writer,
            recorded: header.topics().into_iter().filter(|topic| header.wants(topic)).collect(),
            channel_ids: BTreeMap::new(),
            frames: header.stored.first(),
            unstored: Unstored::default(),
            closed_frames: header.stored.first(),
            syncer: None,
            first_log: None,
            observer: None,
            buffer: Vec::new(),
            discs: EncodedDiscs::default(),
            particles: LastParticles::default(),
            written,
        })
    }

    /// Whether a topic, with its leading slash, is recorded.
    #[must_use]
    pub fn wants(&self, topic: &str) -> bool {
        self.recorded.contains(&topic)
    }

    /// Sends all messages from now on to an observer. That of a resumed run first receives the particles, and the drawings
    /// and the log of the start.
    ///
    /// # Errors
    /// A channel without a schema: a defect of the program.
    pub fn show_to(&mut self, mut observer: Box<dyn FrameObserver>) -> Result<(), RecordError> {
        observer.begin(ChannelList::of(&self.header, &self.recorded)?);
        if self.frames > 0 {
            let start = Timestamp::new(0, 0);
            if let Some(particles) = self.particles.message() {
                observer.message(channels::PARTICLES, 0, particles);
            }
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
        let (scenes, rate) = (Arc::clone(&self.scenes), self.header.playback_fps);
        let drawing = || DiscDrawing::new(scenes, rate, self.drawn_frames());
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
        let frame_clock = FrameClock {
            frame: self.frames,
            step_or_event_count: clock.count,
            time: clock.time,
            time_unit: self.header.time_unit.to_owned(),
        };
        self.message(FrameClock::TOPIC, log_time, &frame_clock)?;
        self.trace(frame.state());
        let is_drawn = self.drawn_frames().has(self.frames);
        let has_arrows = is_drawn && self.wants(channels::VELOCITY);
        let arrows = has_arrows.then(|| self.scenes.velocity(frame.state(), time));
        self.write_state(frame, log_time, time)?;
        for channel in self.header.channels {
            let message = frame.message(channel.topic).filter(|_| self.wants(channel.topic));
            if let Some(message) = message {
                self.payload(channel.topic, log_time, message.payload)?;
            }
        }
        self.draw(frame, arrows, log_time, time)?;
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

    /// Writes the particles if they have changed, and the state without their constants.
    fn write_state(
        &mut self,
        frame: &mut Frame,
        log_time: u64,
        time: Timestamp,
    ) -> Result<(), RecordError> {
        let (rows, columns) = (frame.rows_mut(), self.header.state_columns);
        if self.wants(channels::PARTICLES) {
            match self.particles.update(rows, columns) {
                Some(mut particles) => {
                    self.unstored.particles = None;
                    self.payload(channels::PARTICLES, log_time, &mut particles[..])?;
                }
                None => self.keep_particles(rows, log_time)?,
            }
        }
        if self.wants(channels::STATE) {
            self.payload(channels::STATE, log_time, rows.take_message(columns, time))?;
        }
        Ok(())
    }

    fn end_frame(&mut self) -> Result<(), RecordError> {
        self.frames += 1;
        let ends_block = self.is_end_of_keyframe();
        if self.writer.end_frame(ends_block)? {
            self.closed_frames = self.frames;
        }
        Ok(())
    }

    /// Adds a line to the log of the last frame, such as the reason for the end of the run. No effect before the first frame.
    ///
    /// # Errors
    /// A sink that fails.
    pub fn remark(&mut self, line: LogLine) -> Result<(), RecordError> {
        let Some(last) = self.frames.checked_sub(1) else { return Ok(()) };
        let (log_time, time) = self.times_of(last)?;
        self.write_log(&[line], log_time, time)
    }

    /// Ends the recording with its outcome and returns the sink, flushed but not synced.
    ///
    /// # Errors
    /// A sink that fails; the recording is then torn.
    pub fn finish(mut self, outcome: &Outcome) -> Result<W, RecordError> {
        self.write_remaining_hashes()?;
        self.writer.metadata(OUTCOME_RECORD, &outcome.to_metadata())?;
        Ok(self.writer.finish()?)
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

    /// Declares all channels at the first frame, so that a recording without frames has none.
    fn add_channels(&mut self) -> Result<(), RecordError> {
        if !self.channel_ids.is_empty() {
            return Ok(());
        }
        for topic in self.recorded.clone() {
            let schema = schema_of(topic, self.header.channels)?;
            let group = Group::of(topic, self.header.channels);
            let id = self.writer.declare(group, topic, &schema);
            self.channel_ids.insert(topic, (group, id));
        }
        Ok(())
    }

    /// The frames that are drawn: only an observer sees the drawing of a frame that is not stored.
    fn drawn_frames(&self) -> DrawnFrames {
        let Header { stored, frames_expected: frames, draw_every: every, .. } = self.header;
        let stored = match (&self.observer, stored) {
            (Some(_), StoredFrames::Keyframes(_)) => StoredFrames::All,
            _ => stored,
        };
        DrawnFrames { stored, frames, every }
    }

    /// Adds the positions of a frame to the paths so far.
    fn trace(&mut self, state: &[f64]) {
        if self.wants(channels::TRAIL)
            && let Some(positions) = self.scenes.traced(state)
        {
            self.trails.push(self.frames, positions);
        }
    }

    fn draw(
        &mut self,
        frame: &Frame,
        mut arrows: Option<SceneUpdate>,
        log_time: u64,
        time: Timestamp,
    ) -> Result<(), RecordError> {
        let is_first = self.is_first();
        let is_drawn = self.drawn_frames().has(self.frames);
        for topic in self.recorded.clone() {
            let scene = match topic {
                // An analysis reads the walls of every frame.
                _ if !is_drawn && topic != channels::WALLS => continue,
                channels::DISCS => {
                    self.payload(topic, log_time, frame.discs())?;
                    continue;
                }
                channels::VELOCITY => arrows.take().unwrap_or_default(),
                channels::FORCE_CHAINS => self.scenes.contacts(frame.contacts(), time),
                channels::TRAIL => self.scenes.trail(&self.trails, time),
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
        let enlarged = self.header.scenery.enlargement();
        let every = self.header.draw_every.get();
        let drawn = (every > 1)
            .then(|| format!("one frame in {every} is drawn (`draw_every` in [record])"));
        let of_discs = enlarged.into_iter().chain(drawn).filter(|_| self.wants(channels::DISCS));
        let facts = scale.into_iter().chain(of_discs);
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
        let written = self.payload(topic, log_time, &buffer[..]);
        self.buffer = buffer;
        written
    }

    fn payload<'a>(
        &mut self,
        topic: &'static str,
        log_time: u64,
        payload: impl Into<Payload<'a>>,
    ) -> Result<(), RecordError> {
        let payload = payload.into();
        let Some(&(group, channel)) = self.channel_ids.get(topic) else {
            return Err(RecordError::Container(format!("{topic} has no channel")));
        };
        if self.unstored.is_now && group != Group::Scalars {
            return self.hash(topic, log_time, &payload);
        }
        if topic == channels::LOG && self.is_first() {
            self.first_log.get_or_insert_with(|| payload.to_vec());
        }
        // The writer may use the memory of the payload.
        if let Some(observer) = &mut self.observer {
            observer.message(topic, log_time, &payload);
        }
        let head = MessageHead { channel, sequence: self.frames as u32, log_time };
        Ok(self.writer.message(group, head, payload)?)
    }
}

fn log_level(level: Level) -> log::Level {
    match level {
        Level::Info => log::Level::Info,
        Level::Warning => log::Level::Warning,
        Level::Error => log::Level::Error,
    }
}
