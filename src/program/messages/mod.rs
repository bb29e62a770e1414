//! Messages of the programs: the plan before the runs, the summary after them, errors and the next command.

pub(crate) mod argument_errors;
pub(crate) mod examples;
pub(crate) mod exit;
mod heartbeat;
pub(crate) mod progress;
pub(crate) mod result_arguments;
pub(crate) mod suggestion;

use crate::messages::progress::size;
use kinetoscope::executor::cluster::task::quoted;
use kinetoscope::plan::{Plan, PlannedRun};
use kinetoscope::run::RunReport;
use kinetoscope_console::Exit;
pub(crate) use kinetoscope_console::text::plural;
use kinetoscope_console::text::{escaped_word, one_line, shown_path, visible};
use kinetoscope_console::{Message, StandardOutput, without_styles};
use kinetoscope_manifest::Experiment;
use kinetoscope_recording::recorder::Outcome;
use std::fmt::Display;
use std::io::{self, IsTerminal as _};
use std::path::{MAIN_SEPARATOR, Path, PathBuf};

/// An error that ends a command: its text as printed, and the exit code.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Failure {
    /// The exit code.
    pub exit: Exit,
    /// What is wrong, without control characters, except for the colors of a rendered error.
    what: String,
    /// Where it is.
    place: Option<String>,
    /// The one thing to do, without control characters.
    help: Option<String>,
}

impl Failure {
    /// An error without help.
    pub(crate) fn new(exit: Exit, what: impl Display) -> Self {
        let what = visible(&format!("error: {what}")).into_owned();
        Self { exit, what, place: None, help: None }
    }

    /// The error of a message.
    pub(crate) fn of(exit: Exit, message: impl Into<Message>) -> Self {
        let Message { what, help } = message.into();
        let failure = Self::new(exit, what);
        match help {
            Some(help) => failure.help(help),
            None => failure,
        }
    }

    /// An error whose text is complete, such as that of a manifest with its underlined lines.
    #[must_use]
    pub(crate) fn rendered(exit: Exit, text: String) -> Self {
        Self { exit, what: text.trim_end().to_owned(), place: None, help: None }
    }

    /// Several errors, with the worst of their exit codes.
    #[must_use]
    pub(crate) fn together(errors: &[Self]) -> Self {
        let exit = errors.iter().fold(Exit::Done, |exit, error| exit.worst(error.exit));
        let texts: Vec<String> = errors.iter().map(Self::text).collect();
        Self::rendered(exit, texts.join("\n\n"))
    }

    /// Adds the one thing to do.
    #[must_use]
    pub(crate) fn help(self, help: impl Display) -> Self {
        Self { help: Some(visible(&help.to_string()).into_owned()), ..self }
    }

    /// Adds the place of the error, on a line of its own before the help.
    #[must_use]
    pub(crate) fn at(self, place: &str) -> Self {
        Self { place: Some(one_line(place).into_owned()), ..self }
    }

    /// The text as printed.
    #[must_use]
    pub(crate) fn text(&self) -> String {
        let place = self.place.iter().map(|place| format!("\n --> {place}"));
        let help = self.help.iter().map(|help| format!("\nhelp: {help}"));
        [self.what.clone()].into_iter().chain(place).chain(help).collect()
    }

    /// The text without colors, for JSON.
    #[must_use]
    pub(crate) fn plain_text(&self) -> String {
        without_styles(&self.text())
    }

    /// Prints the error.
    pub(crate) fn report(&self) -> Exit {
        kinetoscope_console::complain(&self.text(), true);
        self.exit
    }
}

/// An error in the arguments.
pub(crate) fn bad(what: impl Display) -> Failure {
    Failure::new(Exit::BadInput, what)
}

/// Prints a text of the program's own to standard output, as the result of a command.
pub(crate) fn print_exactly(text: &str) -> Exit {
    let output = StandardOutput::default();
    output.print_exactly(&format!("{text}\n"));
    concluded(&output, Exit::Done)
}

/// The exit code of a command whose output is complete: [`Exit::Retryable`] or worse if it could not be written.
pub(crate) fn concluded(output: &StandardOutput, exit: Exit) -> Exit {
    match output.failure() {
        None => exit,
        Some(failure) => {
            complain(&failure);
            exit.worst(Exit::Retryable)
        }
    }
}

/// Prints a line to standard error. If it is closed, the exit code still reports the error.
pub(crate) fn complain(text: &str) {
    kinetoscope_console::complain(text, false);
}

/// Whether errors are colored: on a terminal, unless `NO_COLOR` is set.
#[must_use]
pub(crate) fn has_colors() -> bool {
    io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none()
}

/// Names a run within its experiment: its coordinates and replicate, or the experiment's name.
pub(crate) fn name_of(run: &PlannedRun, experiment: &Experiment) -> String {
    let mut parts: Vec<String> = run
        .run
        .coordinates
        .iter()
        .map(|coordinate| format!("{} = {}", coordinate.key, coordinate.value))
        .collect();
    if experiment.replicates > 1 {
        parts.push(format!("replicate {}", run.run.replicate));
    }
    if parts.is_empty() {
        experiment.name.clone()
    } else {
        one_line(&parts.join(", ")).into_owned()
    }
}

