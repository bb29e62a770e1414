//! Guarantee: with `draw_every = k`, every k-th frame is drawn, and the first and the last one, as without it. All other messages are
//! those of every frame, moving walls among them, and an observer receives what is recorded.
//!
//! Control: with k = 1, every frame is drawn.

#![allow(clippy::unwrap_used, reason = "a test's own failure")]

use crate::sample::{fill, header, time_of};
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::keyframe::is_drawing;
use kinetoscope_recording::observer::{ChannelList, FrameObserver};
use kinetoscope_recording::reader::{RecordedFrame, Recording};
use kinetoscope_recording::recorder::{Clock, Compression, Header, Outcome, Recorder};
use kinetoscope_recording::scenery::Wall;
use std::num::NonZeroU64;
use std::path::Path;
use std::sync::{Arc, Mutex};

const FRAMES: u64 = 24;

type Seen = Arc<Mutex<Vec<(String, u64, Vec<u8>)>>>;

/// Keeps topic, log time and payload of each message.
struct Keeper(Seen);

impl FrameObserver for Keeper {
    fn begin(&mut self, _: ChannelList) {}

    fn message(&mut self, topic: &'static str, log_time_ns: u64, payload: &[u8]) {
        self.0.lock().unwrap().push((topic.to_owned(), log_time_ns, payload.to_vec()));
    }

    fn end_of_frame(&mut self) {}
}

/// The frames of a recording in which every k-th frame is drawn, and what an observer has seen.
fn frames(k: u64) -> (Vec<RecordedFrame>, Seen) {
    let header = Header {
        draw_every: NonZeroU64::new(k).unwrap(),
        frames_expected: Some(FRAMES),
        ..header(Compression::Zstd)
    };
    let seen = Seen::default();
    let bytes = [true, false].map(|is_observed| {
        let mut recorder = Recorder::create(Vec::new(), &header).unwrap();
        if is_observed {
            recorder.show_to(Box::new(Keeper(Arc::clone(&seen)))).unwrap();
        }
        let mut frame = Frame::new();
        for index in 0..FRAMES {
            fill(&mut frame, index, 50);
            frame.push_wall(Wall::Circle { center: [0.0, 0.0], radius: time_of(index) + 1.0 });
            recorder.write(Clock { count: 10 * index, time: time_of(index) }, &mut frame).unwrap();
        }
        recorder.finish(&Outcome::Complete).unwrap()
    });
    let [observed, bytes] = bytes;
    assert!(observed == bytes);
    let recording = Recording::from_bytes(bytes, Path::new("sample.mcap")).unwrap();
    (recording.frames().unwrap().map(Result::unwrap).collect(), seen)
}

#[test]
fn every_kth_frame_is_drawn_and_all_states_are_recorded() {
    let (all, _) = frames(1);
    for k in [1, 3, 23, 24, u64::MAX] {
        let (found, seen) = frames(k);
        assert_eq!(found.len() as u64, FRAMES);
        for (index, (frame, whole)) in (0..).zip(found.iter().zip(&all)) {
            let is_drawn = index % k == 0 || index + 1 == FRAMES;
            let expected = whole.messages().iter().filter(|message| {
                is_drawn || message.topic() == "/walls" || !is_drawing(message.topic())
            });
            let of = |message: &&kinetoscope_recording::reader::RecordedMessage| {
                // The first line of the log names the distance.
                let is_facts = index == 0 && message.topic() == "/log";
                (message.topic().to_owned(), (!is_facts).then(|| message.payload().to_vec()))
            };
            let recorded = frame.messages().iter();
            assert!(
                recorded.map(|m| of(&m)).eq(expected.map(|m| of(&m))),
                "k = {k}, frame {index}"
            );
            assert!(frame.state().is_some() && frame.state() == whole.state());
        }
        let fact = format!("one frame in {k} is drawn");
        let is_named = found[0].log_lines().iter().any(|line| line.text.starts_with(&fact));
        assert_eq!(is_named, k > 1, "k = {k}");
        let recorded = found.iter().flat_map(RecordedFrame::messages).map(|message| {
            (message.topic().to_owned(), message.log_time_ns(), message.payload().to_vec())
        });
        let mut recorded: Vec<_> = recorded.collect();
        let mut seen = seen.lock().unwrap().clone();
        recorded.sort();
        seen.sort();
        assert!(recorded == seen, "k = {k}");
    }
}
