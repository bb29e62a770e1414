//! The progress display: a bar a running job and one for all on a terminal, a line a finished run elsewhere.

use crate::run::{RunError, RunReport, RunStart};
use indicatif::{HumanBytes, MultiProgress, ProgressBar, ProgressState, ProgressStyle};
use kinetoscope_recording::recorder::Outcome;
use std::fmt;
use std::io::IsTerminal;
use std::time::Duration;

/// Where progress is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verbosity {
    /// Nowhere.
    Quiet,
    /// Bars on a terminal, else a line now and then.
    Normal,
    /// A line for each finished run too.
    Verbose,
}

/// The progress of all runs, on standard error.
pub struct ProgressDisplay {
    bars: MultiProgress,
    total: ProgressBar,
    verbosity: Verbosity,
    on_terminal: bool,
}

/// The progress of one run.
pub struct RunProgress<'a> {
    display: &'a ProgressDisplay,
    stem: String,
    bar: ProgressBar,
}

impl ProgressDisplay {
    /// A display for so many runs.
    #[must_use]
    pub fn new(runs: usize, verbosity: Verbosity) -> Self {
        let on_terminal = std::io::stderr().is_terminal();
        let bars = MultiProgress::new();
        let total = if verbosity == Verbosity::Quiet || !on_terminal {
            ProgressBar::hidden()
        } else {
            bars.add(ProgressBar::new(runs as u64))
        };
        total.set_style(style("all  {wide_bar} {pos}/{len} runs, {eta} left {msg}"));
        total.enable_steady_tick(Duration::from_millis(200));
        Self { bars, total, verbosity, on_terminal }
    }

    /// Shows that a run has begun.
    #[must_use]
    pub fn start_run(&self, stem: &str) -> RunProgress<'_> {
        let bar = if self.verbosity == Verbosity::Quiet || !self.on_terminal {
            ProgressBar::hidden()
        } else {
            self.bars.insert_before(&self.total, ProgressBar::new(1))
        };
        let run = style("{wide_bar} {pos}/{len} frames {rate:>8} {eta:>4} left");
        bar.set_style(run.with_key("rate", rate));
        RunProgress { display: self, stem: stem.to_owned(), bar }
    }

    /// So many runs are finished elsewhere, and what is under way, in words.
    pub fn elsewhere(&self, finished: usize, under_way: &str) {
        self.total.set_position(finished as u64);
        self.total.set_message(under_way.to_owned());
    }

    /// Says something beside the bars, unless nothing is to be said.
    pub fn remark(&self, text: &str) {
        if self.verbosity != Verbosity::Quiet {
            self.line(text);
        }
    }

    /// Takes all bars away.
    pub fn close(&self) {
        self.total.finish_and_clear();
        // Nothing can be done about a terminal that is gone.
        let _ = self.bars.clear();
    }

    fn line(&self, text: &str) {
        if self.on_terminal {
            self.bars.suspend(|| eprintln!("{text}"));
        } else {
            eprintln!("{text}");
        }
    }
}

impl RunProgress<'_> {
    /// So many of so many frames are recorded.
    pub fn frame(&self, done: u64, of: u64) {
        self.bar.set_length(of);
        self.bar.set_position(done);
    }

    /// The run has ended.
    pub fn finish(self, report: &Result<RunReport, RunError>) {
        self.bar.finish_and_clear();
        self.display.total.inc(1);
        if let Ok(RunReport { start: RunStart::Restarted(reason), .. }) = report {
            self.display.line(&format!("{}: began anew, since {reason}", self.stem));
        }
        let wanted = match self.display.verbosity {
            Verbosity::Quiet => false,
            Verbosity::Normal => !self.display.on_terminal,
            Verbosity::Verbose => true,
        };
        if let (true, Ok(report)) = (wanted, report) {
            let word = match &report.outcome {
                Outcome::Complete => "done",
                Outcome::Fault(_) => "ended in a fault",
                Outcome::Interrupted => "interrupted",
            };
            let since = match report.start {
                RunStart::Resumed { frame } => format!(" from frame {frame} on"),
                RunStart::Fresh | RunStart::Restarted(_) => String::new(),
            };
            self.display.line(&format!(
                "{}: {word}{since}, {} frames, {}, {:.2} s",
                self.stem,
                report.frames,
                size(report.bytes),
                report.wall_time.as_secs_f64()
            ));
        }
    }
}

/// A number of bytes as people read it, such as "1.50 MiB".
#[must_use]
pub fn size(bytes: u64) -> String {
    HumanBytes(bytes).to_string()
}

/// Frames a second: whole ones, but where they are few.
fn rate(state: &ProgressState, text: &mut dyn fmt::Write) {
    let frames = state.per_sec();
    let digits = if frames < 10.0 { 1 } else { 0 };
    // A bar that can't be written is shown again with the next frame.
    let _ = write!(text, "{frames:.digits$}/s");
}

fn style(template: &str) -> ProgressStyle {
    // The templates are constants of this file and valid; were one not, the default style shows the same numbers.
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}
