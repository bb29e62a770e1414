//! The progress display: on a terminal, one bar per run in progress and one in total; otherwise, one line per finished run, and one
//! every ten seconds about those in progress. Before the runs, starts that take long have a bar or such lines.

use crate::messages::heartbeat::{Activity, Heartbeat};
use indicatif::{
    HumanBytes, HumanDuration, MultiProgress, ProgressBar, ProgressState, ProgressStyle,
};
use kinetoscope::executor::observer::{ExecutionObserver, RunObserver};
use kinetoscope::run::{RunError, RunReport, RunStart};
use kinetoscope_console::text::plural;
use kinetoscope_console::{can_start_thread, complain};
use kinetoscope_recording::recorder::Outcome;
use std::fmt;
use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Amount of progress output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verbosity {
    /// None.
    Quiet,
    /// Bars on a terminal, otherwise lines.
    Normal,
    /// One line per finished run in addition.
    Verbose,
}

/// Time between two lines about what is in progress, where no bars are shown.
const HEARTBEAT: Duration = Duration::from_secs(10);

/// The progress of all runs, on standard error.
pub(crate) struct ProgressDisplay {
    bars: MultiProgress,
    total: ProgressBar,
    verbosity: Verbosity,
    on_terminal: bool,
    activity: Arc<Activity>,
    /// Prints the activity at intervals; `None` on a terminal, which shows bars, and without output.
    heartbeat: Mutex<Option<Heartbeat>>,
}

/// What shows the progress of runs.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ProgressOutput {
    None,
    Bars,
    Lines,
}

/// The progress of one run.
struct RunProgress<'a> {
    display: &'a ProgressDisplay,
    stem: String,
    bar: ProgressBar,
    /// How much of the total is of this run.
    parts: AtomicU64,
}

impl ProgressDisplay {
    /// A display for `runs` runs.
    pub(crate) fn new(runs: usize, verbosity: Verbosity) -> Self {
        let on_terminal = std::io::stderr().is_terminal();
        let bars = MultiProgress::new();
        let total = if verbosity == Verbosity::Quiet || !on_terminal {
            ProgressBar::hidden()
        } else {
            bars.add(ProgressBar::new(PARTS_PER_RUN * runs as u64))
        };
        let all = style("all  {wide_bar} {runs} runs, {left} left {msg}");
        total.set_style(all.with_key("runs", finished_runs).with_key("left", time_left));
        // Without a thread for it, the bar moves when runs end.
        if !total.is_hidden() && can_start_thread() {
            total.enable_steady_tick(Duration::from_millis(200));
        }
        let activity = Arc::new(Activity::new(runs));
        let heartbeat = (verbosity != Verbosity::Quiet && !on_terminal).then(|| {
            let activity = Arc::clone(&activity);
            Heartbeat::start(HEARTBEAT, move || complain(&activity.text(), false))
        });
        Self { bars, total, verbosity, on_terminal, activity, heartbeat: Mutex::new(heartbeat) }
    }

    /// Removes all bars, and ends the lines about the runs in progress.
    pub(crate) fn close(&self) {
        drop(self.heartbeat.lock().unwrap_or_else(PoisonError::into_inner).take());
        self.total.finish_and_clear();
        // An error means that the terminal was closed.
        let _ = self.bars.clear();
    }

    fn output(&self) -> ProgressOutput {
        match (self.verbosity, self.on_terminal) {
            (Verbosity::Quiet, _) => ProgressOutput::None,
            (_, true) => ProgressOutput::Bars,
            (_, false) => ProgressOutput::Lines,
        }
    }

    /// Prints above the bars.
    pub(crate) fn above(&self, print: impl FnOnce()) {
        if self.on_terminal {
            self.bars.suspend(print);
        } else {
            print();
        }
    }

    fn line(&self, text: &str) {
        self.above(|| complain(text, false));
    }
}

