//! Errors of the input: paths that name nothing to analyze, and recordings that cannot be read.

use kinetoscope_console::text::shown_path;
use kinetoscope_object_storage::error::StoreError;
use std::path::Path;

/// A path that names nothing to analyze, with the user's next step.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub(crate) struct InvalidPath {
    /// What is wrong.
    pub(crate) reason: String,
    /// Whether the same command may succeed later.
    pub(crate) is_retryable: bool,
}

impl InvalidPath {
    pub(super) fn new(reason: String) -> Self {
        Self { reason, is_retryable: false }
    }

    pub(super) fn without_recordings(path: &Path) -> Self {
        Self::new(format!(
            "{} contains no finished recording (*.mcap). Run the experiment first; the same command completes an interrupted run, and a partial file is analyzed only if it is named",
            shown_path(path)
        ))
    }
}

impl From<StoreError> for InvalidPath {
    fn from(error: StoreError) -> Self {
        Self { reason: error.to_string(), is_retryable: error.is_retryable }
    }
}

/// A recording of which no frame can be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct UnreadableRecording(pub String);

impl UnreadableRecording {
    pub(crate) fn new(reason: impl std::fmt::Display) -> Self {
        Self(reason.to_string())
    }
}
