//! A path of the command line that names nothing to analyze.

use kinetoscope_object_storage::error::StoreError;
use std::path::Path;

/// A path that names nothing to analyze, with the user's next step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InvalidPath {
    /// Why.
    pub why: String,
    /// Whether the same command may succeed later.
    pub is_retryable: bool,
}

impl InvalidPath {
    pub(super) fn wrong(why: String) -> Self {
        Self { why, is_retryable: false }
    }

    pub(super) fn empty(path: &Path) -> Self {
        Self::wrong(format!(
            "{} holds no finished recording (*.mcap). Run an experiment first, or again where it was stopped; a partial file is read only when named itself",
            path.display()
        ))
    }
}

impl From<StoreError> for InvalidPath {
    fn from(error: StoreError) -> Self {
        Self { why: error.to_string(), is_retryable: error.is_retryable }
    }
}
