//! Recordings that keep only keyframes: of the other frames, the scalars and a hash of the state.

use super::{Recorder, StoredFrames};
use crate::channels::PARTICLES;
use crate::error::RecordError;
use crate::keyframe::{KEYFRAME, Keyframe, MessageHash, end_frame, is_drawing};
use crate::last_particles::message;
use crate::provenance::HASHES_RECORD;
use crate::table::Rows;
use std::collections::BTreeMap;
use std::io::Write;

/// Bytes of hashes in a metadata record, which takes two digits per byte.
const HASHES_PER_RECORD: usize = 128 << 10;

/// What is kept of the frames since the last keyframe.
#[derive(Debug, Default)]
pub(super) struct Unstored {
    /// Whether the current frame is not stored.
    pub(super) is_now: bool,
    /// The hashes of the messages that are not stored.
    pub(super) hashes: Vec<u8>,
    /// The hash of the last particles, once it is known.
    pub(super) particles: Option<MessageHash>,
}

impl<W: Write> Recorder<W> {
    /// Continues with this frame, as if all before it had been written: for a run whose messages are only compared.
    #[must_use]
    pub fn at_frame(mut self, frame: u64) -> Self {
        self.frames = frame;
        self
    }

    /// Whether the next frame is the first one of the file.
    pub(super) fn is_first(&self) -> bool {
        self.frames == self.header.stored.first()
    }

    pub(super) fn begin_frame(&mut self) {
        let stored = self.header.stored.has(self.frames, self.header.frames_expected);
        self.unstored.is_now = !stored;
    }

    /// Keeps the hash of a message. Drawings follow from the state, and only an observer receives them.
    pub(super) fn hash(
        &mut self,
        topic: &'static str,
        log_time: u64,
        payload: &[u8],
    ) -> Result<(), RecordError> {
        if !is_drawing(topic) {
            let channel = self.recorded.iter().position(|recorded| *recorded == topic);
            let hash = MessageHash::of(topic, channel.unwrap_or(usize::MAX), log_time, payload)?;
            hash.append_to(&mut self.unstored.hashes);
        }
        if let Some(observer) = &mut self.observer {
            observer.message(topic, log_time, payload);
        }
        Ok(())
    }

    /// Keeps particles that have not changed. A keyframe is read without those before it; therefore, a recording of keyframes has them in
    /// each keyframe, and their hash for each other frame.
    pub(super) fn keep_particles(&mut self, rows: &Rows, log_time: u64) -> Result<(), RecordError> {
        if !matches!(self.header.stored, StoredFrames::Keyframes(_)) {
            return Ok(());
        }
        let columns = self.header.state_columns;
        let particles = || message(rows, columns);
        if !self.unstored.is_now {
            return self.payload(PARTICLES, log_time, &mut particles()[..]);
        }
        let hash = match self.unstored.particles {
            Some(hash) => hash,
            None => {
                let channel = self.recorded.iter().position(|recorded| *recorded == PARTICLES);
                MessageHash::of(PARTICLES, channel.unwrap_or(usize::MAX), log_time, &particles())?
            }
        };
        hash.append_to(&mut self.unstored.hashes);
        self.unstored.particles = Some(hash);
        Ok(())
    }

    /// Ends a frame: its hashes, or the message of a keyframe. An observer receives the state of the model as well.
    pub(super) fn write_keyframe(
        &mut self,
        model: &mut Vec<u8>,
        log_time: u64,
    ) -> Result<(), RecordError> {
        if let Some(observer) = self.observer.as_mut().filter(|_| !model.is_empty()) {
            observer.model_state(model);
        }
        if self.unstored.is_now {
            end_frame(&mut self.unstored.hashes);
        } else if matches!(self.header.stored, StoredFrames::Keyframes(_)) {
            let hashes = std::mem::take(&mut self.unstored.hashes);
            let keyframe = Keyframe { model: std::mem::take(model), hashes };
            self.message(KEYFRAME, log_time, &keyframe)?;
        }
        Ok(())
    }

    /// Whether the frame that ends now is a keyframe, after which the chunk is closed: damage to one leaves the others.
    pub(super) fn is_end_of_keyframe(&self) -> bool {
        matches!(self.header.stored, StoredFrames::Keyframes(_)) && !self.unstored.is_now
    }

    /// Writes the hashes after the last keyframe, which only a run that failed or was interrupted has.
    pub(super) fn write_remaining_hashes(&mut self) -> Result<(), RecordError> {
        let hashes = std::mem::take(&mut self.unstored.hashes);
        for part in hashes.chunks(HASHES_PER_RECORD) {
            let text = part.iter().map(|byte| format!("{byte:02x}")).collect();
            self.writer.metadata(HASHES_RECORD, &BTreeMap::from([("hashes".to_owned(), text)]))?;
        }
        Ok(())
    }
}
