//! Lines about the runs in progress for output that is not a terminal, so that a log shows that a long run is alive.

use kinetoscope_console::text::plural;
use std::collections::BTreeMap;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

/// Runs in progress that a line names.
const MOST_NAMED: usize = 3;

/// What is known of the runs.
#[derive(Debug)]
pub(crate) struct Activity(Mutex<Counts>);

#[derive(Debug)]
struct Counts {
    runs: usize,
    finished: usize,
    /// Runs that have no recording because of an error.
    failed: usize,
    /// Frames recorded and frames in total, by the name of each run in progress.
    running: BTreeMap<String, [u64; 2]>,
    /// About runs on other machines.
    message: String,
}

impl Activity {
    /// No run of `runs` has started.
    pub(crate) fn new(runs: usize) -> Self {
        let (running, message) = (BTreeMap::new(), String::new());
        Self(Mutex::new(Counts { runs, finished: 0, failed: 0, running, message }))
    }

    fn counts(&self) -> MutexGuard<'_, Counts> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn start(&self, run: &str) {
        self.counts().running.insert(run.to_owned(), [0, 0]);
    }

    pub(crate) fn set_frames(&self, run: &str, done: u64, of: u64) {
        if let Some(frames) = self.counts().running.get_mut(run) {
            *frames = [done, of];
        }
    }

    /// The run ended: with a recording, or with an error. Returns how many runs have failed.
    pub(crate) fn finish(&self, run: &str, has_recording: bool) -> usize {
        let mut counts = self.counts();
        counts.running.remove(run);
        if has_recording {
            counts.finished += 1;
        } else {
            counts.failed += 1;
        }
        counts.failed
    }

    /// Sets what is known of runs on other machines.
    pub(crate) fn set_remote(&self, finished: usize, message: &str) {
        let mut counts = self.counts();
        counts.finished = finished;
        message.clone_into(&mut counts.message);
    }

    /// Formats the activity in one line.
    pub(crate) fn text(&self) -> String {
        let counts = self.counts();
        let mut parts =
            vec![format!("{} of {} finished", counts.finished, plural(counts.runs as u64, "run"))];
        if counts.failed > 0 {
            parts.push(format!("{} failed", counts.failed));
        }
        parts.extend(counts.running.iter().take(MOST_NAMED).map(|(run, [done, of])| {
            if *of == 0 {
                format!("{run} starts")
            } else {
                format!("{run} at frame {done} of {of}")
            }
        }));
        let more = counts.running.len().saturating_sub(MOST_NAMED);
        if more > 0 {
            parts.push(format!("{more} more in progress"));
        }
        if !counts.message.is_empty() {
            parts.push(counts.message.clone());
        }
        parts.join(", ")
    }
}

/// Calls a function at intervals, on a thread of its own, until it is dropped.
#[derive(Debug)]
pub(crate) struct Heartbeat {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Heartbeat {
    /// The first call is after one interval.
    pub(crate) fn start(interval: Duration, beat: impl Fn() + Send + 'static) -> Self {
        let (stop, stopped) = mpsc::channel::<()>();
        let beats = move || {
            while stopped.recv_timeout(interval) == Err(RecvTimeoutError::Timeout) {
                beat();
            }
        };
        // Without a thread for them, there are no calls.
        Self { stop: Some(stop), thread: Builder::new().spawn(beats).ok() }
    }
}

impl Drop for Heartbeat {
    fn drop(&mut self) {
        // The thread ends when its channel closes.
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            // A panic of the thread has been reported already.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn line_names_the_runs_in_progress() {
        let activity = Activity::new(7);
        assert_eq!(activity.text(), "0 of 7 runs finished");
        for run in ["a", "b", "c", "d", "e"] {
            activity.start(run);
        }
        activity.set_frames("b", 3, 40);
        activity.finish("a", true);
        let expected =
            "1 of 7 runs finished, b at frame 3 of 40, c starts, d starts, 1 more in progress";
        assert_eq!(activity.text(), expected);
        activity.finish("b", false);
        assert!(activity.text().starts_with("1 of 7 runs finished, 1 failed, c starts"));
        activity.set_remote(5, "2 waiting");
        assert!(activity.text().starts_with("5 of 7 ") && activity.text().ends_with(", 2 waiting"));
    }

    /// Lines come as long as the heartbeat exists, and none comes after it.
    #[test]
    fn heartbeat_repeats_until_it_is_dropped() {
        let (sender, lines) = mpsc::channel();
        let activity = Arc::new(Activity::new(1));
        let heartbeat = Heartbeat::start(Duration::from_millis(1), move || {
            // The receiver outlives the heartbeat.
            sender.send(activity.text()).unwrap();
        });
        for _ in 0..3 {
            assert_eq!(lines.recv().unwrap(), "0 of 1 run finished");
        }
        drop(heartbeat);
        // The thread has ended, and with it the sender.
        while lines.try_recv().is_ok() {}
        assert_eq!(lines.try_recv(), Err(mpsc::TryRecvError::Disconnected));
    }
}
