//! Exit codes of the programs.

use crate::messages::Failure;
use kinetoscope::outputs::upload::UploadReport;
use kinetoscope::run::RunError;
use kinetoscope_console::{Exit, Explained as _};
use kinetoscope_files::output_file::is_of_path;
use kinetoscope_files::regular_file::is_of_file;
use kinetoscope_recording::error::ReadError;
use std::io;

/// Every exit code with its meaning, except for those of the analysis (`analysis/src/cli/arguments.rs`).
const MEANINGS: [(u8, &str); 10] = [
    (0, "done"),
    (1, "a run failed"),
    (2, "bad manifest or arguments"),
    (4, "a difference was found"),
    (
        5,
        "a recording is missing, unfinished, damaged or unknown;\n       what could be read was used",
    ),
    (70, "an internal error, or not enough memory"),
    (75, "a disk or another input or output failed: the same\n       command may succeed later"),
    (129, "ended by SIGHUP: the terminal was closed"),
    (130, "ended by Ctrl-C"),
    (143, "ended by SIGTERM"),
];

/// The exit codes of a command as its help lists them: 0, 2, 70 and 75, which every command has, and `others`.
pub(crate) fn exit_codes(others: &[u8]) -> String {
    let is_listed = |code: u8| [0, 2, 70, 75].contains(&code) || others.contains(&code);
    let listed = MEANINGS.iter().filter(|(code, _)| is_listed(*code));
    let lines: Vec<String> =
        listed.map(|(code, meaning)| format!("\n  {code:<4} {meaning}")).collect();
    format!("Exit codes:{}", lines.concat())
}

/// The exit codes of `run`, and of other commands that build the starts of runs, in addition to those of every command.
pub(crate) const OF_RUN: &[u8] = &[1, 129, 130, 143];

/// The exit code of a failed access to object storage.
pub(crate) fn of_storage(is_retryable: bool) -> Exit {
    if is_retryable { Exit::Retryable } else { Exit::BadInput }
}

/// The error of a file that the user named and that cannot be read. `help` is the next step if the file itself is the cause.
pub(crate) fn unread(error: &io::Error, what: String, help: &str) -> Failure {
    if is_of_file(error) {
        Failure::new(Exit::BadInput, what).help(help)
    } else {
        Failure::new(Exit::Retryable, what).help(ON_FAILED_DISK)
    }
}

/// The exit code of a recording that cannot be read.
pub(crate) fn exit_of_unread(error: &ReadError) -> Exit {
    if error.is_of_machine() { Exit::Retryable } else { Exit::Unreadable }
}

/// The error of a recording that cannot be read.
pub(crate) fn unread_recording(error: &ReadError) -> Failure {
    Failure::of(exit_of_unread(error), error.message())
}

/// What to do if a disk fails.
pub(crate) const ON_FAILED_DISK: &str = "check the disk, then run the same command again";

/// The exit code of an output that cannot be written.
pub(crate) fn of_output(error: &io::Error) -> Exit {
    if is_of_path(error) { Exit::BadInput } else { Exit::Retryable }
}

/// The exit code of a run that left no complete recording.
pub(crate) fn of_run_error(error: &RunError) -> Exit {
    match error {
        RunError::Record(error) if error.is_retryable() => Exit::Retryable,
        _ => Exit::RunFailed,
    }
}

/// The exit code of the uploads of an experiment.
pub(crate) fn of_uploads(report: &UploadReport) -> Exit {
    match &report.failure {
        _ if report.has_conflicts => Exit::RunFailed,
        Some(error) => of_storage(error.is_retryable),
        None => Exit::Done,
    }
}
