//! The errors of the analysis, with the exit codes to which they lead.

use crate::export::ExportError;
use crate::input::InvalidPath;
use crate::write_file::WriteError;
use kinetoscope_console::Exit;

/// Why the command ended early, with its exit code.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub(super) struct CommandError {
    pub(super) exit: Exit,
    pub(super) message: String,
}

impl CommandError {
    pub(super) fn usage(message: impl std::fmt::Display) -> Self {
        Self { exit: Exit::BadInput, message: message.to_string() }
    }

    pub(super) fn unreadable(error: impl std::fmt::Display) -> Self {
        Self { exit: Exit::Unreadable, message: error.to_string() }
    }
}

impl From<WriteError> for CommandError {
    fn from(error: WriteError) -> Self {
        let exit = if error.is_of_path { Exit::BadInput } else { Exit::Retryable };
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
        let exit = if error.is_retryable { Exit::Retryable } else { Exit::BadInput };
        Self { exit, message: kinetoscope_console::with_help(&error.reason) }
    }
}
