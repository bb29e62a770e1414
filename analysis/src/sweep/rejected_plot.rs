//! Why a requested plot cannot be drawn.

/// A plot that cannot be drawn: what is wrong, and what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what}\nhelp: {help}")]
pub(crate) struct RejectedPlot {
    pub(crate) what: String,
    pub(crate) help: String,
}

impl RejectedPlot {
    pub(crate) fn new(what: impl Into<String>, help: impl Into<String>) -> Self {
        Self { what: what.into(), help: help.into() }
    }
}