/// Formats the plan summary printed before the runs start.
pub(crate) fn describe(
    experiment: &Experiment,
    plan: &Plan,
    jobs: usize,
    destination: &str,
) -> String {
    let to_do = plan.to_do();
    let finished = plan.finished().count();
    let mut text = format!("{}: {}, ", experiment.name, experiment.model());
    text += &plural(plan.runs.len() as u64, "run");
    if experiment.replicates > 1 {
        text += &format!(" ({} replicates per point)", experiment.replicates);
    }
    let mut estimates = to_do.iter().filter_map(|run| run.estimate());
    let particles = counted(estimates.clone().map(|run| run.particles), "particle");
    let frames = counted(estimates.clone().map(|run| run.frames), "frame");
    if let (Some(particles), Some(frames)) = (particles, frames) {
        text += &format!("\n  {particles}, {frames}");
        match (experiment.keeps_only_metrics(), plan.runs.len() > 1) {
            (true, _) => text += &format!(", of which the metrics are kept, {jobs} in parallel"),
            (false, true) => {
                let bytes = size(plan.bytes_to_write());
                text += &format!(", at most {bytes} in total, {jobs} in parallel");
            }
            (false, false) => text += &format!(", at most {}", size(plan.bytes_to_write())),
        }
        let distance = estimates.clone().map(|run| run.draw_every.get()).max();
        if let (Some(distance @ 2..), false) = (distance, experiment.keeps_only_metrics()) {
            let up_to = if plan.runs.len() > 1 { "up to " } else { "" };
            text +=
                &format!("\n  one frame in {up_to}{distance} is drawn (`draw_every` in [record])");
        }
        if estimates.any(|run| run.has_series_of_unknown_size) {
            text += "\n  plus the requested series of collisions or contacts, whose size is not known before";
        }
    }
    text += &format!("\n  to {destination}");
    if finished > 0 {
        let runs = plural(plan.runs.len() as u64, "run");
        text += &format!(
            "\n  {finished} of {runs} already finished (use --force to rerun {})",
            if finished == 1 { "it" } else { "them" }
        );
    }
    text
}

/// Formats the range of a count over the runs, such as "5 to 50 particles"; `None` without runs.
pub(crate) fn counted(counts: impl Iterator<Item = u64> + Clone, what: &str) -> Option<String> {
    let (min, max) = (counts.clone().min()?, counts.max()?);
    Some(if min == max { plural(max, what) } else { format!("{min} to {}", plural(max, what)) })
}

/// Formats what was recorded and what was interrupted.
pub(crate) fn summary(plan: &Plan, endings: &[&RunReport]) -> String {
    let (interrupted, written): (Vec<&RunReport>, Vec<&RunReport>) =
        endings.iter().partition(|ending| ending.outcome == Outcome::Interrupted);
    let bytes: u64 = written.iter().map(|ending| ending.bytes).sum();
    let seconds: f64 = written.iter().map(|ending| ending.wall_time.as_secs_f64()).sum();
    let frames: u64 = written.iter().map(|ending| ending.frames).sum();
    let mut lines = Vec::new();
    match written.as_slice() {
        [] => {}
        [ending] => lines.push(format!(
            "Wrote {} ({}, {} in {seconds:.2} s)",
            shown_path(&ending.path),
            size(bytes),
            plural(frames, "frame")
        )),
        several => lines.push(format!(
            "Wrote {} recordings to {} ({}, {frames} frames, {seconds:.1} s of computing)",
            several.len(),
            shown_path(&plan.folder),
            size(bytes)
        )),
    }
    lines.extend(interrupted.iter().map(|ending| {
        format!("Kept {} with {} so far", shown_path(&ending.path), plural(ending.frames, "frame"))
    }));
    lines.join("\n")
}

/// The error if the disk has less free space than the recordings need. `option` names their folder on the command line.
pub(crate) fn disk_shortage(plan: &Plan, needed: u64, option: &str) -> Option<Failure> {
    let what = missing_space(plan, needed)?;
    Some(Failure::new(Exit::Retryable, what).help(format!(
        "free disk space, choose another folder with {option} DIR, or record less ([record] frames, channels)"
    )))
}

/// What a disk with less free space than the recordings need has.
pub(crate) fn missing_space(plan: &Plan, needed: u64) -> Option<String> {
    let existing = existing_ancestor(&plan.folder)?;
    let free = fs4::available_space(&existing).ok()?;
    let (needs, has) = (size(needed), size(free));
    let place = shown_path(&existing);
    (needed > free)
        .then(|| format!("the recordings need up to {needs}, but only {has} is free in {place}"))
}

/// The nearest folder above a path, or the path itself, that exists.
pub(crate) fn existing_ancestor(path: &Path) -> Option<PathBuf> {
    let existing = path.ancestors().find(|path| path.as_os_str().is_empty() || path.is_dir())?;
    Some(if existing.as_os_str().is_empty() { PathBuf::from(".") } else { existing.to_owned() })
}

/// Quotes a word of a command line to copy, if a shell requires it.
pub(crate) fn word(text: &str) -> String {
    let is_plain = |letter: char| {
        letter.is_alphanumeric() || letter == MAIN_SEPARATOR || "._-=:,+@%/".contains(letter)
    };
    if text.chars().all(is_plain) {
        return text.to_owned();
    }
    escaped_word(text).unwrap_or_else(|| quoted(text))
}
