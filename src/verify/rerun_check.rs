//! Compares the messages of a rerun with those of a recording, or with the hashes that it keeps of them, while they are produced.
//!
//! The comparison has a thread of its own, because hashing messages takes about as long as compressing them.

use crate::interrupt::Interrupt;
use crate::verify::error::VerifyError;
use kinetoscope_recording::error::RecordError;
use kinetoscope_recording::error::{ReadError, ReadFault};
use kinetoscope_recording::keyframe::{FrameHashes, KEYFRAME, Keyframe, MessageHash};
use kinetoscope_recording::observer::{ChannelList, FrameObserver};
use kinetoscope_recording::reader::{Frames, RecordedFrame, Recording};
use kinetoscope_recording::recorder::Header;
use std::mem::replace;
use std::ops::Range;
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{Builder, JoinHandle};

/// Frames that wait for the check. Memory holds two more: the one that is checked and the one that is filled.
const WAITING: usize = 2;

/// What a check has found.
#[derive(Debug, Default)]
pub(crate) struct Findings {
    /// Number of frames with equal messages.
    pub(crate) equal_frames: u64,
    /// Why the rest of the recording cannot be read.
    pub(crate) unreadable: Option<ReadError>,
    /// The first frame and channel that differ.
    mismatch: Option<(u64, String)>,
}

/// A check that runs.
pub(crate) struct RerunCheck {
    path: PathBuf,
    thread: JoinHandle<Findings>,
}

impl RerunCheck {
    /// Starts a check of the messages that the returned observer receives, from frame `first` on. It stops the rerun at the first
    /// difference. `left_out` is a topic that depends on frames before the first one of this rerun.
    ///
    /// # Errors
    /// A recording that cannot be opened, or a system without another thread.
    pub(crate) fn start(
        recording: &Recording,
        rerun: &Header,
        first: u64,
        left_out: Option<&'static str>,
        stop: &Interrupt,
    ) -> Result<(Self, Box<dyn FrameObserver>), VerifyError> {
        let topics: Vec<&'static str> =
            rerun.topics().into_iter().filter(|topic| rerun.wants(topic)).collect();
        let left_out = topics.iter().position(|topic| Some(*topic) == left_out);
        let expected = ExpectedHashes::of(recording, topics)?;
        let mut comparison = HashComparison { expected, left_out };
        let (sender, frames) = sync_channel(WAITING);
        let stop = stop.clone();
        let thread = Builder::new()
            .name("check".to_owned())
            .spawn(move || comparison.compare_all(first, &frames, &stop))
            .map_err(|error| VerifyError::Write(RecordError::Thread(error)))?;
        let check = Self { path: recording.path().to_owned(), thread };
        Ok((check, Box::new(MessageSender { frame: Messages::default(), frames: sender })))
    }

    /// Waits for the end of the check, which comes when the rerun has dropped the observer.
    ///
    /// # Errors
    /// A difference.
    pub(crate) fn findings(self) -> Result<Findings, VerifyError> {
        let mut findings = self.thread.join().unwrap_or_else(|panic| resume_unwind(panic));
        match findings.mismatch.take() {
            Some((frame, channel)) => Err(VerifyError::Differs { path: self.path, frame, channel }),
            None => Ok(findings),
        }
    }
}

/// The messages of a frame.
#[derive(Default)]
struct Messages {
    /// Topic, log time in ns, and place of the payload in `bytes`.
    list: Vec<(&'static str, u64, Range<usize>)>,
    bytes: Vec<u8>,
}

/// Sends the messages of each frame to the check.
struct MessageSender {
    frame: Messages,
    frames: SyncSender<Messages>,
}

impl FrameObserver for MessageSender {
    fn begin(&mut self, _channel_list: ChannelList) {}

    fn message(&mut self, topic: &'static str, log_time_ns: u64, payload: &[u8]) {
        let start = self.frame.bytes.len();
        self.frame.bytes.extend_from_slice(payload);
        self.frame.list.push((topic, log_time_ns, start..self.frame.bytes.len()));
    }

