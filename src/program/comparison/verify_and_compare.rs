//! `verify` and `compare`: recordings against a rerun and against each other.

use crate::comparison::forecast;
use crate::comparison::rerun::{exit_of, listen, with_progress};
use crate::comparison::restore::verify_sample;
use crate::messages::Failure;
use crate::messages::exit::exit_of_unread;
use crate::messages::result_arguments::ResultArguments;
use crate::named_recordings::named_recordings;
use clap::Args;
use kinetoscope::verify::compare::{RecordingComparison, compare_recordings};
use kinetoscope::verify::diff::Comparison;
use kinetoscope::verify::divergence::{Cause, Divergence, Growth, Step};
use kinetoscope::verify::error::VerifyError;
use kinetoscope::verify::merge::{check_merge, merge_recordings};
use kinetoscope::verify::{Finding, Verification, verify};
use kinetoscope_console::text::{one_line, plural, shown_path};
use kinetoscope_console::{Exit, Explained as _, Message};
use kinetoscope_recording::reader::Outcome;
use serde_json::json;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// Rerun the run of a recording and compare, or a random sample of the runs in a table of an experiment.
#[derive(Debug, Args)]
pub(crate) struct VerifyArguments {
    /// Recordings (*.mcap), and folders of recordings; with --sample, the folder of an experiment or its runs.parquet
    #[arg(required = true, value_name = "RECORDING")]
    paths: Vec<PathBuf>,
    /// Execute so many random runs of the table in memory, and compare the hashes of their messages
    #[arg(long, value_name = "N")]
    sample: Option<NonZeroUsize>,
    #[command(flatten)]
    result: ResultArguments,
}

/// Compare two recordings: manifests, versions, messages. More recordings are compared with the first one, too.
#[derive(Debug, Args)]
pub(crate) struct CompareArguments {
    /// Recording (*.mcap)
    #[arg(value_name = "RECORDING")]
    left: PathBuf,
    /// Recordings to compare with it
    #[arg(value_name = "OTHER", required = true)]
    others: Vec<PathBuf>,
    /// Execute both runs again, to find the step at which they differ for the first time, and thereby the cause
    #[arg(long)]
    find_step: bool,
    /// Write a recording of all these runs to a new file: the first one, the others as ghosts over it, and their distances from
    /// it. A layout for it is written next to it
    #[arg(long, value_name = "FILE")]
    mcap: Option<PathBuf>,
    #[command(flatten)]
    result: ResultArguments,
}

impl VerifyArguments {
    /// Verifies each recording and prints the result.
    #[must_use]
    pub(crate) fn execute(&self) -> Exit {
        if let (Some(number), [table]) = (self.sample, self.paths.as_slice()) {
            let verified = verify_sample(table, number.get(), &self.result);
            let exit = verified.unwrap_or_else(|failure| self.result.failed(&failure));
            return self.result.concluded(exit);
        }
        let failed = |failure: Failure| self.result.concluded(self.result.failed(&failure));
        self.verify_all().map_or_else(failed, |report| report.print(&self.result))
    }

    fn verify_all(&self) -> Result<Report, Failure> {
        if self.sample.is_some() {
            let failure = Failure::new(Exit::BadInput, "--sample takes one experiment");
            return Err(failure.help("verify each with its own command"));
        }
        let paths = named_recordings(&self.paths)?;
        let (mut all, mut equal) = (Report::equal(), 0);
        for path in &paths {
            let verified = with_progress(path, &self.result, |interrupt, on_frame| {
                verify(path, interrupt, on_frame)
            })?;
            let mut report = match verified {
                Ok(verification) => verified_report(&verification, path),
                Err(error) => Report::of_error(&error),
            };
            if paths.len() > 1 && !matches!(report.exit, Exit::Signal(_)) {
                let about = |error: Message| error.about(shown_path(path));
                report.errors = report.errors.into_iter().map(about).collect();
            }
            equal += u64::from(report.exit == Exit::Done);
            let is_interrupted = matches!(report.exit, Exit::Signal(_));
            all.add(report);
            if is_interrupted {
                return Ok(all);
            }
        }
        if paths.len() > 1 {
            let count = plural(paths.len() as u64, "recording");
            all.lines.push(format!("{equal} of {count} equal to their reruns"));
        }
        Ok(all)
    }
}

