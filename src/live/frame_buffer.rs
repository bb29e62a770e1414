//! The frames between the run and its viewers. The run never waits for a viewer; a slow viewer misses whole frames.

use super::pace::Pace;
use super::protocol::{PlaybackRequest, PlaybackState};
use crate::interrupt::Interrupt;
use kinetoscope_recording::channels::LOG;
use kinetoscope_recording::observer::ChannelList;
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Maximum length of a viewer's queue; a new frame displaces the oldest one.
const MAX_QUEUED_FRAMES: usize = 4;
/// Maximum number of messages of the log that a late viewer receives: the first, with the lines of the start, and the newest.
const MAX_LOG_MESSAGES: usize = 256;
/// Interval at which a held run checks for Ctrl-C.
const INTERRUPT_INTERVAL: Duration = Duration::from_millis(50);
/// Time after the end of the broadcast in which viewers receive the last frame and close.
const CLOSING: Duration = Duration::from_millis(1500);
/// The same after Ctrl-C.
const CLOSING_INTERRUPTED: Duration = Duration::from_millis(250);

/// One message of a frame.
#[derive(Debug)]
pub(super) struct BroadcastMessage {
    /// Index of its channel in the list.
    pub(super) channel: usize,
    pub(super) log_time_ns: u64,
    pub(super) payload: Vec<u8>,
}

/// A complete frame, shared by all viewers.
#[derive(Debug)]
pub(super) struct BroadcastFrame {
    /// Number of frames broadcast so far, over all runs.
    pub(super) number: u64,
    /// The run, as in [`RunInfo`].
    pub(super) session: u64,
    pub(super) log_time_ns: u64,
    pub(super) messages: Vec<Arc<BroadcastMessage>>,
}

/// The run that is announced to viewers.
#[derive(Debug)]
pub(super) struct RunInfo {
    /// Number of runs announced; 0 before the first.
    pub(super) session: u64,
    pub(super) name: String,
    pub(super) channel_list: ChannelList,
    /// The protocol's id of the first channel; the ids are consecutive.
    pub(super) first_channel_id: u64,
}

/// The frames queued for one viewer.
#[derive(Default)]
struct Mailbox {
    queue: VecDeque<Arc<BroadcastFrame>>,
}

struct State {
    run_info: Arc<RunInfo>,
    /// For each channel, the messages of the last frame that had any; of the log, those of all frames. A late viewer receives them
    /// first.
    latest: BTreeMap<usize, Vec<Arc<BroadcastMessage>>>,
    frames: u64,
    time_ns: u64,
    viewers: BTreeMap<u64, Mailbox>,
    next_viewer: u64,
    /// Whether any viewer has subscribed.
    has_subscriber: bool,
    pace: Pace,
    /// The viewer that paused the run.
    paused_by: Option<u64>,
    closed: Option<Instant>,
}

/// The announced run, its latest frames and the viewers' queues.
pub(super) struct FrameBuffer {
    state: Mutex<State>,
    changed: Condvar,
    interrupt: Interrupt,
    /// Whether the run is held to a speed that viewers control.
    pub(super) is_paced: bool,
}

