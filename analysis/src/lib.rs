//! From recordings alone to numbers with errors, plots and verdicts.
// The numbers here are derived and never recorded: they need no fixed bits across platforms, so std's maths will do.
#![allow(clippy::disallowed_methods)]

pub mod figures;
pub mod laws;
pub mod measurement;
pub mod observables;
pub mod plot;
pub mod statistics;
