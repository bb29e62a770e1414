//! Errors of the drawing library.

/// A plot that could not be drawn, with the message of the drawing library.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct DrawingError(pub String);
