//! Compares the messages of a rerun with those of a recording, or with the hashes that it keeps of them, while they are produced. Of a
//! frame that is not stored, its drawings are not compared: they follow from the state.
//!
//! The comparison has a thread of its own, because hashing messages takes about as long as compressing them.

use crate::interrupt::Interrupt;
use crate::verify::error::VerifyError;
use crate::verify::rerun::Rerun;
use kinetoscope_recording::channels::{LOG, PARTICLES, TRAIL};
use kinetoscope_recording::error::{ReadError, ReadFault, RecordError};
use kinetoscope_recording::frame::LogLine;
use kinetoscope_recording::keyframe::{FrameHashes, KEYFRAME, Keyframe, MessageHash, is_drawing};
use kinetoscope_recording::observer::{ChannelList, FrameObserver};
use kinetoscope_recording::reader::{Frames, Outcome, RecordedFrame, RecordedMessage, Recording};
use std::collections::VecDeque;
use std::mem::replace;
use std::ops::Range;
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{Builder, JoinHandle};

/// Frames that wait for the check. Memory holds two more: the one that is checked and the one that is filled.
const WAITING: usize = 2;
/// The place of a difference that is not in a channel.
const NUMBER_OF_FRAMES: &str = "number of frames";

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
    /// Starts a check of all messages of a rerun, and of the states of its model at the keyframes of the recording. It stops the rerun
    /// at the first difference. The recording must end with a rerun that begins at the start of the run and is no part of it; if one
    /// begins later, the paths of the particles are not compared, because they depend on the frames before.
    ///
    /// # Errors
    /// A recording that cannot be opened, or a system without another thread.
    pub(crate) fn start(recording: &Recording, rerun: &mut Rerun<'_>) -> Result<Self, VerifyError> {
        let (header, first) = (&rerun.start.header, rerun.first);
        let topics = header.topics().into_iter().filter(|topic| header.wants(topic));
        let topics = topics.map(|topic| (topic, header.schema_name(topic))).collect();
        let expected = ExpectedMessages::of(recording, topics)?;
        let has_end = first == 0 && !rerun.is_part;
        let mut comparison = MessageComparison { expected, first, has_end, particles: None };
        let (sender, frames) = sync_channel(WAITING);
        let stop = rerun.stop.clone();
        let thread = Builder::new()
            .name("check".to_owned())
            .spawn(move || comparison.compare_all(&frames, &stop))
            .map_err(|error| VerifyError::Write(RecordError::Thread(error)))?;
        rerun.observer =
            Some(Box::new(MessageSender { frame: Messages::default(), frames: sender }));
        rerun.keyframes_of = recording.provenance().stored;
        Ok(Self { path: recording.path().to_owned(), thread })
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
    /// The state of the model, if the frame is a keyframe of the recording.
    model: Option<Vec<u8>>,
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

    fn model_state(&mut self, state: &[u8]) {
        self.frame.model = Some(state.to_vec());
    }

    fn end_of_frame(&mut self) {
        let (list, bytes) = (self.frame.list.len(), self.frame.bytes.len());
        let next = Messages {
            list: Vec::with_capacity(list),
            bytes: Vec::with_capacity(bytes),
            model: None,
        };
        // An error means that the check has ended.
        drop(self.frames.send(replace(&mut self.frame, next)));
    }
}

fn keyframe_message(frame: &RecordedFrame) -> Option<&RecordedMessage> {
    frame.messages().iter().find(|message| message.topic() == KEYFRAME)
}

/// The keyframe of a frame; `None` if it has none, or a damaged one.
pub(crate) fn keyframe_of(frame: &RecordedFrame) -> Option<Keyframe> {
    Keyframe::from_bytes(keyframe_message(frame)?.payload())
}

/// What a recording keeps of a frame.
#[derive(Default)]
struct Expected {
    hashes: Vec<MessageHash>,
    keyframe: Option<RecordedMessage>,
    /// Whether all channels of the frame are stored.
    is_stored: bool,
    /// A topic whose schema is not that of the rerun.
    other_schema: Option<&'static str>,
}

impl Expected {
    /// Whether the frame has the keyframe of a state, or none if there is no state. The hashes in it are those of the frames before,
    /// with which they are compared.
    fn has_keyframe_of(&self, model: Option<Vec<u8>>) -> bool {
        match (&self.keyframe, model) {
            (Some(message), Some(model)) => {
                Keyframe::from_bytes(message.payload()).is_some_and(|recorded| {
                    Keyframe { model, ..recorded }.is_written_as(message.payload())
                })
            }
            (None, None) => true,
            _ => false,
        }
    }
}