impl FrameBuffer {
    /// Creates an empty buffer. Runs are held to `speed`, in seconds of playback per second, if there is one.
    pub(super) fn new(speed: Option<f64>, interrupt: &Interrupt) -> Self {
        let run_info = RunInfo {
            session: 0,
            name: "no run yet".to_owned(),
            channel_list: ChannelList { channels: Vec::new(), playback_fps: 1.0, end_ns: None },
            first_channel_id: 1,
        };
        let state = State {
            run_info: Arc::new(run_info),
            latest: BTreeMap::new(),
            frames: 0,
            time_ns: 0,
            viewers: BTreeMap::new(),
            next_viewer: 0,
            has_subscriber: false,
            pace: Pace::new(speed.unwrap_or(1.0)),
            paused_by: None,
            closed: None,
        };
        Self {
            state: Mutex::new(state),
            changed: Condvar::new(),
            interrupt: interrupt.clone(),
            is_paced: speed.is_some(),
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Announces a run, which replaces the previous one.
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
        state.viewers.values_mut().for_each(|mailbox| mailbox.queue.clear());
    }

    /// Queues a frame for all viewers.
    pub(super) fn broadcast(&self, messages: Vec<BroadcastMessage>) {
        let Some(log_time_ns) = messages.last().map(|message| message.log_time_ns) else { return };
        let messages: Vec<Arc<BroadcastMessage>> = messages.into_iter().map(Arc::new).collect();
        let mut state = self.lock();
        state.keep_for_late_viewers(&messages);
        state.frames += 1;
        state.time_ns = log_time_ns;
        let (number, session) = (state.frames, state.run_info.session);
        let frame = Arc::new(BroadcastFrame { number, session, log_time_ns, messages });
        for mailbox in state.viewers.values_mut() {
            if mailbox.queue.len() == MAX_QUEUED_FRAMES {
                mailbox.queue.pop_front();
            }
            mailbox.queue.push_back(Arc::clone(&frame));
        }
    }

    /// Blocks the run until the next frame is due: until the first viewer subscribes, and according to speed and pause. Ctrl-C and
    /// the end of the server release the run.
    pub(super) fn hold(&self) {
        if !self.is_paced {
            return;
        }
        let mut state = self.lock();
        loop {
            if self.interrupt.is_raised() || state.closed.is_some() {
                return;
            }
            let wait = if state.has_subscriber {
                let (now, rate) = (Instant::now(), state.run_info.channel_list.playback_fps);
                let time_ns = state.time_ns;
                match state.pace.wait(now, time_ns, rate) {
                    None => return,
                    Some(wait) => wait.min(INTERRUPT_INTERVAL),
                }
            } else {
                INTERRUPT_INTERVAL
            };
            let waited = self.changed.wait_timeout(state, wait);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Adds a viewer.
    pub(super) fn add_viewer(&self) -> u64 {
        let mut state = self.lock();
        let viewer = state.next_viewer;
        state.next_viewer += 1;
        state.viewers.insert(viewer, Mailbox::default());
        viewer
    }

    /// Removes a viewer, and ends its pause.
    pub(super) fn remove_viewer(&self, viewer: u64) {
        let mut state = self.lock();
        state.viewers.remove(&viewer);
        if state.paused_by == Some(viewer) {
            state.paused_by = None;
            state.pace.play();
        }
        self.changed.notify_all();
    }

    /// The announced run, and the log time of its last broadcast frame in ns.
    pub(super) fn run_info(&self) -> (Arc<RunInfo>, u64) {
        let state = self.lock();
        (Arc::clone(&state.run_info), state.time_ns)
    }

    /// Takes the frames queued for a viewer.
    pub(super) fn take(&self, viewer: u64) -> VecDeque<Arc<BroadcastFrame>> {
        let mut state = self.lock();
        state
            .viewers
            .get_mut(&viewer)
            .map(|mailbox| std::mem::take(&mut mailbox.queue))
            .unwrap_or_default()
    }

    /// Subscribes to channels of a run. Returns their last messages, none if another run was announced, and the number of the last
    /// frame. The messages are from one frame, except for channels that are drawn once, and for the log.
    pub(super) fn subscribe(
        &self,
        session: u64,
        channels: &[usize],
    ) -> (Vec<Arc<BroadcastMessage>>, u64) {
        let mut state = self.lock();
        state.has_subscriber = true;
        self.changed.notify_all();
        if session != state.run_info.session {
            return (Vec::new(), state.frames);
        }
        let latest = channels.iter().filter_map(|channel| state.latest.get(channel)).flatten();
        (latest.cloned().collect(), state.frames)
    }

    /// Executes a viewer's request and returns the new playback state.
    pub(super) fn control(&self, viewer: u64, request: &PlaybackRequest) -> PlaybackState {
        let mut state = self.lock();
        let time_ns = state.time_ns;
        state.pace.control(request, time_ns);
        state.paused_by = state.pace.is_paused().then_some(viewer);
        self.changed.notify_all();
        PlaybackState {
            jumped: request.jump_to_ns.is_some_and(|to| to > time_ns),
            ..state.playback()
        }
    }

    /// The playback state and the number of changes by viewers.
    pub(super) fn playback(&self) -> (PlaybackState, u64) {
        let state = self.lock();
        (state.playback(), state.pace.changes())
    }

    /// Ends the broadcast.
    pub(super) fn close(&self) {
        self.lock().closed = Some(Instant::now());
        self.changed.notify_all();
    }

    /// Whether the broadcast has ended, so that viewers receive the last frames and close.
    pub(super) fn is_closed(&self) -> bool {
        self.lock().closed.is_some()
    }

    /// Whether the time for closing has passed, so that all connections end.
    pub(super) fn is_over(&self) -> bool {
        let limit = if self.interrupt.is_raised() { CLOSING_INTERRUPTED } else { CLOSING };
        self.lock().closed.is_some_and(|closed| closed.elapsed() >= limit)
    }
}

impl State {
    fn keep_for_late_viewers(&mut self, messages: &[Arc<BroadcastMessage>]) {
        let log =
            self.run_info.channel_list.channels.iter().position(|channel| channel.topic == LOG);
        for message in messages.iter().filter(|message| Some(message.channel) != log) {
            self.latest.remove(&message.channel);
        }
        for message in messages {
            self.latest.entry(message.channel).or_default().push(Arc::clone(message));
        }
        let Some(kept) = log.and_then(|log| self.latest.get_mut(&log)) else { return };
        let excess = kept.len().saturating_sub(MAX_LOG_MESSAGES);
        kept.drain(1..=excess);
    }

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
    use kinetoscope_recording::observer::ChannelInfo;

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
        let viewer = buffer.add_viewer();
        (0..10).for_each(|index| buffer.broadcast(frame(index)));
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
        (0..3).for_each(|index| buffer.broadcast(frame(index)));
        let (latest, seen) = buffer.subscribe(0, &[0, 2]);
        let latest: Vec<&[u8]> = latest.iter().map(|message| message.payload.as_slice()).collect();
        assert_eq!(latest, [[2, 0], [2, 2]]);
        let viewer = buffer.add_viewer();
        buffer.broadcast(frame(3));
        let next: Vec<u64> = buffer.take(viewer).iter().map(|frame| frame.number).collect();
        assert_eq!(next, [seen + 1]);
    }

    #[test]
    fn a_late_viewer_has_the_log_of_the_start_and_the_newest_lines() {
        let buffer = FrameBuffer::new(None, &Interrupt::default());
        let channel = |topic| ChannelInfo { topic, schema_name: String::new(), schema: Vec::new() };
        let channels = ["/frame", LOG].map(channel).to_vec();
        buffer.announce("run", ChannelList { channels, playback_fps: 1.0, end_ns: None });
        let frames = MAX_LOG_MESSAGES as u64 + 10;
        for log_time_ns in 0..frames {
            let message = |channel| BroadcastMessage { channel, log_time_ns, payload: Vec::new() };
            // Every other of the last frames has no line.
            let has_line = log_time_ns + 4 < frames || log_time_ns % 2 == 0;
            let messages = if has_line { vec![message(0), message(1)] } else { vec![message(0)] };
            buffer.broadcast(messages);
        }
        let times = |channel: usize| -> Vec<u64> {
            let (latest, _) = buffer.subscribe(1, &[channel]);
            latest.iter().map(|message| message.log_time_ns).collect()
        };
        assert_eq!(times(0), [frames - 1]);
        let log = times(1);
        assert_eq!(log.len(), MAX_LOG_MESSAGES);
        assert_eq!(log[..2], [0, 9]);
        assert_eq!(log[log.len() - 2..], [frames - 4, frames - 2]);
        buffer.announce(
            "next",
            ChannelList { channels: Vec::new(), playback_fps: 1.0, end_ns: None },
        );
        assert!(buffer.subscribe(2, &[0, 1]).0.is_empty());
    }

    #[test]
    fn pause_ends_with_the_viewer_that_asked_for_it() {
        let buffer = FrameBuffer::new(Some(1.0), &Interrupt::default());
        let (asking, silent) = (buffer.add_viewer(), buffer.add_viewer());
        let request =
            PlaybackRequest { pause: true, speed: 1.0, jump_to_ns: None, id: String::new() };
        assert!(buffer.control(asking, &request).paused);
        buffer.remove_viewer(silent);
        assert!(buffer.playback().0.paused);
        let silent = buffer.add_viewer();
        buffer.remove_viewer(asking);
        assert!(!buffer.playback().0.paused, "viewer {silent} did not ask for a pause");
    }
}
