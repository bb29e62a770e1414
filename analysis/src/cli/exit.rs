//! The errors of the analysis, with the exit codes to which they lead.

use crate::export::{ExportError, needs_parquet};
use crate::input::{InvalidPath, UnreadableRecording};
use crate::thumbnail::ThumbnailError;
use crate::write_file::WriteError;
use kinetoscope_console::{Exit, Explained as _, Message};
use kinetoscope_recording::error::ReadError;

/// Why the command ended early, with its exit code.
#[derive(Debug, thiserror::Error)]
#[error("{}", message.what)]
pub(super) struct CommandError {
    pub(super) exit: Exit,
    pub(super) message: Message,
}

impl CommandError {
    pub(super) fn usage(message: impl Into<Message>) -> Self {
        Self { exit: Exit::BadInput, message: message.into() }
    }

    /// The error of a command that can read none of its inputs.
    pub(super) fn all_unreadable(reasons: &[UnreadableRecording]) -> Self {
        let exit = UnreadableRecording::exit(reasons).unwrap_or(Exit::Unreadable);
        let reasons: Vec<String> = reasons.iter().map(|why| why.message.to_string()).collect();
        Self { exit, message: reasons.join("\nerror: ").into() }
    }
}

impl From<ReadError> for CommandError {
    fn from(error: ReadError) -> Self {
        Self::all_unreadable(&[error.into()])
    }
}

impl From<ThumbnailError> for CommandError {
    fn from(error: ThumbnailError) -> Self {
        match error {
            ThumbnailError::Read(error) => error.into(),
            other => Self::all_unreadable(&[other.message().into()]),
        }
    }
}

impl From<WriteError> for CommandError {
    fn from(error: WriteError) -> Self {
        let exit = if error.is_of_path { Exit::BadInput } else { Exit::Retryable };
        Self { exit, message: error.message() }
    }
}

impl From<ExportError> for CommandError {
    fn from(error: ExportError) -> Self {
        match error {
            ExportError::Write(error) => error.into(),
            ExportError::NotBuiltIn => Self::usage(needs_parquet()),
        }
    }
}

impl From<InvalidPath> for CommandError {
    fn from(error: InvalidPath) -> Self {
        let exit = if error.is_retryable { Exit::Retryable } else { Exit::BadInput };
        Self { exit, message: error.message }
    }
}