/// What a recording keeps of its frames, in order.
struct ExpectedMessages {
    path: PathBuf,
    frames: Frames,
    /// The topics of the rerun with their schemas; a message is hashed with the position of its topic.
    topics: Vec<(&'static str, Option<String>)>,
    /// The hashes of frames that are not stored, before the frame of `stored`.
    hashes: FrameHashes,
    /// The scalars of the frames that are not stored, before the frame of `stored`.
    scalars: VecDeque<Expected>,
    /// The stored frame that was read last.
    stored: Option<Expected>,
    /// Why the run failed.
    fault: Option<String>,
    /// The hash of the particles, as recorded last.
    particles: Option<MessageHash>,
    /// The frame after the last one that was returned.
    next: u64,
    at_end: bool,
}

impl ExpectedMessages {
    fn of(
        recording: &Recording,
        topics: Vec<(&'static str, Option<String>)>,
    ) -> Result<Self, ReadError> {
        Ok(Self {
            path: recording.path().to_path_buf(),
            frames: recording.frames()?.with_scalar_frames(),
            topics,
            hashes: FrameHashes::default(),
            scalars: VecDeque::new(),
            stored: None,
            fault: match &recording.provenance().outcome {
                Some(Outcome::Fault(fault)) => Some(fault.clone()),
                _ => None,
            },
            particles: None,
            next: recording.provenance().stored.first(),
            at_end: false,
        })
    }

    fn damaged(&self, what: &str) -> ReadError {
        let fault = ReadFault::Damaged { byte: 0, what: what.to_owned() };
        ReadError { path: self.path.clone(), intact_frames: self.next, fault }
    }

    fn position(&self, topic: &str) -> Option<usize> {
        self.topics.iter().position(|(known, _)| *known == topic)
    }

    /// A frame; `None` if the recording ends before it.
    fn of_frame(&mut self, frame: u64) -> Result<Option<Expected>, ReadError> {
        while let Some(expected) = self.next()? {
            if self.next > frame {
                return Ok(Some(expected));
            }
        }
        Ok(None)
    }

    /// The next frame; `None` at the end.
    fn next(&mut self) -> Result<Option<Expected>, ReadError> {
        loop {
            let next = match self.hashes.next() {
                Some(Ok(hashes)) => Some(self.unstored(hashes)?),
                Some(Err(_)) => return Err(self.damaged("the hashes of its frames")),
                None => self.stored.take(),
            };
            if let Some(mut expected) = next {
                self.next += 1;
                let channel = self.position(PARTICLES);
                add_particles(&mut expected.hashes, &mut self.particles, channel);
                return Ok(Some(expected));
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

    /// A frame that is not stored, with these hashes in addition to those of its scalars.
    fn unstored(&mut self, hashes: Vec<MessageHash>) -> Result<Expected, ReadError> {
        let scalars = self.scalars.pop_front();
        let mut expected = scalars.ok_or_else(|| self.damaged("scalars of frames are missing"))?;
        expected.hashes.extend(hashes);
        expected.hashes.sort_by_key(|hash| hash.channel);
        Ok(expected)
    }

    /// The messages of a frame without the line about the end of the run, which was added to its last frame later. The outcome, which is
    /// compared, has the same text.
    fn without_remark<'a>(&self, frame: &'a RecordedFrame) -> &'a [RecordedMessage] {
        let is_remark = |line: &LogLine| {
            let fault = self.fault.as_deref().map(|fault| fault.trim_end_matches('…'));
            fault.is_some_and(|fault| line.text.starts_with(fault))
        };
        match (frame.messages().split_last(), frame.log_lines().last()) {
            (Some((last, others)), Some(line)) if last.topic() == LOG && is_remark(line) => others,
            _ => frame.messages(),
        }
    }

    /// Reads a stored frame and the hashes of the frames before it, or the scalars of a frame that is not stored.
    fn read(&mut self, frame: &RecordedFrame) -> Result<(), ReadError> {
        if !frame.is_complete() {
            let scalars = self.expected(frame)?;
            self.scalars.push_back(scalars);
            return Ok(());
        }
        let hashes = keyframe_of(frame).map(|keyframe| keyframe.hashes).unwrap_or_default();
        let before = FrameHashes::new(hashes.clone()).filter(Result::is_ok).count() as u64;
        let scalars = self.scalars.len() as u64;
        if frame.clock.frame != self.next.saturating_add(before) || before != scalars {
            return Err(self.damaged("hashes of frames are missing"));
        }
        self.hashes = FrameHashes::new(hashes);
        self.stored = Some(self.expected(frame)?);
        Ok(())
    }

    /// The hashes of the messages of a frame.
    fn expected(&self, frame: &RecordedFrame) -> Result<Expected, ReadError> {
        let (keyframe, is_stored) = (keyframe_message(frame).cloned(), frame.is_complete());
        let mut expected = Expected { keyframe, is_stored, ..Expected::default() };
        let messages = self.without_remark(frame).iter();
        for message in messages.filter(|message| message.topic() != KEYFRAME) {
            let channel = self.position(message.topic());
            let channel = channel.ok_or_else(|| self.damaged("a channel that no run has"))?;
            let (topic, schema) = &self.topics[channel];
            if schema.as_deref() != Some(message.schema()) {
                expected.other_schema.get_or_insert(topic);
            }
            let hash = MessageHash::of(topic, channel, message.log_time_ns(), message.payload());
            expected.hashes.push(hash.map_err(|error| self.damaged(&error.to_string()))?);
        }
        Ok(expected)
    }
}

/// Adds the hash of the particles, which are recorded only when they change, to the hashes of a frame without them.
fn add_particles(
    hashes: &mut Vec<MessageHash>,
    last: &mut Option<MessageHash>,
    channel: Option<usize>,
) {
    match hashes.iter().find(|hash| Some(usize::from(hash.channel)) == channel) {
        Some(recorded) => *last = Some(*recorded),
        None => hashes.extend(*last),
    }
    hashes.sort_by_key(|hash| hash.channel);
}

/// Compares the messages of a rerun with the expected ones.
struct MessageComparison {
    expected: ExpectedMessages,
    /// The first frame of the rerun.
    first: u64,
    /// Whether the recording must end with the rerun.
    has_end: bool,
    /// The hash of the particles of the rerun.
    particles: Option<MessageHash>,
}

impl MessageComparison {
    /// Compares all frames up to the first difference.
    fn compare_all(&mut self, frames: &Receiver<Messages>, stop: &Interrupt) -> Findings {
        let mut findings = Findings::default();
        for (frame, messages) in (self.first..).zip(frames) {
            match self.difference(frame, messages) {
                Ok(None) => findings.equal_frames += 1,
                Ok(Some(channel)) => {
                    findings.mismatch = Some((frame, channel));
                    stop.stop();
                    return findings;
                }
                Err(error) => {
                    findings.unreadable = Some(error);
                    return findings;
                }
            }
        }
        if self.has_end {
            match self.expected.next() {
                Ok(None) => {}
                Ok(Some(_)) => {
                    let frame = findings.equal_frames;
                    findings.mismatch = Some((frame, NUMBER_OF_FRAMES.to_owned()));
                }
                Err(error) => findings.unreadable = Some(error),
            }
        }
        findings
    }

    /// The first channel of a frame that differs.
    fn difference(&mut self, frame: u64, messages: Messages) -> Result<Option<String>, ReadError> {
        let Some(mut expected) = self.expected.of_frame(frame)? else {
            return Ok(Some(NUMBER_OF_FRAMES.to_owned()));
        };
        if let Some(topic) = expected.other_schema {
            return Ok(Some(topic.to_owned()));
        }
        let mut found = Vec::new();
        let is_compared = |topic: &str| expected.is_stored || !is_drawing(topic);
        for (topic, log_time_ns, payload) in &messages.list {
            if !is_compared(topic) {
                continue;
            }
            let channel = self.expected.position(topic);
            // A channel that is missing from the list gives a difference.
            let payload = &messages.bytes[payload.clone()];
            found.extend(MessageHash::of(topic, channel.unwrap_or(0), *log_time_ns, payload));
        }
        add_particles(&mut found, &mut self.particles, self.expected.position(PARTICLES));
        let left_out = self.expected.position(TRAIL).filter(|_| self.first > 0);
        for hashes in [&mut expected.hashes, &mut found] {
            hashes.retain(|hash| Some(usize::from(hash.channel)) != left_out);
        }
        let length = expected.hashes.len().max(found.len());
        let differing = (0..length).find(|&index| expected.hashes.get(index) != found.get(index));
        if let Some(index) = differing {
            let hash = expected.hashes.get(index).or(found.get(index));
            let topic = hash.and_then(|hash| self.expected.topics.get(usize::from(hash.channel)));
            return Ok(Some(topic.map_or(NUMBER_OF_FRAMES, |(topic, _)| *topic).to_owned()));
        }
        Ok((!expected.has_keyframe_of(messages.model)).then(|| KEYFRAME.to_owned()))
    }
}
