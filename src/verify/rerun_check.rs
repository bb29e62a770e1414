//! Compares the messages of a rerun with those of a recording, or with the hashes that it keeps of them, while they are produced.

use crate::interrupt::Interrupt;
use kinetoscope_recording::error::{ReadError, ReadFault};
use kinetoscope_recording::keyframe::{FrameHashes, KEYFRAME, Keyframe, MessageHash};
use kinetoscope_recording::observer::{ChannelList, FrameObserver};
use kinetoscope_recording::reader::{Frames, RecordedFrame, Recording};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// What a check has found so far.
#[derive(Debug, Default)]
pub(crate) struct Findings {
    /// Number of frames with equal messages.
    pub(crate) equal_frames: u64,
    /// The first frame and channel that differ.
    pub(crate) mismatch: Option<(u64, String)>,
    /// Why the rest of the recording cannot be read.
    pub(crate) unreadable: Option<ReadError>,
}

/// Shares the findings with the recorder's thread.
#[derive(Clone, Debug, Default)]
pub(crate) struct SharedFindings(Arc<Mutex<Findings>>);

impl SharedFindings {
    fn change(&self, change: impl FnOnce(&mut Findings)) {
        change(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner));
    }

    /// Takes the findings.
    pub(crate) fn take(&self) -> Findings {
        let mut taken = Findings::default();
        self.change(|findings| taken = std::mem::take(findings));
        taken
    }
}

/// The keyframe of a frame; `None` if it has none, or a damaged one.
pub(crate) fn keyframe_of(frame: &RecordedFrame) -> Option<Keyframe> {
    let message = frame.messages().iter().find(|message| message.topic() == KEYFRAME)?;
    Keyframe::from_bytes(message.payload())
}

/// The hashes of a recording's frames, in order.
struct Expected {
    path: PathBuf,
    frames: Frames,
    /// The hashes of frames that are not stored, before the frame of `stored`.
    hashes: FrameHashes,
    /// The hashes of the messages of the stored frame that was read last.
    stored: Option<Vec<MessageHash>>,
    /// The frame after the last one whose hashes were returned.
    next: u64,
    at_end: bool,
}

impl Expected {
    fn of(recording: &Recording) -> Result<Self, ReadError> {
        let next = recording.provenance().stored.first();
        let path = recording.path().to_path_buf();
        let frames = recording.frames()?;
        let hashes = FrameHashes::default();
        Ok(Self { path, frames, hashes, stored: None, next, at_end: false })
    }

    fn damaged(&self, what: &str) -> ReadError {
        let fault = ReadFault::Damaged { byte: 0, what: what.to_owned() };
        ReadError { path: self.path.clone(), intact_frames: self.next, fault }
    }

    /// The next frame and its hashes; `None` at the end.
    fn next(&mut self, topics: &[&str]) -> Result<Option<(u64, Vec<MessageHash>)>, ReadError> {
        loop {
            let next = match (self.hashes.next(), self.stored.take()) {
                (Some(hashes), stored) => {
                    self.stored = stored;
                    Some(hashes.map_err(|_| self.damaged("the hashes of its frames"))?)
                }
                (None, stored) => stored,
            };
            if let Some(hashes) = next {
                self.next += 1;
                return Ok(Some((self.next - 1, hashes)));
            }
            if self.at_end {
                return Ok(None);
            }
            match self.frames.next().transpose()? {
                Some(frame) => self.read(&frame, topics)?,
                None => {
                    self.at_end = true;
                    self.hashes = FrameHashes::new(self.frames.remaining_hashes().to_vec());
                }
            }
        }
    }

