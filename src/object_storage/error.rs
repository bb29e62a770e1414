//! Errors of object storage.

use std::io;
use thiserror::Error;

/// The reason why an address cannot be used, with the remedy for the user.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{message}")]
pub struct StoreError {
    message: String,
    /// Whether the same command may succeed later.
    pub is_retryable: bool,
}

impl StoreError {
    /// An error that only another command can correct.
    pub(crate) fn permanent(message: String) -> Self {
        Self { message, is_retryable: false }
    }

    /// An error after which the same command may succeed.
    #[cfg(feature = "s3")]
    pub(crate) fn retryable(message: String) -> Self {
        Self { message, is_retryable: true }
    }
}

impl From<StoreError> for io::Error {
    fn from(error: StoreError) -> Self {
        Self::other(error)
    }
}
