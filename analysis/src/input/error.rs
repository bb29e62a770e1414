//! Errors of the input: paths that name nothing to analyze, and recordings that cannot be read.

use kinetoscope_console::text::shown_path;
use kinetoscope_console::{Explained, Message};
use kinetoscope_object_storage::error::StoreError;
use kinetoscope_recording::error::ReadError;
use std::path::Path;

/// A path that names nothing to analyze, with the user's next step.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", message.what)]
pub(crate) struct InvalidPath {
    /// What is wrong, and what to do.
    pub(crate) message: Message,
    /// Whether the same command may succeed later.
    pub(crate) is_retryable: bool,
}

impl InvalidPath {
    pub(super) fn new(what: String, help: &str) -> Self {
        Self { message: Message::new(what, help), is_retryable: false }
    }

    pub(super) fn without_recordings(path: &Path) -> Self {
        Self::new(
            format!("{} contains no finished recording (*.mcap)", shown_path(path)),
            "run the experiment first; the same command completes an interrupted run, and a partial file is analyzed only if it is named",
        )
    }
}

impl From<StoreError> for InvalidPath {
    fn from(error: StoreError) -> Self {
        Self { message: error.message(), is_retryable: error.is_retryable }
    }
}

/// A recording of which no frame can be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", .0.what)]
pub struct UnreadableRecording(pub Message);

impl UnreadableRecording {
    pub(crate) fn new(what: impl Into<String>, help: impl Into<String>) -> Self {
        Self(Message::new(what, help))
    }
}

impl Explained for UnreadableRecording {
    fn help(&self) -> Option<String> {
        self.0.help.clone()
    }
}

impl From<&ReadError> for UnreadableRecording {
    fn from(error: &ReadError) -> Self {
        Self(error.message())
    }
}

impl From<ReadError> for UnreadableRecording {
    fn from(error: ReadError) -> Self {
        Self::from(&error)
    }
}