impl ExecutionObserver for ProgressDisplay {
    fn start_run<'a>(&'a self, stem: &str) -> Box<dyn RunObserver + 'a> {
        let bar = match self.output() {
            ProgressOutput::Bars => {
                let bar = self.bars.insert_before(&self.total, ProgressBar::new(1));
                let run =
                    style("{prefix:22!} {wide_bar} {pos}/{len} frames {rate:>8} {left:>4} left");
                bar.set_style(run.with_key("rate", rate).with_key("left", time_left));
                bar.set_prefix(short_name(stem));
                bar
            }
            ProgressOutput::Lines | ProgressOutput::None => ProgressBar::hidden(),
        };
        self.activity.start(stem);
        Box::new(RunProgress {
            display: self,
            stem: stem.to_owned(),
            bar,
            parts: AtomicU64::new(0),
        })
    }

    fn show_remote(&self, finished: usize, message: &str) {
        self.total.set_position(PARTS_PER_RUN * finished as u64);
        self.total.set_message(message.to_owned());
        self.activity.set_remote(finished, message);
    }

    /// Prints a line above the bars, unless the output is quiet.
    fn remark(&self, text: &str) {
        if self.verbosity != Verbosity::Quiet {
            self.line(text);
        }
    }
}

impl RunProgress<'_> {
    /// Raises this run's share of the total to `parts`. A resumed run starts with what it had.
    fn add_to_total(&self, parts: u64) {
        let before = self.parts.fetch_max(parts, Ordering::Relaxed);
        self.display.total.inc(parts.saturating_sub(before));
    }
}

impl RunObserver for RunProgress<'_> {
    fn frame(&self, done: u64, of: u64) {
        match self.display.output() {
            ProgressOutput::Bars => {
                self.bar.set_length(of);
                self.bar.set_position(done);
                self.add_to_total(PARTS_PER_RUN * done.min(of) / of.max(1));
            }
            ProgressOutput::Lines => self.display.activity.set_frames(&self.stem, done, of),
            ProgressOutput::None => {}
        }
    }

    fn finish(self: Box<Self>, report: &Result<RunReport, RunError>) {
        self.bar.finish_and_clear();
        let failed = self.display.activity.finish(&self.stem, report.is_ok());
        match report {
            Ok(_) => self.add_to_total(PARTS_PER_RUN),
            Err(_) => self.display.total.set_message(format!("{failed} failed")),
        }
        if let Ok(RunReport { start: RunStart::Restarted(reason), .. }) = report {
            self.display.line(&format!("{}: restarted from scratch: {reason}", self.stem));
        }
        let wanted = match self.display.verbosity {
            Verbosity::Quiet => false,
            Verbosity::Normal => !self.display.on_terminal,
            Verbosity::Verbose => true,
        };
        if let (true, Ok(report)) = (wanted, report) {
            let word = match &report.outcome {
                Outcome::Complete => "done",
                Outcome::Fault(_) => "failed",
                Outcome::Interrupted => "interrupted",
            };
            let since = match report.start {
                RunStart::Resumed { frame } => format!(" from frame {frame} on"),
                RunStart::Fresh | RunStart::Restarted(_) => String::new(),
            };
            self.display.line(&format!(
                "{}: {word}{since}, {}, {}, {:.2} s",
                self.stem,
                plural(report.frames, "frame"),
                size(report.bytes),
                report.wall_time.as_secs_f64()
            ));
        }
    }
}

/// Formats a number of bytes, such as "1.50 MiB".
pub(crate) fn size(bytes: u64) -> String {
    HumanBytes(bytes).to_string()
}

/// Length of the total bar for one run, so that runs in progress count, too.
const PARTS_PER_RUN: u64 = 1000;

/// Formats the number of runs that are finished, of all.
fn finished_runs(state: &ProgressState, text: &mut dyn fmt::Write) {
    let [done, all] = [state.pos(), state.len().unwrap_or(0)].map(|parts| parts / PARTS_PER_RUN);
    // A failed write is repeated with the next frame.
    let _ = write!(text, "{done}/{all}");
}

/// Formats the time that is left, which is unknown before the first frame.
fn time_left(state: &ProgressState, text: &mut dyn fmt::Write) {
    let _ = match state.pos() {
        0 => write!(text, "?"),
        _ => write!(text, "{:#}", HumanDuration(state.eta())),
    };
}

