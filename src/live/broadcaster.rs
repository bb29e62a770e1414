//! What of a run is put on the buffer, and when.

use super::frame_buffer::{BroadcastMessage, FrameBuffer};
use kinetoscope_recording::channels::LOG;
use kinetoscope_recording::observer::{ChannelList, FrameObserver};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Shows one run.
pub(super) struct Broadcaster {
    buffer: Arc<FrameBuffer>,
    /// Unset when this run makes room for the next one.
    taken: Arc<AtomicBool>,
    name: String,
    channels: BTreeMap<&'static str, usize>,
    end_ns: Option<u64>,
    /// Between two frames that are shown, by the clock.
    interval: Duration,
    shown: Option<Instant>,
    /// The frame that is being recorded.
    frame: Option<Progress>,
    /// What was drawn or logged, and is to be shown.
    messages: Vec<BroadcastMessage>,
}

/// Whether a frame under way is to be shown.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Progress {
    Wanted,
    /// Of it only the log is kept.
    PassedOver,
}

impl Broadcaster {
    pub(super) fn new(buffer: Arc<FrameBuffer>, taken: Arc<AtomicBool>, name: &str) -> Self {
        Self {
            buffer,
            taken,
            name: name.to_owned(),
            channels: BTreeMap::new(),
            end_ns: None,
            interval: Duration::ZERO,
            shown: None,
            frame: None,
            messages: Vec::new(),
        }
    }

    /// A run that keeps a pace shows all frames; another one as many as playback has, and the last.
    fn progress_at(&self, log_time_ns: u64) -> Progress {
        let due = self.shown.is_none_or(|shown| shown.elapsed() >= self.interval);
        if self.buffer.paced || due || self.end_ns == Some(log_time_ns) {
            Progress::Wanted
        } else {
            Progress::PassedOver
        }
    }
}

impl FrameObserver for Broadcaster {
    fn begin(&mut self, channel_list: ChannelList) {
        let topics = channel_list.channels.iter().map(|channel| channel.topic);
        self.channels = topics.enumerate().map(|(place, topic)| (topic, place)).collect();
        self.end_ns = channel_list.end_ns;
        self.interval =
            Duration::try_from_secs_f64(1.0 / channel_list.playback_rate).unwrap_or(Duration::MAX);
        self.buffer.announce(&self.name, channel_list);
    }

    fn message(&mut self, topic: &'static str, log_time_ns: u64, payload: &[u8]) {
        let progress = self.frame.unwrap_or_else(|| self.progress_at(log_time_ns));
        self.frame = Some(progress);
        let Some(&channel) = self.channels.get(topic) else { return };
        if progress == Progress::Wanted || topic == LOG {
            self.messages.push(BroadcastMessage {
                channel,
                log_time_ns,
                payload: payload.to_vec(),
            });
        }
    }

    fn end_of_frame(&mut self) {
        if self.frame.take() == Some(Progress::Wanted) {
            self.shown = Some(Instant::now());
            self.buffer.show(std::mem::take(&mut self.messages));
        }
        self.buffer.hold();
    }
}

impl Drop for Broadcaster {
    /// A last word of the log may have come after the last frame; a frame that was cut short is not shown.
    fn drop(&mut self) {
        let log = self.channels.get(LOG);
        self.messages.retain(|message| Some(&message.channel) == log);
        self.buffer.show(std::mem::take(&mut self.messages));
        self.taken.store(false, Ordering::Release);
    }
}
