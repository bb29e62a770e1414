//! Selection of the frames of one run that viewers receive.

use super::frame_buffer::BroadcastMessage;
use super::viewer::Service;
use kinetoscope_recording::channels::LOG;
use kinetoscope_recording::observer::{ChannelList, FrameObserver};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Broadcasts the frames of one run.
pub(super) struct Broadcaster {
    service: Arc<Service>,
    /// Cleared when this run ends, so that the next one can be broadcast.
    taken: Arc<AtomicBool>,
    name: String,
    channels: BTreeMap<&'static str, usize>,
    end_ns: Option<u64>,
    /// Minimum time between two broadcast frames.
    interval: Duration,
    shown: Option<Instant>,
    /// The frame that is being recorded.
    frame: Option<Selection>,
    /// Messages of the current frame that are to be broadcast.
    messages: Vec<BroadcastMessage>,
}

/// Whether the current frame is broadcast.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Selection {
    Broadcast,
    /// Only messages of the log are kept.
    Skipped,
}

impl Broadcaster {
    pub(super) fn new(service: Arc<Service>, taken: Arc<AtomicBool>, name: &str) -> Self {
        Self {
            service,
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

    /// Selects all frames of a paced run; otherwise as many as the playback shows in the same time, and the last one.
    fn selection_at(&self, log_time_ns: u64) -> Selection {
        let due = self.shown.is_none_or(|shown| shown.elapsed() >= self.interval);
        if self.service.buffer.is_paced || due || self.end_ns == Some(log_time_ns) {
            Selection::Broadcast
        } else {
            Selection::Skipped
        }
    }
}

impl FrameObserver for Broadcaster {
    fn begin(&mut self, channel_list: ChannelList) {
        let topics = channel_list.channels.iter().map(|channel| channel.topic);
        self.channels = topics.enumerate().map(|(place, topic)| (topic, place)).collect();
        self.end_ns = channel_list.end_ns;
        self.interval =
            Duration::try_from_secs_f64(1.0 / channel_list.playback_fps).unwrap_or(Duration::MAX);
        self.service.buffer.announce(&self.name, channel_list);
    }

    fn message(&mut self, topic: &'static str, log_time_ns: u64, payload: &[u8]) {
        let selection = self.frame.unwrap_or_else(|| self.selection_at(log_time_ns));
        self.frame = Some(selection);
        let Some(&channel) = self.channels.get(topic) else { return };
        if selection == Selection::Broadcast || topic == LOG {
            self.messages.push(BroadcastMessage {
                channel,
                log_time_ns,
                payload: payload.to_vec(),
            });
        }
    }

    fn end_of_frame(&mut self) {
        if self.frame.take() == Some(Selection::Broadcast) {
            self.shown = Some(Instant::now());
            self.service.buffer.broadcast(std::mem::take(&mut self.messages));
        }
        self.service.buffer.hold();
    }
}

impl Drop for Broadcaster {
    /// Broadcasts a line of the log that followed the last frame; an incomplete frame is dropped.
    fn drop(&mut self) {
        let log = self.channels.get(LOG);
        self.messages.retain(|message| Some(&message.channel) == log);
        self.service.buffer.broadcast(std::mem::take(&mut self.messages));
        self.taken.store(false, Ordering::Release);
    }
}
