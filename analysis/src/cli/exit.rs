//! Exit codes of `analyze-recordings`, and the errors that lead to them.

use crate::export::ExportError;
use crate::input::InvalidPath;
use crate::write_file::WriteError;

/// How the command ended, by exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum AnalysisExit {
    /// Done; all checks passed.
    Done = 0,
    /// Invalid arguments or checks file.
    Usage = 2,
    /// A run ended otherwise than expected, a check failed or its metric is missing, or a metric differs from the baseline.
    CheckFailed = 3,
    /// Some input is unreadable; the rest was analyzed.
    Unreadable = 5,
    /// The output cannot be written; the same command may succeed later.
    Retry = 75,
}

/// Why the command ended early, with its exit code.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub(super) struct CommandError {
    pub(super) exit: AnalysisExit,
    pub(super) message: String,
}

impl CommandError {
    pub(super) fn usage(message: impl std::fmt::Display) -> Self {
        Self { exit: AnalysisExit::Usage, message: message.to_string() }
    }

    pub(super) fn unreadable(error: impl std::fmt::Display) -> Self {
        Self { exit: AnalysisExit::Unreadable, message: error.to_string() }
    }
}

impl From<WriteError> for CommandError {
    fn from(error: WriteError) -> Self {
        let exit = if error.is_of_path { AnalysisExit::Usage } else { AnalysisExit::Retry };
        Self { exit, message: kinetoscope_console::with_help(&error.to_string()) }
    }
}

impl From<ExportError> for CommandError {
    fn from(error: ExportError) -> Self {
        match error {
            ExportError::Write(error) => error.into(),
            ExportError::NotBuiltIn => Self::usage(error),
        }
    }
}

impl From<InvalidPath> for CommandError {
    fn from(error: InvalidPath) -> Self {
        let exit = if error.is_retryable { AnalysisExit::Retry } else { AnalysisExit::Usage };
        Self { exit, message: kinetoscope_console::with_help(&error.reason) }
    }
}
