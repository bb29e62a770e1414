//! Metrics with standard errors, plots and checks, derived from recordings only.
//!
//! Reading order: [`cli`] parses the command line, [`input`] finds the recordings that belong together, [`run`] reads one
//! recording through the observer of its model in [`models`], [`sweep`] combines runs, [`checks`] compares metrics with
//! bounds and baselines, and [`report`] writes the results.
// The numbers here are derived and never recorded: they need no fixed bits across platforms, so std's maths suffices.
#![allow(clippy::disallowed_methods)]

pub mod checks;
pub mod cli;
pub mod export;
pub mod input;
pub mod metric;
pub mod models;
pub mod plot;
pub mod report;
pub mod run;
pub mod statistics;
pub mod sweep;
pub mod thumbnail;
pub mod write_file;
