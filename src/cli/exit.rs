//! Exit codes of the programs.

use crate::outputs::upload::UploadReport;
use kinetoscope_files::output_file::is_of_path;
use std::io;
use std::process::ExitCode;

/// Every exit code with its meaning, except for 3 (a check failed), which only the analysis has
/// (`analysis/src/cli/arguments.rs`).
const MEANINGS: [(u8, &str); 10] = [
    (0, "done"),
    (1, "a run failed"),
    (2, "bad manifest or arguments"),
    (4, "a difference was found"),
    (
        5,
        "a recording or an attestation is missing, unfinished,\n       damaged or unknown; what could be read was used",
    ),
    (70, "an internal error, or not enough memory"),
    (75, "a disk or another input or output failed: the same\n       command may succeed later"),
    (129, "ended by SIGHUP: the terminal was closed"),
    (130, "ended by Ctrl-C"),
    (143, "ended by SIGTERM"),
];

/// The exit codes of a command as its help lists them: 0, 2, 70 and 75, which every command has, and `others`.
#[must_use]
pub fn exit_codes(others: &[u8]) -> String {
    let is_listed = |code: u8| [0, 2, 70, 75].contains(&code) || others.contains(&code);
    let listed = MEANINGS.iter().filter(|(code, _)| is_listed(*code));
    let lines: Vec<String> =
        listed.map(|(code, meaning)| format!("\n  {code:<4} {meaning}")).collect();
    format!("Exit codes:{}", lines.concat())
}

/// The exit codes of `run` in addition to those of every command.
pub const OF_RUN: &[u8] = &[1, 129, 130, 143];

/// How the program ends. The numbers are documented and do not change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Everything requested exists.
    Done,
    /// A run failed and would fail again.
    RunFailed,
    /// The manifest or the arguments are wrong.
    BadManifest,
    /// The compared recordings differ.
    Differs,
    /// A recording, or a part of it, cannot be read or is missing.
    Unreadable,
    /// A disk or another input or output failed.
    Retryable,
    /// Ended by a signal; the code is 128 plus its number.
    Signal(u8),
}

impl Exit {
    /// The exit code of a failed access to object storage.
    pub(crate) fn of_storage(is_retryable: bool) -> Self {
        if is_retryable { Self::Retryable } else { Self::BadManifest }
    }

    /// The exit code of an output that cannot be written.
    #[must_use]
    pub fn of_output(error: &io::Error) -> Self {
        if is_of_path(error) { Self::BadManifest } else { Self::Retryable }
    }

    /// The exit code of the uploads of an experiment.
    pub(crate) fn of_uploads(report: &UploadReport) -> Self {
        match &report.failure {
            _ if report.has_conflicts => Self::RunFailed,
            Some(error) => Self::of_storage(error.is_retryable),
            None => Self::Done,
        }
    }

    /// The number that the shell sees.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::RunFailed => 1,
            Self::BadManifest => 2,
            Self::Differs => 4,
            Self::Unreadable => 5,
            Self::Retryable => 75,
            Self::Signal(code) => code,
        }
    }

    /// The worse of two exit codes: what a retry cannot repair is worse than what it can.
    #[must_use]
    pub fn worst(self, other: Self) -> Self {
        if other.severity() > self.severity() { other } else { self }
    }

    const fn severity(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::Retryable => 1,
            Self::BadManifest => 2,
            Self::Unreadable => 3,
            Self::Differs => 4,
            Self::RunFailed => 5,
            Self::Signal(_) => 6,
        }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit.code())
    }
}

#[cfg(test)]
mod tests {
    use super::Exit;

    #[test]
    fn worst_exit_code_does_not_depend_on_the_order() {
        let ascending = [Exit::Done, Exit::Retryable, Exit::BadManifest, Exit::RunFailed];
        for (index, &low) in ascending.iter().enumerate() {
            for &high in &ascending[index..] {
                assert_eq!((low.worst(high), high.worst(low)), (high, high));
            }
        }
    }
}
