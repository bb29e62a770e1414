//! From recordings alone to numbers with errors, plots and verdicts.
//!
//! In reading order: [`command`] takes the paths, [`input`] finds which recordings belong together, [`run`] reads one of
//! them through the [`observables`] of its model, [`sweep`] puts runs together, [`checks`] judges, [`report`] tells.
// The numbers here are derived and never recorded: they need no fixed bits across platforms, so std's maths will do.
#![allow(clippy::disallowed_methods)]

pub mod command;
pub mod export_command;
pub mod input;
pub mod memory;
mod remote;
pub mod run;

pub mod catalog;
pub mod laws;
pub mod measurement;
pub mod observables;
pub mod statistics;

pub mod coordinates;
pub mod sweep;

pub mod checks;
pub mod metrics;
#[cfg(feature = "parquet")]
pub mod metrics_parquet;

pub mod figures;
pub mod plot;
pub mod thumbnail;

pub mod report;
pub mod table;

pub mod baseline;
pub mod ci;
pub mod export;
pub mod files;
pub mod html;
