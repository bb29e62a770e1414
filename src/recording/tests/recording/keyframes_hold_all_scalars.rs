//! Guarantee: a recording of keyframes has the scalars of every frame, bit for bit, and of the frames between keyframes a hash of the
//! state, but none of a drawing. An observer, which receives the drawings, changes no byte.
//!
//! Control: the recording of all frames has states and drawings in each of them.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use crate::sample::{fill, header, record, time_of};
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::keyframe::{FrameHashes, KEYFRAME, Keyframe, MessageHash, is_drawing};
use kinetoscope_recording::observer::{ChannelList, FrameObserver};
use kinetoscope_recording::reader::{RecordedFrame, Recording, StoredFrames};
use kinetoscope_recording::recorder::{Clock, Compression, Header, Outcome, Recorder};
use std::num::NonZeroU64;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

const FRAMES: u64 = 24;
const DISTANCE: u64 = 5;

fn header_of_keyframes() -> Header {
    let stored = StoredFrames::Keyframes(NonZeroU64::new(DISTANCE).unwrap());
    Header { stored, frames_expected: Some(FRAMES), ..header(Compression::Zstd) }
}

fn frames(bytes: Vec<u8>) -> Vec<RecordedFrame> {
    let recording = Recording::from_bytes(bytes, Path::new("sample.mcap")).unwrap();
    recording.frames().unwrap().with_scalar_frames().map(Result::unwrap).collect()
}

/// Topics and payloads of a frame that a filter selects.
fn payloads(frame: &RecordedFrame, is_wanted: impl Fn(&str) -> bool) -> Vec<(String, Vec<u8>)> {
    let messages = frame.messages().iter().filter(|message| is_wanted(message.topic()));
    messages.map(|message| (message.topic().to_owned(), message.payload().to_vec())).collect()
}

#[test]
fn scalars_of_all_frames_are_stored_and_only_states_are_hashed() {
    let keys = frames(record(&header_of_keyframes(), FRAMES, 50));
    let all = Header { frames_expected: Some(FRAMES), ..header(Compression::Zstd) };
    let all = frames(record(&all, FRAMES, 50));
    assert_eq!((keys.len(), all.len()), (FRAMES as usize, FRAMES as usize));
    let is_scalar =
        |topic: &str| !["/particles", "/state", KEYFRAME].contains(&topic) && !is_drawing(topic);
    let mut hashes = Vec::new();
    let particles = payloads(&all[0], |topic| topic == "/particles");
    for (index, (key, full)) in (0..).zip(keys.iter().zip(&all)) {
        assert_eq!(payloads(key, is_scalar), payloads(full, is_scalar), "frame {index}");
        assert!(!payloads(full, is_drawing).is_empty() && full.state().is_some(), "control");
        let is_keyframe = index % DISTANCE == 0 || index + 1 == FRAMES;
        assert_eq!(key.is_complete(), is_keyframe, "frame {index}");
        if is_keyframe {
            // A recording of all frames has the particles in the first one.
            let is_model = |topic: &str| ![KEYFRAME, "/particles"].contains(&topic);
            assert_eq!(payloads(key, |topic| topic == "/particles"), particles, "frame {index}");
            assert_eq!(payloads(key, is_model), payloads(full, is_model), "frame {index}");
            let keyframe = payloads(key, |topic| topic == KEYFRAME).remove(0).1;
            hashes.extend(FrameHashes::new(Keyframe::from_bytes(&keyframe).unwrap().hashes));
        } else {
            assert!(key.messages().iter().all(|message| is_scalar(message.topic())));
        }
    }
    let expected = all.iter().zip(&keys).filter(|(_, key)| !key.is_complete()).map(|(full, _)| {
        let state = full.messages().iter().find(|message| message.topic() == "/state").unwrap();
        // The channels after the clock.
        let particles = MessageHash::of("/particles", 1, 0, &particles[0].1);
        let state = MessageHash::of("/state", 2, state.log_time_ns(), state.payload());
        Ok(vec![particles.unwrap(), state.unwrap()])
    });
    assert!(hashes.into_iter().eq(expected));
}

/// Counts drawings.
struct Drawings(Arc<AtomicUsize>);

impl FrameObserver for Drawings {
    fn begin(&mut self, _: ChannelList) {}

    fn message(&mut self, topic: &'static str, _: u64, _: &[u8]) {
        self.0.fetch_add(usize::from(topic == "/discs"), Ordering::Relaxed);
    }

    fn end_of_frame(&mut self) {}
}

#[test]
fn observer_sees_all_drawings_and_changes_no_byte() {
    let header = header_of_keyframes();
    let mut recorder = Recorder::create(Vec::new(), &header).unwrap();
    let seen = Arc::new(AtomicUsize::new(0));
    recorder.show_to(Box::new(Drawings(Arc::clone(&seen)))).unwrap();
    let mut frame = Frame::new();
    for index in 0..FRAMES {
        fill(&mut frame, index, 50);
        recorder.write(Clock { count: 10 * index, time: time_of(index) }, &mut frame).unwrap();
    }
    assert!(recorder.finish(&Outcome::Complete).unwrap() == record(&header, FRAMES, 50));
    assert_eq!(seen.load(Ordering::Relaxed) as u64, FRAMES);
}