    /// Reads a stored frame, and the hashes of the frames before it.
    fn read(&mut self, frame: &RecordedFrame, topics: &[&str]) -> Result<(), ReadError> {
        let hashes = keyframe_of(frame).map(|keyframe| keyframe.hashes).unwrap_or_default();
        let before = FrameHashes::new(hashes.clone()).filter(Result::is_ok).count() as u64;
        if frame.clock.frame != self.next.saturating_add(before) {
            return Err(self.damaged("hashes of frames are missing"));
        }
        self.hashes = FrameHashes::new(hashes);
        let mut own = Vec::new();
        for message in frame.messages().iter().filter(|message| message.topic() != KEYFRAME) {
            let channel = topics.iter().position(|topic| *topic == message.topic());
            let channel = channel.ok_or_else(|| self.damaged("a channel that no run has"))?;
            let hash = MessageHash::of(channel, message.log_time_ns(), message.payload());
            own.push(hash.map_err(|error| self.damaged(&error.to_string()))?);
        }
        self.stored = Some(own);
        Ok(())
    }
}

/// Receives the messages of a rerun and compares them. It stops the rerun at the first difference.
pub(crate) struct RerunCheck {
    expected: Expected,
    topics: Vec<&'static str>,
    /// A topic that depends on frames before the first one of this rerun.
    left_out: Option<&'static str>,
    frame: u64,
    current: Vec<MessageHash>,
    findings: SharedFindings,
    stop: Interrupt,
    is_over: bool,
}

impl RerunCheck {
    /// Compares a rerun from frame `first` on.
    ///
    /// # Errors
    /// A recording that cannot be opened.
    pub(crate) fn new(
        recording: &Recording,
        first: u64,
        left_out: Option<&'static str>,
        stop: &Interrupt,
    ) -> Result<(Self, SharedFindings), ReadError> {
        let findings = SharedFindings::default();
        let check = Self {
            expected: Expected::of(recording)?,
            topics: Vec::new(),
            left_out,
            frame: first,
            current: Vec::new(),
            findings: findings.clone(),
            stop: stop.clone(),
            is_over: false,
        };
        Ok((check, findings))
    }

    fn differs(&mut self, channel: Option<u8>) {
        let topic = channel.and_then(|channel| self.topics.get(usize::from(channel)));
        let topic = topic.map_or("number of frames", |topic| *topic).to_owned();
        let frame = self.frame;
        self.findings.change(|findings| findings.mismatch = Some((frame, topic)));
        self.end();
        self.stop.stop();
    }

    fn end(&mut self) {
        self.is_over = true;
    }

    fn compare(&mut self) {
        let mut expected = loop {
            match self.expected.next(&self.topics) {
                Ok(Some((frame, _))) if frame < self.frame => {}
                Ok(Some((_, hashes))) => break hashes,
                Ok(None) => return self.differs(None),
                Err(error) => {
                    self.findings.change(|findings| findings.unreadable = Some(error));
                    return self.end();
                }
            }
        };
        let left_out = self.topics.iter().position(|topic| Some(*topic) == self.left_out);
        let mut found = std::mem::take(&mut self.current);
        for hashes in [&mut expected, &mut found] {
            hashes.retain(|hash| Some(usize::from(hash.channel)) != left_out);
        }
        let length = expected.len().max(found.len());
        let first = (0..length).find(|&index| expected.get(index) != found.get(index));
        match first {
            Some(index) => {
                let hash = expected.get(index).or(found.get(index));
                self.differs(hash.map(|hash| hash.channel));
            }
            None => self.findings.change(|findings| findings.equal_frames += 1),
        }
    }
}

impl FrameObserver for RerunCheck {
    fn begin(&mut self, channel_list: ChannelList) {
        self.topics = channel_list.channels.iter().map(|channel| channel.topic).collect();
    }

    fn message(&mut self, topic: &'static str, log_time_ns: u64, payload: &[u8]) {
        let channel = self.topics.iter().position(|known| *known == topic);
        // A channel that is missing from the list gives a difference.
        self.current.extend(MessageHash::of(channel.unwrap_or(0), log_time_ns, payload));
    }

    fn end_of_frame(&mut self) {
        if !self.is_over {
            self.compare();
        }
        self.current.clear();
        self.frame += 1;
    }
}