/// The place of a run in its sweep, from the stem of its file; the experiment's name if it is the only one.
fn short_name(stem: &str) -> String {
    let mut parts: Vec<&str> = stem.split("__").collect();
    // The last part is the start of the run's key.
    parts.truncate(parts.len().max(2) - 1);
    match parts.as_slice() {
        [name] => (*name).to_owned(),
        parts => parts[1..].join(", "),
    }
}

/// Formats the frames per second, below 10 with one decimal.
fn rate(state: &ProgressState, text: &mut dyn fmt::Write) {
    let frames = state.per_sec();
    let digits = if frames < 10.0 { 1 } else { 0 };
    // A failed write is repeated with the next frame.
    let _ = write!(text, "{frames:.digits$}/s");
}

fn style(template: &str) -> ProgressStyle {
    // The templates are valid constants of this file; the default style would show the same numbers.
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// Time after which starts have a bar.
const LONG: Duration = Duration::from_secs(1);

/// Length of the bar.
const PARTS: f64 = 1000.0;

/// Starts that are complete, with the fractions of the others, and all starts.
type Completion = (f64, usize);

/// The progress of the starts of a plan, on standard error, until it is dropped.
pub(crate) struct PreparationDisplay {
    begun: Instant,
    bar: ProgressBar,
    progress: Arc<Mutex<Completion>>,
    /// Prints the progress at intervals; `None` on a terminal, which shows the bar, and without output.
    _heartbeat: Option<Heartbeat>,
}

impl PreparationDisplay {
    pub(crate) fn new(verbosity: Verbosity) -> Self {
        let (is_quiet, on_terminal) =
            (verbosity == Verbosity::Quiet, std::io::stderr().is_terminal());
        let bar = match is_quiet || !on_terminal {
            true => ProgressBar::hidden(),
            false => ProgressBar::new(PARTS as u64),
        };
        bar.set_style(style("preparing {msg}  {wide_bar} {percent} %, {eta} left"));
        let progress = Arc::new(Mutex::new((0.0, 0)));
        let heartbeat = (!is_quiet && !on_terminal).then(|| {
            let progress = Arc::clone(&progress);
            Heartbeat::start(HEARTBEAT, move || {
                let progress = *progress.lock().unwrap_or_else(PoisonError::into_inner);
                complain(&completion_text(progress), false);
            })
        });
        Self { begun: Instant::now(), bar, progress, _heartbeat: heartbeat }
    }

    /// Receives the progress from any thread.
    pub(crate) fn show(&self, done: f64, starts: usize) {
        *self.progress.lock().unwrap_or_else(PoisonError::into_inner) = (done, starts);
        if !self.bar.is_hidden() && self.begun.elapsed() > LONG {
            self.bar.set_message(plural(starts as u64, "start"));
            self.bar.set_position((PARTS * done / starts as f64) as u64);
        }
    }
}

impl Drop for PreparationDisplay {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Formats the progress in one line.
fn completion_text((done, starts): Completion) -> String {
    let percent = if starts == 0 { 0.0 } else { 100.0 * done / starts as f64 };
    format!("preparing {}: {percent:.1} %", plural(starts.max(1) as u64, "start"))
}

#[cfg(test)]
mod tests {
    use super::{completion_text, short_name};

    #[test]
    fn bar_of_a_run_names_its_place_in_the_sweep() {
        assert_eq!(short_name("heap__friction=0.5__r2__0123abcd"), "friction=0.5, r2");
        assert_eq!(short_name("heap__0123abcd"), "heap");
        assert_eq!(short_name("recordings/heap.mcap"), "recordings/heap.mcap");
    }

    #[test]
    fn line_states_the_complete_part_of_all_starts() {
        assert_eq!(completion_text((0.0, 0)), "preparing 1 start: 0.0 %");
        assert_eq!(completion_text((0.25, 1)), "preparing 1 start: 25.0 %");
        assert_eq!(completion_text((3.5, 4)), "preparing 4 starts: 87.5 %");
    }
}
