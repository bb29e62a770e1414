//! The last words on runs that this machine did: what was recorded, what went wrong, the exit code and the next command.

use crate::cli::executor;
use crate::cli::exit::Exit;
use crate::cli::messages::{name_of, summary};
use crate::executor::cluster::task::quoted;
use crate::executor::local::Result;
use crate::outputs::upload::{UploadReport, Uploader};
use crate::plan::{Plan, Status};
use crate::run::{RunError, RunReport};
use kinetoscope_manifest::Experiment;
use kinetoscope_recording::recorder::Outcome;
use std::path::{MAIN_SEPARATOR, Path, PathBuf};

/// Says something unless nothing is to be said.
pub(crate) type Say<'a> = &'a dyn Fn(&str);

/// What the last words are about.
pub(crate) struct Conclusion<'a> {
    pub(crate) experiment: &'a Experiment,
    pub(crate) plan: &'a Plan,
    /// Where recordings went that did not stay in the plan's folder.
    pub(crate) depot: Option<&'a Uploader>,
    /// Whether others wait for these runs: then failures are written down for them.
    pub(crate) is_task: bool,
    pub(crate) say: Say<'a>,
}

impl Conclusion<'_> {
    /// Says how the runs ended, and returns the exit code. `signal` is that of a signal that stopped them.
    pub(crate) fn of(&self, results: &[Result<'_>], signal: Option<u8>) -> Exit {
        let Self { plan, depot, say, .. } = self;
        let (mut exit, failed) = self.complain(results);
        let endings: Vec<&RunReport> =
            results.iter().filter_map(|(_, result)| result.as_ref()?.as_ref().ok()).collect();
        if !endings.is_empty() {
            say(&summary(plan, &endings));
        }
        let delivery = depot.map(|depot| (depot, depot.report(plan)));
        let is_all_there = delivery.as_ref().is_none_or(|(_, delivery)| delivery.is_complete());
        if results.is_empty() && is_all_there {
            say(&format!("Nothing to do: {} has all recordings", self.place()));
        }
        if let Some((depot, delivery)) = delivery {
            exit = delivered(&delivery, depot, exit, say);
        }
        if failed > 0 && results.len() > 1 {
            eprintln!("{failed} of {} runs did not end well", results.len());
        }
        if let Some(code) = signal {
            eprintln!("Stopped. The same command goes on from here.");
            return Exit::Signal(code);
        }
        if exit == Exit::Done {
            say(&self.next_command());
        }
        exit
    }

    /// Says of each run that did not end well why, and how many there are; returns the gravest exit code.
    fn complain(&self, results: &[Result<'_>]) -> (Exit, usize) {
        let (mut exit, mut failed) = (Exit::Done, 0);
        for run in &self.plan.runs {
            if let Status::Done(Outcome::Fault(fault)) = &run.status {
                eprintln!("{}: ended in a fault earlier: {fault}", name_of(run, self.experiment));
                exit = Exit::RunFailed;
            }
        }
        for (run, result) in results {
            let (message, class) = match result {
                None => continue,
                Some(Ok(ending)) => match &ending.outcome {
                    Outcome::Complete | Outcome::Interrupted => continue,
                    Outcome::Fault(fault) => {
                        (format!("ended in a fault: {fault}"), Exit::RunFailed)
                    }
                },
                Some(Err(RunError::Record(error))) if error.is_retryable() => {
                    (error.to_string(), Exit::Retryable)
                }
                Some(Err(error)) => (error.to_string(), Exit::RunFailed),
            };
            eprintln!("{}: {message}", name_of(run, self.experiment));
            failed += 1;
            if self.is_task && !matches!(result, Some(Ok(_))) {
                let is_retryable = class == Exit::Retryable;
                executor::report_failure(&self.plan.folder, run, is_retryable, &message);
            }
            if exit != Exit::RunFailed {
                exit = class;
            }
        }
        (exit, failed)
    }

    /// Where the recordings are.
    fn place(&self) -> String {
        match self.depot {
            None => self.plan.folder.display().to_string(),
            Some(depot) => depot.address().to_string(),
        }
    }

    fn next_command(&self) -> String {
        let place = word(&self.place());
        let (feature, results) = match self.depot {
            None => ("", String::new()),
            Some(_) => {
                let folder = Path::new("recordings").join(&self.experiment.name);
                let folder = word(&folder.display().to_string());
                (" --features object-storage", format!(" --output {folder}"))
            }
        };
        format!("\nNext:\n  {} {place}{results}", analysis_called_as_we_are(feature))
    }
}

/// How `analyze-recordings` is called by whoever called this program: by cargo, which runs programs in `target`, or beside this one.
fn analysis_called_as_we_are(feature: &str) -> String {
    let own = std::env::args_os().next().map(PathBuf::from).unwrap_or_default();
    if own.components().any(|part| part.as_os_str() == "target") {
        return format!("cargo run --release{feature} --bin analyze-recordings --");
    }
    word(&own.with_file_name("analyze-recordings").display().to_string())
}

/// A word of a command line to copy: in quotes where a shell asks for them.
fn word(text: &str) -> String {
    let is_plain = |letter: char| {
        letter.is_alphanumeric() || letter == MAIN_SEPARATOR || "._-=:,+@%/".contains(letter)
    };
    if text.chars().all(is_plain) { text.to_owned() } else { quoted(text) }
}

/// Says what came of the puts to object storage, and returns the graver exit code.
pub(crate) fn delivered(
    delivery: &UploadReport,
    depot: &Uploader,
    exit: Exit,
    say: Say<'_>,
) -> Exit {
    if delivery.put > 0 {
        let plural = if delivery.put == 1 { "recording" } else { "recordings" };
        say(&format!("Put {} {plural} to {}", delivery.put, depot.address()));
    }
    for complaint in &delivery.complaints {
        eprintln!("{complaint}");
    }
    let uploads = Exit::of_uploads(delivery);
    if exit == Exit::Done || uploads == Exit::RunFailed { uploads } else { exit }
}
