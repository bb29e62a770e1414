//! Resumption of a recording after a kill: the recorder's part of the checkpoint, and the reuse of the file's bytes.

use super::{Header, Recorder};
use crate::error::RecordError;
use crate::file::{RecordingFile, Syncer};
use crate::open_chunk::OpenChunk;
use crate::reader::{RecordedFrame, Recording};
use crate::trail::Trails;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// The part of a recorder with which a killed run can resume.
pub(super) struct Resumable {
    pub(super) open: OpenChunk,
    syncer: Syncer,
}

/// The state from which a recorder resumes, in addition to the complete chunks in its file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecorderState {
    frames: u64,
    closed_frames: u64,
    closed_bytes: u64,
    open: OpenChunk,
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
        recorder.resumable = Some(Resumable { open: OpenChunk::default(), syncer });
        Ok(recorder)
    }

    /// Syncs the file between two frames and returns the state that [`Recorder::resume`] needs in addition.
    ///
    /// # Errors
    /// A disk that fails, or a recorder that was not created to be resumed: a defect of the program.
    pub fn save_point(&self) -> Result<RecorderState, RecordError> {
        let Some(Resumable { open, syncer }) = &self.resumable else {
            return Err(RecordError::Container("this recording cannot be resumed".to_owned()));
        };
        syncer.sync()?;
        Ok(RecorderState {
            frames: self.frames,
            closed_frames: self.closed_frames,
            closed_bytes: self.bytes_written(),
            open: open.clone(),
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
        let file = RecordingFile::reopen(folder, stem, state.closed_bytes)?;
        let path = file.partial_path().to_owned();
        let broken = |what: String| RecordError::NotContinued { path: path.clone(), what };
        let mut recorder = Self::create_resumable(file, header)?;
        if state.closed_frames > 0 {
            let intact = Recording::open(&path).and_then(|recording| recording.frames());
            let mut intact = intact.map_err(|error| broken(error.to_string()))?;
            while recorder.frames < state.closed_frames {
                match intact.next() {
                    Some(Ok(frame)) => recorder.replay(&frame)?,
                    Some(Err(error)) => return Err(broken(error.to_string())),
                    None => return Err(broken("it has fewer frames than its checkpoint".into())),
                }
            }
        }
        if recorder.bytes_written() != state.closed_bytes {
            return Err(broken("its chunks do not end where its checkpoint expects".to_owned()));
        }
        recorder.replay_open(state)?;
        Ok(recorder)
    }

    fn replay(&mut self, frame: &RecordedFrame) -> Result<(), RecordError> {
        self.add_channels()?;
        self.frames = frame.clock.frame;
        for message in frame.messages() {
            let known = self.recorded.iter().find(|topic| **topic == message.topic());
            let topic = *known.ok_or_else(|| {
                RecordError::Container(format!("{} has no channel", message.topic()))
            })?;
            self.payload(topic, message.log_time_ns(), message.payload())?;
        }
        self.end_frame()
    }

    fn replay_open(&mut self, state: RecorderState) -> Result<(), RecordError> {
        if state.frames > 0 {
            self.add_channels()?;
        }
        let topics: BTreeMap<u16, &str> =
            self.channel_ids.iter().map(|(topic, id)| (*id, *topic)).collect();
        for message in state.open.messages() {
            let topic = topics.get(&message.channel_id);
            let topic =
                *topic.ok_or_else(|| RecordError::Container("a channel is missing".to_owned()))?;
            // The sequence number is the frame's index.
            self.frames = message.frame;
            self.payload(topic, message.log_time, message.payload)?;
        }
        self.frames = state.frames;
        self.trails = state.trails;
        self.unstored.hashes = state.hashes;
        Ok(())
    }
}
