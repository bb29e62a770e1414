//! What the run puts up and the viewers look at. The run never waits for a viewer here: whoever is slow misses whole frames.

use super::pace::Pace;
use super::protocol::{PlaybackRequest, PlaybackState};
use crate::interrupt::Interrupt;
use kinetoscope_recording::observer::ChannelList;
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Viewers at once.
const MOST_VIEWERS: usize = 16;
/// Frames that wait for one viewer; the oldest goes when another one comes.
const MOST_WAITING: usize = 4;
/// How soon a held run hears of Ctrl-C.
const HEARING: Duration = Duration::from_millis(50);

/// One message of a frame.
#[derive(Debug)]
pub(super) struct BroadcastMessage {
    /// Place of its channel in the channel_list.
    pub(super) channel: usize,
    pub(super) log_time_ns: u64,
    pub(super) payload: Vec<u8>,
}

/// A frame, whole, that all viewers share.
#[derive(Debug)]
pub(super) struct BroadcastFrame {
    /// Frames shown before it, of all runs.
    pub(super) number: u64,
    pub(super) log_time_ns: u64,
    pub(super) messages: Vec<Arc<BroadcastMessage>>,
}

/// A run as it is announced to viewers.
#[derive(Debug)]
pub(super) struct RunInfo {
    /// Counts the runs shown; 0 before the first.
    pub(super) session: u64,
    pub(super) name: String,
    pub(super) channel_list: ChannelList,
    /// The protocol's id of the first channel; the others follow.
    pub(super) first_channel_id: u64,
}

/// What one viewer has before it.
#[derive(Default)]
struct Mailbox {
    waiting: VecDeque<Arc<BroadcastFrame>>,
}

struct State {
    run_info: Arc<RunInfo>,
    /// Of each channel its messages in the last frame that had any: what a late viewer sees first.
    latest: BTreeMap<usize, Vec<Arc<BroadcastMessage>>>,
    frames: u64,
    time_ns: u64,
    viewers: BTreeMap<u64, Mailbox>,
    next_viewer: u64,
    /// Whether anybody has ever subscribed.
    was_watched: bool,
    pace: Pace,
    closed: Option<Instant>,
}

/// What there is to see and who sees it.
pub(super) struct FrameBuffer {
    state: Mutex<State>,
    changed: Condvar,
    interrupt: Interrupt,
    /// Whether the run keeps a pace, and viewers control it.
    pub(super) paced: bool,
}

