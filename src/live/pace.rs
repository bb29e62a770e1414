//! The time at which a run that is held to a speed may continue.

use super::protocol::PlaybackRequest;
use std::time::{Duration, Instant};

/// Minimum speed, in seconds of playback per second.
pub(super) const SLOWEST: f64 = 0.01;
/// Maximum speed, in seconds of playback per second.
pub(super) const FASTEST: f64 = 100.0;

/// Maximum time between two frames.
const LONGEST: Duration = Duration::from_secs(86_400);

/// Speed, pauses and steps.
#[derive(Debug)]
pub(super) struct Pace {
    speed: f64,
    paused: bool,
    /// Log time up to which the run does not wait, ns: the target of a viewer's jump or step.
    run_to_ns: u64,
    /// Time at which the last frame was due.
    due: Option<Instant>,
    changes: u64,
}

impl Pace {
    pub(super) fn new(speed: f64) -> Self {
        Self { speed, paused: false, run_to_ns: 0, due: None, changes: 0 }
    }

    /// Starts another run at log time 0 and the same speed.
    pub(super) fn begin_run(&mut self) {
        self.run_to_ns = 0;
        self.due = None;
    }

    pub(super) fn speed(&self) -> f64 {
        self.speed
    }

    pub(super) fn is_paused(&self) -> bool {
        self.paused
    }

    /// Number of changes by viewers.
    pub(super) fn changes(&self) -> u64 {
        self.changes
    }

    /// Ends a pause.
    pub(super) fn play(&mut self) {
        if self.paused {
            self.paused = false;
            self.changes += 1;
        }
    }

    /// Executes a viewer's request at a log time. A jump backward is ignored, because the run cannot go back.
    pub(super) fn control(&mut self, request: &PlaybackRequest, time_ns: u64) {
        let speed = f64::from(request.speed);
        if (SLOWEST..=FASTEST).contains(&speed) {
            self.speed = speed;
        }
        self.paused = request.pause;
        if let Some(to) = request.jump_to_ns.filter(|&to| to > time_ns) {
            self.run_to_ns = to;
        }
        self.changes += 1;
    }

    /// Time to wait after the frame at this log time; `None` if the next one is due.
    pub(super) fn wait(
        &mut self,
        now: Instant,
        time_ns: u64,
        playback_fps: f64,
    ) -> Option<Duration> {
        if time_ns < self.run_to_ns {
            self.due = Some(now);
            return None;
        }
        if self.paused {
            self.due = Some(now);
            return Some(Duration::MAX);
        }
        let interval = Duration::try_from_secs_f64(1.0 / (playback_fps * self.speed));
        let interval = interval.unwrap_or(LONGEST).min(LONGEST);
        let due = *self.due.get_or_insert(now) + interval;
        if due > now {
            return Some(due - now);
        }
        // A delay of more than one interval is not caught up.
        self.due = Some(if now - due > interval { now } else { due });
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME_NS: u64 = 40_000_000;

    fn request(pause: bool, speed: f32, jump_to_ns: Option<u64>) -> PlaybackRequest {
        PlaybackRequest { pause, speed, jump_to_ns, id: String::new() }
    }

    #[test]
    fn frames_are_due_at_the_playback_rate_times_the_speed() {
        let start = Instant::now();
        let after = |ms: u64| start + Duration::from_millis(ms);
        let mut pace = Pace::new(2.0);
        assert_eq!(pace.wait(start, 0, 25.0), Some(Duration::from_millis(20)));
        assert_eq!(pace.wait(after(19), 0, 25.0), Some(Duration::from_millis(1)));
        assert_eq!(pace.wait(after(23), 0, 25.0), None);
        // 3 ms late: the next one is due 20 ms after the last was due.
        assert_eq!(pace.wait(after(23), FRAME_NS, 25.0), Some(Duration::from_millis(17)));
        // Late by more than one interval: due 20 ms after it came.
        assert_eq!(pace.wait(after(100), FRAME_NS, 25.0), None);
        assert_eq!(pace.wait(after(100), 2 * FRAME_NS, 25.0), Some(Duration::from_millis(20)));
    }

    #[test]
    fn a_paused_run_waits_and_steps() {
        let now = Instant::now();
        let mut pace = Pace::new(1.0);
        pace.control(&request(true, 1.0, None), 0);
        assert_eq!(pace.wait(now, 0, 25.0), Some(Duration::MAX));
        pace.control(&request(true, 1.0, Some(2 * FRAME_NS)), 0);
        assert_eq!(pace.wait(now, 0, 25.0), None);
        assert_eq!(pace.wait(now, FRAME_NS, 25.0), None);
        assert_eq!(pace.wait(now, 2 * FRAME_NS, 25.0), Some(Duration::MAX));
        pace.control(&request(true, 1.0, Some(FRAME_NS)), 2 * FRAME_NS);
        assert_eq!(pace.wait(now, 2 * FRAME_NS, 25.0), Some(Duration::MAX), "no way back");
        pace.play();
        assert_eq!(pace.wait(now, 2 * FRAME_NS, 25.0), Some(Duration::from_millis(40)));
    }

    #[test]
    fn impossible_speeds_are_ignored() {
        let mut pace = Pace::new(1.0);
        for speed in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e9] {
            pace.control(&request(false, speed, None), 0);
            assert_eq!(pace.speed(), 1.0);
        }
        pace.control(&request(false, 0.5, None), 0);
        assert_eq!(pace.speed(), 0.5);
    }
}
