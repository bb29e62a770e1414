//! Kinetoscope: reproducible particle experiments, from a TOML manifest to one MCAP recording per run.
//!
//! Folders in the order of their dependencies: `interrupt`, `live`, `run`, `plan`, `outputs`, `executor` and `verify`, `cli`.
//! The physics is the package `kinetoscope-physics`.

pub mod interrupt;
pub mod live;

pub mod run;

pub mod plan;

pub mod outputs;

pub mod executor;
pub mod verify;

pub mod cli;
