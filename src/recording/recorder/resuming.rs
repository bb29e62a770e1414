//! Resumption of a recording after a kill: the recorder's part of the checkpoint, and the reuse of the file's bytes.

use super::{Header, Recorder};
use crate::channels::PARTICLES;
use crate::container::{Broken, Fields, damaged};
use crate::error::RecordError;
use crate::file::RecordingFile;
use crate::last_particles::LastParticles;
use crate::reader::{RecordedFrame, Recording};
use crate::record_kind as kind;
use crate::trail::Trails;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// The state from which a recorder resumes, in addition to the chunks in its file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecorderState {
    frames: u64,
    /// Number of frames in complete blocks.
    closed_frames: u64,
    /// Size of the file, which may have chunks of the open block at its end.
    bytes: u64,
    /// The contents of the chunks of the open block.
    open_block: Vec<Vec<u8>>,
    trails: Trails,
    hashes: Vec<u8>,
}

impl RecorderState {
    /// Number of frames written so far, including the start.
    #[must_use]
    pub fn frames(&self) -> u64 {
        self.frames
    }
}

impl Recorder<RecordingFile> {
    /// Starts a recording that can be resumed after a kill: see [`Recorder::save_point`].
    ///
    /// # Errors
    /// As [`Recorder::create`].
    pub fn create_resumable(file: RecordingFile, header: &Header) -> Result<Self, RecordError> {
        let syncer = file.syncer()?;
        let mut recorder = Self::create(file, header)?;
        recorder.writer.keep_open_block();
        recorder.syncer = Some(syncer);
        Ok(recorder)
    }

    /// Syncs the file between two frames and returns the state that [`Recorder::resume`] needs in addition.
    ///
    /// # Errors
    /// A disk that fails, or a recorder that was not created to be resumed: a defect of the program.
    pub fn save_point(&mut self) -> Result<RecorderState, RecordError> {
        self.writer.flush()?;
        let Some(syncer) = &self.syncer else {
            return Err(RecordError::Container("this recording cannot be resumed".to_owned()));
        };
        syncer.sync()?;
        Ok(RecorderState {
            frames: self.frames,
            closed_frames: self.closed_frames,
            bytes: self.bytes_written(),
            open_block: self.writer.open_block(),
            trails: self.trails.clone(),
            hashes: self.unstored.hashes.clone(),
        })
    }

    /// Resumes the partial file of a killed run. The same writer writes the intact messages again and compares the bytes with
    /// those on the disk; then it appends the messages that were in memory.
    ///
    /// # Errors
    /// A file that does not belong to this state and header, or a disk that fails.
    pub fn resume(
        folder: &Path,
        stem: &str,
        header: &Header,
        state: RecorderState,
    ) -> Result<Self, RecordError> {
        let file = RecordingFile::reopen(folder, stem, state.bytes)?;
        let path = file.partial_path().to_owned();
        let broken = |what: String| RecordError::NotContinued { path: path.clone(), what };
        let mut recorder = Self::create_resumable(file, header)?;
        if state.closed_frames > 0 {
            let intact = Recording::open(&path).and_then(|recording| recording.frames());
            let intact = intact.map_err(|error| broken(error.to_string()))?;
            let mut intact = intact.with_scalar_frames();
            while recorder.frames < state.closed_frames {
                match intact.next() {
                    Some(Ok(frame)) => recorder.replay(&frame)?,
                    Some(Err(error)) => return Err(broken(error.to_string())),
                    None => return Err(broken("it has fewer frames than its checkpoint".into())),
                }
            }
        }
        let bytes = state.bytes;
        recorder.replay_open(state).map_err(|error| match error {
            Broken::Damaged(what) => broken(what),
            Broken::Io(error) => RecordError::Io(error),
            Broken::Torn | Broken::NotMcap | Broken::Merged => broken("it is cut off".to_owned()),
        })?;
        if recorder.bytes_written() != bytes {
            return Err(broken("its chunks do not end where its checkpoint expects".to_owned()));
        }
        Ok(recorder)
    }

    fn replay(&mut self, frame: &RecordedFrame) -> Result<(), RecordError> {
        self.add_channels()?;
        self.frames = frame.clock.frame;
        self.begin_frame();
        for message in frame.messages() {
            let topic = self.known(message.topic()).ok_or_else(|| {
                RecordError::Container(format!("{} has no channel", message.topic()))
            })?;
            self.replay_message(topic, message.log_time_ns(), message.payload())?;
        }
        self.end_frame()
    }

    fn replay_message(
        &mut self,
        topic: &'static str,
        log_time: u64,
        payload: &[u8],
    ) -> Result<(), RecordError> {
        if topic == PARTICLES {
            self.particles = LastParticles::Message(payload.to_vec());
            self.unstored.particles = None;
        }
        self.payload(topic, log_time, payload)
    }

    fn known(&self, topic: &str) -> Option<&'static str> {
        self.recorded.iter().find(|known| **known == topic).copied()
    }

    /// Writes the messages of the open block again, frame by frame.
    fn replay_open(&mut self, state: RecorderState) -> Result<(), Broken> {
        let refused = |error: RecordError| match error {
            RecordError::Io(error) => Broken::Io(error),
            error => Broken::Damaged(error.to_string()),
        };
        if state.frames > 0 {
            self.add_channels().map_err(refused)?;
        }
        let topics: BTreeMap<u16, &'static str> =
            self.channel_ids.iter().map(|(topic, (_, id))| (*id, *topic)).collect();
        let mut frames: BTreeMap<u32, Vec<OpenMessage<'_>>> = BTreeMap::new();
        for content in &state.open_block {
            for message in OpenMessage::all(content)? {
                frames.entry(message.frame).or_default().push(message);
            }
        }
        for (frame, messages) in frames {
            self.frames = frame.into();
            self.begin_frame();
            for message in messages {
                let topic = topics.get(&message.channel);
                let topic = *topic.ok_or_else(|| damaged("a channel is missing"))?;
                self.replay_message(topic, message.log_time, message.payload).map_err(refused)?;
            }
            self.end_frame().map_err(refused)?;
        }
        self.writer.flush()?;
        self.frames = state.frames;
        self.trails = state.trails;
        self.unstored.hashes = state.hashes;
        Ok(())
    }
}

/// A message in the content of an open chunk.
struct OpenMessage<'a> {
    channel: u16,
    /// The sequence number is the frame's index.
    frame: u32,
    log_time: u64,
    payload: &'a [u8],
}

impl<'a> OpenMessage<'a> {
    /// The messages of a content, in order.
    fn all(content: &'a [u8]) -> Result<Vec<Self>, Broken> {
        let (mut rest, mut messages) = (Fields(content), Vec::new());
        while !rest.0.is_empty() {
            let (kind, length) = (rest.u8()?, rest.u64()?);
            let length = usize::try_from(length).map_err(|_| damaged("a record is too long"))?;
            let mut fields = Fields(rest.bytes(length)?);
            if kind == kind::MESSAGE {
                let (channel, frame) = (fields.u16()?, fields.u32()?);
                let (log_time, _publish_time) = (fields.u64()?, fields.u64()?);
                messages.push(Self { channel, frame, log_time, payload: fields.0 });
            }
        }
        Ok(messages)
    }
}
