//! Metrics with standard errors, plots and checks, derived from recordings only.
//!
//! Reading order: [`cli`] parses the command line, `input` finds the recordings that belong together, [`run`] reads one
//! recording through the observer of its model in `models`, `sweep` combines runs, `checks` compares metrics with
//! bounds and baselines, and `report` writes the results.
// The numbers here are derived and never recorded: they need no fixed bits across platforms, so std's maths suffices.
#![allow(clippy::disallowed_methods)]

mod checks;
pub mod cli;
mod export;
pub mod input;
mod metric;
mod models;
mod plot;
mod report;
pub mod run;
mod statistics;
mod sweep;
mod thumbnail;
mod write_file;

pub use models::registry::{is_metric, nearest_metric};
pub use report::metrics_reference;
