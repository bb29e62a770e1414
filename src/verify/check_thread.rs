//! A check of messages on a thread of its own: hashing them takes about as long as compressing them.

use crate::verify::rerun_check::RerunCheck;
use kinetoscope_recording::observer::{ChannelList, FrameObserver};
use std::mem::take;
use std::ops::Range;
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::thread::{Builder, JoinHandle};

/// Frames that wait for the check. With the one that is checked and the one that is filled, memory holds one more than this twice.
const WAITING: usize = 2;

/// The messages of a frame.
#[derive(Default)]
struct Messages {
    list: Vec<(&'static str, u64, Range<usize>)>,
    bytes: Vec<u8>,
}

impl Messages {
    fn show_to(&self, check: &mut RerunCheck) {
        for (topic, log_time_ns, range) in &self.list {
            check.message(topic, *log_time_ns, &self.bytes[range.clone()]);
        }
        check.end_of_frame();
    }

    fn clear(&mut self) {
        self.list.clear();
        self.bytes.clear();
    }
}

/// Passes the messages of each frame to a check on another thread. When this value is dropped, it waits for the check.
pub(crate) struct CheckThread {
    /// The check until it has its thread, and without one if none can be started.
    check: Option<RerunCheck>,
    frame: Messages,
    frames: Option<SyncSender<Messages>>,
    checked: Option<Receiver<Messages>>,
    thread: Option<JoinHandle<()>>,
}

impl CheckThread {
    pub(crate) fn new(check: RerunCheck) -> Self {
        Self {
            check: Some(check),
            frame: Messages::default(),
            frames: None,
            checked: None,
            thread: None,
        }
    }
}

fn work(mut check: RerunCheck, frames: &Receiver<Messages>, give_back: &Sender<Messages>) {
    for mut frame in frames {
        frame.show_to(&mut check);
        frame.clear();
        // An error means that no further frame follows.
        drop(give_back.send(frame));
    }
}

impl FrameObserver for CheckThread {
    fn begin(&mut self, channel_list: ChannelList) {
        let Some(mut check) = self.check.take() else { return };
        check.begin(channel_list);
        let (frames, waiting) = sync_channel(WAITING);
        let (give_back, checked) = channel();
        // The check is moved only into a thread that exists.
        let (hand_over, take_over) = channel();
        let body = move || {
            if let Ok(check) = take_over.recv() {
                work(check, &waiting, &give_back);
            }
        };
        match Builder::new().name("check".to_owned()).spawn(body) {
            Ok(thread) => {
                (self.frames, self.checked, self.thread) =
                    (Some(frames), Some(checked), Some(thread));
                drop(hand_over.send(check));
            }
            Err(_) => self.check = Some(check),
        }
    }

    fn message(&mut self, topic: &'static str, log_time_ns: u64, payload: &[u8]) {
        let start = self.frame.bytes.len();
        self.frame.bytes.extend_from_slice(payload);
        self.frame.list.push((topic, log_time_ns, start..self.frame.bytes.len()));
    }

    fn end_of_frame(&mut self) {
        if let Some(check) = &mut self.check {
            self.frame.show_to(check);
            self.frame.clear();
        }
        if let Some(frames) = &self.frames {
            // An error means that the thread has panicked, which is reported; the number of equal frames is then too small.
            drop(frames.send(take(&mut self.frame)));
            let used = self.checked.as_ref().and_then(|checked| checked.try_recv().ok());
            self.frame = used.unwrap_or_default();
        }
    }
}

impl Drop for CheckThread {
    fn drop(&mut self) {
        self.frames = None;
        if let Some(thread) = self.thread.take() {
            drop(thread.join());
        }
    }
}
