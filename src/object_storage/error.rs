//! Errors of object storage.

use kinetoscope_console::{Explained, Message};
use std::io;
use thiserror::Error;

/// The reason why an address cannot be used, with the remedy for the user.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{}", message.what)]
pub struct StoreError {
    message: Message,
    /// Whether the same command may succeed later.
    pub is_retryable: bool,
}

impl StoreError {
    /// An error that only another command can correct.
    pub(crate) fn permanent(message: impl Into<Message>) -> Self {
        Self { message: message.into(), is_retryable: false }
    }

    /// An error after which the same command may succeed.
    #[cfg(feature = "s3")]
    pub(crate) fn retryable(message: impl Into<Message>) -> Self {
        Self { message: message.into(), is_retryable: true }
    }
}

impl Explained for StoreError {
    fn help(&self) -> Option<String> {
        self.message.help.clone()
    }
}

/// With the user's next step, because the reader of a recording knows only that of a disk.
impl From<StoreError> for io::Error {
    fn from(error: StoreError) -> Self {
        Self::other(error.message.clause())
    }
}