    fn end_of_frame(&mut self) {
        let (messages, bytes) = (self.frame.list.len(), self.frame.bytes.len());
        let next =
            Messages { list: Vec::with_capacity(messages), bytes: Vec::with_capacity(bytes) };
        // An error means that the check has ended.
        drop(self.frames.send(replace(&mut self.frame, next)));
    }
}

/// The keyframe of a frame; `None` if it has none, or a damaged one.
pub(crate) fn keyframe_of(frame: &RecordedFrame) -> Option<Keyframe> {
    let message = frame.messages().iter().find(|message| message.topic() == KEYFRAME)?;
    Keyframe::from_bytes(message.payload())
}

/// The hashes of a recording's frames, in order.
struct ExpectedHashes {
    path: PathBuf,
    frames: Frames,
    /// The topics of the rerun; a message is hashed with the position of its topic.
    topics: Vec<&'static str>,
    /// The hashes of frames that are not stored, before the frame of `stored`.
    hashes: FrameHashes,
    /// The hashes of the messages of the stored frame that was read last.
    stored: Option<Vec<MessageHash>>,
    /// The frame after the last one whose hashes were returned.
    next: u64,
    at_end: bool,
}

impl ExpectedHashes {
    fn of(recording: &Recording, topics: Vec<&'static str>) -> Result<Self, ReadError> {
        Ok(Self {
            path: recording.path().to_path_buf(),
            frames: recording.frames()?,
            topics,
            hashes: FrameHashes::default(),
            stored: None,
            next: recording.provenance().stored.first(),
            at_end: false,
        })
    }

    fn damaged(&self, what: &str) -> ReadError {
        let fault = ReadFault::Damaged { byte: 0, what: what.to_owned() };
        ReadError { path: self.path.clone(), intact_frames: self.next, fault }
    }

    /// The hashes of a frame; `None` if the recording ends before it.
    fn of_frame(&mut self, frame: u64) -> Result<Option<Vec<MessageHash>>, ReadError> {
        while let Some((index, hashes)) = self.next()? {
            if index >= frame {
                return Ok(Some(hashes));
            }
        }
        Ok(None)
    }

    /// The next frame and its hashes; `None` at the end.
    fn next(&mut self) -> Result<Option<(u64, Vec<MessageHash>)>, ReadError> {
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
                Some(frame) => self.read(&frame)?,
                None => {
                    self.at_end = true;
                    self.hashes = FrameHashes::new(self.frames.remaining_hashes().to_vec());
                }
            }
        }
    }

    /// Reads a stored frame, and the hashes of the frames before it.
    fn read(&mut self, frame: &RecordedFrame) -> Result<(), ReadError> {
        let hashes = keyframe_of(frame).map(|keyframe| keyframe.hashes).unwrap_or_default();
        let before = FrameHashes::new(hashes.clone()).filter(Result::is_ok).count() as u64;
        if frame.clock.frame != self.next.saturating_add(before) {
            return Err(self.damaged("hashes of frames are missing"));
        }
        self.hashes = FrameHashes::new(hashes);
        let mut own = Vec::new();
        for message in frame.messages().iter().filter(|message| message.topic() != KEYFRAME) {
            let channel = self.topics.iter().position(|topic| *topic == message.topic());
            let channel = channel.ok_or_else(|| self.damaged("a channel that no run has"))?;
            let hash = MessageHash::of(channel, message.log_time_ns(), message.payload());
            own.push(hash.map_err(|error| self.damaged(&error.to_string()))?);
        }
        self.stored = Some(own);
        Ok(())
    }
}

/// Compares the hashes of a rerun's messages with the expected ones.
struct HashComparison {
    expected: ExpectedHashes,
    /// The position of the topic that is not compared.
    left_out: Option<usize>,
}

impl HashComparison {
    /// Compares all frames up to the first difference.
    fn compare_all(
        &mut self,
        first: u64,
        frames: &Receiver<Messages>,
        stop: &Interrupt,
    ) -> Findings {
        let mut findings = Findings::default();
        for (frame, messages) in (first..).zip(frames) {
            match self.difference(frame, &messages) {
                Ok(None) => findings.equal_frames += 1,
                Ok(Some(channel)) => {
                    findings.mismatch = Some((frame, channel));
                    stop.stop();
                    break;
                }
                Err(error) => {
                    findings.unreadable = Some(error);
                    break;
                }
            }
        }
        findings
    }

    /// The first channel of a frame that differs.
    fn difference(&mut self, frame: u64, messages: &Messages) -> Result<Option<String>, ReadError> {
        let Some(mut expected) = self.expected.of_frame(frame)? else {
            return Ok(Some("number of frames".to_owned()));
        };
        let (topics, mut found) = (&self.expected.topics, Vec::new());
        for (topic, log_time_ns, payload) in &messages.list {
            let channel = topics.iter().position(|known| known == topic);
            // A channel that is missing from the list gives a difference.
            let payload = &messages.bytes[payload.clone()];
            found.extend(MessageHash::of(channel.unwrap_or(0), *log_time_ns, payload));
        }
        for hashes in [&mut expected, &mut found] {
            hashes.retain(|hash| Some(usize::from(hash.channel)) != self.left_out);
        }
        let length = expected.len().max(found.len());
        let differing = (0..length).find(|&index| expected.get(index) != found.get(index));
        Ok(differing.map(|index| {
            let hash = expected.get(index).or(found.get(index));
            let topic = hash.and_then(|hash| topics.get(usize::from(hash.channel)));
            topic.map_or("number of frames", |topic| *topic).to_owned()
        }))
    }
}
