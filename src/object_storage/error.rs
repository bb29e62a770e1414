//! Why a place on object storage can't be used.

use std::fmt;
use std::io;

/// Why a place on object storage can't be used, with the user's next step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoreError {
    message: String,
    /// Whether the same command may succeed later. A wrong address stays wrong.
    pub is_retryable: bool,
}

impl StoreError {
    /// What only another command can mend.
    pub(crate) fn wrong(message: String) -> Self {
        Self { message, is_retryable: false }
    }

    /// What may be gone at the next try.
    #[cfg(feature = "s3")]
    pub(crate) fn passing(message: String) -> Self {
        Self { message, is_retryable: true }
    }
}

impl fmt::Display for StoreError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.message)
    }
}

impl std::error::Error for StoreError {}

impl From<StoreError> for io::Error {
    fn from(error: StoreError) -> Self {
        Self::other(error)
    }
}