impl CompareArguments {
    /// Compares the recordings and prints the result.
    #[must_use]
    pub(crate) fn execute(&self) -> Exit {
        let interrupt = match self.find_step.then(listen).transpose() {
            Ok(interrupt) => interrupt,
            Err(failure) => return self.result.concluded(self.result.failed(&failure)),
        };
        let mergeable = self.mcap.as_ref().map(|file| check_merge(1 + self.others.len(), file));
        if let Some(Err(error)) = mergeable {
            return Report::of_error(&error).print(&self.result);
        }
        let mut report = Report::equal();
        for other in &self.others {
            report.add(match compare_recordings(&self.left, other, interrupt.as_ref()) {
                Ok(comparison) => compared(&comparison, [&self.left, other], self.find_step),
                Err(error) => Report::of_error(&error),
            });
        }
        if let Some(file) = &self.mcap
            && matches!(report.exit, Exit::Done | Exit::Differs)
        {
            let recordings: Vec<&Path> =
                [&self.left].into_iter().chain(&self.others).map(PathBuf::as_path).collect();
            report.add(match merge_recordings(&recordings, file) {
                Ok(lines) => Report { lines, ..Report::equal() },
                Err(error) => Report::of_error(&error),
            });
        }
        report.print(&self.result)
    }
}

/// Result of a comparison.
#[derive(Debug)]
struct Report {
    /// What was found.
    lines: Vec<String>,
    /// What is wrong.
    errors: Vec<Message>,
    exit: Exit,
}

impl Report {
    const fn equal() -> Self {
        Self { lines: Vec::new(), errors: Vec::new(), exit: Exit::Done }
    }

    /// Adds another result. The exit code is the first one that is not zero, unless a later one says that nothing is known.
    fn add(&mut self, other: Self) {
        self.lines.extend(other.lines);
        self.errors.extend(other.errors);
        if matches!(self.exit, Exit::Done | Exit::Differs) && other.exit != Exit::Done {
            self.exit = other.exit;
        }
    }

    fn of_error(error: &VerifyError) -> Self {
        Self { lines: Vec::new(), errors: vec![error.message()], exit: exit_of(error) }
    }

    fn print(&self, result: &ResultArguments) -> Exit {
        if result.json {
            let equal = self.exit == Exit::Done;
            result.print_json(&json!({
                "exit_code": self.exit.code(),
                "equal": equal,
                "findings": self.lines,
                "errors": self.errors.iter().map(Message::to_string).collect::<Vec<_>>(),
            }));
        } else {
            let lines: Vec<_> = self.lines.iter().map(|line| one_line(line)).collect();
            result.print(&lines.join("\n"), || json!(null));
        }
        for error in &self.errors {
            Failure::of(self.exit, error.clone()).report();
        }
        result.concluded(self.exit)
    }
}

fn verified_report(verification: &Verification, path: &Path) -> Report {
    let mut report = match &verification.finding {
        Finding::SameBytes { frames } => {
            let mut report = Report::equal();
            let frames = plural(*frames, "frame");
            report.lines.push(format!("{frames} rerun: equal in every byte"));
            report
        }
        Finding::Messages(comparison) => {
            let mut report = messages(comparison, "the file", "the rerun");
            if comparison.difference.is_none() {
                let frames = plural(comparison.equal_frames, "frame");
                report
                    .lines
                    .push(format!("{frames} rerun: equal in every message, not in every byte"));
            }
            report
        }
    };
    let is_equal = report.exit == Exit::Done;
    report.lines.splice(0..0, notes(verification, path));
    match &verification.recording.provenance().outcome {
        Some(Outcome::Fault(fault)) if is_equal => {
            report.lines.push(format!("both failed in the same way: {fault}"));
        }
        Some(Outcome::Interrupted) if is_equal => {
            report.errors.push(Message::new(
                "the run was interrupted: the rest cannot be compared",
                "run its manifest again to finish it",
            ));
            report.exit = Exit::Unreadable;
        }
        _ => {}
    }
    if !verification.key_fits {
        let error = "the run key in the file does not match its manifest: one of them was changed";
        report.errors.insert(0, error.into());
        report.exit = Exit::Differs;
    }
    report
}

/// What differs between the program that recorded the file and this one.
fn notes(verification: &Verification, path: &Path) -> Vec<String> {
    let mut lines = vec![shown_path(path)];
    let provenance = verification.recording.provenance();
    let (recorded, own) = (&provenance.program_version, env!("CARGO_PKG_VERSION"));
    if recorded != own {
        lines.push(format!("recorded by version {recorded} of the program; this is {own}"));
    }
    let (recorded, own) = (provenance.physics_version, verification.physics_version);
    if recorded != own {
        lines.push(format!(
            "recorded with physics version {recorded} of {}; this is {own}: the numbers are expected to differ",
            provenance.model
        ));
    }
    for key in &verification.reinterpreted {
        lines.push(format!("this version reads the manifest differently: {key}"));
    }
    lines
}

