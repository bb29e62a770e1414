//! How the program ends, and what that means to the shell.

use crate::outputs::upload::UploadReport;
use std::process::ExitCode;

/// The exit codes as the help shows them.
pub const EXIT_CODES: &str = "Exit codes:
  0    done
  1    a run ended in a physical fault or failed for good
  2    bad manifest or arguments
  4    --verify, --compare or --attested found a difference
  5    a recording or an attestation is missing, unfinished, damaged or unknown; what could be read was compared
  75   a disk or another input or output failed: the same command again may succeed
  130  ended by Ctrl-C
  143  ended by SIGTERM";

/// How the program ends. The numbers are documented and do not change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Everything asked for is there.
    Done,
    /// A run failed and would fail again.
    RunFailed,
    /// The manifest or the arguments are wrong.
    BadManifest,
    /// What was compared differs.
    Differs,
    /// A recording, or a part of it, can't be read or is not there.
    Unreadable,
    /// A disk or another input or output failed.
    Retryable,
    /// Ended by a signal; the code is 128 and its number.
    Signal(u8),
}

impl Exit {
    /// The exit code of a failed access to object storage.
    pub(crate) fn of_storage(is_retryable: bool) -> Self {
        if is_retryable { Self::Retryable } else { Self::BadManifest }
    }

    /// The exit code of the uploads of an experiment.
    pub(crate) fn of_uploads(report: &UploadReport) -> Self {
        match &report.failure {
            _ if report.has_conflicts => Self::RunFailed,
            Some(error) => Self::of_storage(error.is_retryable),
            None => Self::Done,
        }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(match exit {
            Exit::Done => 0,
            Exit::RunFailed => 1,
            Exit::BadManifest => 2,
            Exit::Differs => 4,
            Exit::Unreadable => 5,
            Exit::Retryable => 75,
            Exit::Signal(code) => code,
        })
    }
}