impl FrameBuffer {
    /// An empty buffer. With a speed, in seconds of playback a second, runs are held to it.
    pub(super) fn new(speed: Option<f64>, interrupt: &Interrupt) -> Self {
        let run_info = RunInfo {
            session: 0,
            name: "no run yet".to_owned(),
            channel_list: ChannelList { channels: Vec::new(), playback_rate: 1.0, end_ns: None },
            first_channel_id: 1,
        };
        let state = State {
            run_info: Arc::new(run_info),
            latest: BTreeMap::new(),
            frames: 0,
            time_ns: 0,
            viewers: BTreeMap::new(),
            next_viewer: 0,
            was_watched: false,
            pace: Pace::new(speed.unwrap_or(1.0)),
            closed: None,
        };
        Self {
            state: Mutex::new(state),
            changed: Condvar::new(),
            interrupt: interrupt.clone(),
            paced: speed.is_some(),
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Announces a run in the place of the last one.
    pub(super) fn announce(&self, name: &str, channel_list: ChannelList) {
        let mut state = self.lock();
        let last = &state.run_info;
        let run_info = RunInfo {
            session: last.session + 1,
            name: name.to_owned(),
            first_channel_id: last.first_channel_id + last.channel_list.channels.len() as u64,
            channel_list,
        };
        state.run_info = Arc::new(run_info);
        state.latest.clear();
        state.time_ns = 0;
        state.pace.begin_run();
        state.viewers.values_mut().for_each(|mailbox| mailbox.waiting.clear());
    }

    /// Shows a frame to all who keep up.
    pub(super) fn show(&self, messages: Vec<BroadcastMessage>) {
        let Some(log_time_ns) = messages.last().map(|message| message.log_time_ns) else { return };
        let messages: Vec<Arc<BroadcastMessage>> = messages.into_iter().map(Arc::new).collect();
        let mut state = self.lock();
        for message in &messages {
            state.latest.remove(&message.channel);
        }
        for message in &messages {
            state.latest.entry(message.channel).or_default().push(Arc::clone(message));
        }
        state.frames += 1;
        state.time_ns = log_time_ns;
        let frame = Arc::new(BroadcastFrame { number: state.frames, log_time_ns, messages });
        for mailbox in state.viewers.values_mut() {
            if mailbox.waiting.len() == MOST_WAITING {
                mailbox.waiting.pop_front();
            }
            mailbox.waiting.push_back(Arc::clone(&frame));
        }
    }

    /// Holds the run until it is time for the next frame: until somebody watches, and as viewers ask for. Ctrl-C and the end
    /// of the show let it go.
    pub(super) fn hold(&self) {
        if !self.paced {
            return;
        }
        let mut state = self.lock();
        loop {
            if self.interrupt.is_raised() || state.closed.is_some() {
                return;
            }
            let wait = if state.was_watched {
                if state.viewers.is_empty() {
                    // Whoever paused the run is gone.
                    state.pace.play();
                }
                let (now, rate) = (Instant::now(), state.run_info.channel_list.playback_rate);
                let time_ns = state.time_ns;
                match state.pace.wait(now, time_ns, rate) {
                    None => return,
                    Some(wait) => wait.min(HEARING),
                }
            } else {
                HEARING
            };
            let waited = self.changed.wait_timeout(state, wait);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// A viewer comes; `None` where there are enough.
    pub(super) fn enter(&self) -> Option<u64> {
        let mut state = self.lock();
        if state.viewers.len() >= MOST_VIEWERS {
            return None;
        }
        let viewer = state.next_viewer;
        state.next_viewer += 1;
        state.viewers.insert(viewer, Mailbox::default());
        Some(viewer)
    }

    /// A viewer goes.
    pub(super) fn leave(&self, viewer: u64) {
        self.lock().viewers.remove(&viewer);
        self.changed.notify_all();
    }

    /// The run that is shown.
    pub(super) fn run_info(&self) -> Arc<RunInfo> {
        Arc::clone(&self.lock().run_info)
    }

    /// The frames that wait for a viewer.
    pub(super) fn take(&self, viewer: u64) -> VecDeque<Arc<BroadcastFrame>> {
        let mut state = self.lock();
        state
            .viewers
            .get_mut(&viewer)
            .map(|mailbox| std::mem::take(&mut mailbox.waiting))
            .unwrap_or_default()
    }

    /// Somebody watches from here on: the last messages of each of these channels, of one frame but for what is drawn once or
    /// logged, and the number of that frame.
    pub(super) fn watch(&self, channels: &[usize]) -> (Vec<Arc<BroadcastMessage>>, u64) {
        let mut state = self.lock();
        state.was_watched = true;
        self.changed.notify_all();
        let latest = channels.iter().filter_map(|channel| state.latest.get(channel)).flatten();
        (latest.cloned().collect(), state.frames)
    }

    /// Does what a viewer asks for, and says where playback is then.
    pub(super) fn control(&self, request: &PlaybackRequest) -> PlaybackState {
        let mut state = self.lock();
        let time_ns = state.time_ns;
        state.pace.control(request, time_ns);
        self.changed.notify_all();
        PlaybackState {
            jumped: request.jump_to_ns.is_some_and(|to| to > time_ns),
            ..state.playback()
        }
    }

    /// Where playback is, and how often viewers have changed it.
    pub(super) fn playback(&self) -> (PlaybackState, u64) {
        let state = self.lock();
        (state.playback(), state.pace.changes())
    }

    /// The show is over.
    pub(super) fn close(&self) {
        self.lock().closed = Some(Instant::now());
        self.changed.notify_all();
    }

    /// How long the show has been over.
    pub(super) fn closed_for(&self) -> Option<Duration> {
        self.lock().closed.map(|closed| closed.elapsed())
    }
}

impl State {
    fn playback(&self) -> PlaybackState {
        PlaybackState {
            paused: self.pace.is_paused(),
            time_ns: self.time_ns,
            speed: self.pace.speed(),
            jumped: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(index: u64) -> Vec<BroadcastMessage> {
        let message = |channel: usize| BroadcastMessage {
            channel,
            log_time_ns: index,
            payload: vec![index as u8, channel as u8],
        };
        vec![message(0), message(1), message(2)]
    }

    #[test]
    fn a_slow_viewer_misses_whole_frames_and_the_oldest() {
        let buffer = FrameBuffer::new(None, &Interrupt::default());
        let viewer = buffer.enter().unwrap();
        (0..10).for_each(|index| buffer.show(frame(index)));
        let waiting = buffer.take(viewer);
        let times: Vec<u64> = waiting.iter().map(|frame| frame.log_time_ns).collect();
        assert_eq!(times, [6, 7, 8, 9]);
        for shown in waiting {
            let whole = frame(shown.log_time_ns);
            assert_eq!(shown.messages.len(), whole.len());
            for (shown, recorded) in shown.messages.iter().zip(whole) {
                assert_eq!((shown.channel, &shown.payload), (recorded.channel, &recorded.payload));
            }
        }
        assert!(buffer.take(viewer).is_empty());
    }

    #[test]
    fn a_late_viewer_has_the_last_frame_once() {
        let buffer = FrameBuffer::new(None, &Interrupt::default());
        (0..3).for_each(|index| buffer.show(frame(index)));
        let (latest, seen) = buffer.watch(&[0, 2]);
        let latest: Vec<&[u8]> = latest.iter().map(|message| message.payload.as_slice()).collect();
        assert_eq!(latest, [[2, 0], [2, 2]]);
        let viewer = buffer.enter().unwrap();
        buffer.show(frame(3));
        let next: Vec<u64> = buffer.take(viewer).iter().map(|frame| frame.number).collect();
        assert_eq!(next, [seen + 1]);
    }

    #[test]
    fn there_is_an_end_to_viewers() {
        let buffer = FrameBuffer::new(None, &Interrupt::default());
        let viewers: Vec<u64> = (0..MOST_VIEWERS).map(|_| buffer.enter().unwrap()).collect();
        assert_eq!(buffer.enter(), None);
        buffer.leave(viewers[3]);
        assert!(buffer.enter().is_some());
    }
}