/// Reports the first difference between the messages; it weighs more than an unreadable rest.
fn messages(comparison: &Comparison, left: &str, right: &str) -> Report {
    if let Some(difference) = &comparison.difference {
        let error = format!("first difference: {}", difference.describe(left, right));
        return Report { errors: vec![error.into()], exit: Exit::Differs, ..Report::equal() };
    }
    match &comparison.unreadable {
        Some(error) => {
            let errors = vec![error.message()];
            Report { errors, exit: exit_of_unread(error), ..Report::equal() }
        }
        None => Report::equal(),
    }
}

fn compared(comparison: &RecordingComparison, paths: [&Path; 2], find_step: bool) -> Report {
    let [left, right] = paths.map(shown_path);
    let mut lines = vec![format!("{left} → {right}")];
    if comparison.keys.is_empty() {
        lines.push("equal manifests".to_owned());
    } else {
        lines.push("the manifests differ:".to_owned());
        lines.extend(comparison.keys.iter().map(|key| format!("  {key}")));
    }
    for (what, [one, other]) in &comparison.versions {
        lines.push(format!("{what}: {one} → {other}"));
    }
    let frames = plural(comparison.messages.equal_frames, "frame");
    if let Some(divergence) = &comparison.divergence {
        lines.extend(cause(divergence, comparison.has_other_physics(), find_step));
        lines.extend(forecast::lines(divergence, paths, &unit_of(divergence)));
    }
    let has_equal =
        comparison.messages.unreadable.is_none() || comparison.messages.equal_frames > 0;
    if comparison.messages.difference.is_none() && has_equal {
        lines.push(match comparison.same_bytes {
            _ if !comparison.messages.not_compared.is_empty() => {
                format!("{frames}: equal in every message that both recordings have")
            }
            Some(true) => format!("{frames}: equal in every byte"),
            Some(false) => format!("{frames}: equal in every message, not in every byte"),
            None => format!("{frames}: equal in every message"),
        });
    }
    let not_compared: Vec<&str> =
        comparison.messages.not_compared.iter().map(String::as_str).collect();
    if !not_compared.is_empty() {
        let named = not_compared.join(", ");
        lines.push(format!(
            "not compared where only one recording has them, because it keeps other frames: {named}"
        ));
    }
    Report { lines, ..messages(&comparison.messages, &left, &right) }
}

/// The unit of time after a number.
fn unit_of(divergence: &Divergence) -> String {
    let unit = &divergence.time_unit;
    format!("{}{unit}", if unit.is_empty() { "" } else { " " })
}

/// Where the states differ for the first time, and why.
fn cause(divergence: &Divergence, other_physics: bool, find_step: bool) -> Vec<String> {
    let Divergence { frame, step, separation, particles, growth, has_other_steps, .. } = divergence;
    let named: Vec<String> = particles.iter().take(4).map(usize::to_string).collect();
    let rest = if particles.len() > 4 { ", …" } else { "" };
    let unit = unit_of(divergence);
    let at = match step {
        Some(Step { count: 0, time }) => format!("time {time:?}{unit}"),
        Some(Step { count: 1, time }) => format!("1 step or event, at time {time:?}{unit},"),
        Some(Step { count, time }) => format!("{count} steps or events, at time {time:?}{unit},"),
        None => format!("frame {frame}"),
    };
    let later = growth.map_or_else(String::new, |Growth { frame, separation, .. }| {
        format!(", {separation:.1e} in frame {frame}")
    });
    let mut lines = vec![format!(
        "states differ from {at} on: separation {separation:.1e}{later} (relative to the largest value of the column), particles {}{rest}",
        named.join(", ")
    )];
    if find_step && step.is_none() && *frame > 0 {
        let why = match has_other_steps {
            true => "the runs have other time steps",
            false => {
                "a run cannot be repeated by this program, or no states of the same time before this frame differ"
            }
        };
        lines.push(format!("only frames were compared, not steps: {why}"));
    }
    lines.push(match divergence.cause() {
        Cause::Rounding => {
            let time = growth.and_then(|growth| growth.time_per_e);
            let growth = time.map_or_else(String::new, |time| {
                format!(", amplified by a factor of e per {time:.3e}{unit}")
            });
            if other_physics {
                format!("cause: the manifests; the difference is as small as rounding errors{growth}")
            } else {
                format!("cause: rounding errors{growth}")
            }
        }
        Cause::Physics if *has_other_steps => "cause: the time steps differ; the separation is above rounding errors".to_owned(),
        Cause::Physics => "cause: other initial values, coefficients or equations: the separation is above rounding errors from the start".to_owned(),
        Cause::Undecided if find_step => "cause: not decided by the frames".to_owned(),
        Cause::Undecided => "cause: not decided by the frames; --find-step executes both runs again".to_owned(),
    });
    lines
}
