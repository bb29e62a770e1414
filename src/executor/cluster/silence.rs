//! Notices tasks that an engine lists as running although they record nothing: a controller that was restarted may have missed the
//! end of a task, and lists it until the node registers again, in Slurm after half an hour or more.

use std::time::{Duration, Instant};

/// Time without progress after which a task is reported; at least ten checkpoints.
const SILENCE: Duration = Duration::from_mins(10);
const CHECKPOINTS: f64 = 10.0;

/// The progress of all unfinished runs: anything that changes whenever a task records, ends or saves its state.
pub(super) type Progress = u64;

/// When the runs last made progress.
pub(super) struct Silence {
    limit: Duration,
    last: Option<(Progress, Instant)>,
    is_reported: bool,
}

impl Silence {
    /// Tasks save their state every `checkpoint_every_s` seconds.
    pub(super) fn new(checkpoint_every_s: f64) -> Self {
        let checkpoints = Duration::try_from_secs_f64(CHECKPOINTS * checkpoint_every_s);
        let limit = SILENCE.max(checkpoints.unwrap_or(Duration::MAX));
        Self { limit, last: None, is_reported: false }
    }

    /// The message about `running` tasks that have made no progress for too long; once for each silence.
    pub(super) fn message(
        &mut self,
        running: usize,
        progress: Progress,
        now: Instant,
    ) -> Option<String> {
        let since = match self.last {
            Some((last, since)) if last == progress && running > 0 => since,
            _ => {
                self.last = Some((progress, now));
                self.is_reported = false;
                return None;
            }
        };
        let silent = now.duration_since(since);
        if self.is_reported || silent < self.limit {
            return None;
        }
        self.is_reported = true;
        let minutes = silent.as_secs() / 60;
        let tasks = if running == 1 { "1 task" } else { &format!("{running} tasks") };
        Some(format!(
            "{tasks} running according to the scheduler, but nothing was recorded for {minutes} minutes. Where no process of a task is \
             left, cancel it: this command submits its runs again"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn silence_of_running_tasks_is_reported_once() {
        let (start, minute) = (Instant::now(), Duration::from_mins(1));
        let mut silence = Silence::new(1.0);
        let mut at = |minutes: u32, running, progress| {
            silence.message(running, progress, start + minutes * minute)
        };
        assert_eq!(at(0, 2, 5), None);
        assert_eq!(at(9, 2, 5), None);
        assert_eq!(at(9, 2, 6), None, "progress");
        assert_eq!(at(18, 2, 6), None);
        let message = at(19, 2, 6).unwrap();
        assert!(message.starts_with("2 tasks running"), "{message}");
        assert!(message.contains("nothing was recorded for 10 minutes"), "{message}");
        assert_eq!(at(40, 2, 6), None, "once");
        assert_eq!(at(41, 2, 7), None);
        assert!(at(51, 1, 7).unwrap().starts_with("1 task running"), "another silence");
        // Tasks that wait in the queue are silent without a defect.
        assert_eq!(at(60, 0, 7), None);
        assert_eq!(at(99, 0, 7), None);
    }

    #[test]
    fn rare_checkpoints_make_long_silences() {
        let (start, minute) = (Instant::now(), Duration::from_mins(1));
        let mut silence = Silence::new(120.0);
        assert_eq!(silence.message(1, 0, start), None);
        assert_eq!(silence.message(1, 0, start + 19 * minute), None);
        assert!(silence.message(1, 0, start + 20 * minute).is_some());
        assert_eq!(Silence::new(f64::INFINITY).limit, Duration::MAX);
    }
}
